"""Yarn tension from strips: a stiffness past the crimp, or crimp interchange with biaxial tests."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from warpdrape.calibration.bands import Band, bootstrap
from warpdrape.calibration.kinds import FAMILIES
from warpdrape.calibration.preparation import LoadingCurve
from warpdrape.errors import InputError

STEEP_PART = 0.5
"""Force from which on a strip's line is fitted, over its largest: yarns are straight there [-]."""


@dataclass(frozen=True)
class YarnCurve:
    """One strip: the tension of one yarn against strain, the other family free.

    Attributes:
        test: name of the test.
        family: of the yarns pulled.
        name: of the specimen.
        strain: [-], rising, shape [n].
        tension: [N per yarn], shape [n].
        failed_at: strain of failure [-]; None where it did not fail.
        weight: in a fit with other specimens [-].
    """

    test: str
    family: str
    name: str
    strain: np.ndarray
    tension: np.ndarray
    failed_at: float | None = None
    weight: float = 1.0


def yarn_curve(
    test: str, family: str, curve: LoadingCurve, width: float, spacing: float
) -> YarnCurve:
    """Tension per yarn of a strip.

    Args:
        test: name of the test.
        family: pulled.
        curve: force over strain.
        width: of the strip [m].
        spacing: width of sheet that one yarn carries [m].
    """
    tension = curve.force * spacing / width
    return YarnCurve(test, family, curve.name, curve.at, tension, curve.failed_at, curve.weight)


@dataclass(frozen=True, eq=False)
class LinearFit:
    """T = K (ε − ε0) of one family, on the steep part.

    Attributes:
        family: of the yarns.
        stiffness: K [N per unit strain].
        start: ε0, where the line meets no tension: crimp, and slack that was not taken off [-].
        end: largest strain of the data [-].
    """

    family: str
    stiffness: Band
    start: Band
    end: float


def fit_linear(curves: Sequence[YarnCurve], draws: int = 400) -> LinearFit:
    """One stiffness for the strips of a family: the mean of their lines, with its band.

    Raises:
        InputError: a strip does not rise.
    """
    lines = np.array([_line(curve) for curve in curves])
    groups = _groups(curves)

    def mean(counts: np.ndarray) -> np.ndarray:
        return counts @ lines / counts.sum()

    both = bootstrap(groups, mean, weights=_weights(curves), draws=draws)
    end = float(np.median([c.strain[-1] for c in curves]))
    return LinearFit(curves[0].family, both.part([0]), both.part([1]), end)


def fit_failure(curves: Sequence[YarnCurve], draws: int = 400) -> Band | None:
    """Mean strain at the largest force of strips that failed; None where fewer than half did."""
    broken = [c for c in curves if c.failed_at is not None]
    if 2 * len(broken) < len(curves) or not broken:
        return None
    failed, weights = np.array([c.failed_at for c in broken]), _weights(broken)
    return bootstrap([len(failed)], lambda c: c @ failed / c.sum(), weights=weights, draws=draws)


def _line(curve: YarnCurve) -> tuple[float, float]:
    steep = curve.tension >= STEEP_PART * curve.tension.max()
    if steep.sum() < 4:
        raise InputError(f"{curve.name}: fewer than four points above half of its force: no line")
    slope, level = np.polyfit(curve.strain[steep], curve.tension[steep], 1)
    if slope <= 0.0:
        raise InputError(f"{curve.name}: its tension does not rise with strain: check the columns")
    return float(slope), float(-level / slope)


def _weights(specimens: Sequence[YarnCurve | BiaxialPoints]) -> np.ndarray:
    return np.array([specimen.weight for specimen in specimens])


def _groups(curves: Sequence[YarnCurve]) -> list[int]:
    names = [c.test for c in curves]
    return [names.count(name) for name in dict.fromkeys(names)]


@dataclass(frozen=True)
class BiaxialPoints:
    """One biaxial specimen.

    Attributes:
        test: name of the test.
        name: of the specimen.
        strains: (ε1, ε2) [-], shape [n, 2].
        tensions: (T1, T2) [N per yarn], shape [n, 2].
        weight: in a fit with other specimens [-].
    """

    test: str
    name: str
    strains: np.ndarray
    tensions: np.ndarray
    weight: float = 1.0


def crimp_tensions_of(
    parameters: np.ndarray, spacing: np.ndarray, strains: np.ndarray
) -> np.ndarray:
    """(T1, T2) [N per yarn] of the crimp-interchange law for many strains at once.

    The law of `materials.laws.CrimpInterchange`; the height h1 of the warp by bisection on the
    balance of vertical forces, which falls with the weft's height and rises with the warp's.

    Args:
        parameters: crimp of warp and weft [-], EA of warp and weft [N].
        spacing: cell lengths along warp and weft [m].
        strains: shape [n, 2].
    """
    crimp, stiffness = parameters[:2], parameters[2:]
    rest = spacing * (1.0 + crimp)
    total = float(np.sum(spacing * np.sqrt(crimp * (2.0 + crimp))))
    across = spacing * (1.0 + strains)

    def pulls(first: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        heights = np.stack([first, total - first], axis=1)
        lengths = np.hypot(across, heights)
        pull = np.maximum(stiffness * (lengths / rest - 1.0), 0.0)
        return pull * heights / lengths, pull * across / lengths

    low, high = np.zeros(len(strains)), np.full(len(strains), total)
    for _ in range(50):
        middle = 0.5 * (low + high)
        up, down = pulls(middle)[0].T
        rising = up > down
        high, low = np.where(rising, middle, high), np.where(rising, low, middle)
    return pulls(0.5 * (low + high))[1]


def free_strip(parameters: np.ndarray, family: int, strain: np.ndarray) -> np.ndarray:
    """Tension [N per yarn] of a strip whose other family is free: none until its crimp is gone."""
    crimp, stiffness = parameters[family], parameters[2 + family]
    return np.maximum(stiffness * ((1.0 + strain) / (1.0 + crimp) - 1.0), 0.0)


def fit_crimp(
    strips: Sequence[YarnCurve],
    biaxial: Sequence[BiaxialPoints],
    spacing: np.ndarray,
    draws: int = 60,
) -> Band:
    """Crimps and yarn stiffnesses (crimp 1, 2 [-], EA 1, 2 [N]) from strips and biaxial tests.

    Args:
        strips: uniaxial; may be none.
        biaxial: at least one specimen.
        spacing: cell lengths along warp and weft [m].
        draws: of the bootstrap; each is a fit of its own.
    """
    largest = max(float(np.abs(b.tensions).max()) for b in biaxial)
    start = np.array([0.005, 0.005, *_first_stiffness(strips, biaxial)])
    names = [b.test for b in biaxial]
    groups = [names.count(n) for n in dict.fromkeys(names)] + _groups(strips)

    def misses(parameters: np.ndarray, counts: np.ndarray) -> np.ndarray:
        found = []
        for count, b in zip(counts, biaxial, strict=False):
            if count:
                off = crimp_tensions_of(parameters, spacing, b.strains) - b.tensions
                found.append(np.sqrt(count / off.size) * off.ravel() / largest)
        for count, c in zip(counts[len(biaxial) :], strips, strict=True):
            if count:
                off = free_strip(parameters, FAMILIES.index(c.family), c.strain) - c.tension
                found.append(np.sqrt(count / off.size) * off / largest)
        return np.concatenate(found)

    def solve(counts: np.ndarray, begin: np.ndarray) -> np.ndarray:
        return (
            least_squares(
                lambda p: misses(p * start, counts),
                begin / start,
                bounds=([1e-4, 1e-4, 1e-3, 1e-3], [60.0, 60.0, 1e3, 1e3]),
                x_scale=1.0,
                diff_step=1e-5,
            ).x
            * start
        )

    weights = _weights([*biaxial, *strips])
    best = solve(weights, start)
    return bootstrap(groups, lambda counts: solve(counts, best), weights=weights, draws=draws)


def _first_stiffness(strips: Sequence[YarnCurve], biaxial: Sequence[BiaxialPoints]) -> list[float]:
    """A beginning for EA: the steepest chord of each family."""
    found = []
    for family in range(2):
        chords = [
            b.tensions[:, family].max() / max(float(b.strains[:, family].max()), 1e-4)
            for b in biaxial
        ]
        found.append(max(max(chords), 1e-6))
    return found
