"""Time integration: exact and closed solutions, its order, its stable step, its energy."""

import math

import numpy as np
import pytest
from element_checks import forces
from law_checks import PLAIN, SPACING, crimp_table, fabric

from warpdrape.errors import InputError
from warpdrape.flat_mesh import FlatMesh
from warpdrape.laws import IsotropicMembrane, LinearTension, NoShear, ShearPolynomial
from warpdrape.membrane import build_membrane
from warpdrape.model import build_model, initial_state
from warpdrape.motion import Float, Stroke
from warpdrape.ply import Ply, lay_up, stack_top
from warpdrape.scene import Clamp, Numerics, Scene
from warpdrape.stepping import Stepper
from warpdrape.time_step import lump_masses
from warpdrape.tool import Tool

ELASTIC = fabric(LinearTension(300.0, 350.0), ShearPolynomial((2e-4,)), factor=1.0)
INTERLOCK = ShearPolynomial((0.37044e-3, -0.84105e-3, 1.03113e-3))


def march(scene, frames, device="cpu"):
    """Positions at every frame [m], shape [frame + 1, n, 3], and the step [s]."""
    model = build_model(scene, device, frames)
    state = initial_state(model)
    stepper = Stepper(model, state)
    positions = [state.x.numpy().copy()]
    for frame in range(1, frames + 1):
        stepper.begin_frame(frame)
        for _ in range(model.timing.steps_per_frame // model.timing.search_every):
            stepper.block()
        positions.append(state.x.numpy().copy())
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
        name="hang", plies=[ply], clamps=[hold], duration=4 * 2 * math.pi / omega,
        gravity=(0.0, -g, 0.0), numerics=Numerics(time_step=step, stabiliser_floor=0.0),
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
        name="swing", plies=[ply], clamps=[hold], duration=1e5 * step, gravity=scene.gravity,
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


LAWS = {
    "linear": fabric(LinearTension(46e3, 48e3), INTERLOCK),
    "skew": fabric(LinearTension(46e3, 48e3), INTERLOCK, angle=math.radians(60)),
    "soft": fabric(LinearTension(10.0, 11.0), INTERLOCK),
    "crimp": fabric(PLAIN, INTERLOCK),
    "tabulated": fabric(crimp_table(), INTERLOCK, cell=(SPACING, SPACING)),
    "isotropic": fabric(IsotropicMembrane(2e4, 0.3)),
}


def true_frequency_squared(membrane, masses, x):
    """Largest ω² [1/s²] of the assembled stiffness, by differences of the forces."""
    n, step = x.size, 1e-9
    stiffness = np.empty((n, n))
    for k in range(n):
        move = np.zeros(n)
        move[k] = step
        move = move.reshape(x.shape)
        stiffness[:, k] = (forces(membrane, x - move) - forces(membrane, x + move)).ravel() / (2 * step)
    root = np.sqrt(np.repeat(masses, 3))
    scaled = stiffness / np.outer(root, root)
    return np.linalg.eigvalsh(0.5 * (scaled + scaled.T)).max()


def states_of(ply):
    """Flat, stretched, and sheared either way and far past locking, all a little in tension, in a plane."""
    flat = ply.rest_points
    t1, t2 = ply.yarn_directions
    back = np.linalg.inv(np.stack([t1, t2], axis=1))
    states = (1e-4, 0.0), (0.008, 0.0), (1e-4, 0.8), (1e-4, -0.6), (0.008, 0.6), (1e-4, 1.2)
    for strain, shear in states:
        if ply.fabric.yarn_angle - shear < 0.3:
            continue
        angle = ply.fabric.yarn_angle - shear
        yarns = np.array([[1.0, math.cos(angle)], [0.0, math.sin(angle)]]) * (1 + strain)
        x = flat.copy()
        x[:, :2] = flat[:, :2] @ (yarns @ back).T
        yield x


MESHES = [(p, a) for p in ("grid", "diagonal", "random") for a in ("pairs", "plain")]


@pytest.mark.parametrize(
    ("law", "pattern", "averaging"),
    [("linear", *mesh) for mesh in MESHES]
    + [(law, *mesh) for law in LAWS if law != "linear" for mesh in MESHES[1:5:3]],
)
def test_stable_step_is_safe_and_not_far_too_short(law, pattern, averaging):
    ply = Ply.rectangle("ply", LAWS[law], 0.02, cells=3, mesh=pattern, warp_angle=0.3)
    numerics = Numerics(averaging=averaging)
    scene = Scene(name="step", plies=[ply], duration=1.0, numerics=numerics)
    masses = lump_masses(scene)
    assert not masses.added.any()
    bound = 4 / masses.stable_step**2
    membrane = build_membrane(ply, numerics, 0, 0, "cpu")
    true = [true_frequency_squared(membrane, masses.mass, x) for x in states_of(ply)]
    assert max(true) <= bound
    if law != "soft" and pattern != "random":  # its step is set by the shear stiffness at 75°, which no state here reaches
        assert max(true) > 0.25 * bound  # the step is at least half the longest
    if (law, pattern, averaging) == ("linear", "grid", "plain"):
        assert max(true) > 0.8 * bound


def test_a_step_above_the_stable_one_is_refused():
    ply = Ply.rectangle("ply", ELASTIC, 0.02, cells=2)
    stable = lump_masses(Scene(name="s", plies=[ply], duration=1.0)).stable_step
    scene = Scene(name="s", plies=[ply], duration=1.0, numerics=Numerics(time_step=1.01 * stable))
    with pytest.raises(InputError, match=r"time_step = .* above the stable .*minimum_time_step"):
        scene.run()


def test_mass_is_that_of_the_sheet_and_scaling_reports_what_it_adds(device):
    ply = Ply.rectangle("ply", ELASTIC, 0.03, 0.02, edge=5e-3, mesh="random")
    exact = ELASTIC.areal_density * 0.03 * 0.02
    plain = Scene(name="s", plies=[ply], duration=1e-4)
    masses = lump_masses(plain)
    assert masses.mass.sum() == pytest.approx(exact, rel=1e-12)
    assert not masses.added.any()
    target = 1.3 * 0.9 * masses.stable_step
    scaled = Scene(name="s", plies=[ply], duration=1e-4, numerics=Numerics(minimum_time_step=target))
    heavy = lump_masses(scaled)
    assert (heavy.added >= 0.0).all() and heavy.added.sum() > 0.01 * exact
    assert heavy.mass.sum() - heavy.added.sum() == pytest.approx(exact, rel=1e-12)
    assert 0.9 * heavy.stable_step == pytest.approx(target, rel=1e-9)
    result = scaled.run(device=device, frames=1)
    assert result.summary["added_mass_kg"] == pytest.approx(heavy.added.sum(), rel=1e-12)
    assert result.summary["mass_kg"] == pytest.approx(heavy.mass.sum(), rel=1e-12)
    assert result.summary["time_step_s"] <= target * (1 + 1e-12)
    assert plain.run(device=device, frames=1).summary["added_mass_kg"] == 0.0


def test_clamps_follow_their_motion_and_pay_for_it(device):
    ply = Ply.rectangle("ply", ELASTIC, 0.04, 0.02, cells=4)
    move = Stroke(travel=(0.001, 0.0, 0.0), duration=0.02)
    ends = [
        Clamp(name=name, ply="ply", where=lambda p, s=s: s * p[:, 0] > 0.0199, follow=(1.0, 0.0, 0.0),
              **({"motion": move} if s > 0 else {}))
        for name, s in (("fixed", -1.0), ("led", 1.0))
    ]
    scene = Scene(
        name="pull", plies=[ply], clamps=ends, duration=0.025, gravity=(0.0, 0.0, 0.0),
        numerics=Numerics(damping=500.0),
    )
    result = scene.run(device=device, frames=25)
    moved = result.plies[0].points - result.plies[0].rest_points
    right = ply.rest_points[:, 0] > 0.0199
    np.testing.assert_allclose(moved[right], np.broadcast_to((0.001, 0, 0), (right.sum(), 3)), atol=1e-15)
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


def test_a_floating_tool_settles_with_its_reaction_equal_to_its_force(device):
    ply = lay_up([Ply.rectangle("ply", ELASTIC, 0.04, cells=4)])
    top = stack_top(ply)
    table = Tool.plate("table", width=0.1, height=0.1)
    press = Tool.plate("press", width=0.1, height=0.1, facing="down",
                       motion=Float(force=20.0, mass=0.02, ramp=0.01))
    scene = Scene(name="press", plies=ply, tools=[table, press.moved((0.0, 0.0, top + 1e-6))],
                  duration=0.04)
    result = scene.run(device=device, frames=40)
    assert result.summary["status"] == "completed", result.summary["message"]
    pressing = result.history["press_force_n"][-10:]
    np.testing.assert_allclose(np.abs(pressing), 20.0, rtol=0.01)
    weight = result.summary["mass_kg"] * 9.81
    np.testing.assert_allclose(np.abs(result.history["table_force_n"][-10:]), 20.0 + weight, rtol=0.01)
    # Along its axis it went the gap and into two penalty springs, of share · m/Δt² in all.
    spring = 0.02 * result.summary["mass_kg"] / result.summary["time_step_s"] ** 2
    sunk = result.history["press_displacement_m"][-10:]
    np.testing.assert_allclose(sunk, 1e-6 + 2 * 20.0 / spring, rtol=0.01)
    assert result.summary["energy_error"] < 0.02
