"""Fit inner vertices, or a lattice, to an outline with a rim of Delaunay triangles."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from warpdrape.blanks.flat_mesh import FlatMesh
from warpdrape.blanks.outlines import Outline, Points, enclosed
from warpdrape.errors import InputError

Rows = NDArray[np.int64]
"""Vertex indices, a row an edge or a triangle."""
FLAT = 1e-9
"""Twice the area over the square of the longest side below which a hull triangle is rounding."""
ATTEMPTS = 30
"""Rounds of splitting outline segments that are not yet in the triangulation."""
SAMPLES = 16
"""Points per edge length that stand for the outline when distances to it are measured."""


def trim(
    outline: Outline, edge: float, points: Points, triangles: Rows, clearance: float
) -> FlatMesh:
    """Keep the lattice triangles well inside an outline and fill the rim.

    Args:
        outline: the shape.
        edge: length of the outline's segments [m].
        points: lattice vertices [m], shape [vertex, 2].
        triangles: lattice triangles, shape [triangle, 3].
        clearance: least distance of a lattice vertex from the outline, over ``edge``.
    """
    keep = gaps(outline, edge, points) > clearance * edge
    core = triangles[keep[triangles].all(axis=1)]
    middles = points[core][:, [1, 2, 0]] + points[core][:, [2, 0, 1]]
    gap = gaps(outline, edge, 0.5 * middles.reshape(-1, 2)).reshape(-1, 3)
    core = core[(gap > 0.5 * clearance * edge).all(axis=1)]
    number = np.cumsum(keep) - 1
    return FlatMesh.from_arrays(*fill(outline.loops(edge), points[keep], number[core]))


def gaps(outline: Outline, edge: float, points: Points) -> NDArray[np.float64]:
    """Distance of points from the outline [m], negative outside; capped at two edges."""
    from scipy.spatial import cKDTree

    samples = np.concatenate(outline.loops(edge / SAMPLES))
    distance, _ = cKDTree(samples).query(points, distance_upper_bound=2.0 * edge)
    distance = np.minimum(distance, 2.0 * edge)
    return np.where(outline.contains(points), distance, -distance)


def fill(loops: Sequence[Points], inner: Points, core: Rows | None = None) -> tuple[Points, Rows]:
    """Triangulate what lies inside closed loops: given triangles, Delaunay for the rest.

    Segments that Delaunay leaves out are halved; core triangles whose outer side it leaves out
    are given up, so that the rim takes their place.

    Args:
        loops: outline points [m], a [point, 2] array each.
        inner: more vertices [m], shape [inner, 2].
        core: triangles of inner vertices that are kept as they are, shape [triangle, 3].

    Returns:
        Vertices (those of the loops, midpoints that had to be added, then the inner ones) and
        triangles, shape [triangle, 3].
    """
    core = np.empty((0, 3), np.int64) if core is None else core
    for _ in range(ATTEMPTS):
        points = np.concatenate([*loops, inner])
        shift = len(points) - len(inner)
        walls = np.concatenate([_loop_edges(loops), _outer_edges(core) + shift])
        covered = np.zeros(len(inner), bool)
        covered[core] = True
        covered[_outer_edges(core)] = False
        active = np.flatnonzero(np.r_[np.ones(shift, bool), ~covered])
        simplices = active[_delaunay(points[active])]
        missing = ~_present(walls, simplices)
        if not missing.any():
            rim = _between(points, simplices, walls)
            return points, np.concatenate([core + shift, rim])
        loops = _halve(loops, missing[:shift])
        lost = _keys(walls[shift:][missing[shift:]] - shift)
        core = core[~np.isin(_keys(_sides(core)), lost).reshape(-1, 3).any(axis=1)]
    raise InputError(
        "the outline has details too fine or angles too sharp for this edge length: "
        "give a shorter edge or a simpler outline"
    )


def _between(points: Points, simplices: Rows, walls: Rows) -> Rows:
    """Triangles inside the outline but not inside the core: an odd number of walls around."""
    on_wall = np.zeros(len(points), bool)
    on_wall[walls] = True
    doubtful = np.flatnonzero(on_wall[simplices].all(axis=1))
    inside = np.ones(len(simplices), bool)
    middles = points[simplices[doubtful]].mean(axis=1)
    inside[doubtful] = enclosed(middles, points[walls])
    return simplices[inside]


def _delaunay(points: Points) -> Rows:
    """Delaunay triangles without the flat ones that rounding leaves on a straight hull."""
    from scipy.spatial import Delaunay

    rows = Delaunay(points).simplices.astype(np.int64)
    a, b, c = (points[rows[:, k]] for k in range(3))
    u, v, w = b - a, c - a, c - b
    longest = np.max([(side**2).sum(axis=1) for side in (u, v, w)], axis=0)
    return rows[np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]) > FLAT * longest]


def _loop_edges(loops: Sequence[Points]) -> Rows:
    sizes = [len(loop) for loop in loops]
    starts = np.cumsum([0, *sizes[:-1]])
    edges = [
        np.column_stack([start + np.arange(size), start + (np.arange(size) + 1) % size])
        for start, size in zip(starts, sizes, strict=True)
    ]
    return np.concatenate(edges)


def _halve(loops: Sequence[Points], missing: NDArray[np.bool_]) -> list[Points]:
    """Put a midpoint into every segment that is missing; segments are counted through the loops."""
    halved, start = [], 0
    for loop in loops:
        at = np.flatnonzero(missing[start : start + len(loop)])
        middle = 0.5 * (loop[at] + np.roll(loop, -1, axis=0)[at])
        halved.append(np.insert(loop, at + 1, middle, axis=0))
        start += len(loop)
    return halved


def _sides(triangles: Rows) -> Rows:
    return triangles[:, [[1, 2], [2, 0], [0, 1]]].reshape(-1, 2)


def _keys(edges: Rows) -> NDArray[np.int64]:
    return (edges.min(axis=1) << 32) | edges.max(axis=1)


def _outer_edges(triangles: Rows) -> Rows:
    """Sides that belong to one of the triangles only, shape [edge, 2]."""
    sides = _sides(triangles)
    _, first, counts = np.unique(_keys(sides), return_index=True, return_counts=True)
    return sides[first[counts == 1]]


def _present(edges: Rows, triangles: Rows) -> NDArray[np.bool_]:
    return np.isin(_keys(edges), _keys(_sides(triangles)))
