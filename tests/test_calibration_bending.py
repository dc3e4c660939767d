"""Bending found again: cantilevers by the elastica, loops by the friction between fibres."""

import numpy as np
import pytest
from calibration_checks import pulled
from scipy.integrate import solve_ivp

from warpdrape.calibration.bending import fit_cantilever, fit_loops
from warpdrape.calibration.hysteresis import first_loading, friction_history, loop_width
from warpdrape.calibration.raw_table import Specimen
from warpdrape.calibration.tests_file import Test
from warpdrape.coupons.closed_forms import (
    flexural_length,
)


def test_cantilever_by_the_elastica():
    """Overhangs and angles of one strip give one stiffness; at 41.5° half the overhang."""
    stiffness, density = 2e-3, 0.6
    length = (stiffness / (9.81 * density)) ** (1 / 3)
    angles = np.radians([20.0, 41.5, 60.0])
    over = [length / flexural_length(1.0, float(a)) for a in angles]
    test = pulled("cantilever", {"overhang": over, "angle": angles}, values={"family": "warp"})
    fit = fit_cantilever([test], density)
    # 41.5° is 0.5 to 0.3 %: Peirce's figure against the elastica
    np.testing.assert_allclose(fit.readings["t"], stiffness, rtol=0.01)
    assert len(fit.readings["t"]) == 3 and fit.stiffness.told


WAY = np.concatenate([np.linspace(0, 250, 80), np.linspace(250, -250, 160)[1:],
                      np.linspace(-250, 0, 80)[1:]])  # fmt: skip


def test_dahls_friction_is_its_equation():
    for part in (slice(0, 80), slice(79, 239)):
        way = WAY[part]
        sign = np.sign(way[-1] - way[0])
        start = 0.0 if part.start == 0 else friction_history(WAY, 12.0)[79]
        solved = solve_ivp(
            lambda s, p, sign=sign: [(1 - sign * p[0]) / 12.0 * sign], (0.0, abs(way[-1] - way[0])),
            [start], t_eval=np.abs(way - way[0]), rtol=1e-10, atol=1e-12,
        )  # fmt: skip
        found = friction_history(WAY, 12.0)[part]
        np.testing.assert_allclose(found, solved.y[0], atol=1e-8)


def test_loops_give_their_curve_and_friction():
    curve = 0.05 * (1 - np.exp(-np.abs(WAY) / 60.0)) * np.sign(WAY)
    moment = curve + 0.01 * friction_history(WAY, 9.0)
    tests = [
        Test("l", "bending_loop", {"family": "warp"}, tuple(
            Specimen(str(k), "l.csv", {"curvature": WAY, "moment": moment}) for k in range(2)
        ))
    ]  # fmt: skip
    fit = fit_loops(tests, draws=20)
    assert fit.friction.value[0] == pytest.approx(0.01, rel=0.01)
    assert fit.over == pytest.approx(9.0, rel=0.03)
    exact = 0.05 * (1 - np.exp(-fit.curvatures / 60.0))
    np.testing.assert_allclose(fit.moments.value, exact, atol=2e-4)
    np.testing.assert_allclose(fit.moment(WAY), moment, atol=4e-4)
    # at 100 1/m both branches have all their friction: 2HB = 2 M_y
    assert fit.width.value[0] == pytest.approx(0.02, rel=0.01)
    slope = np.polyfit(WAY[16:49], moment[16:49], 1)[0]  # 50 to 150 1/m
    assert fit.stiffness.value[0] == pytest.approx(slope, rel=0.05)


def test_first_way_out_of_a_loop():
    specimen = Specimen("s", "s.csv", {"a": -WAY, "b": -3.0 * WAY})
    at, value = first_loading(specimen, "a", "b")
    assert at[0] == 0.0 and at[-1] == 250.0 and len(at) == 80
    np.testing.assert_allclose(value, 3.0 * at)
    assert loop_width(specimen, "a", "b", 100.0) == pytest.approx(0.0, abs=1e-9)
    assert loop_width(specimen, "a", "b", 300.0) is None
