"""Pressure on a side of a ply: force, work, and a membrane blown up."""

import json
import math

import numpy as np
import pytest
from law_checks import fabric

from warpdrape import Clamp, InputError, Numerics, Ply, Pressure, Scene
from warpdrape.materials.laws import LinearTension, ShearPolynomial
from warpdrape.verification.bulge import blown_up, hencky

STIFF = fabric(LinearTension(1e3, 1e3), ShearPolynomial((1e-3,)), factor=1.0)
STILL = {"gravity": (0.0, 0.0, 0.0)}


def loose(pressure, **settings):
    """A square ply in nothing but a pressure."""
    ply = Ply.rectangle("ply", STIFF, 0.02, cells=2, warp_angle=0.3)
    return Scene(name="free", plies=[ply], pressures=[pressure], duration=5e-3, **STILL, **settings)


def fallen(result):
    return (result.plies[0].points - result.plies[0].rest_points).mean(axis=0)


@pytest.mark.parametrize(("side", "sign"), [("upper", -1.0), ("lower", 1.0)])
def test_a_loose_ply_is_pushed_off(side, sign, device):
    load = Pressure(name="air", ply="ply", pressure=20.0, side=side, ramp=0.0)
    result = loose(load).run(device=device, frames=5)
    time, step = 5e-3, result.summary["time_step_s"]
    way = sign * 0.5 * 20.0 / STIFF.areal_density * time * (time + step)
    np.testing.assert_allclose(fallen(result), (0.0, 0.0, way), atol=1e-9 * abs(way))
    history = result.history
    assert history["air_pressure_pa"] == pytest.approx(20.0)
    assert history["air_force_z_n"] == pytest.approx(sign * 20.0 * 4e-4, rel=1e-9)
    kinetic = 0.5 * (20.0 * 4e-4 * time) ** 2 / (STIFF.areal_density * 4e-4)
    assert history["air_work_j"][-1] == pytest.approx(kinetic, rel=1e-9)
    assert history["external_work_j"][-1] == history["air_work_j"][-1]
    assert result.summary["energy_error"] < 1e-9
    assert result.summary["pressures"][0]["work_j"] == history["air_work_j"][-1]


def test_pressure_goes_through_the_points_of_its_table(device):
    points = [(1e-3, 0.0), (3e-3, 30.0), (4e-3, -10.0)]
    result = loose(Pressure(name="air", ply="ply", pressure=points)).run(device=device, frames=5)
    shown = result.history["air_pressure_pa"]
    assert 0.0 < shown[2] < 30.0  # between two points
    np.testing.assert_allclose(shown, [0.0, 0.0, shown[2], 30.0, -10.0, -10.0], atol=1e-9)


def test_a_constant_pressure_rises_within_its_ramp():
    load = Pressure(name="air", ply="ply", pressure=-8.0, ramp=2e-3)
    np.testing.assert_allclose(load.at(np.array([0.0, 1e-3, 2e-3, 9.0])), [0.0, -4.0, -8.0, -8.0])


def test_it_acts_where_it_is_told(device):
    load = Pressure(name="air", ply="ply", pressure=10.0, ramp=0.0, where=lambda p: p[:, 0] < 1e-9)
    history = loose(load).run(device=device, frames=1).history
    assert history["air_force_z_n"][0] == pytest.approx(-10.0 * 2e-4, rel=1e-9)


def test_the_closed_form_is_the_published_one():
    # Hencky's factor for ν = 0.3, as corrected by Chien: 0.653.
    q = 1e-4
    assert hencky(q, 1.0, 1.0, 0.3) / q ** (1.0 / 3.0) == pytest.approx(0.653, abs=1e-3)


def test_a_membrane_blown_up_rises_as_hencky_says(device):
    result = blown_up(10.0, edge=8e-3).run(device=device, frames=10)
    ply = result.plies[0]
    middle = int(np.argmin(np.hypot(*ply.rest_points[:, :2].T)))
    assert np.hypot(*ply.rest_points[middle, :2]) < 4e-3
    height = ply.points[:, 2].max()
    assert height / 0.1 == pytest.approx(hencky(10.0, 0.1, 1e4, 0.3), rel=0.01)
    assert result.summary["kinetic_ratio"] < 1e-3
    assert result.summary["energy_error"] < 0.01
    # The work of a pressure that stays is p times the volume; here it rises first, to less.
    corners = ply.points[ply.triangles]
    volume = -np.linalg.det(corners).sum() / 6.0
    assert abs(volume) > 1e-5
    assert 0.5 * 10.0 * abs(volume) < result.history["air_work_j"][-1] <= 10.0 * abs(volume)


def test_threads_share_a_pressure(device):
    ends = [
        blown_up(10.0, edge=0.02).run(device=device, frames=2, threads=threads).plies[0].points
        for threads in ((1, 2) if device == "cpu" else (1,))
    ]
    assert ends[0][:, 2].max() > 1e-3
    np.testing.assert_allclose(ends[-1], ends[0], atol=1e-9)


def thrown(contact, gap, pressure=20e3, ramp=5e-3):
    """A film pressed onto a held ply from a distance."""
    film = fabric(LinearTension(300.0, 300.0), ShearPolynomial((1e-4,)))
    low = Ply.rectangle("low", film, 0.04, cells=4)
    high = Ply.rectangle("high", film, 0.03, cells=3, z=film.thickness + gap)
    return Scene(
        name="thrown",
        plies=[low, high],
        clamps=[Clamp(name="held", ply="low", where=lambda p: p[:, 0] < 1.0)],
        pressures=[Pressure(name="air", ply="high", pressure=pressure, ramp=ramp)],
        duration=2.5e-3,
        numerics=Numerics(contact=contact),
        **STILL,
    )


def test_a_ply_faster_than_any_tool_is_stopped_by_the_next(device):
    """At 30 m/s, where searches look ahead for 4 m/s unless something is faster."""
    scenes = [thrown(contact, 5e-3) for contact in ("fast", "exact")]
    results = [scene.run(device=device, frames=5) for scene in scenes]
    lowest = [result.ply("high").points[:, 2].min() for result in results]
    assert min(lowest) > 0.8 * scenes[0].plies[0].fabric.thickness
    assert lowest[0] == pytest.approx(lowest[1], rel=0.05)


def test_plies_that_gain_speed_faster_than_searches_look_ahead_are_warned_of(device):
    """… and the advice cures it: searched at every step, the film is stopped."""
    violent = {"gap": 3e-3, "pressure": 50e3, "ramp": 1e-4}
    missed = thrown("fast", **violent).run(device=device, frames=5)
    assert missed.ply("high").points[:, 2].min() < 0.0
    assert any("gained speed" in words for words in missed.summary["warnings"])
    found = thrown("exact", **violent).run(device=device, frames=5)
    assert not any("gained speed" in words for words in found.summary["warnings"])
    assert found.ply("high").points[:, 2].min() > 0.0


def test_the_record_of_a_run_holds_its_pressures(tmp_path):
    load = Pressure(name="air", ply="ply", pressure=[(0.0, 0.0), (1e-3, 5.0)])
    loose(load).run(tmp_path / "run", frames=1)
    (record,) = json.loads((tmp_path / "run" / "run.json").read_text())["pressures"]
    assert record["pressure"] == [[0.0, 0.0], [1e-3, 5.0]] and record["side"] == "upper"


@pytest.mark.parametrize(
    ("settings", "match"),
    [
        ({"pressure": math.nan}, "must be finite"),
        ({"pressure": "much"}, "must be a number"),
        ({"pressure": [(0.0, 1.0)]}, "two or more pairs"),
        ({"pressure": [(1.0, 1.0), (0.0, 2.0)]}, "times must rise"),
        ({"side": "left"}, "upper"),
        ({"ramp": -1.0}, "zero or more"),
        ({"name": "a b"}, "plain identifier"),
        ({"where": 3}, "function of the flat points"),
        ({"where": lambda p: p[:, 0] > 9.0}, "acts on no triangle"),
        ({"where": lambda p: p[:, 0]}, "must give a mask"),
        ({"ply": "other"}, "unknown ply 'other'"),
    ],
)
def test_a_pressure_that_cannot_be_meant_is_refused(settings, match):
    with pytest.raises(InputError, match=match):
        loose(Pressure(**{"name": "air", "ply": "ply", "pressure": 1.0, **settings})).run(frames=1)
