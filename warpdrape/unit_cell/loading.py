"""A cell pulled both ways, and sheared under held tensions; what comes out as tables."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from warpdrape.errors import InputError, RunFailed, positive
from warpdrape.unit_cell.equilibrium import Equilibrium, settle
from warpdrape.unit_cell.model import Model
from warpdrape.unit_cell.sides import distance, width

PAST_CRIMP = 0.003
"""Strain beyond the larger crimp to which a table goes where none is asked for [-]."""
PAST_LOCKING = math.radians(8.0)
"""Angle beyond locking to which shear goes where none is asked for [rad]."""
STEEPEST = math.radians(80.0)
FEWEST_ANGLES = 6
"""Of a shear curve that is worth a card."""
ANGLE_STEP = math.radians(2.0)
FINE = (0.25, 0.5, 1.0, 2.0)
"""First angles, over the sticking angle, within which friction builds up [-]."""


@dataclass(frozen=True)
class Loads:
    """What is done to a cell.

    Attributes:
        shear_tension: T1 and T2 that are held while it shears [N per yarn].
        largest_strain: of the table of tensions [-]; None for crimp and a little more.
        largest_angle: of shear [rad]; None for locking and a little more.
        points: of the table from no strain to the largest, along each strain.
    """

    shear_tension: tuple[float, float]
    largest_strain: float | None = None
    largest_angle: float | None = None
    points: int = 9

    def __post_init__(self) -> None:
        for family, tension in zip(("warp", "weft"), self.shear_tension, strict=True):
            positive(f"shear_tension_{family}", tension, unit="N")
        if self.largest_strain is not None and not (
            0.0 < positive("largest_strain", self.largest_strain) <= 0.2
        ):
            raise InputError(f"largest_strain = {self.largest_strain} must be 0.2 (20 %) at most")
        if self.largest_angle is not None and not (
            math.radians(10.0) <= positive("largest_angle", self.largest_angle) <= STEEPEST
        ):
            raise InputError(
                f"largest_angle = {math.degrees(self.largest_angle):.4g}° must lie in 10 … 80°"
            )
        if not 5 <= self.points <= 41:
            raise InputError(f"points = {self.points} must lie in 5 … 41")


@dataclass(frozen=True, eq=False)
class TensionTable:
    """Tensions on an even grid of strains.

    Attributes:
        strains: ε1 and ε2 of the grid [-], shape [n] each; 0 among them.
        tensions: T1, T2 [N per yarn], shape [2, n, m].
        squeeze: largest of sections at crossovers [-].
        yarn_strain: largest of a yarn itself [-].
    """

    strains: tuple[np.ndarray, np.ndarray]
    tensions: np.ndarray
    squeeze: float
    yarn_strain: float


@dataclass(frozen=True, eq=False)
class ShearCurve:
    """The couple of a cell over the shear angle, its tensions held.

    Attributes:
        angles: γ from 0 on [rad], shape [n].
        elastic: C_s of the elastic forces, mean of both ways of shear [N·m per cell].
        friction: C_s of friction, built up over the sticking angle.
        skew: largest difference of both ways from their mean, over the largest couple [-].
        strains: ε1, ε2 that keep the tensions [-], shape [n, 2].
        locking: angle from which on neighbours have less room than their width as woven [rad]; None
            where the curve ends before.
        touching: angle at which neighbours, as narrow as they are by then, begin to touch [rad];
            None where they do not.
        narrower: by how much warp and weft are, at the end [-], shape [2].
        end: why it ends where it does.
        states: cells at rest, one an angle.
    """

    angles: np.ndarray
    elastic: np.ndarray
    friction: np.ndarray
    skew: float
    strains: np.ndarray
    locking: float | None
    touching: float | None
    narrower: np.ndarray
    end: str
    states: tuple[Equilibrium, ...]

    @property
    def couples(self) -> np.ndarray:
        """C_s [N·m per cell], elastic and friction together, shape [n]."""
        return self.elastic + self.friction


def strain_axes(model: Model, loads: Loads) -> tuple[np.ndarray, np.ndarray]:
    """Strains of a table: from as far as crimp lets the ply shrink to the largest, 0 among them."""
    crimps = model.cell.crimps
    largest = loads.largest_strain
    if largest is None:
        largest = max(crimps) + PAST_CRIMP
    step = float(f"{largest / (loads.points - 1):.3g}")  # a card's digits keep it even
    axes = []
    for crimp in crimps:
        below = min(math.ceil(crimp / step), loads.points - 1)
        axes.append(step * np.arange(-below, loads.points))
    return axes[0], axes[1]


def pull(model: Model, loads: Loads, say: Callable[[float], None] = lambda _: None) -> TensionTable:
    """Tensions over both strains.

    Args:
        model: the cell.
        loads: what is done to it.
        say: told the share that is done.

    Raises:
        RunFailed: no rest is found.
    """
    warp, weft = strain_axes(model, loads)
    tensions = np.zeros((2, len(warp), len(weft)))
    squeeze = strain = 0.0
    for i, first in enumerate(warp):
        start = None  # along a row each begins where the last came to rest
        for j, second in enumerate(weft):
            found = settle(model, np.array([first, second, 0.0]), start)
            start, tensions[:, i, j] = found, found.tension
            squeeze = max(squeeze, found.squeeze)
            strain = max(strain, *found.yarn_strain)
        say((i + 1) / len(warp))
    return TensionTable((warp, weft), tensions, squeeze, strain)


def shear_angles(model: Model, loads: Loads) -> np.ndarray:
    """Angles of a shear curve [rad]: fine where friction builds up, then even."""
    end = loads.largest_angle
    if end is None:
        end = min(model.cell.locking + PAST_LOCKING, STEEPEST)
    first = model.cell.sticking_angle * np.array(FINE)
    even = np.linspace(0.0, end, max(FEWEST_ANGLES, math.ceil(end / ANGLE_STEP)) + 1)
    return np.unique(np.concatenate([first[first < end], even[even > 1.2 * first[-1]], [0.0]]))


def shear(
    model: Model,
    loads: Loads,
    say: Callable[[float], None] = lambda _: None,
) -> ShearCurve:
    """The couple over the shear angle, both ways.

    Args:
        model: the cell.
        loads: what is done to it.
        say: told the share that is done.

    Raises:
        RunFailed: no rest is found before the curve is worth anything.
    """
    angles = shear_angles(model, loads)
    both: list[tuple[Equilibrium, Equilibrium]] = []
    end = "as asked for" if loads.largest_angle is not None else "a little past locking"
    strain = np.zeros(2)
    starts: tuple[Equilibrium | None, Equilibrium | None] = (None, None)
    for number, angle in enumerate(angles):
        try:
            ahead, back = (
                settle(model, np.array([*strain, way * angle]), start, loads.shear_tension)
                for way, start in zip((1.0, -1.0), starts, strict=True)
            )
        except RunFailed as error:
            if number < FEWEST_ANGLES:
                raise
            end = f"beyond it no rest was found ({error})"
            break
        both.append((ahead, back))
        strain, starts = ahead.strain[:2], (ahead, back)
        say((number + 1) / len(angles))
    return _curve(model, angles[: len(both)], both, end)


def _overlap(model: Model, at: Equilibrium, woven: bool) -> float:
    """By how much neighbours overlap, over their width now or as woven [-]; below 0 a gap."""
    widths = model.cell.width if woven else (width(model, 0, at.strain), width(model, 1, at.strain))
    return max(1.0 - float(distance(model, k, at.strain)) / float(widths[k]) for k in (0, 1))


def _curve(model: Model, angles: np.ndarray, both: list, end: str) -> ShearCurve:
    ahead, back = (np.array([pair[k].couple for pair in both]) for k in (0, 1))
    elastic = 0.5 * (ahead - back)
    sliding = np.array([0.5 * (one.friction + other.friction) for one, other in both])
    friction = sliding * -np.expm1(-angles / model.cell.sticking_angle)
    largest = max(float(np.max(elastic + friction)), 1e-300)
    return ShearCurve(
        angles,
        elastic,
        friction,
        float(np.abs(ahead - elastic).max()) / largest,
        np.array([pair[0].strain[:2] for pair in both]),
        _closing(angles, np.array([_overlap(model, pair[0], woven=True) for pair in both])),
        _closing(angles, np.array([_overlap(model, pair[0], woven=False) for pair in both])),
        both[-1][0].strain[3:],
        end,
        tuple(pair[0] for pair in both),
    )


def _closing(angles: np.ndarray, overlaps: np.ndarray) -> float | None:
    """Angle at which a gap is gone [rad], in a line between two; None where it is not."""
    if overlaps[-1] <= 0.0:
        return None
    first = int(np.argmax(overlaps > 0.0))
    if first == 0:
        return None
    return float(np.interp(0.0, overlaps[first - 1 : first + 1], angles[first - 1 : first + 1]))
