"""Time integration: exact and closed solutions, its order, its stable step, its energy."""

import math
from dataclasses import replace

import numpy as np
import pytest
from law_checks import fabric

from warpdrape.blanks.flat_mesh import FlatMesh
from warpdrape.blanks.ply import Ply, lay_up, stack_top
from warpdrape.dynamics.model import build_model, initial_state
from warpdrape.dynamics.stepping import Stepper
from warpdrape.dynamics.time_step import lump_masses
from warpdrape.errors import InputError
from warpdrape.interaction import bodies_of
from warpdrape.materials.bending import Bending
from warpdrape.materials.laws import LinearTension, NoShear, ShearPolynomial
from warpdrape.numerics import Numerics
from warpdrape.scene import Scene
from warpdrape.setup import Clamp
from warpdrape.tools.floating import Float
from warpdrape.tools.motion import Path, Stroke
from warpdrape.tools.tool import Tool

ELASTIC = fabric(LinearTension(300.0, 350.0), ShearPolynomial((2e-4,)), factor=1.0)


def march(scene, frames, device="cpu"):
    """Positions at every frame [m], shape [frame + 1, n, 3], and the step [s]."""
    model = build_model(scene, device, frames)
    state = initial_state(model)
    stepper = Stepper(model, state)
    positions = [state.plies.x.numpy().copy()]
    for frame in range(1, frames + 1):
        stepper.begin_frame(frame)
        for _ in range(model.timing.steps_per_frame // model.timing.search_every):
            stepper.block()
        positions.append(state.plies.x.numpy().copy())
    return np.array(positions), model.timing


def test_free_fall_is_exact(device):
    gravity = np.array([1.0, -2.0, -9.81])
    ply = Ply.rectangle("ply", ELASTIC, 0.02, cells=2, z=0.3)
    scene = Scene(name="fall", plies=[ply], duration=0.01, gravity=gravity)
    x, timing = march(scene, 10, device)
    time = np.arange(11) * timing.steps_per_frame * timing.time_step
    fallen = x - x[0]
    exact = 0.5 * time[:, None, None] ** 2 * gravity
    # Velocities are half a step apart from positions: the fall begins within a step.
    within = time[:, None, None] * timing.time_step * np.abs(gravity)
    assert (np.abs(fallen - exact) <= within + 1e-15).all()
    second = fallen[2:] - 2 * fallen[1:-1] + fallen[:-2]
    frame = timing.steps_per_frame * timing.time_step
    np.testing.assert_allclose(second, np.broadcast_to(gravity * frame**2, second.shape), rtol=1e-9)


def test_mass_damping_slows_a_fall_as_it_should(device):
    ply = Ply.rectangle("ply", ELASTIC, 0.02, cells=2)
    rate, duration = 300.0, 0.01
    scene = Scene(name="fall", plies=[ply], duration=duration, numerics=Numerics(damping=rate))
    result = scene.run(device=device, frames=10)
    # v' = −g − c v from rest.
    exact = -9.81 / rate * (duration - (1 - math.exp(-rate * duration)) / rate)
    fallen = (result.plies[0].points - result.plies[0].rest_points)[:, 2]
    np.testing.assert_allclose(fallen, exact, rtol=2e-3)
    assert result.summary["energy_error"] < 2e-3
    assert result.history["damping_j"][-1] > 0.3 * result.history["external_work_j"][-1]


HEIGHT, BASE = 0.02, 0.03
SPRING = fabric(LinearTension(300.0, 350.0), NoShear(), factor=1.0)


def hanging(step=None, g=9.81):
    """One triangle held at its base, its tip hanging on warp yarns; its ω [1/s] and the scene.

    k1 stretches by u/h, so the tip feels A E' u/h² on a mass of ρ A/3: ω² = 3 E'/(ρ h²).
    """
    mesh = FlatMesh([(-BASE / 2, 0.0), (BASE / 2, 0.0), (0.0, -HEIGHT)], [[0, 2, 1]])
    ply = Ply(name="tip", fabric=SPRING, mesh=mesh, warp_angle=-math.pi / 2)
    line = SPRING.tension.warp / SPRING.yarn_width[0]
    omega = math.sqrt(3 * line / SPRING.areal_density) / HEIGHT
    hold = Clamp(name="base", ply="tip", where=[0, 1], follow=(0.0, 1.0, 0.0))
    scene = Scene(
        name="hang",
        plies=[ply],
        clamps=[hold],
        duration=4 * 2 * math.pi / omega,
        gravity=(0.0, -g, 0.0),
        numerics=Numerics(time_step=step, stabiliser_floor=0.0),
    )
    return scene, omega


def frequency(positions, frame):
    """ω [1/s] of samples that follow a + b cos ωt + c sin ωt, from their recurrence."""
    middle = positions.mean()
    for _ in range(20):
        y = positions - middle
        cosine = (y[1:-1] * (y[2:] + y[:-2])).sum() / (2 * (y[1:-1] ** 2).sum())
        # The mean that leaves the recurrence y+ + y− = 2 cos y without a rest.
        rest = (positions[2:] + positions[:-2] - 2 * cosine * positions[1:-1]).mean()
        middle = rest / (2 - 2 * cosine)
    return math.acos(cosine) / frame


def test_vertex_on_a_yarn_swings_with_its_period_to_second_order(device):
    _, omega = hanging()
    errors = []
    steps = [0.4 / omega, 0.2 / omega, 0.1 / omega]
    for step in steps:
        scene, _ = hanging(step)
        x, timing = march(scene, 60, device)
        frame = timing.steps_per_frame * timing.time_step
        tip = x[:, 2, 1]
        found = frequency(tip, frame)
        # Central differences swing at sin(ω_d Δt/2) = ω Δt/2.
        discrete = 2 / timing.time_step * math.asin(0.5 * omega * timing.time_step)
        assert found == pytest.approx(discrete, rel=1e-7)
        errors.append((found / omega - 1, timing.time_step))
        # About its place of rest, g/ω² lower, and as far below it as above.
        deepest = -HEIGHT - 2 * 9.81 / omega**2
        assert tip.min() == pytest.approx(deepest, abs=0.1 * 9.81 / omega**2)
        np.testing.assert_allclose(x[:, 2, [0, 2]], 0.0, atol=1e-16)
    (e0, t0), (e1, t1), (e2, t2) = errors
    assert math.log(e0 / e1) / math.log(t0 / t1) == pytest.approx(2.0, abs=0.05)
    assert math.log(e1 / e2) / math.log(t1 / t2) == pytest.approx(2.0, abs=0.05)


def test_clamp_carries_the_weight_of_what_hangs_on_it(device):
    _, omega = hanging()
    scene, _ = hanging(0.02 / omega)
    result = scene.run(device=device, frames=4)  # each frame is one whole period
    force = result.history["base_force_n"][1:]
    weight = result.summary["mass_kg"] * 9.81
    np.testing.assert_allclose(force, weight, rtol=0.005)
    assert abs(result.history["clamp_work_j"]).max() == 0.0


def test_energy_of_a_free_vibration_does_not_drift(device):
    # As stiff in compression as in tension: the kink between them makes a few per cent of drift in
    # as many steps of a sheet that swings this wildly, as no integrator with a fixed step avoids.
    ply = Ply.rectangle("sheet", ELASTIC, 0.02, cells=1)
    hold = Clamp(name="left", ply="sheet", where=lambda p: p[:, 0] < -0.0099)
    scene = Scene(name="swing", plies=[ply], clamps=[hold], duration=1.0, gravity=(2e4, 2e3, 5e2))
    step = lump_masses(scene).stable_step * 0.5
    scene = Scene(
        name="swing",
        plies=[ply],
        clamps=[hold],
        duration=1e5 * step,
        gravity=scene.gravity,
        numerics=Numerics(time_step=step),
    )
    result = scene.run(device=device, frames=200)
    assert result.summary["steps"] >= 1e5, result.summary["message"]
    history = result.history
    scale = np.abs(history["external_work_j"]).max()
    assert history["kinetic_j"].max() > 0.05 * scale
    assert history["internal_j"].max() > 0.3 * scale
    # What is out of balance swings with the step, as velocities are half a step late; no drift.
    parts = history["unbalanced_j"][1:].reshape(5, 40).mean(axis=1)
    assert np.ptp(parts) < 2e-3 * scale
    assert np.abs(history["unbalanced_j"]).max() < 0.1 * scale


def test_clamps_follow_their_motion_and_pay_for_it(device):
    ply = Ply.rectangle("ply", ELASTIC, 0.04, 0.02, cells=4)
    move = Stroke(travel=(0.001, 0.0, 0.0), duration=0.02)
    ends = [
        Clamp(
            name=name,
            ply="ply",
            where=lambda p, s=s: s * p[:, 0] > 0.0199,
            follow=(1.0, 0.0, 0.0),
            **({"motion": move} if s > 0 else {}),
        )
        for name, s in (("fixed", -1.0), ("led", 1.0))
    ]
    scene = Scene(
        name="pull",
        plies=[ply],
        clamps=ends,
        duration=0.025,
        gravity=(0.0, 0.0, 0.0),
        numerics=Numerics(damping=500.0),
    )
    result = scene.run(device=device, frames=25)
    moved = result.plies[0].points - result.plies[0].rest_points
    right = ply.rest_points[:, 0] > 0.0199
    np.testing.assert_allclose(
        moved[right], np.broadcast_to((0.001, 0, 0), (right.sum(), 3)), atol=1e-15
    )
    # T per metre times the width; weft and shear stay free.
    line = ELASTIC.tension.warp / ELASTIC.yarn_width[0]
    expected = line * (0.001 / 0.04) * 0.02
    assert result.history["led_force_n"][-1] == pytest.approx(expected, rel=1e-3)
    assert result.history["fixed_force_n"][-1] == pytest.approx(-expected, rel=1e-3)
    work = result.history["clamp_work_j"][-1]
    stored, lost = result.history["internal_j"][-1], result.history["damping_j"][-1]
    assert stored == pytest.approx(0.5 * expected * 0.001, rel=1e-3)
    assert work == pytest.approx(stored + lost, rel=2e-3)
    assert result.history["led_displacement_m"][-1] == pytest.approx(0.001)


def test_a_clamp_holds_its_own_ply():
    low, high = lay_up([Ply.rectangle(name, ELASTIC, 0.02, cells=2) for name in ("low", "high")])
    lift = Stroke(travel=(0.0, 0.0, 1e-3), duration=1e-3)
    clamp = Clamp(name="all", ply="high", where=lambda p: p[:, 0] < 1.0, motion=lift)
    scene = Scene(
        name="lift", plies=[low, high], clamps=[clamp], duration=1e-3, gravity=(0.0, 0.0, 0.0)
    )
    result = scene.run(frames=1)
    moved = {ply.name: ply.points - ply.rest_points for ply in result.plies}
    np.testing.assert_allclose(moved["high"][:, 2], 1e-3, atol=1e-15)
    np.testing.assert_allclose(moved["low"], 0.0, atol=1e-15)


def test_a_vertex_that_is_not_a_number_counts_as_run_away(device):
    ply = Ply.rectangle("ply", ELASTIC, 0.02, cells=2)
    model = build_model(Scene(name="nan", plies=[ply], duration=1e-3), device, 1)
    for value in (np.nan, np.inf):
        state = initial_state(model)
        velocity = np.zeros((len(ply.rest_points), 3))
        velocity[3, 1] = value
        state.plies.v.assign(velocity)
        stepper = Stepper(model, state)
        stepper.begin_frame(1)
        assert state.plies.runaway.numpy()[0] == -1
        stepper.block()
        assert state.plies.runaway.numpy()[0] >= 0


def test_a_clamp_turns_its_vertices_by_its_matrix(device):
    ply = Ply.rectangle("ply", ELASTIC, 0.03, cells=2)
    spin = Stroke(travel=(0.0, 0.0, 1.0), duration=5e-3)

    def matrix(times):
        angle = 1.2 * spin.displacement(times)[..., 2]
        c, s, o = np.cos(angle), np.sin(angle), 0 * angle
        return np.stack(
            [np.stack([c, -s, o], -1), np.stack([s, c, o], -1), np.stack([o, o, o + 1], -1)], -2
        )

    turn = Clamp(name="all", ply="ply", where=lambda p: p[:, 0] < 1.0, matrix=matrix)
    scene = Scene(name="turn", plies=[ply], clamps=[turn], duration=5e-3, gravity=(0.0, 0.0, 0.0))
    result = scene.run(device=device, frames=2)
    exact = ply.rest_points @ matrix(np.array(1.0)).T
    np.testing.assert_allclose(result.plies[0].points, exact, atol=1e-15)
    kinetic = result.history["kinetic_j"]
    inertia = (lump_masses(scene).mass * (ply.rest_points**2).sum(axis=1)).sum()
    rate = 1.2 * spin.peak_speed  # half-way a stroke goes fastest
    assert kinetic[1] == pytest.approx(0.5 * inertia * rate**2, rel=1e-3)
    assert abs(result.history["clamp_work_j"][-1]) < 1e-3 * kinetic[1]


def test_a_floating_tool_settles_with_its_reaction_equal_to_its_force(device):
    ply = lay_up([Ply.rectangle("ply", ELASTIC, 0.04, cells=4)])
    top = stack_top(ply)
    table = Tool.plate("table", width=0.1, height=0.1)
    press = Tool.plate(
        "press",
        width=0.1,
        height=0.1,
        facing="down",
        motion=Float(force=20.0, mass=0.02, ramp=0.01),
    )
    scene = Scene(
        name="press", plies=ply, tools=[table, press.moved((0.0, 0.0, top + 1e-6))], duration=0.04
    )
    result = scene.run(device=device, frames=40)
    assert result.summary["status"] == "completed", result.summary["message"]
    pressing = result.history["press_force_n"][-10:]
    np.testing.assert_allclose(pressing, 20.0, rtol=0.01)  # along its axis, down
    weight = result.summary["mass_kg"] * 9.81
    np.testing.assert_allclose(result.history["table_force_n"][-10:], 20.0 + weight, rtol=0.01)
    # Along its axis it went the gap and into two penalty springs, of share · m/Δt² in all.
    share, step = Numerics().contact_share, result.summary["time_step_s"]
    spring = share * result.summary["mass_kg"] / step**2
    sunk = result.history["press_displacement_m"][-10:]
    np.testing.assert_allclose(sunk, 1e-6 + 2 * 20.0 / spring, rtol=0.01)
    assert result.summary["energy_error"] < 0.02


def test_a_clamp_must_begin_where_its_vertices_lie():
    ply = Ply.rectangle("ply", ELASTIC, 0.04, 0.02, cells=4)
    path = Path(times=(0.0, 0.01), positions=((1e-3, 0.0, 0.0), (2e-3, 0.0, 0.0)))
    clamp = Clamp(name="grip", ply="ply", where=[0, 1], motion=path)
    scene = Scene(name="jump", plies=[ply], clamps=[clamp], duration=0.01)
    with pytest.raises(InputError, match="'grip' does not begin where its vertices lie"):
        scene.run()


def test_heat_and_pressing_are_asked_for_only_where_there_are_any():
    ply = Ply.rectangle("ply", ELASTIC, 0.02, cells=2)
    bodies = bodies_of(
        initial_state(build_model(Scene(name="cold", plies=[ply], duration=0.01), "cpu", 1))
    )
    with pytest.raises(LookupError, match="no ply of this scene cools"):
        _ = bodies.cooling
    with pytest.raises(LookupError, match="nothing in this scene asks"):
        _ = bodies.pressed
    heat, pressing = object(), object()
    warm = bodies._replace(heat=heat, pressing=pressing)
    assert warm.cooling is heat and warm.pressed is pressing


@pytest.mark.parametrize(
    ("plies", "bending", "tool", "names"),
    [
        (1, None, None, []),
        (1, None, "dome", ["tool contact"]),
        (1, None, "pin", ["ply surfaces", "tool features", "tool contact"]),
        (1, Bending(warp=2e-4, weft=3e-4), None, ["ply surfaces", "self-contact", "edge contact"]),
        (2, None, None, ["ply surfaces", "ply contact", "edge contact"]),
    ],
)
def test_contacts_come_with_the_surfaces_that_they_search(plies, bending, tool, names):
    cloth = replace(ELASTIC, bending=bending)
    stack = lay_up([Ply.rectangle(f"ply_{k}", cloth, 0.02, cells=4) for k in range(plies)])
    tools = {
        None: [],
        "dome": [Tool.sphere("dome", radius=0.2)],
        "pin": [Tool.sphere("pin", radius=1e-3)],
    }[tool]
    tools = [each.moved((0.0, 0.0, -0.5)) for each in tools]
    model = build_model(Scene(name="meet", plies=stack, tools=tools, duration=0.01), "cpu", 1)
    assert [contact.name for contact in model.contacts] == names
