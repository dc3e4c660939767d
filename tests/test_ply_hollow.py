"""Room for arcs on the hollow side of a bent ply."""

import numpy as np
from interaction_checks import of_kind

from warpdrape import Ply, Scene, lay_up
from warpdrape.contact.ply_contact import PlyContact
from warpdrape.dynamics.model import build_model, initial_state
from warpdrape.dynamics.stepping import search_contacts

RADIUS = 0.04
THICKNESS = 6e-4


def test_inner_vertices_do_not_press_the_chords_of_the_outer_ply(device):
    """Two plies on concentric cylinders touch; the outer's chords cut 0.4 mm off its arc."""
    names = ("inner", "outer")
    blanks = [Ply.rectangle(n, "carbon_interlock", 0.1, cells=10, mesh="grid") for n in names]
    plies = lay_up(blanks)
    model = build_model(Scene(name="bent", plies=plies, duration=1e-3), device, frames=1)
    state = initial_state(model)
    flat = model.rest.numpy()
    x = flat.copy()
    for span, radius, shift in zip(
        model.spans, (RADIUS, RADIUS + THICKNESS), (0.0, 0.005), strict=True
    ):
        own = span.vertices
        turn = (flat[own, 0] + shift) / RADIUS
        x[own, 0], x[own, 2] = radius * np.sin(turn), radius * np.cos(turn)
    state.plies.x.assign(x)
    search_contacts(model, state)
    memory = of_kind(model, state, PlyContact)[1]
    deepest = memory.deepest.numpy().reshape(2, 2)
    # 0.06 mm is seen, at the border perhaps, whose normals turn half as much; 0.32 mm without room.
    assert deepest[0, 1] < 0.2 * THICKNESS  # the inner's vertices under the outer's chords
    assert deepest[1, 0] < 0.2 * THICKNESS  # the outer's vertices over the inner's
