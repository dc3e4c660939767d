"""The energy balance: every term once, with its sign; added mass has inertia and no weight."""

from dataclasses import fields

import numpy as np
import pytest

from warpdrape.blanks.ply import Ply
from warpdrape.dynamics.energy import Energies, balance, measure
from warpdrape.dynamics.model import build_model, initial_state
from warpdrape.dynamics.stepping import Stepper
from warpdrape.numerics import Numerics
from warpdrape.scene import Scene

SUPPLIED = {"tool_work", "clamp_work", "gravity_work", "load_work"}
LISTED_ONLY = {"added_mass_kinetic"}  # a part of the kinetic energy

SELECTIVE = {"mass_scaling": "selective", "minimum_time_step": 5e-6}

STORED = ("yarn", "shear", "stabiliser")
LOST = ("viscosity",)


def powers_of_two():
    names = [field.name for field in fields(Energies) if field.name not in ("stored", "lost")]
    return {name: 2.0**k for k, name in enumerate((*names, *STORED, *LOST))}


def energies_of(terms):
    others = {name: energy for name, energy in terms.items() if name not in STORED + LOST}
    stored, lost = ({name: terms[name] for name in names} for names in (STORED, LOST))
    return Energies(stored=stored, lost=lost, **others)


def test_every_term_is_in_the_balance_once():
    terms = powers_of_two()
    found = sum(v for name, v in terms.items() if name not in SUPPLIED | LISTED_ONLY)
    assert energies_of(terms).unbalanced == found - sum(terms[name] for name in SUPPLIED)


def test_sums_hold_what_their_names_say():
    terms = powers_of_two()
    energies = energies_of(terms)
    for name, parts in {
        "internal": STORED,
        "damping": ("contact_damping", "mass_damping", "tool_damping", *LOST),
        "external_work": tuple(SUPPLIED),
    }.items():
        assert getattr(energies, name) == sum(terms[part] for part in parts), name


def test_added_mass_has_inertia_and_no_weight(device):
    ply = Ply.rectangle("ply", "carbon_interlock", 0.1, cells=3, mesh="random")
    scene = Scene(
        name="fall",
        plies=[ply],
        duration=1e-3,
        numerics=Numerics(minimum_time_step=2e-5),
        gravity=(0.0, 0.0, -10.0),
    )
    model = build_model(scene, device, 1)
    added, mass = model.masses.added, model.masses.mass
    assert added.sum() > 0.5 * mass.sum()
    state = initial_state(model)
    speed = np.linspace(1.0, 3.0, len(mass))
    drop = np.linspace(0.01, 0.02, len(mass))
    state.plies.v.assign(speed[:, None] * (0.6, 0.0, 0.8))
    state.plies.x.assign(ply.rest_points - drop[:, None] * (0.0, 0.0, 1.0))
    energies = balance(model, state, measure(model, state))
    assert energies.kinetic == pytest.approx(0.5 * (mass * speed**2).sum())
    assert energies.added_mass_kinetic == pytest.approx(0.5 * (added * speed**2).sum())
    fallen = drop + 0.5 * model.timing.time_step * 0.8 * speed  # when the velocities were these
    assert energies.gravity_work == pytest.approx(10.0 * ((mass - added) * fallen).sum())


@pytest.mark.parametrize("numerics", [{}, {"damping": 300.0}, SELECTIVE], ids=str)
@pytest.mark.parametrize("steps", [1, 2, 5, 40])
def test_a_fall_is_in_balance_from_the_first_step_on(steps, numerics, device):
    """Gravity's work is counted at the velocities' time: nothing is left however few the steps."""
    ply = Ply.rectangle("ply", "carbon_interlock", 0.1, cells=3)
    given = {"name": "fall", "plies": [ply], "numerics": Numerics(contact="exact", **numerics)}
    step = build_model(Scene(**given, duration=1e-3), device, 1).timing.time_step
    scene = Scene(**given, duration=0.99 * steps * step, gravity=(3.0, 0.0, -9.81))
    result = scene.run(device=device, frames=1)
    history, summary = result.history, result.summary
    assert (summary["steps"], summary["status"]) == (steps, "completed")
    assert summary["energy_error"] < 1e-9
    assert history["kinetic_j"][-1] > 0.9 * history["external_work_j"][-1] > 0.0


@pytest.mark.parametrize("averaging", ["pairs", "plain"])
def test_what_yarn_viscosity_loses_is_what_the_ply_loses(averaging):
    """A loose ply shaken in space: most of its energy goes, all of it into the viscosity."""
    ply = Ply.rectangle("loose", "carbon_interlock", 0.1, cells=4)
    scene = Scene(
        name="loose",
        plies=[ply],
        duration=0.02,
        gravity=(0.0, 0.0, 0.0),
        numerics=Numerics(averaging=averaging, safety=0.5),
    )
    model = build_model(scene, "cpu", 1)
    state = initial_state(model)
    state.plies.v.assign(0.1 * np.random.default_rng(1).standard_normal(ply.rest_points.shape))
    first = balance(model, state, measure(model, state)).kinetic
    stepper = Stepper(model, state)
    stepper.begin_frame(1)
    for _ in range(4000 // model.timing.search_every):
        stepper.block()
    energies = balance(model, state, measure(model, state))
    assert energies.lost["viscosity"] > 0.1 * first
    # Kinetic energy is half a step old: a few per cent of what still swings.
    assert energies.unbalanced == pytest.approx(first, rel=0.03)
