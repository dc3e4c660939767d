"""Tools that let go, and damping that comes on only then: what is left, and what is not."""

import dataclasses
import math

import numpy as np
import pytest

from warpdrape import Bending, Clamp, InputError, Numerics, Ply, Pressure, Scene, Stroke, Tool
from warpdrape.dynamics.model import build_model, initial_state
from warpdrape.dynamics.stepping import Stepper
from warpdrape.verification.strip import yarn_fabric

THICK, LENGTH = 5e-4, 0.06
BENT = dataclasses.replace(
    yarn_fabric(1e5, 0.5), thickness=THICK, bending=Bending(warp=2e-3, weft=2e-3)
)


def test_a_stroke_and_back_stands_still_between():
    motion = Stroke(travel=(0.0, 0.01, -0.02), duration=0.03, ramp=0.2, brake=0.5).and_back(
        after=0.005, duration=0.01
    )
    times = np.array([0.0, 0.03, 0.032, 0.035, 0.045, 1.0])
    way = motion.displacement(times)
    np.testing.assert_allclose(way[[1, 2, 3]], 3 * [(0.0, 0.01, -0.02)], atol=1e-17)
    np.testing.assert_allclose(way[[0, 4, 5]], 0.0, atol=1e-17)
    assert motion.end == pytest.approx(0.045)
    assert Stroke(travel=(1, 0, 0), duration=0.1).and_back().end == pytest.approx(0.2)
    with pytest.raises(InputError, match="and_back after = -1"):
        Stroke(travel=(1, 0, 0), duration=0.1).and_back(after=-1.0)


@pytest.mark.parametrize(
    "numerics", [{}, {"mass_scaling": "selective", "minimum_time_step": 3e-5}], ids=["plain", "sel"]
)
def test_a_loose_ply_slows_down_as_the_rate_over_time_says(numerics):
    """v = v0 exp(−∫ c dt), c through (0, 0) and (10 ms, 300/s) as 3r² − 2r³, then even."""
    ply = Ply.rectangle("ply", yarn_fabric(1e5, 0.5), 0.04, cells=4, mesh="grid")
    rates = Numerics(damping=[(0.0, 0.0), (0.01, 300.0), (0.02, 300.0)], **numerics)
    scene = Scene(
        name="loose", plies=[ply], duration=0.015, gravity=(0.0, 0.0, 0.0), numerics=rates
    )
    model = build_model(scene, "cpu", 1)
    state = initial_state(model)
    state.plies.v.fill_((0.0, 0.0, 2.0))
    if state.scaled is not None:
        state.scaled.w.fill_((0.0, 0.0, 2.0))
    stepper = Stepper(model, state)
    stepper.begin_frame(1)
    for _ in range(model.timing.steps_per_frame // model.timing.search_every):
        stepper.block()
    grid = np.linspace(0.0, 0.015, 30001)
    area = np.trapezoid(rates_at(grid), grid)
    # A step takes the rate at its beginning: they are half a step late, while it rises to 300/s.
    expected = 2.0 * math.exp(0.5 * 300.0 * model.timing.time_step - area)
    assert state.plies.v.numpy()[:, 2] == pytest.approx(expected, rel=1e-3)
    lost = float(state.plies.lost.numpy()[:, 2].sum())
    mass = float(model.masses.mass.sum())
    assert lost == pytest.approx(0.5 * mass * (4.0 - expected**2), rel=2e-3)


def rates_at(time):
    """Of the rule of `scipy`'s monotone interpolation: flat at 10 ms, a slope at the start."""
    from scipy.interpolate import PchipInterpolator

    table = PchipInterpolator([0.0, 0.01, 0.02], [0.0, 300.0, 300.0])
    return table(time)


def test_an_elastic_strip_that_is_let_go_comes_to_rest_flat():
    strip = Ply.rectangle("strip", BENT, LENGTH, 0.01, edge=6e-3, mesh="grid")
    down = Stroke(travel=(0.0, 0.0, -0.02), duration=0.03).and_back(duration=0.02)
    bar = Tool.drum("bar", radius=5e-3, length=0.03, facet=2e-3, motion=down)
    held = Clamp(name="held", ply="strip", where=lambda p: p[:, 0] < -0.5 * LENGTH + 0.0065)
    # The lowest frequency of the free part, 3.516 √(D/m)/L²: damped critically from 50 ms on.
    lowest = 3.516 / (LENGTH - 0.006) ** 2 * math.sqrt(2e-3 / 0.5)
    scene = Scene(
        name="release",
        plies=[strip],
        tools=[bar.moved((0.02, 0.0, 5e-3 + 0.5 * THICK + 1e-4))],
        clamps=[held],
        duration=0.2,
        gravity=(0.0, 0.0, 0.0),
        numerics=Numerics(damping=[(0.045, 0.0), (0.05, 2.0 * lowest)]),
    )
    result = scene.run(frames=20, quiet=True)
    history, points = result.history, result.plies[0].points
    assert result.completed and result.summary["energy_error"] < 2e-3
    bent = history["bending_j"].max()
    assert bent > 3e-5
    assert history["bending_j"][-1] < 1e-4 * bent and history["kinetic_j"][-1] < 1e-4 * bent
    assert np.abs(points[:, 2]).max() < 0.005 * 0.02
    assert history["mass_damping_j"][4] == 0.0 < history["mass_damping_j"][-1]


def test_a_strip_that_friction_holds_keeps_half_of_what_it_was_pulled():
    """Pulled at its end by u over a plate, friction τ = μ p a width: slip comes as far as
    √(2 u EA/τ); led back it slips the other way from the end on, and bears nothing at u/2 already.
    """
    width, pressure, mu, stiffness, way = 0.004, 2e4, 0.3, 1e5, 4e-4
    cloth = yarn_fabric(stiffness, 0.5)
    strip = Ply.rectangle(
        "strip", cloth, 0.2, width, edge=2e-3, mesh="grid", z=0.5 * cloth.thickness
    )
    slip = math.sqrt(2.0 * way * stiffness / (mu * pressure))
    assert slip < 0.15 < 0.2  # the far end never moves
    pulled = Stroke(travel=(way, 0.0, 0.0), duration=0.02).and_back(after=4e-3)
    grip = Clamp(
        name="grip",
        ply="strip",
        where=lambda p: p[:, 0] > 0.1 - 1e-9,
        motion=pulled,
        follow=(1.0, 0.0, 0.0),
    )
    scene = Scene(
        name="locked",
        plies=[strip],
        tools=[Tool.plate(width=0.3, height=0.02)],
        clamps=[grip],
        pressures=[Pressure(name="air", ply="strip", pressure=pressure, ramp=0.0)],
        friction=mu,
        duration=0.05,
        gravity=(0.0, 0.0, 0.0),
        numerics=Numerics(damping=100.0),
    )
    history = scene.run(frames=50, quiet=True).history
    force, moved = history["grip_force_n"], history["grip_displacement_m"]
    most = math.sqrt(2.0 * way * mu * pressure * stiffness) * width
    assert force.max() == pytest.approx(most, rel=0.02)
    back = int(np.argmax(history["time_s"] > 0.024))
    first = back + int(np.argmax(force[back:] < 0.0))
    between = force[first - 1] / (force[first - 1] - force[first])
    middle = 0.5 * (moved[1:] + moved[:-1])  # forces are means over a frame
    zero = middle[first - 2] + between * (middle[first - 1] - middle[first - 2])
    assert zero == pytest.approx(0.5 * way, rel=0.03)


def test_damping_that_means_nothing_is_refused():
    for given, words in (
        (-1.0, "damping = -1.0 1/s must be zero or more"),
        ([(0.0, 0.0), (0.01, -5.0)], r"damping = -5 1/s at 0.01 s is below zero: give zero or"),
        ([(0.0, 0.0)], "damping must be one number"),
        ([(0.01, 0.0), (0.0, 1.0)], "damping: its times must rise"),
    ):
        with pytest.raises(InputError, match=words):
            Numerics(damping=given)


def test_a_finished_run_may_come_to_rest_in_an_extension(tmp_path):
    def scene(duration, damping):
        strip = Ply.rectangle("strip", BENT, 0.03, 0.01, cells=3, mesh="grid")
        return Scene(
            name="rest", plies=[strip], duration=duration, numerics=Numerics(damping=damping)
        )

    scene(2e-3, 0.0).run(tmp_path / "run", frames=2, quiet=True)
    with pytest.raises(InputError, match="numerics: damping"):
        scene(2e-3, 50.0).run(resume=tmp_path / "run", quiet=True)
    longer = scene(4e-3, 50.0).run(resume=tmp_path / "run", extend=True, quiet=True)
    assert longer.completed and longer.history["mass_damping_j"][-1] > 0.0
