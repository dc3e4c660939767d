"""The shear law from picture frames, bias extension and Kawabata's shear, with their bands."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from warpdrape.calibration.bands import Band, bootstrap
from warpdrape.calibration.hysteresis import first_loading
from warpdrape.calibration.locking import STEEPER, locking_angle
from warpdrape.calibration.monotone import (
    INTERVALS,
    LeastSquares,
    RisingBasis,
    errors_expected,
)
from warpdrape.calibration.normalisation import ROWS, couple_by_steps
from warpdrape.calibration.preparation import in_bins, loading_curve
from warpdrape.calibration.tests_file import Test
from warpdrape.errors import InputError

STEP = math.radians(2.5)
"""Between the angles of a table, at most."""
START = 0.05
"""Share of the data's range below which a couple says nothing of an offset [-]."""
FINE = 181
"""Angles on which a locking angle is sought."""
NARROW = math.radians(4.0)
"""Least width of an interval between knots: a curve to 8° has two."""


@dataclass(frozen=True)
class ShearSpecimen:
    """What one specimen says of the couple per area: ``said`` = C(γ) + ``share`` C(γ/2).

    Attributes:
        test: name of its test.
        kind: of it.
        name: of the specimen.
        weight: in a fit of several tests [-].
        angle: γ, rising [rad], shape [n].
        said: [N/m], shape [n].
        share: [-], shape [n].
        steps: what was done to its record.
    """

    test: str
    kind: str
    name: str
    weight: float
    angle: np.ndarray
    said: np.ndarray
    share: np.ndarray
    steps: tuple[str, ...] = ()

    @property
    def couple(self) -> np.ndarray:
        """C(γ) [N/m] by the published steps, from this specimen alone, shape [n]."""
        return couple_by_steps(self.angle, self.said, self.share)


@dataclass(frozen=True, eq=False)
class ShearFit:
    """A couple per area C(γ) [N/m] that starts at nothing and does not fall.

    Attributes:
        basis: its functions.
        coefficients: of them [N/m].
        angles: of the table, from 0 [rad], shape [n].
        band: C there [N/m].
        offset: couple at 0° that the tests show, not in the curve unless kept [N/m].
        kept: whether the tests' offset was left in what was fitted.
        locking: angle [rad]; None where the curve does not lock.
        specimens: what was fitted.
    """

    basis: RisingBasis
    coefficients: np.ndarray
    angles: np.ndarray
    band: Band
    offset: Band
    kept: bool
    locking: Band | None
    specimens: tuple[ShearSpecimen, ...] = field(repr=False)

    def couple(self, angle: np.ndarray) -> np.ndarray:
        """C [N/m] within the data; beyond their end its last value (nothing is known there)."""
        return self.basis.rows(np.asarray(angle)) @ self.coefficients


def shear_specimens(test: Test) -> list[ShearSpecimen]:
    """A test's specimens, normalised.

    Raises:
        InputError: for a record that cannot be used.
    """
    found = []
    for specimen in test.specimens:
        if test.kind == "shear_loop":
            at, value = first_loading(specimen, "angle", "line_force")
            at, value = in_bins(at, value)
            steps: tuple[str, ...] = ("first loading of the loop",)
        else:
            curve = loading_curve(test, specimen)
            at, value, steps = curve.at, curve.force, curve.steps
        said, share = ROWS[test.kind](test.values, at, value)
        found.append(
            ShearSpecimen(
                test.name, test.kind, specimen.name, specimen.weight, at, said, share, steps
            )
        )
    return found


def fit_shear(
    specimens: Sequence[ShearSpecimen], *, keep_offset: bool = True, draws: int = 400
) -> ShearFit:
    """Fit one curve to specimens of any kinds together.

    The data end where half of the specimens of the test that goes farthest end.

    Args:
        specimens: of one or more tests, those of a test together.
        keep_offset: leave the couple that tests show at 0° in the curve, as its first rise.
        draws: of the bootstrap.
    """
    tests = {s.test for s in specimens}
    ends = {t: [s.angle[-1] for s in specimens if s.test == t] for t in tests}
    end = float(max(np.median(each) for each in ends.values()))
    intervals = int(np.clip(end / NARROW, 2, INTERVALS))
    basis = RisingBasis(end, intervals)
    groups = group_sizes(specimens)
    weights = np.array([s.weight for s in specimens])
    offset_fit = _squares([_past_start(s, basis.end) for s in specimens], basis, weights, True)
    squares = _squares(specimens, basis, weights, False)
    angles = np.linspace(0.0, end, max(4, math.ceil(end / STEP - 1e-9) + 1))
    at = basis.rows(angles)
    fine = np.linspace(0.0, end, FINE)
    at_fine = basis.rows(fine)

    def solve(counts: np.ndarray) -> np.ndarray:
        return squares.fit(counts) if keep_offset else offset_fit.fit(counts)[:-1]

    coefficients = solve(weights)
    band = bootstrap(groups, lambda c: at @ solve(c), weights=weights, draws=draws)
    offset = bootstrap(groups, lambda c: offset_fit.fit(c)[-1:], weights=weights, draws=draws)
    locking = None
    if locking_angle(fine, at_fine @ coefficients)[1] >= STEEPER:
        locking = bootstrap(
            groups,
            lambda c: np.array([locking_angle(fine, at_fine @ solve(c))[0]]),
            weights=weights,
            draws=draws,
        )
    return ShearFit(
        basis, coefficients, angles, band, offset, keep_offset, locking, tuple(specimens)
    )


def alone(specimen: ShearSpecimen) -> ShearSpecimen:
    """A specimen that says C(γ) itself, C(γ/2) by a curve of its own taken off.

    Kinds of test that disagree cannot share one C(γ/2): what is too much at an angle would be made
    up for at twice the angle, and so on.
    """
    if not specimen.share.any():
        return specimen
    end = float(specimen.angle[-1])
    basis = RisingBasis(end, int(np.clip(end / NARROW, 2, INTERVALS)))
    fit = _squares([specimen], basis, np.ones(1), True).fit(np.ones(1))
    half = np.column_stack([basis.rows(specimen.angle / 2), np.ones(len(specimen.angle))]) @ fit
    couple = specimen.said - specimen.share * half
    return replace(specimen, said=couple, share=np.zeros_like(specimen.share))


def _past_start(specimen: ShearSpecimen, end: float) -> ShearSpecimen:
    """Without the first rise, which an offset is extrapolated over."""
    kept = specimen.angle >= START * end
    cut = {name: getattr(specimen, name)[kept] for name in ("angle", "said", "share")}
    return replace(specimen, **cut)


def group_sizes(specimens: Sequence[ShearSpecimen]) -> list[int]:
    """Number of specimens of each test, in order."""
    names = [s.test for s in specimens]
    return [names.count(name) for name in dict.fromkeys(names)]


def _rows(basis: RisingBasis, specimen: ShearSpecimen, offset: bool) -> np.ndarray:
    """Rows of C(γ) + share C(γ/2), and of an offset of C, shape [n, size]; within the data."""
    inside = specimen.angle <= basis.end * (1.0 + 1e-9)
    angle, share = specimen.angle[inside], specimen.share[inside]
    rows = basis.rows(angle) + share[:, None] * basis.rows(angle / 2)
    return np.column_stack([rows, 1.0 + share]) if offset else rows


def _squares(
    specimens: Sequence[ShearSpecimen], basis: RisingBasis, weights: np.ndarray, offset: bool
) -> LeastSquares:
    """Sums of squares whose errors are shares of a first fit with even ones."""
    rows = [_rows(basis, s, offset) for s in specimens]
    said = [s.said[: len(r)] for s, r in zip(specimens, rows, strict=True)]
    largest = max(float(np.abs(v).max(initial=0.0)) for v in said)
    if largest <= 0.0:
        raise InputError("the shear tests show no force at all: check columns and units")
    parts = [(r, v, np.full(len(v), largest)) for r, v in zip(rows, said, strict=True)]
    first = LeastSquares.of(parts).fit(weights)
    return LeastSquares.of(
        [(r, v, errors_expected(r @ first, largest)) for r, v in zip(rows, said, strict=True)]
    )


@dataclass(frozen=True)
class Disagreement:
    """How two kinds of test differ where both have data.

    Attributes:
        kinds: the two.
        angles: [rad], shape [n].
        ratio: C of the second over that of the first [-], shape [n].
        apart: whether their bands do not even touch, shape [n].
    """

    kinds: tuple[str, str]
    angles: np.ndarray
    ratio: np.ndarray
    apart: np.ndarray

    def words(self) -> str:
        """In a sentence."""
        worst = int(np.argmax(np.abs(np.log(np.maximum(self.ratio, 1e-9)))))
        first, second = (kind.replace("_", " ") for kind in self.kinds)
        said = (
            f"{second} over {first}: between {self.ratio.min():.3g} and {self.ratio.max():.3g} "
            f"(farthest off at {math.degrees(self.angles[worst]):.0f}°)"
        )
        if not self.apart.any():
            return said + "; their bands meet everywhere"
        where = np.degrees(self.angles[self.apart])
        return said + f"; their bands do not meet at {where.min():.0f}° to {where.max():.0f}°"


def disagreements(fits: dict[str, ShearFit]) -> list[Disagreement]:
    """Compare separate fits of kinds of test, two at a time.

    Args:
        fits: kind of test → the fit of its specimens alone.
    """
    found = []
    kinds = list(fits)
    for i, first in enumerate(kinds):
        for second in kinds[i + 1 :]:
            one, two = fits[first], fits[second]
            end = min(one.basis.end, two.basis.end)
            angles = np.linspace(0.1 * end, end, 19)
            a, b = one.couple(angles), two.couple(angles)
            wide = [
                (np.interp(angles, f.angles, f.band.low), np.interp(angles, f.angles, f.band.high))
                for f in (one, two)
            ]
            apart = (wide[0][0] > wide[1][1]) | (wide[1][0] > wide[0][1])
            ratio = b / np.maximum(a, 1e-12 * max(float(a.max()), 1e-300))
            found.append(Disagreement((first, second), angles, ratio, apart))
    return found
