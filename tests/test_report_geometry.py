"""Lines along yarns, distances from tools, and places on another blank, against other ways."""

import numpy as np
import pytest
import trimesh
from matplotlib.tri import Triangulation
from scipy.spatial import Delaunay
from synthetic_run import blank, frame_of, saddle

from warpdrape.blanks.places import locate
from warpdrape.report.packing import Blocks
from warpdrape.report.rest_match import match_plies
from warpdrape.report.run_data import PlyFrames
from warpdrape.results.tool_distance import ToolDistances
from warpdrape.results.yarn_lines import on_blank, yarn_lines
from warpdrape.tools.pose import Pose, rotation, shifted

SIZE = 0.3


def ends_of(lines, triangles, points):
    weights = np.concatenate([1.0 - lines.weights.sum(axis=2, keepdims=True), lines.weights], 2)
    return np.einsum("kew,kwx->kex", weights, points[triangles[lines.triangles]])


def chord(direction, across):
    """Length of a line across the square blank, by clipping it between the sides."""
    start = across * np.array([-direction[1], direction[0]])
    low, high = -np.inf, np.inf
    for axis in range(2):
        if abs(direction[axis]) > 1e-12:
            cuts = sorted((side - start[axis]) / direction[axis] for side in (-SIZE / 2, SIZE / 2))
            low, high = max(low, cuts[0]), min(high, cuts[1])
        elif abs(start[axis]) > SIZE / 2:
            return 0.0
    return max(high - low, 0.0)


@pytest.mark.parametrize("angle", [0.0, 17.0, 45.0, 90.0, 130.0])
def test_lines_are_whole_and_straight_on_the_blank(angle):
    rest, triangles = blank(7, SIZE)
    direction = np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])
    spacing = 0.011  # no line lies on the blank's edge
    lines = yarn_lines(rest, triangles, direction, spacing)
    ends = ends_of(lines, triangles, rest)[:, :, :2]
    across = ends @ [-direction[1], direction[0]] / spacing
    np.testing.assert_allclose(across, np.round(across[:, :1]) * [1, 1], atol=1e-8)
    most = int(SIZE / spacing) + 1
    expected = sum(chord(direction, k * spacing) for k in range(-most, most + 1))
    assert expected > 5.0
    assert np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum() == pytest.approx(expected)


def test_a_line_along_sides_of_triangles_is_drawn_once():
    rest, triangles = blank(6, SIZE)  # squares of 50 mm, lines every 50 mm along their sides
    lines = yarn_lines(rest, triangles, np.array([1.0, 0.0]), 0.05)
    ends = ends_of(lines, triangles, rest)
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum()
    assert length == pytest.approx(6 * SIZE)  # seven rows, of which the rim has one side only


def test_lines_move_with_the_yarns():
    rest, triangles = blank(6, SIZE)
    formed = saddle(rest, 1.0)
    frame = frame_of(rest, triangles, formed, 30.0)
    direction = on_blank(rest, formed, triangles, frame.warp)
    lines = yarn_lines(rest, triangles, direction, 0.02)
    ends = ends_of(lines, triangles, formed)
    way = ends[:, 1] - ends[:, 0]
    long = np.linalg.norm(way, axis=1) > 1e-6
    way = way[long] / np.linalg.norm(way[long], axis=1, keepdims=True)
    along = (way * frame.warp[lines.triangles[long]]).sum(axis=1)
    np.testing.assert_allclose(np.abs(along), 1.0, atol=1e-9)


def test_distances_from_tools_are_those_from_their_nearest_facets():
    random = np.random.default_rng(2)
    ball = trimesh.creation.icosphere(2, radius=0.05)
    block = trimesh.creation.box((0.2, 0.2, 0.02))
    block.apply_translation([0.0, 0.0, -0.08])
    tools = [(np.array(t.vertices), np.array(t.faces)) for t in (ball, block)]
    poses = [
        Pose(rotation((0.0, 0.6, 0.8), 2.0), np.array([0.01, 0.0, 0.03])),
        shifted((0, 0.02, 0)),
    ]
    points = random.uniform(-0.15, 0.15, (40, 3))
    found = ToolDistances(tools).of(
        points, [pose.place(v) for (v, _), pose in zip(tools, poses, strict=True)]
    )
    expected = np.full(len(points), np.inf)
    for (vertices, faces), pose in zip(tools, poses, strict=True):
        corners = pose.place(vertices)[faces]
        for k, point in enumerate(points):
            near = trimesh.triangles.closest_point(corners, np.tile(point, (len(corners), 1)))
            expected[k] = min(expected[k], np.linalg.norm(near - point, axis=1).min())
    np.testing.assert_allclose(found, expected, atol=1e-8)  # facets are sought in single precision
    assert 0.001 < expected.min() and expected.max() > 0.05


def sheet(count, seed, size=SIZE):
    """A flat mesh of a square by Delaunay, its corners and sides included."""
    random = np.random.default_rng(seed)
    side = np.linspace(-0.5, 0.5, 6)
    rim = [(x, y) for x in side for y in (-0.5, 0.5)] + [(x, y) for y in side for x in (-0.5, 0.5)]
    flat = size * np.concatenate([np.unique(rim, axis=0), random.uniform(-0.45, 0.45, (count, 2))])
    return flat, Delaunay(flat).simplices.astype(np.int64)


def test_places_on_another_blank_are_found():
    flat, triangles = sheet(150, 3)
    points = np.random.default_rng(4).uniform(-0.55, 0.55, (400, 2)) * SIZE
    places = locate(points, flat, triangles)
    inside = (np.abs(points) <= SIZE / 2).all(axis=1)
    np.testing.assert_array_equal(places.triangles >= 0, inside)
    finder = Triangulation(*flat.T, triangles).get_trifinder()
    np.testing.assert_array_equal(places.triangles[inside], finder(*points[inside].T))
    corners = flat[triangles[places.triangles[inside]]]
    back = np.einsum("kw,kwx->kx", places.weights[inside], corners)
    np.testing.assert_allclose(back, points[inside], atol=1e-12)


def test_a_large_triangle_beside_many_small_ones_is_found_too():
    fine, small = sheet(400, 5, 0.01)
    large = np.array([[0.006, -1.0], [2.0, 0.0], [0.006, 1.0]])
    flat = np.concatenate([fine, large])
    triangles = np.concatenate([small, [[len(fine), len(fine) + 1, len(fine) + 2]]])
    places = locate(np.array([[0.0061, 0.0]]), flat, triangles)
    assert places.triangles.tolist() == [len(small)]


def test_plies_belong_together_by_name_or_else_by_place():
    def ply(name, flat, triangles):
        rest = np.column_stack([flat, np.zeros(len(flat))])
        return PlyFrames(name, rest, triangles, rest[None], {}, ())

    one, other = sheet(20, 6), sheet(30, 7)
    first = [ply("a", *one), ply("b", *one)]
    matched = match_plies([ply("b", *one), ply("c", *one)], first, Blocks())
    assert matched == [{"ply": 1, "same": True}, None]
    matched = match_plies([ply("x", *one), ply("y", *other), ply("z", *one)], first, Blocks())
    assert matched[0] == {"ply": 0, "same": True} and matched[2] is None
    assert (matched[1]["ply"], matched[1]["same"]) == (1, False)
    moved = ply("a", one[0] + [0.01, 0.0], one[1])
    assert not match_plies([moved], first, Blocks())[0]["same"]
