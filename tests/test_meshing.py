"""Meshes are sound, exact on their outline, well shaped, and follow the yarns."""

import math

import numpy as np
import pytest
import trimesh

from warpdrape.blanks import meshing
from warpdrape.blanks.flat_mesh import FlatMesh
from warpdrape.blanks.meshing import PATTERNS, mesh_outline
from warpdrape.blanks.outlines import (
    Disc,
    Polygon,
    Rectangle,
    closed_segments,
    enclosed,
    windings,
)
from warpdrape.errors import InputError

EDGE = 0.01
L_WITH_HOLE = Polygon(
    [(0, 0), (0.3, 0), (0.3, 0.12), (0.14, 0.12), (0.14, 0.25), (0, 0.25)],
    holes=[[(0.05, 0.05), (0.09, 0.05), (0.09, 0.09), (0.05, 0.09)]],
)
OUTLINES = {"rectangle": Rectangle(0.3, 0.2), "disc": Disc(0.15), "l_with_hole": L_WITH_HOLE}
ANGLES_DEG = (0.0, 15.0, 22.5, 30.0, 45.0, 77.0)


def outline_area(outline):
    """Area within the chords [m²]."""
    loops = outline.loops(EDGE)
    return sum(
        0.5 * np.sum(p[:, 0] * np.roll(p[:, 1], -1) - p[:, 1] * np.roll(p[:, 0], -1)) for p in loops
    )


def check_sound(mesh, outline):
    holes = len(outline.loops(EDGE)) - 1
    euler = len(mesh.vertices) - len(mesh.edges.vertices) + len(mesh.triangles)
    assert euler == 1 - holes
    assert mesh.areas.min() > 0.0
    assert mesh.areas.sum() == pytest.approx(outline_area(outline), rel=1e-12)
    assert mesh.vertex_areas.sum() == pytest.approx(mesh.areas.sum(), rel=1e-12)
    assert len(mesh.boundary_vertices) == len(mesh.boundary_edges)


@pytest.mark.parametrize("angle_deg", ANGLES_DEG)
@pytest.mark.parametrize("name", OUTLINES)
def test_aligned_meshes_are_sound_and_follow_the_yarns(name, angle_deg):
    outline, angle = OUTLINES[name], math.radians(angle_deg)
    mesh = mesh_outline(outline, edge=EDGE, warp_angle=angle)
    check_sound(mesh, outline)
    # A regular triangle is EDGE/2 high; measured 0.66 and more of that on all these.
    assert mesh.heights.min() > 0.6 * EDGE / 2
    assert mesh.areas.max() < 0.8 * EDGE**2
    centres = mesh.vertices[mesh.triangles].mean(axis=1)
    corners = np.concatenate(outline.loops(EDGE / 4))
    away = np.linalg.norm(centres[:, None] - corners, axis=2).min(axis=1) > 2.2 * EDGE
    assert away.sum() > 0.3 * len(away)
    p = mesh.vertices[mesh.triangles[away]]
    sides = np.roll(p, -1, axis=1) - p
    turned = (np.arctan2(sides[..., 1], sides[..., 0]) - angle) / (math.pi / 4)
    assert np.abs(turned - np.rint(turned)).max() < 1e-9
    assert mesh.areas[away] == pytest.approx(EDGE**2 / 4, rel=1e-9)


@pytest.mark.parametrize("pattern", sorted(set(PATTERNS) - {"aligned"}))
@pytest.mark.parametrize("name", OUTLINES)
def test_other_patterns_are_sound(name, pattern):
    mesh = mesh_outline(OUTLINES[name], edge=EDGE, pattern=pattern)
    check_sound(mesh, OUTLINES[name])
    assert mesh.heights.min() > 0.3 * EDGE


def test_rectangle_grid_is_exact():
    mesh = mesh_outline(Rectangle(0.3, 0.3), cells=20, pattern="grid")
    assert mesh.triangles.shape == (1600, 3)
    assert mesh.areas == pytest.approx(0.015**2 / 4, rel=1e-12)
    assert mesh.vertices.min() == -0.15 and mesh.vertices.max() == 0.15
    for quarter in (1, 2, -3):
        turned = mesh_outline(Rectangle(0.3, 0.3), cells=20, warp_angle=quarter * math.pi / 2)
        assert np.array_equal(turned.vertices, mesh.vertices)
    specimen = Rectangle(0.1, 0.2)
    assert len(mesh_outline(specimen, cells=20, warp_angle=math.pi / 4).triangles) == 3200
    assert len(mesh_outline(specimen, cells=20, pattern="diagonal").triangles) == 1600


def test_rectangle_whose_cells_do_not_fit_still_follows_yarns_at_45_degrees():
    mesh = mesh_outline(Rectangle(0.1, 0.137), edge=0.01, warp_angle=math.pi / 4)
    assert np.ptp(mesh.areas) > 1e-6
    assert mesh.areas.sum() == pytest.approx(0.0137, rel=1e-12)


def test_random_mesh_depends_on_the_seed_only():
    found = []
    for seed in (3, 3, 4):
        meshing._random_mesh.cache_clear()
        found.append(mesh_outline(Disc(0.1), edge=EDGE, pattern="random", seed=seed).vertices)
    first, again, other = found
    assert first is not again and np.array_equal(first, again)
    assert first.shape != other.shape or np.abs(first - other).max() > 1e-4


def test_a_mesh_that_is_asked_for_again_is_the_same_one_and_any_other_is_not():
    square, triangle = Rectangle(0.1, 0.1), [(0, 0), (0.1, 0), (0, 0.1)]
    asked = [
        (square, {}),
        (square, {"edge": 0.02}),
        (square, {"warp_angle": 0.3}),
        (square, {"pattern": "diagonal"}),
        (square, {"pattern": "random"}),
        (square, {"pattern": "random", "seed": 1}),
        (Rectangle(0.1, 0.2), {}),
        (Disc(0.05), {}),
        (Polygon(triangle), {}),
        (Polygon([*triangle, (-0.01, 0.01)]), {}),
    ]
    meshes = [mesh_outline(outline, **{"edge": EDGE, **how}) for outline, how in asked]
    assert len(set(meshes)) == len(asked)
    shapes = {(mesh.vertices.tobytes(), mesh.triangles.tobytes()) for mesh in meshes}
    assert len(shapes) == len(asked)
    again = Polygon([list(point) for point in triangle])
    assert mesh_outline(again, edge=EDGE) is meshes[-2]
    assert mesh_outline(square, edge=EDGE, pattern="random", seed=1) is meshes[5]


def test_windings_are_those_of_the_angle_that_loops_turn_round_a_point():
    rng = np.random.default_rng(5)
    for corners in (3, 7, 20):
        loop, points = rng.normal(size=(corners, 2)), rng.normal(size=(400, 2))
        segments = closed_segments([loop, [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]])
        to = segments[None] - points[:, None, None]
        a, b = np.moveaxis(to, 2, 0)
        turn = np.arctan2(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0], (a * b).sum(axis=2))
        expected = turn.sum(axis=1) / (2.0 * math.pi)
        assert np.ptp(expected) > 1.0
        assert windings(points, segments) == pytest.approx(expected, abs=1e-9)
        assert np.array_equal(enclosed(points, segments), np.round(expected) % 2 == 1)


def test_sharp_and_narrow_outlines_are_met():
    spike = Polygon([(0, 0), (0.2, 0.005), (0.2, 0.012), (0.05, 0.09), (0, 0.1)])
    mesh = mesh_outline(spike, edge=EDGE, warp_angle=0.3)
    assert mesh.areas.sum() == pytest.approx(spike.area, rel=1e-12)
    for corner in spike.points:
        assert np.linalg.norm(mesh.vertices - corner, axis=1).min() == 0.0


def test_jagged_stars_with_a_needle_hole_are_met():
    """Reflex corners poke into the lattice: there its triangles give way to the rim."""
    rng = np.random.default_rng(1)
    for _ in range(12):
        angle = (np.arange(9) + rng.uniform(-0.3, 0.3, 9)) * math.tau / 9
        reach = rng.uniform(3.0, 10.0, 9) * EDGE
        needle = np.array([(0, 0), (0.02 * EDGE, 0), (0, EDGE)]) + rng.uniform(-EDGE, EDGE, 2)
        star = np.column_stack([reach * np.cos(angle), reach * np.sin(angle)])
        outline = Polygon(star, holes=[needle])
        for pattern in ("aligned", "diagonal", "random"):
            check_sound(mesh_outline(outline, edge=EDGE, pattern=pattern), outline)


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ({}, "either edge"),
        ({"edge": 0.01, "cells": 3}, "either edge"),
        ({"edge": 0.0}, "above zero"),
        ({"edge": math.nan}, "finite"),
        ({"edge": 0.5}, "longer than the outline"),
        ({"cells": 0}, "whole number"),
        ({"cells": 2.5}, "whole number"),
        ({"cells": 3, "pattern": "alined"}, "did you mean 'aligned'"),
        ({"cells": 3, "warp_angle": math.inf}, "warp_angle"),
        ({"cells": 3, "pattern": "random", "seed": -1}, "seed"),
    ],
)
def test_bad_mesh_sizes_say_so(arguments, text):
    with pytest.raises(InputError, match=text):
        mesh_outline(Rectangle(0.3, 0.2), **arguments)
    with pytest.raises(InputError, match="at least 10"):
        mesh_outline(Rectangle(1.0, 0.1), cells=3)


@pytest.mark.parametrize(
    ("build", "text"),
    [
        (lambda: Rectangle(-1.0, 1.0), "width"),
        (lambda: Disc(math.nan), "radius"),
        (lambda: Polygon([(0, 0), (1, 0)]), "at least 3"),
        (lambda: Polygon([(0, 0), (1, 0), (1, 0), (1, 1)]), "corner 1 is repeated"),
        (lambda: Polygon([(0, 0), (1, 1), (1, 0), (0, 1)]), "side 0 of points meets side 2"),
        (lambda: Polygon([(0, 0), (2, 0), (1, 0)]), "encloses no area"),
        (lambda: Polygon([(0, 0), (1, 0), (0, 1)], [[(2, 2), (3, 2), (2, 3)]]), "outside"),
        (lambda: Polygon([(0, 0), (1, 0), (0, 1)], [[(0.1, 0.1), (3, 2), (2, 3)]]), "holes"),
        (lambda: Polygon([(0, 0), "x", (0, 1)]), "pairs of numbers"),
    ],
)
def test_bad_outlines_say_so(build, text):
    with pytest.raises(InputError, match=text):
        build()


def test_outlines_know_inside_and_turn_clockwise_loops():
    ccw = Polygon([(0, 0), (1, 0), (0, 1)], holes=[[(0.2, 0.2), (0.4, 0.2), (0.2, 0.4)]])
    cw = Polygon([(0, 1), (1, 0), (0, 0)], holes=[[(0.2, 0.4), (0.4, 0.2), (0.2, 0.2)]])
    assert ccw.area == pytest.approx(0.48) and cw.area == pytest.approx(0.48)
    points = [(0.1, 0.1), (0.25, 0.25), (0.9, 0.9), (-0.1, 0.5), (0.45, 0.45)]
    assert cw.contains(points).tolist() == [True, False, False, False, True]
    rng = np.random.default_rng(0)
    for outline in (L_WITH_HOLE, Disc(0.15), Rectangle(0.3, 0.2)):
        x0, y0, x1, y1 = outline.bounds
        inside = outline.contains(rng.uniform((x0, y0), (x1, y1), (40_000, 2))).mean()
        assert inside * (x1 - x0) * (y1 - y0) == pytest.approx(outline.area, rel=0.02)


SQUARE = np.array([(0, 0), (1, 0), (1, 1), (0, 1)], float)
HALVES = np.array([[0, 1, 2], [0, 2, 3]])


@pytest.mark.parametrize(
    ("vertices", "triangles", "text"),
    [
        (SQUARE[:, :1], HALVES, "shape"),
        (SQUARE, HALVES[:, :2], "triangles have shape"),
        (SQUARE, HALVES[:0], "at least one"),
        (SQUARE, HALVES.astype(float), "whole numbers"),
        (np.where(SQUARE > 0, np.nan, 0), HALVES, "vertices 1, 2, 3 are not finite"),
        (SQUARE, HALVES + 1, "triangles 1 name vertices outside 0..3"),
        (np.array([(0, 0), (1, 0), (2, 0), (0, 1)], float), HALVES, "triangles 0 have zero area"),
        (SQUARE, np.array([[0, 1, 2], [2, 0, 1], [0, 2, 3]]), "triangles 1 repeat"),
        (np.vstack([SQUARE, [(3, 3)]]), HALVES, "vertices 4 belong to no triangle"),
        (np.vstack([SQUARE, [(0, 2)]]), np.vstack([HALVES, [0, 2, 4]]), "0-2 .* more than two"),
        ([[0, 0], [1]], HALVES, "array of numbers"),
    ],
)
def test_bad_meshes_say_what_and_where(vertices, triangles, text):
    with pytest.raises(InputError, match=text):
        FlatMesh(vertices, triangles)


def test_clockwise_triangles_are_turned_and_arrays_are_safe():
    mesh = FlatMesh(SQUARE, HALVES[:, ::-1])
    assert mesh.areas.tolist() == [0.5, 0.5] and mesh.triangles.dtype == np.int32
    assert mesh.heights == pytest.approx(math.sqrt(0.5))
    assert mesh.vertex_areas == pytest.approx([1 / 3, 1 / 6, 1 / 3, 1 / 6])
    boundary = sorted(mesh.boundary_edges.tolist())
    assert boundary == [[0, 1], [1, 2], [2, 3], [3, 0]]
    inner = mesh.edges.triangles[:, 1] >= 0
    assert mesh.edges.vertices[inner].tolist() == [[0, 2]]
    for side in (0, 1):
        rows = mesh.triangles[mesh.edges.triangles[inner, side]]
        assert rows[0, mesh.edges.corners[inner, side]][0] in (1, 3)
    with pytest.raises(ValueError, match="read-only"):
        mesh.vertices[0] = 1.0


@pytest.mark.parametrize("suffix", ["stl", "obj", "ply", "off", "glb"])
def test_files_are_read_with_their_neighbours(tmp_path, suffix):
    path = tmp_path / f"blank.{suffix}"
    source = mesh_outline(Rectangle(300.0, 200.0), cells=6)
    solid = np.column_stack([source.vertices, np.full(len(source.vertices), 7.0)])
    trimesh.Trimesh(solid, source.triangles, process=False).export(path)
    mesh = FlatMesh.from_file(path, scale=1e-3)
    assert mesh.triangles.shape == source.triangles.shape
    assert len(mesh.vertices) == len(source.vertices)
    assert len(mesh.boundary_edges) == len(source.boundary_edges)
    assert mesh.areas.sum() == pytest.approx(0.06, rel=1e-6)


def test_bad_files_say_so(tmp_path):
    with pytest.raises(InputError, match="does not exist"):
        FlatMesh.from_file(tmp_path / "none.stl")
    (tmp_path / "odd.xyzw").write_text("nothing")
    with pytest.raises(InputError, match="cannot be read"):
        FlatMesh.from_file(tmp_path / "odd.xyzw")
    trimesh.creation.box().export(tmp_path / "box.stl")
    with pytest.raises(InputError, match="z varies by 1"):
        FlatMesh.from_file(tmp_path / "box.stl")
    with pytest.raises(InputError, match="scale"):
        FlatMesh.from_file(tmp_path / "box.stl", scale=0.0)
    with pytest.raises(InputError, match="z varies"):
        FlatMesh.from_arrays(np.eye(3), [[0, 1, 2]])
