"""Which side of another ply a vertex lies on: the stacking order's, but round a border."""

import numpy as np
import pytest
from test_ply_search import THICKNESS, contact_of, gaps, memory_of, of_look, two_laid_up

from warpdrape import Clamp, Path, Ply, Scene, lay_up
from warpdrape.dynamics import stepping
from warpdrape.dynamics.model import build_model, initial_state
from warpdrape.interaction import bodies_of


def sides(model, state, way):
    """Whether inner vertices of the upper ply lie across on the lower one, after it has moved.

    Args:
        model: of `two_laid_up`.
        state: its state.
        way: (aside, up) of the upper ply from where it was laid [m], at one search each.
    """
    start, upper = model.rest.numpy(), model.spans[1].first_vertex
    memory, contact = memory_of(model, state), contact_of(model)
    inner = np.flatnonzero(np.abs(start[upper:, :2]).max(axis=1) < 0.02)
    slots = contact.looks[1].first_slot + inner
    for aside, up in way:
        x = start.copy()
        x[upper:, 0] += aside
        x[upper:, 2] += up
        state.plies.x.assign(x)
        stepping.search_contacts(model, state)
    found = memory.contacts.numpy()[slots]
    return memory.seen.numpy()["across"][slots], found["normal"][:, 2], found["near"]


def round_the_border(steps=200):
    """A way off the lower ply, down beside it, and back beneath it, each search a part."""
    clear, below = 0.07, -2 * THICKNESS  # just touching it from beneath
    there = np.linspace(0.0, 1.0, steps)
    off = [(clear * t, 0.0) for t in there]
    down = [(clear, below * t) for t in there]
    return [*off, *down, *((clear * (1.0 - t), below) for t in there)]


@pytest.mark.parametrize("way", [[(0.2, 0.0), (0.0, -2 * THICKNESS)], round_the_border()])
def test_a_ply_that_has_gone_round_a_border_lies_across(way, device):
    _, model, state, *_ = two_laid_up(device)
    across, up, near = sides(model, state, way)
    assert across.all() and near.all()
    np.testing.assert_allclose(up, -1.0, atol=1e-9)
    memory = memory_of(model, state)
    assert memory.deepest.numpy().max() < 1e-6
    assert np.abs(memory.contacts.numpy()["allowance"]).max() < 1e-6
    # It presses with its upper face on the lower face of the ply that was laid below it.
    contact, upper = contact_of(model), model.spans[1].first_vertex
    forces = np.zeros(memory.forces.shape[0])
    forces[contact.looks[1].first_slot :] = 1.0
    memory.forces.assign(np.where(memory.contacts.numpy()["near"] == 1, forces, 0.0))
    lower_face, upper_face = contact.measure(bodies_of(state), memory).pressing["contact_pressure"]
    assert upper_face[upper:].sum() > 4.0 and not lower_face[upper:].any()
    assert lower_face[:upper].sum() == pytest.approx(upper_face[upper:].sum())
    assert not upper_face[:upper].any()
    across, up, _ = sides(model, state, [*way[::-1], (0.0, 0.0)])
    assert not across.any()
    np.testing.assert_allclose(up, 1.0, atol=1e-9)


def test_a_ply_that_is_pressed_through_another_keeps_its_order(device):
    _, model, state, *_ = two_laid_up(device)
    across, up, near = sides(model, state, [(0.0, -k * 1e-4) for k in range(30)])
    assert not across.any() and near.all()
    np.testing.assert_allclose(up, 1.0, atol=1e-9)


@pytest.mark.parametrize("asking", [False, True])
def test_what_has_not_gone_through_does_not_lie_far_behind(asking, device):
    """A walk that has come round a fold finds a vertex on the other side than the place before."""
    _, model, state, *_ = two_laid_up(device)
    sides(model, state, [(0.0, 0.0), (0.0, 3.0 * THICKNESS)])
    memory, inner = memory_of(model, state), contact_of(model).looks[1].first_slot + 12
    seen = memory.seen.numpy()
    assert seen["seen"][inner] > 0 and memory.contacts.numpy()["near"][inner] == 0
    seen["across"][inner], seen["way"][inner] = 1, 0.0
    memory.seen.assign(seen)
    stepping.search_contacts(model, state, asking=asking)
    assert memory.seen.numpy()["across"][inner] == 0
    assert memory.deepest.numpy().max() < 1e-6


def test_a_place_on_another_fold_is_judged_anew(device):
    """A ply over one end of another, arched, one is next found beneath its other end."""
    low = Ply.rectangle("low", "carbon_interlock", 0.06, cells=6)
    high = Ply.rectangle("high", "carbon_interlock", 0.02, cells=2)
    model = build_model(Scene(name="s", plies=lay_up([low, high]), duration=1e-2), device, 1)
    state = initial_state(model)
    x, upper = state.plies.x.numpy().copy(), model.spans[1].first_vertex
    x[:upper, 2] = np.where(np.abs(x[:upper, 0]) < 0.008, -0.03, 0.0)  # no walk crosses this
    memory, (look,) = memory_of(model, state), contact_of(model).looks[1:]
    _, slots = of_look(model, look)
    inner = np.abs(model.rest.numpy()[upper:, :2]).max(axis=1) < 0.008
    for aside, height, across in ((-0.02, THICKNESS, 0), (0.02, -1.2 * THICKNESS, 1)):
        moved = x.copy()
        moved[upper:] += (aside, 0.0, height - x[upper, 2])
        state.plies.x.assign(moved)
        stepping.search_contacts(model, state)
        seen = memory.seen.numpy()[slots][inner]
        assert (seen["ply"] == 1).all() and (seen["across"] == across).all()
    assert memory.deepest.numpy().max() < 1e-6


def test_a_ply_led_round_a_border_is_held_down_by_the_other_one(device):
    """Led beneath a held ply and let go under a gravity that lifts it: it comes to rest below."""
    duration, size = 0.3, 0.02
    low = Ply.rectangle("low", "carbon_interlock", 0.06, cells=6)
    high = Ply.rectangle("high", "carbon_interlock", size, cells=2, z=THICKNESS)
    times = np.linspace(0.0, 0.6 * duration, 6)
    lift = 3 * THICKNESS
    way = [
        (0.0, THICKNESS),
        (0.0, lift),
        (0.06, lift),
        (0.06, -lift),
        (0.0, -lift),
        (0.0, -THICKNESS),
    ]
    positions = np.array([(x, 0.0, z - THICKNESS) for x, z in way])
    scene = Scene(
        name="round",
        plies=[low, high],
        clamps=[
            Clamp(name="held", ply="low", where=lambda p: p[:, 0] < 1.0),
            Clamp(
                name="led",
                ply="high",
                where=lambda p: p[:, 0] < -0.4 * size,
                motion=Path(times=times, positions=positions),
            ),
        ],
        duration=duration,
        gravity=(0.0, 0.0, 9.81),
    )
    result = scene.run(device=device, frames=6)
    assert result.summary["status"] == "completed", result.summary["message"]
    heights = result.ply("high").points[:, 2]
    free = result.ply("high").rest_points[:, 0] > 0.0
    np.testing.assert_allclose(heights[free], -THICKNESS, atol=0.05 * THICKNESS)
    assert result.summary["max_penetration_m"] < 0.02 * THICKNESS
    assert result.summary["energy_error"] < 0.01


def test_round_a_sharp_ridge_a_vertex_lies_on_its_own_side(device):
    """Both legs hang down, one with triangles three times as large: vertex normals lean over the
    ridge so far that they once said of what is beside the other leg that it was deep in the ply.
    """
    low, high = (
        Ply.rectangle(name, "carbon_interlock", size, cells=cells)
        for name, size, cells in (("low", 0.08, 8), ("high", 0.03, 12))
    )
    model = build_model(Scene(name="s", plies=lay_up([low, high]), duration=1e-2), device, 1)
    state, upper = initial_state(model), model.spans[1].first_vertex
    x, lean = model.rest.numpy().copy(), np.radians(4.0)
    leg = np.abs(x[:upper, 0]) * np.where(x[:upper, 0] > 0.0, 0.33, 1.0)
    x[:upper, 0] = np.sign(x[:upper, 0]) * leg * np.sin(lean)
    x[:upper, 2] = -leg * np.cos(lean)
    y, turn = x[upper:, 1].copy(), np.linspace(-1.45, 1.45, len(x) - upper)
    away = np.stack([np.sin(turn), np.zeros_like(turn), np.cos(turn)], axis=1)
    x[upper:] = 1.1 * THICKNESS * away
    x[upper:, 1] = y
    state.plies.x.assign(x)
    for asking in (True, False):
        stepping.search_contacts(model, state, asking=asking)
        (look,) = (look for look in contact_of(model).looks if look.searching == 1)
        _, slots = of_look(model, look)
        assert not memory_of(model, state).seen.numpy()["across"][slots].any()
        np.testing.assert_allclose(gaps(model, state)[slots], 0.1 * THICKNESS, atol=1e-9)
