"""Softened yarns recover their tension: closed forms in time, what swings dies away, energy."""

import math
from dataclasses import replace

import numpy as np
import pytest
import warp as wp
from element_checks import deformed, forces, membrane_of, patch_ply, whole
from law_checks import fabric

from warpdrape import Numerics, Ply, Scene, Stroke
from warpdrape.dynamics.energy import balance, measure
from warpdrape.dynamics.model import build_model, initial_state
from warpdrape.dynamics.stepping import Stepper
from warpdrape.dynamics.time_step import lump_masses
from warpdrape.errors import InputError
from warpdrape.forces.membrane import build_membrane
from warpdrape.forces.recovery import (
    SLOWER,
    guard_stiffness,
    lowest_frequency,
    recovery_rates,
)
from warpdrape.interaction import Run
from warpdrape.kernels.forces.membrane import PatchMemory, make_yarn_membrane
from warpdrape.kernels.forces.recovery import Recovery, RecoveryRates
from warpdrape.materials.law_data import membrane_functions, tension_stiffness
from warpdrape.materials.laws import LinearTension, ShearPolynomial
from warpdrape.materials.softening import soften
from warpdrape.results.soundness import ENERGY_WARNING
from warpdrape.results.summary_text import summary_text
from warpdrape.scenes import hemisphere
from warpdrape.setup import Clamp

SHEAR = ShearPolynomial((0.37044e-3, -0.84105e-3, 1.03113e-3))
CLOTH = fabric(LinearTension(46e3, 48e3), SHEAR)
SOFT = Numerics(yarn_softening=20.0, yarn_recovery=0.4, yarn_viscosity=0.0)
STEP = 1e-6
NUMERICS = hemisphere.build(cells=4).numerics


def held(pairs, steps, numerics=SOFT):
    """Forces of patches held where they are for so many steps, and what they recovered."""
    rng = np.random.default_rng(3)
    ply = patch_ply(CLOTH, "pair", pairs, rng)
    x = wp.array(deformed(ply, "pair", rng), dtype=wp.vec3d)
    membrane = build_membrane(ply, numerics, whole(ply), STEP, "cpu")
    recovered = wp.zeros(pairs, dtype=Recovery)
    memories = [wp.zeros(load.remembered, load.memory) for load in membrane.loads]
    for _ in range(steps):
        f = wp.zeros(x.shape[0], dtype=wp.vec3d)
        for load, memory in zip(membrane.loads, memories, strict=True):
            run = Run(0, load.count)
            load.launch(run, x, membrane.rates, memory, recovered, f)("cpu")
    softened = membrane.measure(x)[1][membrane.order[membrane.patches[:-1]]]
    return ply, x.numpy(), f.numpy().copy(), recovered.numpy(), np.maximum(softened, 0.0)


@pytest.mark.parametrize("steps", [1, 100])
def test_tension_is_taken_up_at_its_rate(steps):
    """dR/dt = g T_s − g/(s − 1) R at rest, step by step: (s − 1) T_s (1 − (1 − b)ⁿ)."""
    ply, _, _, recovered, softened = held(5, steps)
    slowest = SLOWER * lowest_frequency(ply, SOFT, STEP) * STEP
    share = 0.4 * slowest / 19.0
    expected = 19.0 * softened * (1.0 - (1.0 - share) ** steps)
    assert np.abs(expected).max() > 0.0
    np.testing.assert_allclose(recovered["tension"], expected, rtol=1e-9)


def test_at_rest_the_forces_are_the_fabric_s_own():
    """Slack yarns keep the stiffness that they have in compression, softened or not."""
    ply, x, _, _, softened = held(5, 1)
    assert (softened == 0.0).any() and (softened > 0.0).any()
    at_once = RecoveryRates()
    at_once.taken_up, at_once.let_go, at_once.followed = 19.0, 1.0, 1.0
    membrane = build_membrane(ply, SOFT, whole(ply), STEP, "cpu")
    rates = membrane.rates._replace(recovery=at_once)
    at, f = wp.array(x, dtype=wp.vec3d), wp.zeros(len(x), dtype=wp.vec3d)
    recovered = wp.zeros(5, dtype=Recovery)
    for load in membrane.loads:
        memory = wp.zeros(load.remembered, load.memory)
        load.launch(Run(0, load.count), at, rates, memory, recovered, f)("cpu")
    expected = forces(membrane_of(ply), x)
    scale = np.abs(expected).max()
    assert np.abs(expected - forces(membrane_of(ply, yarn_softening=20.0), x)).max() > 0.1 * scale
    np.testing.assert_allclose(f.numpy(), expected, atol=1e-12 * scale)


def test_pairs_recover_as_patches_do():
    ply, x, f, recovered, _ = held(5, 7)
    membrane = build_membrane(ply, SOFT, whole(ply), STEP, "cpu")
    add_patch_forces, _ = make_yarn_membrane(*membrane_functions(CLOTH))
    _, count, inputs = membrane.measurement
    memory, found = wp.zeros(5, dtype=PatchMemory), wp.zeros(5, dtype=Recovery)
    inputs = [0, *inputs, wp.vec2d(), membrane.rates.recovery, wp.array(x, dtype=wp.vec3d)]
    for _ in range(7):
        alone = wp.zeros(len(x), dtype=wp.vec3d)
        wp.launch(add_patch_forces, count, inputs=inputs, outputs=[memory, found, alone])
    np.testing.assert_allclose(f, alone.numpy(), atol=1e-12 * np.abs(f).max())
    for name in ("tension", "followed", "taken"):
        expected = found.numpy()[name]
        assert np.abs(expected).max() > 0.0
        np.testing.assert_allclose(recovered[name], expected, rtol=1e-9, atol=1e-15)


LENGTH = 0.2
EVEN = replace(CLOTH, compressive_factor=0.05)  # softened 20 times, as stiff either way


def swing(mode, guarded=True, periods=6):
    """Kinetic energy of a free strip that swings along its warp, largest in every half period."""
    ply = Ply.rectangle("strip", EVEN, LENGTH, 0.02, cells=20, mesh="diagonal")
    omega = math.pi / LENGTH * math.sqrt(tension_stiffness(EVEN)[0] / 20.0 / EVEN.areal_density)
    half = math.pi / (mode * omega)
    scene = Scene(
        name="strip",
        plies=[ply],
        duration=2 * periods * half,
        gravity=(0.0, 0.0, 0.0),
        self_contact=False,
        numerics=replace(SOFT, safety=0.2),
    )
    model = build_model(scene, "cpu", 1)
    if not guarded:
        (rates,) = {membrane.rates.recovery for membrane in model.forces[0].plies}
        rates.guard = wp.vec2d()
    state = initial_state(model)
    wave = np.sin(mode * math.pi * ply.rest_points[:, 0] / LENGTH + 0.5 * math.pi * (mode - 1))
    state.plies.v.assign(0.5 * wave[:, None] * (1.0, 0.0, 0.0))
    stepper, every = Stepper(model, state), model.timing.search_every
    stepper.begin_frame(1)
    blocks = model.timing.steps // every
    energies = []
    for _ in range(blocks):
        stepper.block()
        energies.append(balance(model, state, measure(model, state)))
    kinetic = np.array([e.kinetic for e in energies])
    in_half = np.array_split(kinetic, 2 * periods)
    unbalanced = np.array_split([e.unbalanced for e in energies], periods)
    left = unbalanced[-1].mean() - unbalanced[0].mean()  # each is a step's work old
    return np.array([each.max() for each in in_half]), left / kinetic[0]


def test_what_swings_along_the_yarns_dies_away():
    """The guard takes more than recovery feeds, also of the slowest.

    What is left in the balance falls with the step: recovery's work is a step old when it is read.
    """
    for mode, most in ((1, 0.5), (3, 0.5)):
        kinetic, unbalanced = swing(mode, periods=12)
        assert kinetic[-6:].max() < most * kinetic[:6].max()
        assert abs(unbalanced) < 0.02
    fed, unbalanced = swing(3, guarded=False)
    assert fed[-1] > 2.0 * fed[0]
    assert abs(unbalanced) < 0.02  # the balance knows where it came from


def pulled(**numerics):
    """A strip pulled along its warp and held, to rest."""
    ply = Ply.rectangle("ply", "carbon_interlock", 0.1, 0.05, cells=4)
    led = {"ply": "ply", "name": "right", "where": lambda p: p[:, 0] > 0.0499}
    held = Clamp(name="left", ply="ply", where=lambda p: p[:, 0] < -0.0499)
    pull = Stroke(travel=(2e-4, 0.0, 0.0), duration=4e-3)
    return Scene(
        name="strip",
        plies=[ply],
        clamps=[held, Clamp(**led, motion=pull)],
        duration=0.02,
        gravity=(0.0, 0.0, 0.0),
        numerics=Numerics(damping=500.0, **numerics),
    ).run(frames=10)


def test_a_strip_held_for_long_carries_the_fabric_s_tension():
    true, soft = pulled(), pulled(yarn_softening=10.0)
    recovered = pulled(yarn_softening=10.0, yarn_recovery=0.4)
    tension = [r.plies[0].line_tension[:, 0].mean() for r in (true, soft, recovered)]
    assert tension[1] < 0.11 * tension[0]
    assert tension[2] == pytest.approx(tension[0], rel=0.01)
    owed = recovered.history["softening_strain"]
    assert owed[-1] < 0.02 * soft.summary["softening_strain"]
    assert recovered.summary["softening_strain"] == owed[-1]
    assert recovered.summary["mean_softening_strain"] == pytest.approx(owed.mean())
    words = " ".join(summary_text(recovered.summary).split())
    assert "softened 10 times: strains up to" in words and "% over the run" in words
    assert "mean_softening_strain" not in soft.summary
    forces = [abs(r.history["right_force_n"][-1]) for r in (true, recovered)]
    assert forces[1] == pytest.approx(forces[0], rel=0.01)
    stored = [r.history["yarn_j"][-1] for r in (true, recovered)]
    assert stored[1] == pytest.approx(stored[0], rel=0.02)
    assert recovered.summary["energy_error"] < ENERGY_WARNING
    assert "recovery_j" in recovered.history and "recovery_j" not in soft.history


def test_a_hemisphere_stretches_its_yarns_no_more_than_at_full_stiffness():
    given = {"cells": 8, "duration": 0.03}
    full = hemisphere.build(accuracy="reference", **given).run(frames=6)
    found = hemisphere.build(**given).run(frames=6)
    soft = replace(hemisphere.build(**given), numerics=replace(NUMERICS, yarn_recovery=0.0))
    soft = soft.run(frames=6)
    strains = [run.summary["plies"][0]["max_strain_warp"] for run in (full, found, soft)]
    assert strains[1] < 0.1 * strains[2]
    off = [np.abs(run.plies[0].points - full.plies[0].points).max() for run in (found, soft)]
    assert off[0] < off[1]


def test_added_mass_makes_it_slower():
    ply = Ply.rectangle("ply", "carbon_interlock", 0.1, cells=4)
    bare, heavy = SOFT, replace(SOFT, minimum_time_step=4e-5)
    light, laden = (
        lump_masses(Scene(name="s", plies=[ply], duration=1.0, numerics=n)) for n in (bare, heavy)
    )
    heavier = laden.mass.sum() / light.mass.sum()
    assert heavier > 10.0
    one, other = (lowest_frequency(ply, n, 4e-5) for n in (bare, heavy))
    # Shear has its share of the step; ω is slower by far more than that.
    assert 1.0 <= other / one * math.sqrt(heavier) < 1.25
    assert guard_stiffness(ply, bare) == guard_stiffness(ply, heavy)
    softened = tension_stiffness(soften(ply.fabric, 20.0))
    assert guard_stiffness(ply, bare) == pytest.approx([0.8 * k for k in softened])


def growth(rates, stiffness, swing, viscosity):
    """By which a mass on a softened yarn, taut all along, grows in a step at most.

    Args:
        rates: of recovery.
        stiffness: k_s [N/m].
        swing: ω Δt with that alone [-].
        viscosity: of the yarn, over k_s [-].
    """
    guard = float(rates.guard[0]) / stiffness
    taken_up, let_go, follow = map(float, (rates.taken_up, rates.let_go, rates.followed))

    def step(position, velocity, tension, followed, before):
        change = position - before
        tension = tension + taken_up * position - let_go * tension
        followed = followed + follow * (position - followed)
        pull = position + tension + guard * (position - followed) + viscosity * change
        velocity = velocity - swing**2 * pull
        return np.stack([position + velocity, velocity, tension, followed, position])

    return np.abs(np.linalg.eigvals(step(*np.eye(5)))).max()


@pytest.mark.parametrize("softening", [1.5, 20.0, 100.0])
@pytest.mark.parametrize("recovery", [0.02, 0.1, 0.5])
@pytest.mark.parametrize("viscosity", [0.0, 0.067])
def test_no_stable_step_lets_anything_grow(softening, recovery, viscosity):
    """On blanks of 2 to 500 triangles along their side, from the slowest to the fastest."""
    numerics = Numerics(yarn_softening=softening, yarn_recovery=recovery)
    ply = Ply.rectangle("ply", "carbon_interlock", 0.1, cells=4)
    stiffness = tension_stiffness(soften(ply.fabric, softening))[0]
    fastest = 1.8 / math.sqrt(1.0 + 2.0 * recovery + 2.0 * viscosity)
    for slowest in (0.004, 0.02, 0.1, 0.3, 0.5, fastest):
        step = slowest / lowest_frequency(ply, numerics, 1e-6)
        rates = recovery_rates(ply, numerics, step)
        for swing in np.linspace(slowest, fastest, 40):
            assert growth(rates, stiffness, swing, viscosity) < 1.0


def test_recovery_is_refused_where_it_makes_no_sense():
    with pytest.raises(InputError, match=r"yarn_recovery = 0\.6 must not exceed 0\.5"):
        Numerics(yarn_recovery=0.6)
    with pytest.raises(InputError, match="does not know yarn_recovery: set it to 0"):
        replace(hemisphere.build(cells=4), approach="fibre_frame")
    advised = replace(NUMERICS, yarn_recovery=0.0, yarn_softening=36.0)
    scene = replace(hemisphere.build(cells=4), numerics=advised)
    assert replace(scene, approach="fibre_frame").run(frames=1).completed


def test_what_recovery_moves_is_told_and_the_advice_stills_it():
    """A blank of four cells, hardly pushed in: its yarns lie flat, and swing slowly."""
    light = hemisphere.build(cells=4, travel=0.01, duration=0.1)
    (words,) = [w for w in light.run(frames=10).summary["warnings"] if "softened" in w]
    assert "as they recovered" in words and "set yarn_recovery = 0" in words
    still = replace(light, numerics=replace(light.numerics, yarn_recovery=0.0)).run(frames=10)
    exact = hemisphere.build(cells=4, travel=0.01, accuracy="reference").run(frames=10)
    for advised in (still, exact):
        assert advised.summary["quasi_static"] and advised.summary["warnings"] == []
