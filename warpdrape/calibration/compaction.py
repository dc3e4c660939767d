"""Thickness under pressure: a table that rises, or a power law of the fibre volume fraction."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from warpdrape.calibration.bands import Band, bootstrap
from warpdrape.calibration.monotone import LeastSquares, RisingBasis
from warpdrape.calibration.preparation import FEWEST, in_bins
from warpdrape.calibration.tests_file import Test
from warpdrape.errors import InputError

LEVELS = 14
"""Points of a table."""
INTERVALS = 6
"""Of the curve of thickness over the pressure's logarithm."""


@dataclass(frozen=True, eq=False)
class Pressed:
    """One specimen's thickness per ply while the pressure rose.

    Attributes:
        test: name of the test.
        name: of the specimen.
        pressure: rising [Pa], shape [n].
        thickness: of one ply [m], shape [n].
        weight: in a fit with other specimens [-].
    """

    test: str
    name: str
    pressure: np.ndarray
    thickness: np.ndarray
    weight: float = 1.0


def pressed(test: Test) -> list[Pressed]:
    """Specimens of a test: pressure, per ply, machine taken off, while it rises.

    Raises:
        InputError: too few rows are left, or a thickness is not above zero.
    """
    found = []
    plies = test.values.get("plies", 1.0)
    for specimen in test.specimens:
        thickness = np.array(specimen.columns["thickness"])
        area = test.values.get("area")
        if "pressure" in specimen.columns:
            pressure = np.array(specimen.columns["pressure"])
        else:
            pressure = np.abs(specimen.columns["force"]) / area
        if "compliance" in test.values:
            if area is None:
                raise InputError(f"tests.{test.name}: compliance needs the plates' area: give it")
            thickness = thickness + test.values["compliance"] * pressure * area
        thickness = thickness / plies
        top = int(np.argmax(pressure))
        thickness, pressure = thickness[: top + 1], pressure[: top + 1]
        before = np.concatenate([[0.0], np.maximum.accumulate(pressure)[:-1]])
        kept = (pressure > before) & (pressure > 0.0)
        if kept.sum() < FEWEST:
            raise InputError(
                f"{specimen.file}: {specimen.name} has {int(kept.sum())} rows of rising pressure, "
                f"fewer than {FEWEST}: check its columns"
            )
        if (thickness[kept] <= 0.0).any():
            raise InputError(
                f"{specimen.file}: {specimen.name} has a thickness that is not above zero: check "
                "the zero of the gap"
            )
        logs, means = in_bins(np.log(pressure[kept]), thickness[kept])
        found.append(Pressed(test.name, specimen.name, np.exp(logs), means, specimen.weight))
    return found


@dataclass(frozen=True, eq=False)
class CompactionFit:
    """Thickness over pressure, falling.

    Attributes:
        pressures: as measured, from the pressure of contact on [Pa], shape [n].
        thickness: there [m].
        coefficient: a of V_f = a p^b [-]; None without a fibre density.
        exponent: b [-].
        specimens: what was fitted.
    """

    pressures: np.ndarray
    thickness: Band
    coefficient: Band | None
    exponent: Band | None
    specimens: tuple[Pressed, ...]

    @property
    def table(self) -> tuple[np.ndarray, np.ndarray]:
        """Thicknesses [m], falling, and pressures above that of contact [Pa], rising."""
        falls = np.concatenate([[True], np.diff(np.minimum.accumulate(self.thickness.value)) < 0.0])
        return self.thickness.value[falls], self.pressures[falls] - self.pressures[0]


def fit_compaction(
    specimens: Sequence[Pressed],
    *,
    contact_pressure: float | None,
    solid: float | None,
    draws: int = 400,
) -> CompactionFit:
    """Fit t = t₀ − Σ a_k S_k(ln p/p₀), a_k ≥ 0, and the power law.

    Args:
        specimens: of one or more tests, those of a test together.
        contact_pressure: p₀, at which the ply has its own thickness [Pa]; the lowest at which all
            specimens have data if None.
        solid: thickness of the fibres alone [m], for the power law; None without.
        draws: of the bootstrap.
    """
    lowest = max(float(s.pressure[0]) for s in specimens)
    start = lowest if contact_pressure is None else contact_pressure
    end = float(np.median([s.pressure[-1] for s in specimens]))
    if not lowest <= start * (1.0 + 1e-9) < end:
        raise InputError(
            f"contact_pressure = {start:.4g} Pa must lie within the data, {lowest:.4g} to "
            f"{end:.4g} Pa"
        )
    basis = RisingBasis(float(np.log(end / start)), INTERVALS)
    parts, logs = [], []
    for s in specimens:
        inside = (s.pressure >= start * (1.0 - 1e-9)) & (s.pressure <= end * (1.0 + 1e-9))
        if inside.sum() < 3:
            raise InputError(f"{s.name} has fewer than three points between the pressures of all")
        rows = basis.rows(np.log(s.pressure[inside] / start))
        rows = np.column_stack([np.ones(len(rows)), -rows])
        parts.append((rows, s.thickness[inside], s.thickness[inside]))
        logs.append((np.log(s.pressure[inside]), np.log(s.thickness[inside])))
    squares = LeastSquares.of(parts)
    names = [s.test for s in specimens]
    groups = [names.count(n) for n in dict.fromkeys(names)]
    pressures = np.geomspace(start, end, LEVELS)
    at = basis.rows(np.log(pressures / start))
    at = np.column_stack([np.ones(LEVELS), -at])
    weights = np.array([s.weight for s in specimens])
    thickness = bootstrap(groups, lambda c: at @ squares.fit(c), weights=weights, draws=draws)
    coefficient = exponent = None
    if solid is not None:
        fits = np.array([np.polyfit(p, np.log(solid) - t, 1) for p, t in logs])
        both = bootstrap(
            groups, lambda c: c @ fits / c.sum(), weights=weights, draws=draws, positive=False
        )
        exponent = both.part([0])
        value, low, high = (np.exp(v[1:]) for v in (both.value, both.low, both.high))
        coefficient = Band(value, low, high, both.specimens, both.told)
    return CompactionFit(pressures, thickness, coefficient, exponent, tuple(specimens))
