"""What tests of the search for tools share: a ply whose vertices are points anywhere in space."""

import numpy as np
from contact_oracle import nearest_on_triangles
from interaction_checks import of_kind
from law_checks import fabric

from warpdrape.blanks.ply import Ply
from warpdrape.contact.tool_contact import ToolContact
from warpdrape.dynamics.model import build_model, initial_state
from warpdrape.dynamics.stepping import search_contacts
from warpdrape.materials.laws import LinearTension
from warpdrape.numerics import Numerics
from warpdrape.scene import Scene

CLOTH = fabric(LinearTension(400.0, 420.0))
HALF = 0.5 * CLOTH.thickness


def searcher(tools, device="cpu", cells=10, **numerics):
    """Model and state of a ply whose vertices serve as the points that search."""
    ply = Ply.rectangle("points", CLOTH, 0.1, cells=cells, mesh="diagonal", z=10.0)
    numerics = Numerics(**numerics)
    scene = Scene(name="search", plies=[ply], tools=tools, duration=1e-3, numerics=numerics)
    model = build_model(scene, device, 1)
    return model, initial_state(model)


def search_of(model):
    """How far contact with tools looks."""
    (contact,) = (contact for contact in model.contacts if isinstance(contact, ToolContact))
    return contact.search


def memory_of(model, state):
    return of_kind(model, state, ToolContact)[1]


def found(model, state):
    """What the last search kept of the one tool: whether near, and the plane's normal and level."""
    planes = memory_of(model, state).planes.numpy()
    near = (planes["normal"] != 0.0).any(axis=1)
    np.testing.assert_array_equal(near, memory_of(model, state).touching.numpy() == 1)
    return near, planes["normal"], planes["level"]


def distances(points, corners):
    """Distance of points from the nearest of all facets, by brute force, shape [n]."""
    nearest, *_ = nearest_on_triangles(points, corners, k=len(corners))
    return np.linalg.norm(points - nearest, axis=1)


def gap_and_push(model, state, x):
    """Gaps of points to the one tool, and the ways in which it would push them."""
    state.plies.x.assign(x)
    search_contacts(model, state)
    near, normal, level = found(model, state)
    assert near.all()
    return (normal * x).sum(axis=1) - level, normal.copy()
