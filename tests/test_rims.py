"""Rims of open tools: where plies may bend over them they are felt between the plies' vertices."""

import numpy as np
import pytest
import trimesh
from contact_oracle import Facing, nearest_on_triangles

from warpdrape import Ply, Scene, Stroke, Tool, Turn
from warpdrape.contact.features import has_features, points_of
from warpdrape.contact.rims import exposed_rims, rims
from warpdrape.scenes import double_dome, hemisphere, square_box, tetrahedron

HALF = 0.3e-3
SIZE, TRAVEL = 0.1, 0.01


def pressed(tool, cells=10, at=(0.004, 0.007), travel=TRAVEL, duration=0.02):
    """A tool pressed down into a sheet on a ring; its rims lie within the sheet's triangles."""
    sheet = Ply.rectangle("sheet", "carbon_interlock", 0.3, cells=cells, mesh="grid")
    motion = Stroke(travel=(0.0, 0.0, -travel), duration=duration)
    low = tool.vertices[:, 2].min()
    moving = Tool(name="tool", surface=tool.surface, motion=motion)
    moving = moving.moved((*at, HALF + 1e-4 - low))
    ring = Tool.die(hole_radius=0.09, edge_radius=0.01, outer_radius=0.25).moved((0, 0, -HALF))
    return Scene(name="p", plies=[sheet], tools=[moving, ring], duration=duration)


def plate():
    return Tool.plate(width=SIZE, height=SIZE, facing="down")


def wall():
    """An upright open surface: what meets the ply is its lower rim."""
    points = [(-0.03, 0, 0), (0.03, 0, 0), (0.03, 0, 0.05), (-0.03, 0, 0.05)]
    return Tool.from_mesh("wall", trimesh.Trimesh(points, [[0, 1, 2], [0, 2, 3]], process=False))


def strip(width=6e-3):
    """A narrow flat surface, facing down."""
    points = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]) * (width / 2, 0.03, 0.0)
    return Tool.from_mesh("strip", trimesh.Trimesh(points, [[0, 2, 1], [0, 3, 2]], process=False))


def deepest(result, points):
    """How deep points lie in a ply that was under them, by brute force [m]."""
    x, triangles = result.plies[0].points, np.asarray(result.plies[0].triangles)
    place, triangle, _ = nearest_on_triangles(points, x[triangles], k=40)
    facing = Facing(triangles, x)
    up = np.array([facing.normals[t] for t in triangle])
    offset = points - place
    distance = np.where((offset * up).sum(axis=1) < 0.0, -1.0, 1.0) * np.linalg.norm(offset, axis=1)
    return float((HALF - distance).max())


@pytest.mark.parametrize("kind", [plate, wall, strip])
def test_a_rim_within_triangles_does_not_pass_through_them(kind):
    """Without rims a plate's reached 3 to 7 mm through, and the wall went all the way."""
    scene = pressed(kind())
    result = scene.run(frames=4, quiet=True)
    assert result.completed, result.summary["message"]
    ends = exposed_rims(scene.tools[0], scene)
    share = np.linspace(0.0, 1.0, 41)[:, None, None]
    on_rims = ((1.0 - share) * ends[:, 0] + share * ends[:, 1]).reshape(-1, 3)
    assert deepest(result, on_rims - (0.0, 0.0, TRAVEL)) < 0.05 * 2.0 * HALF
    entry = result.summary["tools"][0]
    assert entry["max_penetration_m"] < 0.05 * 2.0 * HALF
    assert entry["max_face_penetration_m"] < 0.05 * 2.0 * HALF
    assert entry["max_force_n"] > 0.1
    assert result.summary["energy_error"] < 2e-3
    assert result.plies[0].points[:, 2].min() < -0.8 * TRAVEL


def test_directions_in_which_a_surface_ends():
    ends, outward = rims(Tool.plate(width=0.2, height=0.1))
    middle = ends.mean(axis=1)
    sides = np.abs(middle[:, :2]) > np.array([0.1, 0.05]) - 1e-9
    assert (sides.sum(axis=1) == 1).all(), "all lie on a side"
    expected = np.where(sides, np.sign(middle[:, :2]), 0.0)
    np.testing.assert_allclose(
        outward, np.column_stack([expected, np.zeros(len(ends))]), atol=1e-12
    )
    solid = Tool.from_mesh("box", trimesh.creation.box((0.1, 0.1, 0.1)))
    assert len(rims(solid)[0]) == 0


def scene_of(tool, **options):
    ply = Ply.rectangle("ply", "carbon_interlock", 0.3, cells=10)
    return Scene(name="s", plies=[ply], tools=[tool], duration=0.01, **options)


def test_rims_that_a_ply_cannot_reach_are_none():
    below = (0.0, 0.0, -0.01)
    within = Tool.plate(width=0.2, height=0.2).moved(below)
    assert len(exposed_rims(within, scene_of(within))) > 0
    beside = Tool.plate(width=0.4, height=0.4).moved(below)
    assert len(exposed_rims(beside, scene_of(beside))) == 0
    across = Tool.plate(width=0.4, height=0.2).moved(below)
    ends = exposed_rims(across, scene_of(across))
    np.testing.assert_allclose(np.abs(ends[..., 1]), 0.1, atol=1e-12)
    assert np.abs(ends[..., 0]).min() < 0.15


@pytest.mark.parametrize(("angle", "felt"), [(15.0, True), (45.0, False)])
@pytest.mark.parametrize("above", [False, True])
def test_rims_that_turn_away_from_the_ply_are_none(angle, felt, above):
    """A gutter of two sides, its keel towards the ply; its keel is blunt."""
    run, rise = 0.03, 0.03 * np.tan(np.radians(angle))
    down = -1.0 if above else 1.0
    points = [(s * run, y, -down * rise) for s in (-1, 1) for y in (-0.1, 0.1)]
    points += [(0.0, y, 0.0) for y in (-0.1, 0.1)]
    facets = [[0, 4, 5], [0, 5, 1], [4, 2, 3], [4, 3, 5]]
    gutter = Tool.from_mesh("gutter", trimesh.Trimesh(points, facets, process=False))
    gutter = gutter.moved((0.0, 0.0, -0.01 * down))
    ends = exposed_rims(gutter, scene_of(gutter))
    long = np.abs(ends[:, 1, 1] - ends[:, 0, 1]) > 0.1
    assert long.any() == felt
    assert (~long).any(), "at its two ends it just ends"


def test_rims_that_come_over_a_ply_later_count():
    away = (0.4, 0.0, -0.01)
    still = Tool.plate(width=0.2, height=0.2).moved(away)
    assert len(exposed_rims(still, scene_of(still))) == 0
    stroke = Stroke(travel=(-0.4, 0.0, 0.0), duration=0.01)
    moving = Tool.plate(width=0.2, height=0.2, motion=stroke).moved(away)
    assert len(exposed_rims(moving, scene_of(moving))) == len(rims(moving)[0])
    turned = Tool.plate(
        width=0.2,
        height=0.2,
        turn=Turn(axis=(0.0, 0.0, 1.0), point=(0.0, 0.0, 0.0), angle=[(0.0, 0.0), (0.01, np.pi)]),
    ).moved((-0.4, 0.0, -0.01))
    assert exposed_rims(turned, scene_of(turned)).shape[1:] == (2, 3)


def test_presses_have_no_rims_to_feel():
    for build in (hemisphere.build, square_box.build, tetrahedron.build, double_dome.build):
        assert not has_features(build())


def test_points_lie_along_rims_and_corners_are_one():
    scene = pressed(plate())
    points = points_of(scene)[0] - scene.tools[0].vertices.mean(axis=0)
    assert (np.abs(np.abs(points[:, :2]).max(axis=1) - 0.5 * SIZE) < 1e-9).all()
    corners = (np.abs(np.abs(points[:, :2]) - 0.5 * SIZE) < 1e-9).all(axis=1)
    assert corners.sum() == 4
    order = np.sort(np.arctan2(points[:, 1], points[:, 0]))
    assert np.diff(order).max() < 0.2
