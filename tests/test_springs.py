"""Springs and grippers: force, slip, letting go, work, and what they take of the step."""

import json
import math

import numpy as np
import pytest
from law_checks import fabric

from warpdrape import Clamp, InputError, Path, Ply, Scene, Spring
from warpdrape.dynamics.model import build_model
from warpdrape.dynamics.time_step import lump_masses
from warpdrape.materials.laws import LinearTension, ShearPolynomial

STIFF = fabric(LinearTension(1e3, 1e3), ShearPolynomial((1e-3,)), factor=1.0)
EDGE = {"where": lambda p: p[:, 0] > 0.01 - 1e-9, "ply": "ply"}


def led(ways, *, duration=0.02, **settings):
    """A ply led whole along x and y through points of its way [m], with a spring at its edge."""
    ply = Ply.rectangle("ply", STIFF, 0.02, cells=2)
    spring = Spring(**{"name": "grip", "to": (0.05, 0.0, 0.0), **EDGE, **settings})
    positions = np.array([(x, y, 0.0) for x, y in ways])
    motion = Path(times=np.linspace(0.0, duration, len(ways)), positions=positions)
    hand = Clamp(name="hand", ply="ply", where=lambda p: p[:, 0] < 1.0, motion=motion)
    return Scene(
        name="led",
        plies=[ply],
        clamps=[hand],
        springs=[spring],
        duration=duration,
        gravity=(0.0, 0.0, 0.0),
    )


def history_of(scene, device, frames):
    result = scene.run(device=device, frames=frames)
    assert result.summary["status"] == "completed", result.summary["message"]
    assert result.summary["energy_error"] < 1e-3
    return result.history


def test_a_spring_pulls_with_preload_and_stiffness_and_goes_slack(device):
    scene = led([(0.0, 0.0), (-0.01, 0.0), (0.02, 0.0)], stiffness=500.0, preload=3.0)
    history = history_of(scene, device, 10)
    moved = scene.clamps[0].motion.displacement(history["time_s"])[:, 0]
    # The springs were last asked one step before the frame.
    force = np.maximum(3.0 - 500.0 * moved, 0.0)
    assert force.min() == 0.0 and force.max() > 7.9
    np.testing.assert_allclose(history["grip_force_n"], force, atol=0.02)
    stretched = force[-1] == 0.0
    assert stretched
    # From start to slack it did what was stored in its preload.
    assert history["grip_work_j"][-1] == pytest.approx(0.5 * 3.0**2 / 500.0, rel=1e-3)
    np.testing.assert_allclose(history["grip_slip_m"], 0.0)


def test_a_grip_slips_at_its_force_and_keeps_pulling(device):
    way = [(0.0, 0.0), (-0.02, 0.0), (-0.015, 0.0)]
    scene = led(way, stiffness=500.0, preload=1.0, slip_force=6.0)
    history = history_of(scene, device, 10)
    middle = np.argmin(np.abs(history["time_s"] - 0.01))
    assert history["grip_force_n"][middle] == pytest.approx(6.0, rel=1e-3)
    assert history["grip_slip_m"][-1] == pytest.approx(0.02 - 5.0 / 500.0, rel=1e-3)
    assert history["grip_force_n"][-1] == pytest.approx(6.0 - 500.0 * 0.005, rel=1e-3)
    elastic = 0.5 * (6.0**2 - 1.0**2) / 500.0
    back = 0.5 * (6.0**2 - 3.5**2) / 500.0
    expected = -(elastic + 6.0 * 0.01) + back
    assert history["grip_work_j"][-1] == pytest.approx(expected, rel=2e-3)


def test_a_grip_that_breaks_lets_go_for_good(device):
    scene = led([(0.0, 0.0), (-0.02, 0.0), (0.0, 0.0)], stiffness=500.0, break_force=4.0)
    result = scene.run(device=device, frames=20)
    history = result.history
    assert 3.0 < history["grip_force_n"].max() <= 4.0
    first = np.argmax(history["grip_broken"] > 0.0)
    assert 0 < first < 20
    np.testing.assert_allclose(history["grip_force_n"][first + 1 :], 0.0)
    np.testing.assert_allclose(history["grip_broken"][first:], 1.0)
    (entry,) = result.summary["springs"]
    assert entry["broken_share"] == 1.0
    assert any("100 % of spring 'grip' let go" in words for words in result.summary["warnings"])


@pytest.mark.parametrize("direction", ["following", "fixed"])
def test_the_pull_follows_the_ply_or_keeps_its_direction(direction, device):
    scene = led(
        [(0.0, 0.0), (0.0, 0.05)], stiffness=200.0, preload=2.0, direction=direction, duration=0.05
    )
    history = history_of(scene, device, 50)
    follows = direction == "following"
    longer = 0.05 * (math.sqrt(2.0) - 1.0) if follows else 0.0
    pull = 2.0 + 200.0 * longer
    assert history["grip_force_n"][-1] == pytest.approx(pull, rel=1e-3)
    share = math.sqrt(0.5)
    # The hand holds against it; its force is a mean over the last frame.
    assert history["hand_force_x_n"][-1] == pytest.approx(-pull * (share if follows else 1.0), 0.02)
    expected = pull * share if follows else 0.0
    assert history["hand_force_y_n"][-1] == pytest.approx(expected, rel=0.02, abs=0.05)


def test_a_ply_swings_on_its_springs(device):
    """Hung on springs under gravity: x = (mg/k)(1 − cos ωt)."""
    ply = Ply.rectangle("ply", STIFF, 0.02, cells=2)
    stiffness = 20.0
    mass = STIFF.areal_density * 0.02**2
    omega = math.sqrt(stiffness / mass)
    spring = Spring(
        name="hung",
        ply="ply",
        where=lambda p: p[:, 0] < 1.0,
        to=(0.3, 0.0, 0.0),
        stiffness=stiffness,
    )
    scene = Scene(
        name="hung",
        plies=[ply],
        springs=[spring],
        duration=math.pi / omega,
        gravity=(-9.81, 0.0, 0.0),
    )
    result = scene.run(device=device, frames=8)
    fallen = (result.plies[0].rest_points - result.plies[0].points)[:, 0].mean()
    assert fallen == pytest.approx(2.0 * mass * 9.81 / stiffness, rel=0.01)
    assert result.summary["energy_error"] < 0.01


def test_a_stiff_spring_shortens_the_step_and_runs(device):
    def stable(stiffness):
        scene = led([(0.0, 0.0), (-1e-4, 0.0)], duration=1e-3, stiffness=stiffness)
        return lump_masses(scene).stable_step

    soft, stiff = 1.0, 1e9
    assert stable(stiff) < 0.2 * stable(soft)
    ply = Ply.rectangle("ply", STIFF, 0.02, cells=2)
    spring = Spring(name="grip", to=(0.05, 0.0, 0.0), stiffness=stiff, preload=1.0, **EDGE)
    scene = Scene(
        name="held", plies=[ply], springs=[spring], duration=1e-3, gravity=(0.0, 0.0, 0.0)
    )
    result = scene.run(device=device, frames=4)
    assert result.summary["status"] == "completed", result.summary["message"]
    assert result.summary["energy_error"] < 0.01


def test_threads_share_springs(device):
    threads = (1, 2) if device == "cpu" else (1,)
    ways = [(0.0, 0.0), (-0.01, 0.0)]
    scene = led(ways, stiffness=500.0, preload=3.0)
    forces = [scene.run(device=device, frames=2, threads=n).history for n in threads]
    for name in ("grip_force_n", "hand_force_x_n", "grip_work_j"):
        np.testing.assert_allclose(forces[-1][name], forces[0][name], rtol=1e-9, atol=1e-12)


def test_springs_are_on_the_record_of_a_run(tmp_path):
    scene = led([(0.0, 0.0), (-1e-4, 0.0)], duration=1e-3, stiffness=500.0, slip_force=9.0)
    model = build_model(scene, "cpu", 1)
    assert [force.name for force in model.forces][-1] == "springs"
    scene.run(tmp_path / "run", frames=1)
    (record,) = json.loads((tmp_path / "run" / "run.json").read_text())["springs"]
    assert record["slip_force"] == 9.0 and record["where"]["vertices"] == 3


@pytest.mark.parametrize(
    ("settings", "match"),
    [
        ({"stiffness": 0.0}, "neither stiffness nor preload"),
        ({"stiffness": -1.0}, "zero or more"),
        ({"to": (0.0, 0.0, 0.0)}, "zero vector"),
        ({"direction": "up"}, "following"),
        ({"preload": 3.0, "slip_force": 2.0}, "must lie above its preload"),
        ({"break_force": math.nan}, "finite"),
        ({"slip_force": 5.0, "break_force": 9.0}, "leave one out"),
        ({"where": lambda p: p[:, 0] > 9.0}, "holds no vertex"),
        ({"where": [99]}, "has no vertex 99"),
        ({"where": lambda p: p[:, 0]}, "vertex numbers or a mask"),
        ({"name": "2 grips"}, "plain identifier"),
        ({"name": "hand"}, "rename one"),
        ({"ply": "other"}, "unknown ply 'other'"),
    ],
)
def test_a_spring_that_cannot_be_meant_is_refused(settings, match):
    with pytest.raises(InputError, match=match):
        led([(0.0, 0.0), (-1e-4, 0.0)], **{"stiffness": 1.0, **settings}).run(frames=1)
