"""Bending from cantilevers and Kawabata's loops: stiffness, or a curve with friction."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.optimize import minimize_scalar

from warpdrape.calibration.bands import Band, bootstrap
from warpdrape.calibration.hysteresis import friction_history, loop_width
from warpdrape.calibration.monotone import LeastSquares, RisingBasis
from warpdrape.calibration.raw_table import Specimen
from warpdrape.calibration.tests_file import Test
from warpdrape.coupons.closed_forms import flexural_length
from warpdrape.errors import InputError
from warpdrape.materials.bending import from_flexural_length

ASTM_ANGLE = np.radians(41.5)
"""At which a strip's tip lies below its edge where a test says no angle [rad]."""
SLOPE_BETWEEN = (50.0, 150.0)
"""Curvatures between which Kawabata takes B [1/m]."""
WIDTH_AT = 100.0
"""Curvature at which he takes 2HB [1/m]."""
INTERVALS = 8
"""Of a moment's curve."""
BUILDS_UP = np.geomspace(0.01, 1.0, 16)
"""Curvatures over which friction may build up, over the largest of the loop."""
POINTS = 13
"""Of a curve on a card."""


@dataclass(frozen=True, eq=False)
class StiffnessFit:
    """Bending stiffness of one family from cantilevers.

    Attributes:
        family: of the yarns along the strip.
        stiffness: B [N·m].
        readings: test → B of each of its specimens [N·m].
    """

    family: str
    stiffness: Band
    readings: Mapping[str, np.ndarray]


def fit_cantilever(tests: Sequence[Test], areal_density: float, draws: int = 400) -> StiffnessFit:
    """B = w c³ of a family's strips, c by the elastica from overhang and angle.

    A table of one specimen is taken as readings of as many strips as it has rows.

    Args:
        tests: cantilevers of one family.
        areal_density: [kg/m²].
        draws: of the bootstrap.
    """
    found: dict[str, np.ndarray] = {}
    each: list[float] = []
    for test in tests:
        per_specimen = [_readings(test, s, areal_density) for s in test.specimens]
        if len(per_specimen) == 1:
            readings = list(per_specimen[0])
            each += [test.specimens[0].weight] * len(readings)
        else:
            readings = [float(np.mean(own)) for own in per_specimen]
            each += [specimen.weight for specimen in test.specimens]
        found[test.name] = np.array(readings)
    values = np.concatenate(list(found.values()))
    groups = [len(own) for own in found.values()]
    weights = np.array(each)
    band = bootstrap(groups, lambda c: c @ values / c.sum(), weights=weights, draws=draws)
    return StiffnessFit(tests[0].values["family"], band, found)


def _readings(test: Test, specimen: Specimen, areal_density: float) -> np.ndarray:
    overhang = specimen.columns["overhang"]
    angle = specimen.columns.get(
        "angle", np.full(len(overhang), test.values.get("angle", ASTM_ANGLE))
    )
    try:
        shares = [_length_over_overhang(round(float(a), 5)) for a in angle]
    except InputError as error:
        raise InputError(f"{specimen.file}: {specimen.name}: {error}") from error
    if (overhang <= 0.0).any():
        raise InputError(f"{specimen.file}: {specimen.name} has an overhang that is not above zero")
    return np.array(
        [from_flexural_length(s * o, areal_density) for s, o in zip(shares, overhang, strict=True)]
    )


@lru_cache(maxsize=1024)
def _length_over_overhang(angle: float) -> float:
    if abs(angle - ASTM_ANGLE) < 1e-4:
        return 0.5
    return flexural_length(1.0, angle)


@dataclass(frozen=True, eq=False)
class LoopFit:
    """A curve of moment with friction, of one family.

    Attributes:
        family: of the yarns that bend.
        curvatures: of the table, from 0 [1/m], shape [n].
        moments: without friction [N], shape [n].
        friction: M_y [N].
        over: curvature over which friction builds up [1/m].
        stiffness: B as Kawabata takes it [N·m]; None where loops do not reach so far.
        width: 2HB as he takes it [N]; likewise.
        basis: of the curve.
        coefficients: of it [N].
    """

    family: str
    curvatures: np.ndarray
    moments: Band
    friction: Band
    over: float
    stiffness: Band | None
    width: Band | None
    basis: RisingBasis
    coefficients: np.ndarray

    def moment(self, at: np.ndarray) -> np.ndarray:
        """Moment along a record of curvatures, friction and all [N], shape [n]."""
        rows = self.basis.rows(np.abs(at)) * np.sign(at)[:, None]
        friction = float(self.friction.value[0])
        return rows @ self.coefficients + friction * friction_history(at, self.over)


def fit_loops(tests: Sequence[Test], draws: int = 400) -> LoopFit:
    """One curve M(κ) that does not fall, and Dahl's friction, for a family's loops.

    M = Σ a_k S_k(|κ|) sgn κ + M_y p: linear in a_k and M_y for each curvature over which friction
    builds up; that one by search, again for every draw of the bootstrap, on a grid there.
    """
    specimens = [s for test in tests for s in test.specimens]
    groups = [len(test.specimens) for test in tests]
    end = float(np.median([np.abs(s.columns["curvature"]).max() for s in specimens]))
    if end <= 0.0:
        raise InputError(f"{specimens[0].file}: the loop has no curvature: check its columns")
    basis = RisingBasis(end, INTERVALS)
    largest = max(float(np.abs(s.columns["moment"]).max()) for s in specimens)
    if largest <= 0.0:
        raise InputError(f"{specimens[0].file}: the loop has no moment: check its columns")
    grid = [_squares(specimens, basis, largest, share * end) for share in BUILDS_UP]
    weights = np.array([s.weight for s in specimens])
    best = int(np.argmin([g.misfit(weights, g.fit(weights)) for g in grid]))

    def miss(logarithm: float) -> float:
        squares = _squares(specimens, basis, largest, np.exp(logarithm) * end)
        return squares.misfit(weights, squares.fit(weights))

    bracket = BUILDS_UP[max(best - 1, 0)], BUILDS_UP[min(best + 1, len(BUILDS_UP) - 1)]
    found = minimize_scalar(miss, bounds=np.log(bracket), method="bounded", options={"xatol": 1e-3})
    over = float(np.exp(found.x)) * end
    final = _squares(specimens, basis, largest, over)
    curvatures = np.linspace(0.0, end, POINTS)
    wanted = np.zeros((POINTS + 1, basis.size + 1))
    wanted[:-1, :-1] = basis.rows(curvatures)
    wanted[-1, -1] = 1.0  # the friction, after the moments
    near = grid[max(best - 2, 0) : best + 3]

    def solve(counts: np.ndarray) -> np.ndarray:
        if (counts == weights).all():
            return wanted @ final.fit(weights)
        fits = [g.fit(counts) for g in near]
        off = [g.misfit(counts, c) for g, c in zip(near, fits, strict=True)]
        return wanted @ fits[int(np.argmin(off))]

    band = bootstrap(groups, solve, weights=weights, draws=draws)
    widths = [loop_width(s, "curvature", "moment", WIDTH_AT) for s in specimens]
    return LoopFit(
        tests[0].values["family"],
        curvatures,
        band.part(slice(0, POINTS)),
        band.part([POINTS]),
        over,
        _of_each(groups, [_slope(s) for s in specimens], weights, draws),
        _of_each(groups, widths, weights, draws),
        basis,
        final.fit(weights)[:-1],
    )


def _squares(
    specimens: Sequence[Specimen], basis: RisingBasis, largest: float, over: float
) -> LeastSquares:
    parts = []
    for specimen in specimens:
        at, moment = specimen.columns["curvature"], specimen.columns["moment"]
        rows = basis.rows(np.abs(at)) * np.sign(at)[:, None]
        rows = np.column_stack([rows, friction_history(at, over)])
        parts.append((rows, moment, np.full(len(at), largest)))
    return LeastSquares.of(parts)


def _slope(specimen: Specimen) -> float | None:
    """B by Kawabata: mean slope of both ways out between two curvatures; None if not reached."""
    at, moment = specimen.columns["curvature"], specimen.columns["moment"]
    found = []
    for sign in (1.0, -1.0):
        led, answer = sign * at, sign * moment
        out = np.concatenate([[False], np.diff(led) > 0.0])
        part = out & (led >= SLOPE_BETWEEN[0]) & (led <= SLOPE_BETWEEN[1])
        if part.sum() >= 4 and np.ptp(led[part]) > 0.9 * (SLOPE_BETWEEN[1] - SLOPE_BETWEEN[0]):
            found.append(float(np.polyfit(led[part], answer[part], 1)[0]))
    return float(np.mean(found)) if found else None


def _of_each(
    groups: Sequence[int], values: Sequence[float | None], weights: np.ndarray, draws: int
) -> Band | None:
    """Mean of what specimens say with its band; None where one does not say it."""
    if any(value is None for value in values):
        return None
    array = np.array(values, dtype=float)
    return bootstrap(groups, lambda c: c @ array / c.sum(), weights=weights, draws=draws)
