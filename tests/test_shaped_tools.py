"""Tools of other outlines than round ones: their surfaces against closed forms and brute force."""

import math

import numpy as np
import pytest
from contact_oracle import heights, nearest_on_triangles
from test_tools import open_borders

from warpdrape.errors import InputError
from warpdrape.tools.plan import rounded_polygon, rounded_rectangle, waist_radius, waisted
from warpdrape.tools.pointed import prism, tetrahedron
from warpdrape.tools.profile import Line
from warpdrape.tools.shaped import box_punch, double_dome, double_dome_cavity, holder, opening
from warpdrape.tools.sweep import sample_plan, sweep

DEG = math.pi / 180.0
FACET = 3e-3
THICKNESS = 6e-4
STEP = 1e-7
SIDE, CORNER, FILLET, HEIGHT = 0.15, 0.03, 0.015, 0.06
RADIUS, DISTANCE, WAIST = 0.05, 0.12, 0.04
POINTED = {
    "tetrahedron": tetrahedron(60 * DEG, 0.015, 0.09),
    "regular tetrahedron": tetrahedron(math.acos(1 / 3), 0.01, 0.06),
    "prism": prism(0.1, 50 * DEG, 75 * DEG, 0.015, 0.08),
}


def beyond_square(points, half, radius):
    """Signed distance to a rounded square in plan, and its gradient there."""
    q = np.abs(points[:, :2]) - (half - radius)
    positive = np.maximum(q, 0.0)
    corner = np.linalg.norm(positive, axis=1)
    side = np.where(q[:, :1] > q[:, 1:], (1.0, 0.0), (0.0, 1.0))
    way = np.where(
        (q > 0.0).all(axis=1)[:, None], positive / np.fmax(corner, 1e-300)[:, None], side
    )
    inside = np.minimum(q.max(axis=1), 0.0)
    return corner + inside - radius, way * np.sign(points[:, :2] + 1e-300)


def of_corners(surface):
    """Corners of the facets [m] and their normals, each shape [n, 3]."""
    corners = surface.mesh.vertices[surface.mesh.faces]
    return corners.reshape(-1, 3), surface.normals.reshape(-1, 3)


def chords(surface, distance):
    """Largest distance [m] of facets' and their sides' middles from the true surface."""
    corners = surface.mesh.vertices[surface.mesh.faces]
    middles = [corners.mean(axis=1), *(0.5 * (corners[:, k - 1] + corners[:, k]) for k in range(3))]
    return max(np.abs(distance(m)).max() for m in middles)


def box_distance(points):
    """Way [m] out of the box punch: round its core, a box of 15 mm less on every side."""
    d, _ = beyond_square(points, SIDE / 2 - FILLET, CORNER - FILLET)
    below = FILLET - points[:, 2]
    outside = np.hypot(np.maximum(d, 0.0), np.maximum(below, 0.0))
    return outside + np.minimum(np.maximum(d, below), 0.0) - FILLET


def dome_distance(points, radius=RADIUS, waist=WAIST, axis=RADIUS):
    """Way [m] out of the double dome's lower half, in the plane through x and the point."""
    hollow, a = waist_radius(radius, DISTANCE, waist), DISTANCE / 2
    x, r = np.abs(points[:, 0]), np.hypot(points[:, 1], points[:, 2] - axis)
    on_dome = x * (waist + hollow) + r * a > a * (waist + hollow)  # the plane through both
    return np.where(on_dome, np.hypot(x - a, r) - radius, hollow - np.hypot(x, r - waist - hollow))


def gradient(distance, points, step=STEP):
    """Of a distance by central differences, shape [n, 3]."""
    ways = step * np.eye(3)
    return np.stack([distance(points + w) - distance(points - w) for w in ways], 1) / (2 * step)


def test_a_box_punch_is_a_box_of_round_corners_and_edges():
    surface = box_punch(rounded_rectangle(SIDE, SIDE, CORNER), FILLET, HEIGHT, FACET)
    points, normals = of_corners(surface)
    assert np.abs(box_distance(points)).max() < 1e-12
    lying = points[:, 2] > FILLET + 1e-9  # where distance has a gradient of one piece
    bent = points[:, 2] < FILLET - 1e-9
    for part in (lying, bent):
        np.testing.assert_allclose(
            normals[part], gradient(box_distance, points[part]), atol=STEP / FILLET
        )
    assert chords(surface, box_distance) < 0.1 * THICKNESS
    assert surface.exact and surface.mesh.is_winding_consistent and open_borders(surface.mesh) == 1


def test_the_volume_of_a_box_punch_is_that_of_the_closed_form():
    surface = box_punch(rounded_rectangle(SIDE, SIDE, CORNER), FILLET, HEIGHT, 1e-3)
    mesh, z = surface.mesh, HEIGHT
    a, b, c = (mesh.vertices[mesh.faces[:, k]] - (0.0, 0.0, z) for k in range(3))
    volume = (a * np.cross(b, c)).sum() / 6.0  # the open top lies in the plane of the origin
    plan = SIDE**2 - (4.0 - math.pi) * CORNER**2
    cut = (1.0 - math.pi / 4.0) * FILLET**2
    inward = FILLET * (10.0 - 3.0 * math.pi) / (12.0 - 3.0 * math.pi)  # its centroid; Pappus
    way = 4.0 * (SIDE - 2.0 * CORNER) + 2.0 * math.pi * (CORNER - inward)
    assert volume == pytest.approx(plan * HEIGHT - cut * way, rel=5e-4)  # chords of 1 mm


def test_a_die_is_flat_and_its_edge_is_round():
    plan, edge, outer = rounded_rectangle(0.156, 0.156, 0.033), 0.01, 0.25
    surface = opening(plan, edge, outer, 0.05, FACET)
    points, normals = of_corners(surface)

    def distance(p):
        d, _ = beyond_square(p, 0.078, 0.033)
        wall = np.where(p[:, 2] > -edge, edge - np.hypot(edge - d, p[:, 2] + edge), d)
        return np.where(d > edge, -p[:, 2], wall)

    assert np.abs(distance(points)).max() < 1e-12
    assert np.hypot(*points[:, :2].T).max() == pytest.approx(outer)
    assert points[:, 2].min() == pytest.approx(-0.05)
    flat = points[:, 2] == 0.0
    assert (normals[flat] == (0.0, 0.0, 1.0)).all()
    _, way = beyond_square(points, 0.078, 0.033)
    wall = points[:, 2] < -edge - 1e-9
    np.testing.assert_allclose(normals[wall][:, :2], -way[wall], atol=1e-9)
    assert open_borders(surface.mesh) == 2
    faces = surface.mesh.face_normals
    assert ((surface.normals * faces[:, None]).sum(axis=2) > 0.99).all()


def test_a_holder_faces_down_round_the_dies_flat():
    plan = waisted(RADIUS, DISTANCE, WAIST)
    surface = holder(plan, 0.01, 0.25, FACET)
    points, normals = of_corners(surface)
    assert points[:, 2].min() == 0.0 and open_borders(surface.mesh) == 2
    assert (normals[points[:, 2] == 0.0] == (0.0, 0.0, -1.0)).all()
    # nothing of it over the die's rounding, 10 mm round the opening
    out = sample_plan(plan, FACET)
    reach = np.abs(out[0] + 0.01 * out[1]).max(axis=0)
    assert (np.abs(points[:, :2]) >= reach - 1e-9).any(axis=1).any()
    rings = np.array([[*p, 0.0] for p in out[0]])
    assert np.linalg.norm(points[:, None, :2] - rings[None, :, :2], axis=2).min() > 0.01 - 1e-4


@pytest.mark.parametrize("name", POINTED)
def test_a_pointed_punch_lies_a_radius_outside_its_core(name):
    core = POINTED[name]
    surface = core.surface(FACET)
    points, normals = of_corners(surface)
    triangles = np.concatenate(
        [[(f[0], f[k], f[k + 1]) for k in range(1, len(f) - 1)] for f in core.faces]
    )

    def out_of_core(p):
        nearest, _, _ = nearest_on_triangles(p, triangles)
        return np.linalg.norm(p - nearest, axis=1) - core.radius

    assert np.abs(out_of_core(points)).max() < 1e-9
    nearest, _, _ = nearest_on_triangles(points, triangles)
    np.testing.assert_allclose(normals, (points - nearest) / core.radius, atol=1e-7)
    assert points[:, 2].min() == pytest.approx(0.0, abs=1e-4)  # a chord off the rounding
    assert chords(surface, out_of_core) < 0.05 * THICKNESS
    assert surface.mesh.is_winding_consistent and open_borders(surface.mesh) == 1
    faces = surface.mesh.face_normals
    assert ((surface.normals * faces[:, None]).sum(axis=2) > 0.99).all()


def test_the_faces_of_a_regular_tetrahedron_meet_at_its_angle():
    normals = POINTED["regular tetrahedron"].normals
    assert normals @ normals.T == pytest.approx(np.where(np.eye(3), 1.0, -1 / 3))
    slopes = np.degrees(np.arccos(-POINTED["prism"].normals[:, 2]))
    assert sorted(slopes) == pytest.approx([50.0, 50.0, 75.0, 75.0])


@pytest.mark.parametrize("name", POINTED)
def test_a_die_clears_a_pointed_punch_all_round(name):
    core, clearance = POINTED[name], 3e-3
    height = 0.5 * core.rim[0, 2]
    plan = rounded_polygon(*core.section(height, clearance))
    at, out = sample_plan(plan, 1e-3)
    mesh = core.surface(1e-3).mesh
    cut = mesh.section(plane_origin=(0, 0, height), plane_normal=(0, 0, 1)).vertices[:, :2]
    gap = np.linalg.norm(at[:, None] - cut[None], axis=2).min(axis=1)
    outside = (at - cut[np.linalg.norm(at[:, None] - cut[None], axis=2).argmin(axis=1)]) * out
    assert (outside.sum(axis=1) > 0.0).all()
    assert gap.min() > clearance - 1e-5
    flat = [k for k, piece in enumerate(plan) if isinstance(piece, Line)]
    middles = np.array([np.add(plan[k].start, plan[k].end) / 2 for k in flat])
    beside = np.linalg.norm(middles[:, None] - cut[None], axis=2).min(axis=1)
    # the section's own points are up to 4 mm apart on flats: across, the gap is as asked for
    assert (beside < math.hypot(clearance, 12e-3)).all()


def test_a_double_dome_is_two_spheres_and_a_saddle():
    surface = double_dome(RADIUS, DISTANCE, WAIST, 0.08, FACET)
    points, normals = of_corners(surface)
    low = points[:, 2] < RADIUS - 1e-9
    assert np.abs(dome_distance(points[low])).max() < 1e-12
    np.testing.assert_allclose(normals[low], gradient(dome_distance, points[low]), atol=1e-5)
    assert points[:, 2].min() == pytest.approx(0.0, abs=5e-5)  # no facet ends at the pole
    middle = np.abs(points[:, 0]) < 1e-9
    assert points[middle, 2].min() == pytest.approx(RADIUS - WAIST)
    assert np.abs(points[middle, 1]).max() == pytest.approx(WAIST)
    inner = np.flatnonzero(surface.mesh.vertices[surface.mesh.faces][:, :, 2].max(axis=1) < RADIUS)
    part = surface.mesh.vertices[surface.mesh.faces[inner]]
    assert np.abs(dome_distance(part.mean(axis=1))).max() < 0.1 * THICKNESS
    assert surface.mesh.is_winding_consistent and open_borders(surface.mesh) == 1


def test_a_double_dome_fills_its_cavity_but_for_the_clearance():
    gap, depth = 2e-3, 0.065
    punch = double_dome(RADIUS, DISTANCE, WAIST, 0.08, FACET)
    cavity = double_dome_cavity(
        RADIUS + gap,
        DISTANCE,
        WAIST + gap,
        depth=depth,
        edge_radius=0.01,
        outer_radius=0.25,
        facet=FACET,
    )
    assert open_borders(cavity.mesh) == 1
    down = punch.mesh.vertices - (0.0, 0.0, depth - gap)
    inside = down[down[:, 2] < -0.011]
    found = heights(inside, cavity.mesh.vertices[cavity.mesh.faces])
    assert np.isfinite(found).mean() > 0.6  # the others are nearest to an edge between facets
    assert np.nanmax(np.abs(found - gap)) < 0.1 * THICKNESS  # the cavity's chords


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: rounded_rectangle(0.1, 0.1, 0.06), "corner radius = 0.06 m .* at most 0.05 m"),
        (lambda: rounded_polygon([(0, 0), (0, 1), (1, 1)], 0.1), "convex and go round"),
        (lambda: waisted(0.05, 0.12, 0.06), "must not exceed the ends' radius"),
        (lambda: waisted(0.05, 0.04, 0.01), "lies within the ends"),
        (
            lambda: box_punch(rounded_rectangle(0.1, 0.1, 0.01), 0.02, 0.05, FACET),
            "reaches 0.02 m over a corner of radius 0.01 m",
        ),
        (lambda: box_punch(rounded_rectangle(0.1, 0.1, 0.03), 0.02, 0.01, FACET), "must exceed"),
        (
            lambda: sweep(rounded_rectangle(0.1, 0.1, 0.01)[:-1], [Line((0, 1), (0, 0))], FACET),
            "must end where it starts",
        ),
        (lambda: opening(rounded_rectangle(0.2, 0.2, 0.01), 0.01, 0.1, 0.1, FACET), "must exceed"),
        (lambda: tetrahedron(95 * DEG, 0.01, 0.05), "must lie between 0° and 90°"),
        (lambda: tetrahedron(60 * DEG, 0.05, 0.05), "must exceed the edge_radius"),
        (lambda: prism(-1.0, 50 * DEG, 75 * DEG, 0.01, 0.05), "ridge length"),
        (
            lambda: opening(waisted(0.05, 0.28, 0.005), 0.001, 0.3, 0.05, FACET),
            "turns back as seen from its middle",
        ),
        (lambda: tetrahedron(60 * DEG, 0.01, 0.05).surface(1e-9), "take a larger one"),
    ],
)
def test_shapes_that_cannot_be_are_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()
