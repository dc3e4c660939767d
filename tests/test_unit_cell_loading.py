"""A unit cell pulled and sheared: curves, tables, loads that say nothing, where no rest is."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from cell_checks import balanced, cell_of

from warpdrape.errors import InputError, RunFailed
from warpdrape.unit_cell.equilibrium import settle
from warpdrape.unit_cell.loading import Loads, _curve, shear, shear_angles, strain_axes
from warpdrape.unit_cell.model import build_model
from warpdrape.unit_cell.weave import satin


def test_a_curve_says_where_it_locks_and_where_neighbours_touch(monkeypatch):
    monkeypatch.setattr("warpdrape.unit_cell.loading.ANGLE_STEP", math.radians(6.0))
    model = build_model(balanced(weave=satin(), friction=0.0), elements=4, points=5)
    curve = shear(model, Loads((1.0, 1.0), largest_angle=math.radians(54.0)))
    strain = np.array([np.interp(curve.locking, curve.angles, e) for e in curve.strains.T])
    exact = math.acos(4.1 / (5.2 * (1.0 + strain.max())))
    assert math.degrees(abs(curve.locking - exact)) < 0.2
    narrower = [max(state.strain[3:]) for state in curve.states]
    at = np.interp(curve.touching, curve.angles, narrower)
    assert math.degrees(abs(curve.touching - math.acos(4.1 * (1.0 - at) / 5.2))) < 0.5
    assert curve.touching > curve.locking + math.radians(0.5)
    couples = np.interp(np.radians([0.0, 12.0, 40.0, 52.0]), curve.angles, curve.couples)
    assert couples[3] - couples[2] > 10.0 * (couples[1] - couples[0])


def test_the_mean_of_both_ways_of_shear_is_given():
    """States made up, harder to shear ahead than back."""
    model = build_model(cell_of(), elements=4, points=5)
    angles = np.radians([0.0, 20.0, 30.0])

    def state(angle, couple, friction):
        strain = np.array([0.0, 0.0, angle, 0.0, 0.0])
        return SimpleNamespace(strain=strain, couple=couple, friction=friction)

    both = [
        (state(0.0, 0.0, 1.0), state(-0.0, 0.0, 1.0)),
        (state(angles[1], 2.0, 3.0), state(-angles[1], -1.0, 1.0)),
        (state(angles[2], 5.0, 4.0), state(-angles[2], -3.0, 2.0)),
    ]
    curve = _curve(model, angles, both, "made up")
    np.testing.assert_allclose(curve.elastic, [0.0, 1.5, 4.0])
    np.testing.assert_allclose(curve.friction, [0.0, 2.0, 3.0], rtol=1e-6)
    np.testing.assert_allclose(curve.couples, [0.0, 3.5, 7.0], rtol=1e-6)
    assert curve.skew == pytest.approx(1.0 / 7.0)
    assert curve.end == "made up" and curve.locking is None


def test_held_tensions_are_held_and_friction_builds_up():
    model = build_model(cell_of(), elements=4, points=5)
    loads = Loads((2.0, 3.0), largest_angle=math.radians(20.0))
    curve = shear(model, loads)
    for state in curve.states:
        np.testing.assert_allclose(state.tension, (2.0, 3.0), rtol=1e-6)
    assert curve.angles[0] == 0.0 and curve.couples[0] == 0.0
    assert curve.angles[-1] == pytest.approx(math.radians(20.0))
    assert (np.diff(curve.couples) > 0.0).all()
    sliding = np.array([state.friction for state in curve.states])
    built = curve.friction / sliding
    np.testing.assert_allclose(built, 1.0 - np.exp(-np.degrees(curve.angles)), atol=1e-3)
    assert curve.end == "as asked for" and curve.locking is None and curve.touching is None


def test_axes_of_a_table_hold_no_strain_and_the_crimp():
    model = build_model(cell_of())
    warp, weft = strain_axes(model, Loads((1.0, 1.0)))
    for axis, crimp in ((warp, model.cell.crimps[0]), (weft, model.cell.crimps[1])):
        assert np.abs(axis).min() < 1e-15
        assert axis[0] <= -crimp < axis[1]
        assert axis[-1] == pytest.approx(max(model.cell.crimps) + 0.003, rel=0.01)
        assert np.ptp(np.diff(axis)) < 1e-15
    angles = shear_angles(model, Loads((1.0, 1.0)))
    assert angles[-1] == pytest.approx(model.cell.locking + math.radians(8.0))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"shear_tension": (0.0, 1.0)}, "shear_tension_warp"),
        ({"largest_strain": 0.5}, "20 %"),
        ({"largest_angle": 1.5}, "10 … 80°"),
        ({"points": 2}, "5 … 41"),
    ],
)
def test_loads_that_say_nothing_are_refused(change, words):
    with pytest.raises(InputError, match=words):
        Loads(**{"shear_tension": (1.0, 1.0), **change})


def test_a_cell_that_finds_no_rest_says_where_and_what_to_try():
    model = build_model(cell_of(), elements=4, points=5)
    with pytest.raises(RunFailed, match=r"γ = 85\.94°: give a smaller largest_angle"):
        settle(model, np.array([0.0, 0.0, 1.5]), tension=(5.0, 5.0))


@pytest.mark.slow
def test_a_curve_ends_where_no_rest_is_found(monkeypatch):
    monkeypatch.setattr("warpdrape.unit_cell.loading.ANGLE_STEP", math.radians(8.0))
    model = build_model(cell_of(), elements=4, points=5)
    far = shear(model, Loads((2.0, 2.0), largest_angle=math.radians(72.0)))
    assert far.end.startswith("beyond it no rest was found")
    assert 40.0 < math.degrees(far.angles[-1]) < 72.0
