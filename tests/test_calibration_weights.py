"""Weights of specimens: one that weighs two counts as two alike do, in every fit."""

from dataclasses import replace

import numpy as np
import pytest
from calibration_checks import pulled
from test_calibration_bending import WAY
from test_calibration_friction import grid_readings
from test_calibration_reading import plan  # noqa: F401  a fixture
from test_calibration_shear import END, frames
from test_calibration_tension import SPACING, biaxial

from warpdrape.calibration.bending import fit_cantilever, fit_loops
from warpdrape.calibration.biaxial_table import fit_table
from warpdrape.calibration.compaction import Pressed, fit_compaction
from warpdrape.calibration.fits import fit_all
from warpdrape.calibration.friction import fit_friction
from warpdrape.calibration.hysteresis import friction_history
from warpdrape.calibration.raw_table import Specimen
from warpdrape.calibration.report import understood
from warpdrape.calibration.shear import fit_shear
from warpdrape.calibration.tension import YarnCurve, fit_crimp, fit_failure, fit_linear
from warpdrape.calibration.tests_file import Test
from warpdrape.errors import InputError

STRAIN = np.linspace(0.0, 0.02, 60)


def strips():
    return [
        YarnCurve("u", "warp", str(k), STRAIN, f * 3e4 * np.maximum(STRAIN - 0.005, 0.0), f * 0.02)
        for k, f in enumerate((0.9, 1.1))
    ]


def linear(found):
    return np.append(fit_linear(found, 2).stiffness.value, fit_failure(found, 2).value)


def crimp(found):
    return fit_crimp([], found, SPACING, draws=2).value


def tension_table(found):
    return fit_table(found, (2.04e-3, 2e-3), draws=2).tensions.value


def cantilever(found):
    test = pulled("cantilever", {"overhang": [0.1]}, values={"family": "warp"})
    return fit_cantilever([replace(test, specimens=tuple(found))], 0.6, 2).stiffness.value


def loops(found):
    fit = fit_loops([Test("l", "bending_loop", {"family": "warp"}, tuple(found))], 2)
    bands = (fit.moments, fit.friction, fit.stiffness, fit.width)
    return np.concatenate([fit.coefficients, *(band.value for band in bands)])


def loop(factor):
    moment = factor * (0.05 * np.tanh(WAY / 90.0) + 0.01 * friction_history(WAY, 9.0))
    return Specimen(str(factor), "l.csv", {"curvature": WAY, "moment": moment})


def friction(found):
    """Coefficients at the conditions: which is the reference depends on how many there are."""
    law = fit_friction(found, draws=2).law("made up")
    return np.array([law(pressure=p, speed=v) for p in (5e3, 1e4, 3e4) for v in (1e-4, 1e-2)])


def compaction(found):
    fit = fit_compaction(found, contact_pressure=1e3, solid=2.4e-4, draws=2)
    return np.concatenate([fit.thickness.value, fit.coefficient.value, fit.exponent.value])


def plates():
    pressure = np.geomspace(900.0, 2e5, 60)
    return [
        Pressed("p", str(f), pressure, f * 6e-4 * (pressure / 1e3) ** (-0.07 * f))
        for f in (1.0, 1.15)
    ]


def couple(found):
    return fit_shear(found, draws=2).couple(np.radians(np.arange(5.0, 50.0, 5.0)))


CASES = {
    "linear": (linear, strips),
    "crimp": (crimp, lambda: biaxial([(1, 1), (1, 0.5)]) + biaxial([(0.5, 1)], 1.3)),
    "table": (tension_table, lambda: biaxial([(1, 1), (0.5, 1)]) + biaxial([(1, 0.5)], 1.3)),
    "cantilever": (
        cantilever,
        lambda: [Specimen(str(c), "c.csv", {"overhang": np.array([c])}) for c in (0.1, 0.12)],
    ),
    "loops": (loops, lambda: [loop(1.0), loop(1.4)]),
    "friction": (friction, lambda: grid_readings(0.05)),
    "compaction": (compaction, plates),
    "shear": (couple, lambda: frames([0.9, 1.2], np.linspace(0.0, END, 150))),
}


@pytest.mark.parametrize("name", CASES)
def test_one_that_weighs_two_counts_as_two(name):
    fit, make = CASES[name]
    found = make()
    weighed = fit([*found[:-1], replace(found[-1], weight=2.0)])
    doubled = fit([*found, found[-1]])
    np.testing.assert_allclose(weighed, doubled, rtol=2e-4, atol=1e-7 * np.abs(doubled).max())
    assert np.abs(weighed / np.where(fit(found) == 0.0, 1.0, fit(found)) - 1.0).max() > 1e-3


def test_a_scale_on_all_weights_changes_nothing():
    for name, (fit, make) in CASES.items():
        found = make()
        scaled = fit([replace(each, weight=3.0) for each in found])
        np.testing.assert_allclose(scaled, fit(found), rtol=1e-4, atol=1e-9, err_msg=name)


def test_a_file_gives_one_weight_or_one_for_each_specimen(plan):  # noqa: F811
    assert [s.weight for s in plan().tests[0].specimens] == [1.0]
    assert [s.weight for s in plan("", "weight = 0.5").tests[0].specimens] == [0.5]
    given = plan("", "weight = [0.25]")
    assert [s.weight for s in given.tests[0].specimens] == [0.25]
    assert "N, weight 0.25" in understood(given) and ", weight" not in understood(plan())
    for given, words in (
        ("weight = [1, 2]", "has 2 numbers for 1 specimens: give one for each, in the order"),
        ("weight = [0]", "weight = 0 must be above zero"),
        ('weight = "much"', "weight"),
    ):
        with pytest.raises(InputError, match=words):
            plan("", given)


def test_weights_come_from_the_file_to_the_fit(plan):  # noqa: F811
    light, heavy = (fit_all(plan("", f"weight = {w}"), draws=2).shear for w in (1, 4))
    assert [s.weight for s in heavy.specimens] == [4.0]
    np.testing.assert_allclose(heavy.band.value, light.band.value, rtol=1e-6)
