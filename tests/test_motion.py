"""Motions: smooth in velocity, their ends and peak speeds as said."""

import numpy as np
import pytest

from warpdrape.errors import InputError
from warpdrape.tools.motion import Float, Path, Still, Stroke, smooth_ramp


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
        (lambda: Float(force=1.0, mass=0.0), "tool mass = 0.0"),
        (lambda: Float(force=1.0, axis=(0.0, 0.0, 0.0)), "zero vector"),
    ],
)
def test_bad_motions_are_refused(make, words):
    with pytest.raises(InputError, match=words):
        make()
