"""Laws of tension found again: crimp, tables, linear yarns, failure."""

from dataclasses import replace

import numpy as np
import pytest

from warpdrape.calibration.biaxial_table import fit_table
from warpdrape.calibration.predictions import Prediction
from warpdrape.calibration.tension import (
    BiaxialPoints,
    YarnCurve,
    crimp_tensions_of,
    fit_crimp,
    fit_failure,
    fit_linear,
    free_strip,
)
from warpdrape.coupons.closed_forms import (
    crimp_tensions,
)
from warpdrape.materials.laws import CrimpInterchange

LAW = CrimpInterchange(2e-3, 2.04e-3, 0.006, 0.010, 20e3, 19e3)
PARAMETERS = np.array([0.006, 0.010, 20e3, 19e3])
SPACING = np.array([2e-3, 2.04e-3])


def test_crimp_law_is_that_of_the_card():
    rng = np.random.default_rng(3)
    strains = rng.uniform(-0.002, 0.015, (40, 2))
    exact = np.array([crimp_tensions(LAW, *each) for each in strains])
    assert exact.max() > 100.0
    found = crimp_tensions_of(PARAMETERS, SPACING, strains)
    np.testing.assert_allclose(found, exact, rtol=1e-9, atol=1e-7)


def biaxial(ratios, factor=1.0):
    found = []
    for warp, weft in ratios:
        strains = np.linspace(0.0, 0.012, 25)[:, None] * np.array([warp, weft])
        tensions = np.array([crimp_tensions(LAW, *each) for each in strains])
        found.append(BiaxialPoints("b", f"{warp} {weft}", strains, factor * tensions))
    return found


def test_crimp_law_is_found_again():
    strain = np.linspace(0.0, 0.02, 60)
    pulled_strips = [
        YarnCurve(f"u{k}", f, f, strain, free_strip(PARAMETERS, k, strain))
        for k, f in enumerate(("warp", "weft"))
    ]
    band = fit_crimp(pulled_strips, biaxial([(1, 1), (1, 0.5), (0.5, 1)]), SPACING, draws=2)
    np.testing.assert_allclose(band.value, PARAMETERS, rtol=1e-3)


def test_table_of_tensions_has_the_laws_of_its_points():
    ratios = [(1, 1), (1, 0.5), (0.5, 1), (1, 0), (0, 1), (1, 0.8), (0.8, 1), (1, 0.25), (0.25, 1)]
    fit = fit_table(biaxial(ratios), (2.04e-3, 2e-3), draws=2)
    grid = np.stack([g.ravel() for g in np.meshgrid(*fit.strains, indexing="ij")], axis=1)
    exact = np.array([crimp_tensions(LAW, *each) for each in grid]).reshape(6, 6, 2)
    for family in range(2):
        # 2 % of the largest: a kink (slack yarns) under cubic splines of five intervals
        off = np.abs(fit.table(family) - exact[..., family])
        assert off.max() < 0.02 * exact.max()
        own = np.diff(fit.table(family), axis=family)
        assert own.min() > -1e-6 * exact.max()
    assert not fit.beyond.any()
    assert fit_table(biaxial([(1, 1)]), (2.04e-3, 2e-3), draws=2).beyond.sum() > 15


def test_tables_of_tension_do_not_fall_whatever_the_data():
    points = biaxial([(1, 1), (1, 0.5), (0.5, 1)])
    falling = [replace(p, tensions=p.tensions * (1.5 - 100 * p.strains)) for p in points]
    assert np.diff(falling[0].tensions[:, 0]).min() < -1.0
    fit = fit_table(falling, (2.04e-3, 2e-3), draws=2)
    for family in range(2):
        own = np.diff(fit.table(family), axis=family)
        assert own.min() > -1e-6 * fit.table(family).max()


def test_errors_count_within_the_cards_data_only():
    at = np.arange(5.0)
    each = Prediction("t", "s", at, 2.0 * at, 2.0 * at + np.where(at > 3, 8.0, 0.8), "", "", 3.0)
    np.testing.assert_allclose(each.errors, np.full(4, 0.1))


def test_linear_yarns_and_failure():
    strain = np.linspace(0.0, 0.02, 100)
    curves = [
        YarnCurve("u", "warp", str(k), strain, f * 3e4 * np.maximum(strain - 0.005, 0.0), at)
        for k, (f, at) in enumerate(((0.9, 0.019), (1.0, 0.020), (1.1, None)))
    ]
    fit = fit_linear(curves)
    assert fit.stiffness.value[0] == pytest.approx(3e4, rel=1e-9)
    assert fit.start.value[0] == pytest.approx(0.005, rel=1e-9)
    assert fit.stiffness.low[0] < 2.7e4 < 3.3e4 < fit.stiffness.high[0]  # t = 2.92 of three
    assert fit_failure(curves).value[0] == pytest.approx(0.0195)
    assert fit_failure(curves[2:] * 2 + curves[:1]) is None
