"""Borders of plies between plies: their edges are felt, what comes over them lies on its side."""

import math

import numpy as np
import pytest
from interaction_checks import of_kind
from test_edge_contact import LIMP, SIDE, found, launched
from test_ply_search import THICKNESS, contact_of, memory_of, of_look

from warpdrape import Ply, Scene, lay_up
from warpdrape.contact.edge_contact import EdgeContact
from warpdrape.dynamics import energy, interactions, stepping
from warpdrape.dynamics.model import build_model, initial_state
from warpdrape.interaction import bodies_of
from warpdrape.numerics import Numerics

CLIMB, SLANT = 0.6, 0.9
"""Of a roof's ridge, and of its legs [rad]."""


def roof_under_a_rim(device, gap=2e-4, turned=False):
    """A roof that climbs out from under a flat ply, its ridge across that one's rim in mid-edge.

    Args:
        device: Warp device.
        gap: between the surfaces of ridge and rim [m].
        turned: upside down, the flat ply lowest.
    """
    names = ("flat", "roof") if turned else ("roof", "flat")
    plies = lay_up([Ply.rectangle(n, LIMP, 6 * SIDE, cells=6, mesh="diagonal") for n in names])
    scene = Scene(
        name="rim",
        plies=plies,
        duration=4e-3,
        gravity=(0.0, 0.0, 0.0),
        numerics=Numerics(yarn_softening=4.0),
    )
    model = build_model(scene, device, frames=1)
    state, rest = initial_state(model), model.rest.numpy()
    roof, flat = (model.spans[k].vertices for k in ((1, 0) if turned else (0, 1)))
    x = np.zeros_like(rest)
    along, leg = rest[roof, 0], math.sin(SLANT) * np.abs(rest[roof, 1])
    x[roof, 0] = math.cos(CLIMB) * along + math.sin(CLIMB) * leg
    x[roof, 1] = math.cos(SLANT) * rest[roof, 1]
    x[roof, 2] = math.sin(CLIMB) * along - math.cos(CLIMB) * leg
    x[flat, :2] = rest[flat, :2] + (0.5 * math.cos(CLIMB) * SIDE - 3.0 * SIDE, 0.5 * SIDE)
    x[flat, 2] = 0.5 * math.sin(CLIMB) * SIDE + (LIMP.thickness + gap) / math.cos(CLIMB)
    if turned:
        x[:, 2] *= -1.0
    state.plies.x.assign(x)
    rim = np.flatnonzero(
        np.isclose(rest[flat, 0], 3.0 * SIDE) & (np.abs(rest[flat, 1] + 0.5 * SIDE) < 0.6 * SIDE)
    )
    ridge = np.flatnonzero(
        np.isclose(rest[roof, 1], 0.0) & (np.abs(rest[roof, 0] - 0.5 * SIDE) < 0.6 * SIDE)
    )
    return model, state, (ridge + roof.start, rim + flat.start)


def apart(x, ridge, rim, up):
    """How far a rim lies over a ridge, across both [m]."""
    normal = np.cross(x[rim[1]] - x[rim[0]], x[ridge[1]] - x[ridge[0]])
    normal *= up * np.sign(normal[2]) / np.linalg.norm(normal)
    return (x[rim].mean(axis=0) - x[ridge[0]]) @ normal


def least_apart(model, state, edges, turned):
    """Ridge and rim thrown at each other at 1 m/s: the least they come apart [m], and energies."""
    up, x = -1.0 if turned else 1.0, state.plies.x.numpy()
    over = np.zeros(len(x), dtype=bool)
    over[model.spans[0 if turned else 1].vertices] = True
    v = np.zeros_like(x)
    v[:, 2] = 0.5 * up * np.where(over, -1.0, 1.0)
    state.plies.v.assign(v)
    start = energy.balance(model, state, energy.measure(model, state))
    stepper, least = stepping.Stepper(model, state), np.inf
    stepper.begin_frame(1)
    for _ in range(model.timing.steps // model.timing.search_every):
        stepper.block()
        least = min(least, apart(state.plies.x.numpy(), *edges, up))
    end = energy.balance(model, state, energy.measure(model, state))
    return least, abs(end.unbalanced - start.unbalanced) / start.kinetic


@pytest.mark.parametrize("turned", [False, True], ids=["from below", "from above"])
def test_a_fold_is_held_by_the_rim_of_another_ply(device, monkeypatch, turned):
    """Between the rim's vertices, past which it went before; no energy comes from nowhere."""
    model, state, edges = roof_under_a_rim(device, turned=turned)
    least, unbalanced = least_apart(model, state, edges, turned)
    assert least > 0.7 * LIMP.thickness
    assert unbalanced < 2e-3
    others = [c for c in interactions.CONTACTS if not c.__name__.endswith("edge_contact")]
    monkeypatch.setattr(interactions, "CONTACTS", tuple(others))
    model, state, edges = roof_under_a_rim(device, turned=turned)
    least, _ = least_apart(model, state, edges, turned)
    assert least < -LIMP.thickness, "vertices alone let it through"


def test_a_rim_is_felt_at_its_gap_and_on_its_faces(device):
    gap = 1e-6
    model, state, (ridge, rim) = roof_under_a_rim(device, gap)
    contact, memory = of_kind(model, state, EdgeContact)
    stepping.search_contacts(model, state)
    contact.hollows.zero_()  # the roof's, which are room
    launched(model, state, "ask")
    pairs = found(model, state)
    assert pairs[tuple(ridge), tuple(rim)] == pytest.approx(gap, abs=1e-9)
    assert pairs[tuple(rim), tuple(ridge)] == pytest.approx(gap, abs=1e-9)
    x, flat = state.plies.x.numpy(), model.spans[1].vertices
    x[flat, 2] -= 2e-5
    state.plies.x.assign(x)
    state.plies.f.zero_()
    launched(model, state, "scatter")
    measured = contact.measure(bodies_of(state), memory)
    below, above = measured.pressing["contact_pressure"]
    assert below[flat].sum() == pytest.approx(above[: flat.start].sum()) and below[flat].sum() > 0.0
    assert not above[flat].any() and not below[: flat.start].any()
    force = state.plies.f.numpy()
    assert force[rim, 2].min() > 0.0 > force[ridge, 2].max()
    np.testing.assert_allclose(force.sum(axis=0), 0.0, atol=1e-12 * np.abs(force).max())


def test_what_lies_over_a_ply_does_not_meet_its_rim_from_inside(device):
    """A roof that climbs inwards under a flat ply is nearest to its inside, not to its rim."""
    model, state, (ridge, rim) = roof_under_a_rim(device, 1e-6)
    x, roof = state.plies.x.numpy(), model.spans[0].vertices
    about = x[ridge].mean(axis=0)
    x[roof, 0] = 2.0 * about[0] - x[roof, 0]
    state.plies.x.assign(x)
    stepping.search_contacts(model, state)
    assert (tuple(rim), tuple(ridge)) not in found(model, state)


def over_the_hollow(device):
    """Two plies: the upper one's border over the lower one's, a valley with much room above."""
    low = Ply.rectangle("low", "carbon_interlock", 0.06, cells=6)
    high = Ply.rectangle("high", "carbon_interlock", 0.02, cells=2)
    scene = Scene(name="valley", plies=lay_up([low, high]), duration=1e-2, self_contact=False)
    model = build_model(scene, device, frames=1)
    x, upper = model.rest.numpy().copy(), model.spans[1].first_vertex
    x[:upper, 2] = 4.0 * x[:upper, 0] ** 2 / 0.3  # rooms of a third of a millimetre and more
    return model, initial_state(model), x, upper


def test_what_comes_over_a_border_lies_on_the_side_into_which_it_reaches_less(device):
    """Room in a hollow once made a vertex 0.4 thicknesses under a ply one that lay over it."""
    model, state, x, upper = over_the_hollow(device)
    memory, (look,) = memory_of(model, state), contact_of(model).looks[1:]
    vertices, slots = of_look(model, look)
    flat = model.rest.numpy()[vertices]
    one = np.flatnonzero((flat[:, :2] == flat[:, :2].min(axis=0)).all(axis=1))[0]
    for place in ((0.0, 0.05), (0.0, 0.025)):  # beside the border, then a search later over it
        moved = x.copy()
        moved[vertices] = (0.0, 0.2, 0.0)  # all others out of sight
        moved[upper + one] = (*place, -0.45 * THICKNESS)
        state.plies.x.assign(moved)
        stepping.search_contacts(model, state)
    room = contact_of(model).surfaces.hollows.numpy()[:upper, 0]
    valley = np.isclose(model.rest.numpy()[:upper, 0], 0.0)
    assert room[valley].min() > 0.46 * THICKNESS, "by which it lay over the ply"
    seen, kept = memory.seen.numpy()[slots][one], memory.contacts.numpy()[slots][one]
    assert seen["across"] == 1 and kept["near"] == 1
    np.testing.assert_allclose(kept["normal"], (0.0, 0.0, -1.0), atol=1e-6)
    assert memory.deepest.numpy().max() < 0.56 * THICKNESS


def test_what_the_next_ply_does_not_cover_sees_those_beyond_at_every_search(device):
    """A rim vertex slides off the ply below it, and falls onto the one below that."""
    sizes = (("lowest", 0.08), ("low", 0.04), ("high", 0.04))
    plies = lay_up([Ply.rectangle(n, "carbon_interlock", size, cells=4) for n, size in sizes])
    scene = Scene(name="s", plies=plies, duration=1e-2, self_contact=False)
    model = build_model(scene, device, frames=1)
    state, rest = initial_state(model), model.rest.numpy()
    (look,) = (k for k in contact_of(model).looks if (k.searching, k.way) == (2, -1))
    vertices, slots = of_look(model, look)
    edge = np.isclose(rest[vertices, 0], 0.02)
    stepping.search_contacts(model, state)
    memory = memory_of(model, state)
    for aside, fall in ((2.5e-3, 0.0), (2.5e-3, THICKNESS)):
        x = rest.copy()
        x[vertices] += np.where(edge, 1.0, 0.0)[:, None] * (aside, 0.0, -fall)
        state.plies.x.assign(x)
        stepping.search_contacts(model, state, asking=False)
    assert (memory.seen.numpy()["ply"][slots][edge] == 1).all()
    assert memory.contacts.numpy()["near"][slots][edge].all()
    inner = np.abs(rest[vertices, :2]).max(axis=1) < 0.015
    assert not memory.seen.numpy()["loose"][slots][inner].any(), "the others walk on"
