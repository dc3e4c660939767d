"""Cases with a closed form and no contact: waves, free fall, catenary, energy, order in time."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import warp as wp

from warpdrape import Numerics, Ply, Scene, Still, Stroke
from warpdrape.coupons.closed_forms import catenary_sag
from warpdrape.dynamics.energy import internal_energy
from warpdrape.dynamics.model import Model, build_model, initial_state
from warpdrape.dynamics.partition import split
from warpdrape.dynamics.stepping import Stepper
from warpdrape.materials.fabric_library import with_bending
from warpdrape.state import State
from warpdrape.verification.case import CaseResult, absolute, relative
from warpdrape.verification.strip import middle_line, strip_scene, yarn_fabric

GRAVITY = 9.81
LOOSE_STEPS = 20_000
"""Steps for which a loose ply is followed."""


def wave_speed() -> CaseResult:
    """Pull one end smoothly by a little; half of it has come to x = c (t − τ/2) at time t.

    c = √(N'/ρ_A), N' the line stiffness: all of the sheet's mass moves, the crossing yarns' too.
    """
    stiffness, density, length = 34e6, 0.63, 1.0
    speed = math.sqrt(stiffness / density)
    rise, end = 0.25 * length / speed, 0.8 * length / speed
    pull = Stroke(travel=(-1e-5, 0.0, 0.0), duration=rise, ramp=0.5)
    scene = strip_scene(yarn_fabric(stiffness, density), length, 200, duration=end, left=pull)
    x, points = middle_line(scene.run(frames=4))
    moved = (points[:, 0] - x) / -1e-5
    front = np.interp(0.5, moved[::-1], x[::-1]) + 0.5 * length
    return relative("wave speed along a yarn", front / (end - 0.5 * rise), speed, 1e-3, "m/s")


def free_fall() -> CaseResult:
    """A free strip falls by g t²/2; from rest the first kick makes it g t (t + Δt)/2."""
    time = 0.1
    scene = strip_scene(yarn_fabric(1e5, 0.6), 0.1, 5, duration=time, gravity=(0.0, 0.0, -GRAVITY))
    result = scene.run(frames=2)
    fallen = -float(result.plies[0].points[:, 2].mean())
    return relative("free fall in 0.1 s", fallen, 0.5 * GRAVITY * time**2, 1e-3, "m")


def catenary() -> CaseResult:
    """A chain of length 1 m hangs between two points 0.8 m apart; exact for inextensible ones."""
    length, span = 1.0, 0.8
    move = 0.5 * (length - span)
    scene = strip_scene(
        yarn_fabric(2e4, 0.6, shear=1.0),
        length,
        40,
        duration=2.5,
        left=Stroke(travel=(move, 0.0, 0.0), duration=0.8),
        right=Stroke(travel=(-move, 0.0, 0.0), duration=0.8),
        gravity=(0.0, 0.0, -GRAVITY),
        numerics=Numerics(damping=12.0),
    )
    _, points = middle_line(scene.run(frames=10))
    return relative("catenary, sag", -points[:, 2].min(), catenary_sag(length, span), 2e-3, "m")


def energy_drift() -> CaseResult:
    """Energy of a free strip that vibrates along itself, over 1e5 steps: last against first tenth.

    The kick–drift velocities belong to half steps; half a kick brings them to the positions' time.
    """
    length = 0.1
    numerics = Numerics(safety=0.3, search_slide=5e-4)  # small steps: energy as of the exact one
    scene = strip_scene(yarn_fabric(1e5, 0.6), length, 10, duration=1.0, numerics=numerics)
    model = build_model(scene, "cpu", 1)
    state = initial_state(model)
    x = model.rest.numpy()
    x[:, 0] += 1e-5 * np.sin(math.pi * x[:, 0] / length)
    state.plies.x.assign(x)
    stepper = Stepper(model, state)
    stepper.begin_frame(1)
    blocks = math.ceil(1e5 / model.timing.search_every)
    energy = np.empty(blocks)
    for block in range(blocks):
        stepper.block()
        energy[block] = _synchronous_energy(model, state)
    tenth = blocks // 10
    drift = energy[-tenth:].mean() / energy[:tenth].mean() - 1.0
    return absolute("energy drift over 1e5 steps of free vibration", drift, 0.0, 1e-5)


def _synchronous_energy(model: Model, state: State) -> float:
    """Kinetic and internal energy [J] at the positions' time."""
    f = wp.zeros_like(state.plies.f)
    (whole,) = split(model, replace(state, plies=replace(state.plies, f=f)), 1)
    for launch in whole.launches.scatter:
        launch(model.device)
    mass = model.masses.mass
    v = state.plies.v.numpy() + 0.5 * model.timing.time_step * f.numpy() / mass[:, None]
    return float(0.5 * (mass * (v**2).sum(axis=1)).sum() + internal_energy(model, state))


def loose_sheet(viscosity: float | None = None) -> CaseResult:
    """A loose ply shaken a little: its energy may not grow, though yarns rest at their corner.

    Central differences are stable on either branch of the yarns' law, tension or compression (a
    hundredth as stiff), and not across the corner between them; viscosity holds that.

    Args:
        viscosity: of the yarns; the default one if None.
    """
    cloth = with_bending("carbon_interlock", "none")
    ply = Ply.rectangle("loose", cloth, 0.1, cells=6)
    numerics = Numerics() if viscosity is None else Numerics(yarn_viscosity=viscosity)
    scene = Scene(
        name="loose", plies=[ply], duration=0.05, gravity=(0.0, 0.0, 0.0), numerics=numerics
    )
    model = build_model(scene, "cpu", 1)
    state = initial_state(model)
    state.plies.v.assign(0.1 * np.random.default_rng(1).standard_normal(ply.rest_points.shape))
    stepper = Stepper(model, state)
    stepper.begin_frame(1)
    first = 0.5 * model.masses.mass @ (state.plies.v.numpy() ** 2).sum(axis=1)
    energy = np.empty(LOOSE_STEPS // model.timing.search_every)
    for block in range(len(energy)):
        stepper.block()
        energy[block] = _synchronous_energy(model, state)
    growth = float(np.maximum(energy.max() / first - 1.0, 0.0))  # not a number if any is none
    return absolute("growth of the energy of a loose ply", growth, 0.0, 0.01)


def time_order() -> CaseResult:
    """Observed order of a shaken strip's positions, by steps of 1, 1/2 and 1/4 of one size."""
    length, cells = 0.1, 10
    fabric = yarn_fabric(1e5, 0.6)
    end = 4.0 * length / math.sqrt(1e5 / 0.6)
    pull = Stroke(travel=(1e-3, 0.0, 0.0), duration=end, ramp=0.5)

    def final(time_step: float) -> np.ndarray:
        numerics = Numerics(time_step=time_step)
        scene = strip_scene(
            fabric, length, cells, duration=end, left=Still(), right=pull, numerics=numerics
        )
        return scene.run(frames=1).plies[0].points

    step = end / 256
    coarse, middle, fine = (final(step / 2**k * (1 + 1e-9)) for k in range(3))
    order = math.log2(np.linalg.norm(coarse - middle) / np.linalg.norm(middle - fine))
    return absolute("order of the time integrator", order, 2.0, 0.1)


def mechanics(quick: bool) -> list[CaseResult]:
    """All cases of this file; they are quick enough to be always the same."""
    return [wave_speed(), free_fall(), catenary(), energy_drift(), loose_sheet(), time_order()]
