"""Friction and compaction found again from sleds and plates."""

import math

import numpy as np
import pytest
from calibration_checks import pulled

from warpdrape.calibration.compaction import fit_compaction, pressed
from warpdrape.calibration.friction import Reading, fit_friction, readings
from warpdrape.errors import InputError


def grid_readings(noise=0.0):
    rng, found = np.random.default_rng(5), []
    for p in (5e3, 1e4, 3e4):
        for v in (1e-4, 1e-3, 1e-2):
            for k in range(3):
                mu = 0.3 * (p / 1e4) ** -0.1 * (v / 1e-3) ** 0.06
                mu *= math.exp(noise * rng.standard_normal())
                found.append(Reading("f", f"{k}", p, v, None, mu))
    return found


def test_friction_factors_are_found_again():
    fit = fit_friction(grid_readings(), draws=20)
    law = fit.law("made up")
    for p, v in ((5e3, 1e-4), (3e4, 1e-2), (1e4, 1e-3)):
        exact = 0.3 * (p / 1e4) ** -0.1 * (v / 1e-3) ** 0.06
        assert law(pressure=p, speed=v) == pytest.approx(exact, rel=1e-9)
    assert fit.apart == pytest.approx(0.0, abs=1e-9)
    noisy = fit_friction(grid_readings(0.05), draws=100)
    at = noisy.bands["pressure"]
    assert (at.low < at.value).all() and (at.value < at.high).all() and noisy.apart > 1e-3


def test_friction_effects_that_change_together_are_refused():
    both = [Reading("f", "a", p, v, None, 0.3) for p, v in ((1e3, 1e-3), (1e4, 1e-2))]
    with pytest.raises(InputError, match="cannot be told apart"):
        fit_friction(both * 2)


def test_sled():
    travel = np.linspace(0.0, 0.06, 100)
    force = np.where(travel < 0.01, 40.0 * travel / 0.004, 30.0)
    force = np.minimum(force, np.where(travel < 0.01, 45.0, 30.0))
    values = {"pressure": 1e4, "area": 0.01, "speed": 1e-3, "against": "ply"}
    (found,) = readings(pulled("sled", {"travel": travel, "force": force}, values=values))
    assert found.kinetic == pytest.approx(0.3) and found.static == pytest.approx(0.45)
    for columns in (
        {"travel": -travel, "force": force},
        {"travel": travel, "force": -force},
        {"travel": 0.3 - travel, "force": force},  # places of the crosshead
    ):
        (other,) = readings(pulled("sled", columns, values=values))
        assert (other.kinetic, other.static) == pytest.approx((0.3, 0.45))
    values = {**values, "normal": 2.0}
    with pytest.raises(InputError, match=r"coefficient of 15: check normal force"):
        readings(pulled("sled", {"travel": travel, "force": force}, values=values))


def test_compaction_power_law_and_table():
    solid, a, b = 0.6 / 2550.0, 0.23, 0.07
    pressure = np.geomspace(500.0, 2e5, 120)
    thickness = solid / (a * pressure**b)
    values = {"area": 2.5e-3, "plies": 4.0, "compliance": 1e-7}
    columns = {"thickness": 4 * thickness - 1e-7 * 2.5e-3 * pressure, "force": 2.5e-3 * pressure}
    test = pulled("compaction", columns, values=values)
    fit = fit_compaction(pressed(test), contact_pressure=1e3, solid=solid, draws=20)
    assert fit.exponent.value[0] == pytest.approx(b, rel=2e-3)
    assert fit.coefficient.value[0] == pytest.approx(a, rel=2e-3)
    np.testing.assert_allclose(fit.thickness.value, solid / (a * fit.pressures**b), rtol=1e-3)
    thicknesses, pressures = fit.table
    assert (np.diff(thicknesses) < 0).all() and pressures[0] == 0.0
    with pytest.raises(InputError, match="contact_pressure = 100 Pa must lie within"):
        fit_compaction(pressed(test), contact_pressure=100.0, solid=None, draws=20)
