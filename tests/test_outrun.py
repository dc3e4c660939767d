"""Plies faster than searches look ahead: warned of at tools, folds marked by the pace of now."""

import numpy as np
import pytest
from law_checks import fabric
from test_self_contact import THICKNESS, folded_patches, placed, zigzag

from warpdrape import Numerics, Ply, Pressure, Scene, Stroke, Tool
from warpdrape.contact.self_contact import SelfContact
from warpdrape.contact.tool_contact import ToolContact
from warpdrape.dynamics import stepping
from warpdrape.dynamics.model import build_model, initial_state
from warpdrape.interaction import bodies_of
from warpdrape.materials.fabric_library import with_bending
from warpdrape.materials.laws import LinearTension, ShearPolynomial
from warpdrape.timing import ASK_EVERY

FILM = fabric(LinearTension(300.0, 300.0), ShearPolynomial((1e-4,)))
WARNING = "a ply gained speed faster than contact with tool 'plate' looks ahead"


def blown(contact="fast", *, ramp=1e-4, pressure=1e5, gap=3e-3, duration=1e-3):
    """A film blown down onto a plate that sinks slowly, so that searches are rare."""
    sinking = Stroke(travel=(0.0, 0.0, -0.05 * duration), duration=duration)
    plate = Tool.plate("plate", width=0.2, height=0.2, motion=sinking).moved((0.0, 0.0, -gap))
    return Scene(
        name="blown",
        plies=[Ply.rectangle("film", FILM, 0.03, cells=3)],
        tools=[plate],
        pressures=[Pressure(name="air", ply="film", pressure=pressure, ramp=ramp)],
        gravity=(0.0, 0.0, 0.0),
        friction=0.2,
        duration=duration,
        numerics=Numerics(contact=contact),
    )


def test_a_ply_that_outruns_contact_with_a_tool_is_warned_of(device):
    """… and either advice cures it."""
    missed = blown().run(device=device, frames=2)
    assert missed.plies[0].points[:, 2].max() < -0.05, "it passed the plate"
    (words,) = (w for w in missed.summary["warnings"] if w.startswith(WARNING))
    assert "load it more slowly, or set contact to exact" in words
    for advised in (blown("exact"), blown(ramp=1e-3)):
        held = advised.run(device=device, frames=2)
        assert -3.1e-3 < held.plies[0].points[:, 2].min() < -2.7e-3, "it came to lie on the plate"
        assert not any(words.startswith(WARNING) for words in held.summary["warnings"])


@pytest.mark.parametrize("share", [0.9, 1.1], ids=["not so far", "through the plate"])
def test_what_has_been_outrun_is_what_the_last_query_saw(share, device):
    """A vertex asked 3 mm off a plate, farther than searches see, is soon on its other side."""
    gap = 3e-3
    model = build_model(blown(gap=gap), device, frames=1)
    state = initial_state(model)
    stepping.search_contacts(model, state)
    x = state.plies.x.numpy()
    x[5, 2] -= share * gap
    state.plies.x.assign(x)
    stepping.search_contacts(model, state, asking=False)
    at = [isinstance(each, ToolContact) for each in model.interactions].index(True)
    contact, memory = model.interactions[at], state.memory[at]
    assert contact.search.radius < 0.9 * gap
    over = share * gap / contact.search.radius if share > 1.0 else 0.0
    np.testing.assert_allclose(memory.fastest.numpy(), [over], rtol=1e-6)
    warnings = contact.measure(bodies_of(state), memory).warnings
    assert len(warnings) == int(over > 0.0)
    for words in warnings:
        assert words.startswith(f"{WARNING} (by {over:.3g} times) and passed it")


def test_folds_are_marked_by_the_speed_of_now(device):
    """Layers 4 thicknesses apart that have just begun to move at 60 m/s."""
    ply = Ply.rectangle("strip", with_bending("carbon_interlock", 1e-5), 0.2, edge=5e-3)
    over = ply.rest_points.copy()
    right = over[:, 0] > 0.02
    over[right, 0] = 0.04 - over[right, 0]
    over[right, 2] += 30.0 * THICKNESS
    lift = np.abs(ply.rest_points[:, 0] - 0.02) < 0.02  # no patch turns by itself
    model, state = placed(ply, over, device)
    stepping.search_contacts(model, state)
    far = ~folded_patches(model, state).astype(bool)
    assert far.any() and lift.any()
    v = np.zeros_like(over)
    v[right, 2] = -200.0
    state.plies.v.assign(v)
    stepping.search_contacts(model, state)
    reach = float(state.plies.paces.numpy()["reach"][0])
    assert 17.0 * reach > 30.0 * THICKNESS, "in sight at that speed"
    assert folded_patches(model, state).sum() > 2 * (~far).sum()


def legs_thrown(device, speed, *, together=False, contact="fast"):
    """A strip in three legs over each other, at rest at first, then the middle one thrown up.

    Returns:
        Speed over what its searches foresaw [-], warnings, and by how much the middle leg is over
        the upper one at the end [m].
    """
    ply = Ply.rectangle("strip", with_bending("carbon_interlock", 1e-5), 0.12, 9e-3, edge=3e-3)
    numerics = Numerics(yarn_softening=36.0, contact=contact)
    shape = zigzag(ply.rest_points, 8e-3, 20e-3)
    model, state = placed(ply, shape, device, duration=2e-3, numerics=numerics)
    middle = np.isclose(shape[:, 2], 8e-3) & (shape[:, 0] < 18e-3) & (shape[:, 0] > 2e-3)
    top = np.isclose(shape[:, 2], 16e-3) & (shape[:, 0] < 18e-3) & (shape[:, 0] > 2e-3)
    stepper = stepping.Stepper(model, state)
    stepper.begin_frame(1)
    stepper.block()
    v = np.zeros_like(shape)
    v[slice(None) if together else middle, 2] = speed
    state.plies.v.assign(v)
    blocks = int(np.ceil(12e-3 / speed / (model.timing.search_every * model.timing.time_step)))
    for _ in range(min(max(blocks, 1 + ASK_EVERY), 40)):
        stepper.block()
    at = [isinstance(each, SelfContact) for each in model.interactions].index(True)
    words = model.interactions[at].measure(bodies_of(state), state.memory[at]).warnings
    x = state.plies.x.numpy()
    outrun = float(state.plies.paces.numpy()["outrun"].max())
    return outrun, words, x[middle, 2].mean() - x[top, 2].mean()


@pytest.mark.parametrize("speed", [20.0, 60.0, 400.0])
def test_a_ply_that_outruns_its_own_folds_is_warned_of(device, speed):
    """Legs out of each other's sight when all asked last; the middle one is beyond at the next."""
    outrun, words, over = legs_thrown(device, speed)
    assert outrun > 1.0 and over > 0.0, "the middle leg has passed the upper one"
    (said,) = words
    assert said.startswith("ply 'strip' gained speed faster than its self-contact looks ahead (by ")
    assert "load it more slowly, or set contact to exact" in said


def test_no_fold_is_said_to_be_passed_where_none_was(device):
    """Folds that move together, however fast, or that are held, slower or looked at more often."""
    outrun, words, over = legs_thrown(device, 400.0, together=True)
    assert outrun > 1.0 and over < 0.0 and not words
    for speed, contact in ((5.0, "fast"), (60.0, "exact")):
        _, words, over = legs_thrown(device, speed, contact=contact)
        assert over < 0.0 and not words


def test_a_fold_that_passes_between_two_searches_is_noticed(device):
    """Layers in sight of each other, first looked at a moment before one jumps through the other.

    The jump is what its speed makes of the time between two searches, so that it is motion; what
    lies on the other side without it, as where a walk comes round a fold, is none.
    """
    ply = Ply.rectangle("strip", with_bending("carbon_interlock", 1e-5), 0.12, 9e-3, edge=3e-3)
    shape = zigzag(ply.rest_points, 4e-3, 20e-3)
    middle = np.isclose(shape[:, 2], 4e-3) & (shape[:, 0] < 18e-3) & (shape[:, 0] > 2e-3)
    for share, said in ((1.0, 1), (0.0, 0)):
        model, state = placed(ply, shape, device, duration=2e-3)
        stepping.search_contacts(model, state)
        interval = model.timing.search_every * model.timing.time_step
        x, v = shape.copy(), np.zeros_like(shape)
        x[middle, 2] += 4.5e-3
        v[middle, 2] = share * 4.5e-3 / interval
        state.plies.x.assign(x)
        v[0, 1] = 4.5e-3 / interval  # a vertex that outruns the searches in both cases
        state.plies.v.assign(v)
        stepping.search_contacts(model, state, asking=False)
        assert float(state.plies.paces.numpy()["outrun"].max()) > 1.0
        at = [isinstance(each, SelfContact) for each in model.interactions].index(True)
        words = model.interactions[at].measure(bodies_of(state), state.memory[at]).warnings
        assert len(words) == said
