"""Motions: smooth in velocity, their ends and peak speeds as said."""

import numpy as np
import pytest

from warpdrape import Ply, Scene, Tool
from warpdrape.errors import InputError
from warpdrape.tools.floating import Float
from warpdrape.tools.motion import Path, Stages, Still, Stroke, smooth_ramp


def speeds(displacement, start, end, n=20001):
    """Speed by central differences, and its changes from sample to sample."""
    time = np.linspace(start, end, n)
    x = displacement(time)
    v = np.linalg.norm(np.diff(x, axis=0), axis=1) / (time[1] - time[0])
    return time, x, v


@pytest.mark.parametrize(
    ("ramp", "brake"), [(0.05, None), (0.3, None), (0.5, None), (0.15, 0.85), (0.2, 0.6)]
)
def test_stroke_is_smooth_in_velocity_and_acceleration(ramp, brake):
    stroke = Stroke(travel=(0.0, 0.03, -0.04), duration=0.08, start=0.01, ramp=ramp, brake=brake)
    time, x, v = speeds(stroke.displacement, 0.0, 0.1)
    np.testing.assert_allclose(x[time <= 0.01], 0.0, atol=1e-18)
    np.testing.assert_allclose(
        x[time >= 0.09], np.broadcast_to((0, 0.03, -0.04), x[time >= 0.09].shape)
    )
    assert (np.diff(x[:, 1]) >= -1e-17).all()
    assert v.max() == pytest.approx(stroke.peak_speed, rel=1e-6)
    assert stroke.peak_speed == pytest.approx(0.05 / 0.08 / (1 - 0.5 * (ramp + (brake or ramp))))
    # 3r² − 2r³ is steepest in the middle of the ramp, 1.5 times its mean; and has no corner.
    a = np.diff(v) / (time[1] - time[0])
    steepest = 1.5 * stroke.peak_speed / (ramp * 0.08)
    assert np.abs(a).max() == pytest.approx(steepest, rel=1e-3)
    corner = 6.0 * stroke.peak_speed / (ramp * 0.08) ** 2 * (time[1] - time[0])
    # Two samples of a piecewise linear slope; an acceleration that jumps would show a/2 here.
    assert np.abs(np.diff(a)).max() < 1.1 * corner < 0.1 * steepest


def test_ramp_is_symmetric_and_exact_at_its_ends():
    u = np.linspace(-0.5, 1.5, 401)
    for ramp in (0.1, 0.3, 0.5):
        w = smooth_ramp(u, ramp, ramp)
        np.testing.assert_allclose(w + smooth_ramp(1 - u, ramp, ramp), 1.0, atol=1e-15)
        assert w[0] == 0.0 and w[-1] == pytest.approx(1.0, abs=1e-15)


def test_path_goes_through_its_samples_without_overshoot_or_jumps():
    times = [0.0, 0.02, 0.05, 0.06, 0.1]
    heights = [0.0, -0.01, -0.01, -0.04, -0.05]
    path = Path(times=times, positions=[(0.2 * h, 0.0, h) for h in heights])
    np.testing.assert_allclose(path.displacement(np.array(times))[:, 2], heights, atol=1e-16)
    time, x, v = speeds(path.displacement, -0.01, 0.11)
    assert (np.diff(x[:, 2]) <= 1e-17).all()
    held = (time > 0.0201) & (time < 0.0499)
    np.testing.assert_allclose(x[held, 2], -0.01, atol=1e-16)
    assert v[0] == v[-1] == 0.0
    assert np.abs(np.diff(v)).max() < 0.01 * v.max()  # begins and ends at rest, without a jump
    assert path.peak_speed == pytest.approx(v.max(), rel=1e-3)
    np.testing.assert_allclose(path.displacement(np.array([-1.0, 1.0]))[:, 2], [0.0, -0.05])


def test_still_things_stay():
    assert Still().displacement(np.linspace(0, 1, 7)).shape == (7, 3)
    assert not Still().displacement(np.linspace(0, 1, 7)).any()
    assert Still().peak_speed == 0.0


def test_force_of_a_floating_tool_rises_smoothly():
    motion = Float(force=100.0, axis=(0.0, 0.0, -2.0), ramp=0.01)
    np.testing.assert_allclose(motion.axis, (0.0, 0.0, -1.0))
    time = np.linspace(-0.002, 0.02, 2001)
    force = motion.force_at(time)
    assert force[0] == 0.0 and force[-1] == pytest.approx(100.0)
    assert (np.diff(force) >= 0).all()
    rate = np.diff(force) / (time[1] - time[0])
    assert np.abs(np.diff(rate)).max() < 0.02 * rate.max()
    assert motion.force_at(np.array(0.005)) == pytest.approx(50.0)
    assert (Float(force=7.0, ramp=0.0).force_at(time) == 7.0).all()
    assert Float(force=10.0).damping == pytest.approx(2.0)


def there_and_back():
    down = Stroke(travel=(0.0, 0.0, -0.02), duration=0.01)
    aside = Stroke(travel=(0.003, 0.0, 0.0), duration=0.01, start=0.015)
    up = Stroke(travel=(0.0, 0.0, 0.05), duration=0.02, start=0.015)
    return Stages(strokes=[up, down, aside])


def test_stages_follow_each_other_and_those_at_one_time_add_up():
    stages = there_and_back()
    at = stages.displacement(np.array([0.0, 0.01, 0.014, 0.025, 0.035, 9.0]))
    np.testing.assert_allclose(at[:3, 2], [0.0, -0.02, -0.02], atol=1e-16)
    np.testing.assert_allclose(at[3], (0.003, 0.0, 0.005), atol=1e-12)
    np.testing.assert_allclose(at[4:], [(0.003, 0.0, 0.03)] * 2)
    _, _, v = speeds(stages.displacement, 0.0, 0.04)
    assert np.abs(np.diff(v)).max() < 0.01 * v.max()
    assert v.max() <= stages.peak_speed < 1.2 * v.max()
    short = [Stroke(travel=(0.0, 0.0, 0.01), duration=2e-4, start=t) for t in (0.0, 0.0, 1.0)]
    assert Stages(strokes=short).peak_speed == pytest.approx(2.0 * short[0].peak_speed)
    assert Stages(strokes=short).largest_way == pytest.approx(0.03)
    assert stages.largest_way == pytest.approx(np.hypot(0.003, 0.03), rel=1e-6)
    assert (stages.start, stages.end) == (0.0, 0.035)
    np.testing.assert_allclose(stages.heading, (0.0, 0.0, -0.02))


def test_a_tool_presses_lets_go_and_leaves(device):
    """A plate presses a ply on another by its stages; its way counts along the first of them."""
    ply = Ply.rectangle("ply", "carbon_interlock", 0.03, cells=3)
    half = 0.5 * ply.fabric.thickness
    down = Stroke(travel=(0.0, 0.0, -1e-3 - 2e-5), duration=2e-3)
    up = Stroke(travel=(0.0, 0.0, 2e-3), duration=2e-3, start=4e-3)
    top = Tool.plate(
        name="top", width=0.1, height=0.1, facing="down", motion=Stages(strokes=[down, up])
    )
    table = Tool.plate(name="table", width=0.1, height=0.1).moved((0.0, 0.0, -half))
    top = top.moved((0.0, 0.0, half + 1e-3))
    scene = Scene(name="press", plies=[ply], tools=[table, top], duration=8e-3)
    result = scene.run(device=device, frames=8)
    way, force = (result.history[f"top_{name}"] for name in ("displacement_m", "force_n"))
    np.testing.assert_allclose(way[[0, 2, 4]], [0.0, 1.02e-3, 1.02e-3], atol=1e-9)
    assert way[-1] == pytest.approx(1.02e-3 - 2e-3)
    assert force[3] > 1.0 and force[-1] == 0.0
    assert result.summary["status"] == "completed"


def test_force_of_a_floating_tool_goes_through_its_table():
    motion = Float(force=[(0.01, 0.0), (0.02, 30.0), (0.04, 10.0)])
    time = np.array([0.0, 0.01, 0.02, 0.03, 0.04, 1.0])
    force = motion.force_at(time)
    np.testing.assert_allclose(force[[0, 1, 2, 4, 5]], [0.0, 0.0, 30.0, 10.0, 10.0])
    assert 10.0 < force[3] < 30.0
    assert motion.damping == pytest.approx(6.0)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Stroke(travel=(0.0, 1.0), duration=1.0), "travel .* three finite numbers"),
        (lambda: Stroke(travel=(0.0, 0.0, 1.0), duration=0.0), "stroke duration = 0.0"),
        (lambda: Stroke(travel=(0.0, 0.0, 1.0), duration=1.0, ramp=0.6), "ramp = 0.6"),
        (lambda: Stroke(travel=(0.0, 0.0, 1.0), duration=1.0, start=-1.0), "start = -1.0"),
        (lambda: Stroke(travel=(0.0, 0.0, 1.0), duration=1.0, brake=0.8), "brake = 0.8 must not"),
        (lambda: Stroke(travel=(0.0, 0.0, 1.0), duration=1.0, ramp=0.1, brake=-0.1), "brake"),
        (lambda: Path(times=[0.0, 0.0], positions=np.zeros((2, 3))), "times must rise"),
        (lambda: Path(times=[0.0, 1.0], positions=np.zeros((3, 3))), "n ≥ 2"),
        (lambda: Path(times=[0.0, 1.0], positions=[[0, 0, 0], [0, 0, np.inf]]), "finite"),
        (lambda: Float(force=-1.0), "tool force = -1.0"),
        (lambda: Float(force=[(0.0, 1.0)]), "two or more pairs"),
        (lambda: Float(force=[(0.0, 1.0), (1.0, -1.0)]), "zero or more at all its times"),
        (lambda: Float(force=[(1.0, 1.0), (0.0, 1.0)]), "times must rise"),
        (lambda: Stages(strokes=[]), "must be a list of Stroke"),
        (lambda: Stages(strokes=[Still()]), "must be a list of Stroke"),
        (lambda: Float(force=1.0, mass=0.0), "tool mass = 0.0"),
        (lambda: Float(force=1.0, axis=(0.0, 0.0, 0.0)), "zero vector"),
    ],
)
def test_bad_motions_are_refused(make, words):
    with pytest.raises(InputError, match=words):
        make()
