"""Planes of tools at their borders, edges and creases, on either side of open ones."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from tool_search_checks import HALF, distances, found, gap_and_push, memory_of, searcher

from warpdrape.contact.tool_surfaces import ridge_bits
from warpdrape.dynamics.model import initial_state
from warpdrape.dynamics.stepping import search_contacts
from warpdrape.tools.profile import Line, extrude
from warpdrape.tools.tool import Tool


def test_a_plate_has_a_back_and_a_rounded_border(device):
    """Vertices come from behind a plate, and go round its border from below to its face."""
    size, apart = 0.2, HALF + 2e-5
    model, state = searcher([Tool.plate(width=size, height=size, facet=0.02)], device, cells=4)
    count = len(model.masses.mass)
    along = np.linspace(-0.07, 0.07, count)
    flat = np.stack([along, 0.3 * along, np.zeros(count)], axis=1)
    up = np.array([0.0, 0.0, 1.0])
    for height in (-1e-3, -apart, -0.9 * HALF):  # comes near, touches, presses
        x = flat + height * up
        state.plies.x.assign(x)
        search_contacts(model, state)
    near, normal, level = found(model, state)
    assert near.all()
    np.testing.assert_allclose(normal, np.tile((0.0, 0.0, -1.0), (count, 1)), atol=1e-12)
    np.testing.assert_allclose((normal * x).sum(axis=1) - level, -0.1 * HALF)

    state = initial_state(model)
    for angle in np.radians(np.arange(-85.0, 86.0, 1.0)):  # about the border, from below to above
        out = np.array([np.cos(angle), 0.0, np.sin(angle)])
        border = np.stack([np.full(count, 0.5 * size), along, np.zeros(count)], axis=1)
        x = border + apart * out
        state.plies.x.assign(x)
        search_contacts(model, state)
        near, normal, level = found(model, state)
        assert near.all()
        gap = (normal * x).sum(axis=1) - level
        # Within 8° of its face the border counts as the face: 1 % of the distance less.
        np.testing.assert_allclose(gap, apart - HALF, atol=0.011 * apart)


@pytest.mark.parametrize(("height", "side"), [(0.9, 1.0), (-0.01, 1.0), (-1.1, -1.0)])
def test_what_is_first_seen_within_a_sheet_came_from_its_front(height, side, device):
    """Just behind it, too: pressed in, not come from the back, which is half a thickness away."""
    model, state = searcher([Tool.plate(width=0.2, height=0.2, facet=0.02)], device, cells=4)
    count = len(model.masses.mass)
    along = np.linspace(-0.07, 0.07, count)
    x = np.stack([along, 0.3 * along, np.full(count, height * HALF)], axis=1)
    gap, push = gap_and_push(model, state, x)
    np.testing.assert_allclose(push, np.tile((0.0, 0.0, side), (count, 1)), atol=1e-12)
    np.testing.assert_allclose(gap, (side * height - 1.0) * HALF, atol=1e-12)


@pytest.mark.parametrize("height", [0.2, -0.2])
def test_what_is_first_seen_beside_a_border_meets_it_as_an_edge(height, device):
    """A little over the plate's plane or under it: the border pushes it straight away."""
    model, state = searcher([Tool.plate(width=0.2, height=0.2, facet=0.02)], device, cells=4)
    count = len(model.masses.mass)
    along, out = np.linspace(-0.07, 0.07, count), np.array([1.5, 0.0, height]) * HALF
    x = np.stack([np.full(count, 0.1), along, np.zeros(count)], axis=1) + out
    gap, push = gap_and_push(model, state, x)
    apart = np.linalg.norm(out)
    np.testing.assert_allclose(push, np.tile(out / apart, (count, 1)), atol=1e-3)
    np.testing.assert_allclose(gap, apart - HALF, atol=1e-3 * HALF)


def test_a_vertex_that_goes_round_a_border_lies_on_the_face_behind_it(device):
    """From one face over the border to the other, and all the way back."""
    size, apart = 0.2, HALF + 2e-5
    model, state = searcher([Tool.plate(width=size, height=size, facet=0.02)], device, cells=4)
    count = len(model.masses.mass)
    along = np.linspace(-0.07, 0.07, count)
    below = [(way, -apart) for way in np.linspace(-1e-3, -1e-4, 10)]
    above = [(way, apart) for way, _ in reversed(below)]
    turns = np.radians(np.arange(-85.0, 86.0, 5.0))
    there = [*below, *(apart * np.array([np.cos(a), np.sin(a)]) for a in turns), *above]
    for way, height in (*there, *there[::-1]):
        x = np.stack([np.full(count, 0.5 * size + way), along, np.full(count, height)], axis=1)
        gap, push = gap_and_push(model, state, x)
        np.testing.assert_allclose(gap, apart - HALF, atol=0.011 * apart)
        if way < 0.0:
            np.testing.assert_allclose(push[:, 2], np.sign(height), atol=1e-12)


CAN = trimesh.creation.cylinder(0.1, 0.05, sections=30).subdivide()
"""At each of its rim's corners there are facets that touch the rim with that corner alone."""


def sharp(kind):
    """A tool with a sharp edge at half its height, 25 mm, and places on that edge, with ways out.

    Of a CAD file's tool the surface's own normals are known; at an edge each face has its own.
    """
    along = np.linspace(-0.09, 0.09, 25)
    edge = np.stack([np.full(25, 0.1), along, np.full(25, 0.025)], axis=1)
    ways = np.tile((1.0, 0.0, 0.0), (25, 1))
    if kind == "can":
        edge = CAN.vertices[CAN.vertices[:, 2] > 0.0249]
        edge = edge[np.linalg.norm(edge[:, :2], axis=1) > 0.0999][:25]
        ways = edge * (10.0, 10.0, 0.0)
        return Tool.from_mesh("can", CAN), edge, ways
    box = Tool.from_mesh("box", trimesh.creation.box(extents=(0.2, 0.2, 0.05)))
    return replace(box, surface=replace(box.surface, exact=kind == "cad")), edge, ways


@pytest.mark.parametrize("kind", ["box", "cad", "can"])
def test_a_sharp_ridge_is_round_to_the_ply(kind, device):
    """Round its edge the gap is the distance from the tool, whichever facet there is asked."""
    tool, edge, ways = sharp(kind)
    model, state = searcher([tool], device, cells=4)
    assert len(edge) == len(model.masses.mass)
    apart = HALF + np.linspace(-5e-5, 1e-5, len(edge))[:, None]
    for angle in np.radians(np.arange(0.0, 91.0, 5.0)):
        out = np.cos(angle) * ways + np.sin(angle) * np.array([0.0, 0.0, 1.0])
        gap, push = gap_and_push(model, state, edge + apart * out)
        np.testing.assert_allclose(gap, apart[:, 0] - HALF, atol=1e-9)
        np.testing.assert_allclose(push, out, atol=1e-5)


def test_a_round_border_is_one_for_all_facets_at_its_corners(device):
    """Beyond the rim of a disc, at its corners, it is a rounded edge, and no plane goes on."""
    cap = CAN.submesh([np.flatnonzero(CAN.face_normals[:, 2] > 0.5)], append=True)
    disc = Tool.from_mesh("disc", cap)
    model, state = searcher([disc], device, cells=4)
    edge = sharp("can")[1]
    for angle in np.radians(np.arange(85.0, -1.0, -5.0)):
        out = np.cos(angle) * edge * (10.0, 10.0, 0.0) + np.sin(angle) * np.array([0.0, 0.0, 1.0])
        gap, push = gap_and_push(model, state, edge + 0.95 * HALF * out)
        # Within 8° of its face the border counts as the face: 1 % of the distance less.
        np.testing.assert_allclose(gap, -0.05 * HALF, atol=0.011 * HALF)
        np.testing.assert_allclose(push, out, atol=0.15)


SMOOTH = {
    "punch": Tool.punch(radius=0.05),
    "die": Tool.die(hole_radius=0.05, edge_radius=0.01, outer_radius=0.1),
    "holder": Tool.blank_holder(hole_radius=0.05, outer_radius=0.1),
    "table": Tool.table(radius=0.05),
    "drum": Tool.drum(radius=0.02, length=0.1),
}


@pytest.mark.parametrize("kind", SMOOTH)
def test_true_surfaces_without_edges_have_no_ridges(kind):
    assert not ridge_bits(SMOOTH[kind]).any()


def valley(flank, exact):
    """A sheet of two flanks that rise so steeply from a crease along y, as made or from a file."""
    rise = np.array([0.02 * np.cos(flank), 0.02 * np.sin(flank)])
    across = [Line((-rise[0], rise[1]), (0.0, 0.0)), Line((0.0, 0.0), tuple(rise))]
    surface = extrude(across, 0.1, 0.01)
    return Tool(name="v", surface=surface) if exact else Tool.from_mesh("v", surface.mesh)


def across_a_valley(flank, side, apart):
    """Places (x, z) at a distance from the nearest flank, above it or behind, and their ways off.

    In the hollow the ways change at once, behind they turn about the crease.
    """
    begins = apart * np.tan(flank) if side > 0.0 else 0.0
    for turn in (-flank, flank):
        along, off = np.array([np.cos(turn), np.sin(turn)]), np.array([-np.sin(turn), np.cos(turn)])
        for way in np.sort(np.sign(turn) * (begins + np.arange(5e-5, 1.5e-3, 1e-4))):
            yield way * along + side * apart * off, side * off
        if side < 0.0 and turn < 0.0:
            for about in np.linspace(-flank, flank, 15):
                off = np.array([np.sin(about), -np.cos(about)])
                yield apart * off, off


@pytest.mark.parametrize("exact", [True, False])
@pytest.mark.parametrize("flank", [30.0, 45.0, 75.0])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_vertex_stays_on_its_side_across_a_crease_of_any_angle(side, flank, exact, device):
    """In the hollow or behind, from one flank to the other: the gap is to the nearest of them.

    From 45° on the flanks' normals point against each other, as those of a sheet's two sides do.
    """
    model, state = searcher([valley(np.radians(flank), exact)], device, cells=4)
    count = len(model.masses.mass)
    along = np.linspace(-0.04, 0.04, count)
    for apart in (1.2 * HALF, 0.9 * HALF):  # comes near, then presses
        for (x, z), off in across_a_valley(np.radians(flank), side, apart):
            places = np.stack([np.full(count, x), along, np.full(count, z)], axis=1)
            gap, push = gap_and_push(model, state, places)
            np.testing.assert_allclose(gap, apart - HALF, atol=1e-9)
            np.testing.assert_allclose(push, np.tile([off[0], 0.0, off[1]], (count, 1)), atol=1e-6)


def faceted(side):
    """A ball of coarse facets to be met from outside, or inside; or a cup, from behind, outside."""
    mesh = trimesh.creation.icosphere(subdivisions=2, radius=0.02)
    if side == "behind":
        mesh = mesh.slice_plane((0.0, 0.0, -5e-3), (0.0, 0.0, 1.0))
    ball = Tool.from_mesh("ball", mesh)
    return ball if side == "outside" else ball.flipped()


@pytest.mark.parametrize("side", ["outside", "inside", "behind"])
def test_a_faceted_tool_pushes_along_the_slope_of_its_distance(side, device):
    """Else sliding over its facets makes energy: pushed along means of normals, 10 % of a press."""
    ball, out = faceted(side), 1.0 if side == "outside" else -1.0
    model, state = searcher([ball], device, cells=20, contact="exact")
    count, mesh, h = len(model.masses.mass), ball.surface.mesh, 5e-7
    rng = np.random.default_rng(4)
    high = ball.vertices[ball.vertices[:, 2] > 0.0]  # off the sheet's rim
    surface, facet = trimesh.sample.sample_surface(mesh, 4 * count, seed=5)
    surface, facet = (each[surface[:, 2] > 0.0][:count] for each in (surface, facet))
    outward = mesh.face_normals[facet]
    corner = rng.integers(len(high), size=count)[::3]  # each third by one
    surface[::3], outward[::3] = high[corner], out * high[corner] / 0.02
    if side == "behind":
        outward = -outward
        gap_and_push(
            model, state, np.asarray(surface + 1.4 * HALF * outward)
        )  # it comes from there
    x = np.asarray(surface + rng.uniform(0.5, 1.1, (count, 1)) * HALF * outward)
    x[::3] += rng.uniform(-5e-6, 5e-6, (count, 3))[::3]
    gap, push = gap_and_push(model, state, x)
    np.testing.assert_allclose(gap, distances(x, mesh.triangles) - HALF, atol=2e-9)
    slope, smooth = np.zeros_like(x), np.ones(count, dtype=bool)
    for k, step in enumerate(h * np.eye(3)):
        (more, one), (less, other) = (gap_and_push(model, state, x + s) for s in (step, -step))
        slope[:, k] = (more - less) / (2.0 * h)
        for beside in (one, other):  # in a hollow edge it has none
            smooth &= np.linalg.norm(push - beside, axis=1) < 0.01
    assert smooth.mean() > 0.9
    # a query in single precision may take the facet beside a hollow edge: 2e-9 m in the slope
    np.testing.assert_allclose(push[smooth], slope[smooth], atol=2e-9 / h + 2e-3)


def test_what_slides_past_a_border_books_what_its_spring_held(device):
    model, state = searcher([Tool.plate(width=0.2, height=0.2, facet=0.02)], device, cells=4)
    count = len(model.masses.mass)
    x = np.zeros((count, 3))
    x[:, 1], x[:, 2] = np.linspace(-0.07, 0.07, count), 0.9 * HALF
    x[:, 0] = 0.0999
    gap, _ = gap_and_push(model, state, x)
    assert (gap < 0.0).all()
    memory = memory_of(model, state)
    held = memory.holds.numpy().copy()
    held["stored"], held["spring"] = np.arange(1.0, count + 1.0), 1e-6
    memory.holds.assign(held)
    state.plies.x.assign(x + np.array([2e-3, 0.0, 0.0]))
    search_contacts(model, state)
    np.testing.assert_array_equal(state.plies.lost.numpy()[:, 0], held["stored"])
    left = memory_of(model, state).holds.numpy()
    assert not left["stored"].any() and not left["spring"].any()
