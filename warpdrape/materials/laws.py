"""The laws of a fabric: yarn tension, shear couple, isotropic membrane. Values per yarn and cell.

Each is a frozen, validated record; `warpdrape.forces.membrane` turns it into what the kernels read.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from warpdrape.errors import InputError, finite, numbers, positive
from warpdrape.materials.rubber import MooneyRivlin
from warpdrape.wording import brief


@dataclass(frozen=True)
class LinearTension:
    """T1 = warp · ε1, T2 = weft · ε2.

    Attributes:
        warp: stiffness of a warp yarn [N per unit strain].
        weft: stiffness of a weft yarn [N per unit strain].
    """

    warp: float
    weft: float

    __repr__ = brief

    def __post_init__(self) -> None:
        positive("warp yarn stiffness", self.warp, unit="N")
        positive("weft yarn stiffness", self.weft, unit="N")


@dataclass(frozen=True, eq=False)
class TabulatedTension:
    """Biaxial tension surface T1(ε1, ε2), T2(ε1, ε2), read off a regular grid.

    A cubic-spline *energy* is fitted, so that the tensions are smooth and come from a potential;
    `warpdrape.materials.spline.fit_energy` says how far the table is from having one.

    Attributes:
        strain_warp: ε1 of the rows [-], evenly spaced, rising, shape [n].
        strain_weft: ε2 of the columns [-], evenly spaced, rising, shape [m].
        tension_warp: T1 [N per yarn], shape [n, m].
        tension_weft: T2 [N per yarn], shape [n, m].
    """

    strain_warp: Sequence[float]
    strain_weft: Sequence[float]
    tension_warp: Sequence[Sequence[float]]
    tension_weft: Sequence[Sequence[float]]

    __repr__ = brief

    def __post_init__(self) -> None:
        for name in ("strain_warp", "strain_weft"):
            axis = numbers(name, getattr(self, name))
            if axis.ndim != 1 or axis.size < 4 or not np.isfinite(axis).all():
                raise InputError(f"{name} needs at least four finite strains")
            steps = np.diff(axis)
            if (steps <= 0).any():
                at = int(np.argmax(steps <= 0))
                raise InputError(
                    f"{name} must rise: {axis[at + 1]} follows {axis[at]}; sort the table"
                )
            if np.ptp(steps) > 1e-6 * steps.max():
                raise InputError(f"{name} must be evenly spaced: resample the table")
            if not axis[0] <= 0.0 < axis[-1]:
                raise InputError(
                    f"{name} runs from {axis[0]} to {axis[-1]} and must hold zero strain: "
                    "add the rows down to 0"
                )
            object.__setattr__(self, name, axis)
        shape = (len(self.strain_warp), len(self.strain_weft))
        for name in ("tension_warp", "tension_weft"):
            table = numbers(name, getattr(self, name))
            if table.shape != shape or not np.isfinite(table).all():
                raise InputError(f"{name} must hold finite tensions [N], shape {shape}")
            object.__setattr__(self, name, table)


@dataclass(frozen=True)
class CrimpInterchange:
    """Saw-tooth yarns that straighten each other, with the height h1 + h2 of the weave kept.

    T_i = t_i p_i (1 + ε_i)/L_i, t_i = EA_i (L_i/l_i − 1) while the yarn is taut, none while it is
    slack; L_i² = (p_i (1 + ε_i))² + h_i² and t1 h1/L1 = t2 h2/L2.

    Attributes:
        spacing_warp: length of a warp yarn's cell along it [m], the fabric's ``cell_warp``.
        spacing_weft: length of a weft yarn's cell along it [m], the fabric's ``cell_weft``.
        crimp_warp: a warp yarn's length over its cell's, less one [-].
        crimp_weft: the same of a weft yarn [-].
        stiffness_warp: EA of a straight warp yarn [N per unit strain].
        stiffness_weft: EA of a straight weft yarn [N per unit strain].
    """

    spacing_warp: float
    spacing_weft: float
    crimp_warp: float
    crimp_weft: float
    stiffness_warp: float
    stiffness_weft: float

    __repr__ = brief

    def __post_init__(self) -> None:
        for family in ("warp", "weft"):
            positive(f"spacing_{family}", getattr(self, f"spacing_{family}"), unit="m")
            positive(f"stiffness_{family}", getattr(self, f"stiffness_{family}"), unit="N")
            crimp = positive(f"crimp_{family}", getattr(self, f"crimp_{family}"), zero=True)
            if crimp > 0.5:
                raise InputError(
                    f"crimp_{family} = {crimp} is above 0.5: give a fraction, 0.004 for 0.4 %"
                )

    @property
    def lengths(self) -> tuple[float, float]:
        """Length of a warp, a weft yarn in one cell at rest [m]."""
        return self.spacing_warp * (1 + self.crimp_warp), self.spacing_weft * (1 + self.crimp_weft)

    @property
    def heights(self) -> tuple[float, float]:
        """Height that a warp, a weft yarn climbs in one cell at rest [m]: √(l² − p²)."""
        return (
            self.spacing_warp * math.sqrt(self.crimp_warp * (2 + self.crimp_warp)),
            self.spacing_weft * math.sqrt(self.crimp_weft * (2 + self.crimp_weft)),
        )


@dataclass(frozen=True)
class ShearPolynomial:
    """C_s = c0 γ + c1 γ³ + c2 γ⁵ + c3 γ⁷.

    Attributes:
        coefficients: c0, c1, … [N·m per cell, γ in rad], at most four.
    """

    coefficients: tuple[float, ...]

    __repr__ = brief

    def __post_init__(self) -> None:
        given = numbers("shear coefficients", self.coefficients)
        values = tuple(finite("shear coefficient", float(c), unit="N·m") for c in given.ravel())
        if not 1 <= len(values) <= 4:
            raise InputError(f"a shear polynomial has one to four odd terms, not {len(values)}")
        positive("first shear coefficient", values[0], unit="N·m")
        object.__setattr__(self, "coefficients", values)

    def couple(self, angle: ArrayLike) -> np.ndarray:
        """C_s [N·m] at shear angles [rad]."""
        angle = np.asarray(angle, dtype=float)
        terms = (c * angle ** (2 * i + 1) for i, c in enumerate(self.coefficients))
        return sum(terms, np.zeros_like(angle))

    def slope(self, angle: ArrayLike) -> np.ndarray:
        """dC_s/dγ [N·m/rad] at shear angles [rad]."""
        angle = np.asarray(angle, dtype=float)
        terms = ((2 * i + 1) * c * angle ** (2 * i) for i, c in enumerate(self.coefficients))
        return sum(terms, np.zeros_like(angle))


@dataclass(frozen=True, eq=False)
class ShearTable:
    """C_s through measured points, odd in γ, monotone between them, linear past the last.

    A couple that falls on its way is warned about where a `Fabric` takes it.

    Attributes:
        angles: shear angles [rad], rising from 0, below π/2, shape [n].
        couples: C_s [N·m per cell], none negative, the last not below its neighbour, shape [n].
    """

    angles: Sequence[float]
    couples: Sequence[float]

    __repr__ = brief

    def __post_init__(self) -> None:
        angles = numbers("shear table angles", self.angles)
        couples = numbers("shear table couples", self.couples)
        if angles.ndim != 1 or angles.size < 3 or couples.shape != angles.shape:
            raise InputError(
                f"a shear table needs three or more angles and as many couples, not {angles.size} "
                f"and {couples.size}; decimals take a point: 0,5 are two numbers, 0.5 is one"
            )
        if not (np.isfinite(angles).all() and np.isfinite(couples).all()):
            raise InputError("a shear table must hold finite numbers only")
        if angles[0] != 0.0 or couples[0] != 0.0:
            first = f"{math.degrees(angles[0]):.4g}° with {couples[0]:.4g} N·m"
            remedy = "put 0° with no couple before it"
            if angles[0] == 0.0:  # friction or weight of the frame, most likely
                remedy = "take that off all couples, or leave the point out and begin with 0, 0"
            raise InputError(f"a shear table starts at 0° with no couple, not at {first}: {remedy}")
        if (np.diff(angles) <= 0).any():
            at = int(np.argmax(np.diff(angles) <= 0))
            first, second = np.degrees(angles[at : at + 2])
            raise InputError(
                f"shear table angles must rise: {second:.4g}° follows {first:.4g}°; sort them"
            )
        if angles[-1] >= math.pi / 2:
            raise InputError(
                f"shear table angles must stay below 90°, where the yarns lie on each other, but "
                f"reach {np.degrees(angles[-1]):.4g}°: leave those out, or check their unit"
            )
        if (couples < 0).any():
            at = np.degrees(angles[np.argmax(couples < 0)])
            raise InputError(
                f"shear table couples must not be negative, but are at {at:.4g}°: check the signs"
            )
        if couples[-1] < couples[-2]:
            raise InputError(
                "shear table couples must not fall at the end, from where they go on in a line: "
                "leave the last points out"
            )
        object.__setattr__(self, "angles", angles)
        object.__setattr__(self, "couples", couples)

    @property
    def slopes(self) -> np.ndarray:
        """Monotone Hermite slopes [N·m/rad] at the knots (Fritsch–Carlson)."""
        from scipy.interpolate import PchipInterpolator

        return PchipInterpolator(self.angles, self.couples).derivative()(self.angles)

    def first_fall(self) -> np.ndarray:
        """The two angles [rad] between which a couple first falls; of one that does."""
        at = int(np.argmax(np.diff(self.couples) < 0.0))
        return np.asarray(self.angles)[at : at + 2]

    def couple(self, angle: ArrayLike) -> np.ndarray:
        """C_s [N·m] at shear angles [rad]."""
        from scipy.interpolate import PchipInterpolator

        size = np.abs(np.asarray(angle, dtype=float))
        inside = PchipInterpolator(self.angles, self.couples)(np.minimum(size, self.angles[-1]))
        beyond = np.maximum(size - self.angles[-1], 0.0)
        return np.sign(angle) * (inside + beyond * self.slopes[-1])

    def slope(self, angle: ArrayLike) -> np.ndarray:
        """dC_s/dγ [N·m/rad] at shear angles [rad]."""
        angle, step = np.asarray(angle, dtype=float), 1e-6
        return (self.couple(angle + step) - self.couple(angle - step)) / (2 * step)


@dataclass(frozen=True)
class NoShear:
    """A net of yarns that shears freely."""

    __repr__ = brief

    def couple(self, angle: ArrayLike) -> np.ndarray:
        """Zero [N·m] at any angle."""
        return np.zeros_like(np.asarray(angle, dtype=float))

    def slope(self, angle: ArrayLike) -> np.ndarray:
        """Zero [N·m/rad] at any angle."""
        return np.zeros_like(np.asarray(angle, dtype=float))


@dataclass(frozen=True)
class IsotropicMembrane:
    """An isotropic sheet in place of yarns (paper, Figure 3c).

    Attributes:
        stiffness: Young's modulus times thickness [N/m].
        poisson: Poisson's ratio [-].
    """

    stiffness: float
    poisson: float = 0.3

    __repr__ = brief

    def __post_init__(self) -> None:
        positive("membrane stiffness", self.stiffness, unit="N/m")
        if not -1.0 < finite("Poisson's ratio", self.poisson) < 0.5:
            raise InputError(f"Poisson's ratio = {self.poisson} must lie between -1 and 0.5")


TensionLaw = LinearTension | TabulatedTension | CrimpInterchange | IsotropicMembrane | MooneyRivlin
Unwoven = IsotropicMembrane | MooneyRivlin
"""Laws of sheets without yarns."""
ShearLaw = ShearPolynomial | ShearTable | NoShear


def falling_angle(shear: ShearLaw, up_to: float = math.radians(80)) -> float | None:
    """Shear angle [rad] where a couple begins to fall, None where it never does up to ``up_to``."""
    angles = np.linspace(0.0, up_to, 8001)
    falls = np.asarray(shear.slope(angles)) < 0.0
    return float(angles[np.argmax(falls)]) if falls.any() else None
