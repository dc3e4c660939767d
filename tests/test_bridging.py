"""Bridges over hollows of known depth, coverage of known share, on plies and tools made up."""

import math

import numpy as np
import pytest
import trimesh

from warpdrape.blanks.ply import Ply
from warpdrape.defects.bridging import clearances, find_bridges
from warpdrape.defects.coverage import coverage, surface_points
from warpdrape.defects.crest_lobes import edge_graph
from warpdrape.defects.gaps import SurfaceGaps, ToolGaps
from warpdrape.defects.wrinkle_field import vertex_normals
from warpdrape.tools.pose import shifted
from warpdrape.tools.tool import Tool

SIDE, THICKNESS = 0.2, 6e-4


def trough(depth, half_width, half_length):
    """A V-shaped hollow with closed ends in a plate, facing up."""
    x, y = half_width, half_length
    far = 1.0
    points = np.array(
        [
            (-far, -far, 0), (far, -far, 0), (far, far, 0), (-far, far, 0),
            (-x, -y, 0), (x, -y, 0), (x, y, 0), (-x, y, 0),
            (0, -y, -depth), (0, y, -depth),
        ]
    )  # fmt: skip
    faces = [(0, 1, 5), (0, 5, 4), (1, 2, 6), (1, 6, 5), (2, 3, 7), (2, 7, 6), (3, 0, 4)]
    faces += [(3, 4, 7), (4, 8, 9), (4, 9, 7), (5, 6, 9), (5, 9, 8), (4, 5, 8), (6, 7, 9)]
    return Tool.from_mesh("trough", trimesh.Trimesh(points, faces, process=False))


def bridges_of(ply, tool, points, least=THICKNESS, below=0.5 * THICKNESS, above=0.5 * THICKNESS):
    triangles = np.asarray(ply.mesh.triangles)
    gaps, still = ToolGaps([tool]), [shifted()]
    ways = gaps.ways(points, still)
    beneath = gaps.beneath(points, vertex_normals(points, triangles), still)
    off = clearances(ways, points, triangles, below, above)
    outline = np.asarray(ply.mesh.boundary_vertices)
    return find_bridges(edge_graph(ply.mesh), outline, points, triangles, off, beneath, least)


def flat_on(cells, height=0.5 * THICKNESS):
    ply = Ply.rectangle("ply", "carbon_interlock", SIDE, cells=cells, mesh="grid")
    flat = np.asarray(ply.mesh.vertices)
    return ply, np.column_stack([flat, np.full(len(flat), height)])


@pytest.mark.parametrize("cells", [40, 80, 120])
def test_a_bridged_hollow_of_known_gap(cells):
    """The middle of the ply is as far from both sides: d cos(half the opening) off them."""
    depth, half = 0.02, 0.03
    ply, points = flat_on(cells)
    (bridge,) = bridges_of(ply, trough(depth, half, 0.06), points)
    lean = math.atan2(depth, half)
    expected = (depth + 0.5 * THICKNESS) * math.cos(lean) - 0.5 * THICKNESS
    assert bridge.gap == pytest.approx(expected, rel=0.02)
    assert abs(points[bridge.vertex, 0]) < 1e-9
    # Off where half − |x| and the way from the ends exceed what leaves THICKNESS of gap.
    margin = THICKNESS / math.sin(lean)
    area = 4.0 * (half - margin) * (0.06 - THICKNESS)
    assert bridge.area == pytest.approx(area, rel=6.0 / cells)


@pytest.mark.parametrize(("cells", "resolved"), [(10, False), (40, True)])
def test_a_bridge_of_a_vertex_or_two_is_told_apart(cells, resolved):
    """A slot of 30 mm under triangles of 20 mm, and of 5 mm."""
    ply, points = flat_on(cells)
    (bridge,) = bridges_of(ply, trough(0.02, 0.015, 0.06), points)
    assert bridge.resolved == resolved and bridge.gap > 5e-3


def test_a_ply_that_follows_the_hollow_does_not_bridge():
    depth, half = 0.02, 0.05
    ply, points = flat_on(40)
    lean = math.atan2(depth, half)
    x = points[:, 0]
    points[:, 2] = np.minimum(0.0, -depth * (1.0 - np.abs(x) / half))
    points[:, 2] += 0.5 * THICKNESS / np.where(np.abs(x) < half, math.cos(lean), 1.0)
    assert bridges_of(ply, trough(depth, half, 1.0 - 1e-6), points) == ()


def test_a_span_that_reaches_the_edge_is_no_bridge():
    ply, points = flat_on(40)
    assert bridges_of(ply, trough(0.02, 0.03, 0.99), points) == ()


def test_a_ply_over_the_hole_of_a_die_is_no_bridge():
    ply, points = flat_on(40)
    die = Tool.die(hole_radius=0.06, edge_radius=0.01, outer_radius=0.3)
    assert bridges_of(ply, die, points) == ()


def test_plies_between_are_no_gap():
    """The third ply of a stack on the tool: 2.5 thicknesses off its surface."""
    ply, points = flat_on(60, height=2.5 * THICKNESS)
    deep = trough(0.02, 0.03, 0.06)
    (bridge,) = bridges_of(ply, deep, points, below=2.5 * THICKNESS)
    assert bridge.gap < 0.02
    assert bridges_of(ply, deep, points) == ()  # seen as lying off the tool everywhere


@pytest.mark.parametrize("cells", [8, 20])
def test_coverage_of_a_plate_is_the_share_of_area(cells):
    plate = Tool.plate(width=0.4, height=0.3)
    ply, points = flat_on(cells)
    surface = SurfaceGaps(points, np.asarray(ply.mesh.triangles))
    found = coverage(plate, shifted(), [surface], 1.5 * THICKNESS)
    assert found == pytest.approx(0.2 * 0.2 / (0.4 * 0.3), rel=0.02)
    assert coverage(plate, shifted((0.0, 0.0, -0.01)), [surface], 1.5 * THICKNESS) == 0.0


def test_points_of_a_surface_stand_for_its_area():
    punch = Tool.punch(radius=0.05, height=0.08)
    points, areas = surface_points(punch, 5000)
    assert areas.sum() == pytest.approx(punch.surface.mesh.area)
    lower = areas[points[:, 2] < 0.05].sum()
    assert lower == pytest.approx(2.0 * math.pi * 0.05**2, rel=0.01)
