"""Bridges: where a ply spans a hollow of a tool that it lies on all round."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from warpdrape.defects.crest_lobes import components
from warpdrape.defects.wrinkle_field import face_vectors, vertex_normals

ALL_ROUND = 0.9
"""Share of the vertices round a bridge that lie on its tool, at least [-]."""

OVER_IT = 0.5
"""Share of a bridge's vertices that its tool lies straight under or over, at least [-]: the hole of
a die does not."""


@dataclass(frozen=True)
class Bridge:
    """One bridge.

    Attributes:
        tool: number of the tool.
        vertex: where it is farthest from the tool.
        gap: there, between ply and tool, less the plies between [m].
        area: of the ply that is off the tool [m²].
        resolved: whether a vertex of it has all its neighbours off the tool too. A smaller one may
            be a chord of the mesh over a rounding.
    """

    tool: int
    vertex: int
    gap: float
    area: float
    resolved: bool


def find_bridges(
    graph: sparse.csr_matrix,
    outline: np.ndarray,
    points: np.ndarray,
    triangles: np.ndarray,
    clearances: np.ndarray,
    beneath: np.ndarray,
    least: float,
) -> tuple[Bridge, ...]:
    """Find the bridges of a ply, the largest gap first.

    Args:
        graph: which vertices share an edge, shape [n, n].
        outline: vertices on the ply's edge.
        points: formed positions [m], shape [n, 3].
        triangles: vertices, shape [m, 3].
        clearances: from each tool to each vertex, less what lies between [m], shape [tool, n].
        beneath: whether a tool lies straight under or over a vertex, shape [tool, n].
        least: gap from which on a ply is off a tool [m].
    """
    if not len(clearances):
        return ()
    sides = np.linalg.norm(face_vectors(points, triangles), axis=1)
    areas = np.bincount(triangles.ravel(), np.repeat(sides / 3.0, 3), len(points))
    nearest = np.argmin(clearances, axis=0)
    gaps = clearances[nearest, np.arange(len(points))]
    off = gaps > least
    count, part = components(graph, off)
    bridges = []
    for number in range(count):
        inside = part == number
        rim = (graph @ inside.astype(float) > 0.0) & ~inside
        tool = int(np.argmax(np.bincount(nearest[rim], minlength=len(clearances))))
        if inside[outline].any() or np.mean(clearances[tool, rim] <= least) < ALL_ROUND:
            continue
        if np.mean(beneath[tool, inside]) >= OVER_IT:
            vertex = int(np.flatnonzero(inside)[np.argmax(clearances[tool, inside])])
            gap, area = float(clearances[tool, vertex]), float(areas[inside].sum())
            inner = inside & ~(graph @ (~inside).astype(float) > 0.0)
            bridges.append(Bridge(tool, vertex, gap, area, bool(inner.any())))
    return tuple(sorted(bridges, key=lambda bridge: -bridge.gap))


def clearances(
    ways: np.ndarray, points: np.ndarray, triangles: np.ndarray, below: float, above: float
) -> np.ndarray:
    """Gaps between a ply and tools, less the plies that lie between [m], shape [tool, n].

    Args:
        ways: from the nearest point of each tool to each vertex [m], shape [tool, n, 3].
        points: formed positions [m], shape [n, 3].
        triangles: vertices, shape [m, 3].
        below: thickness of the stack from its underside to the ply's middle [m].
        above: the same from its upper side [m].
    """
    normals = vertex_normals(points, triangles)
    upper = (ways * normals).sum(axis=2) < 0.0  # the tool is on the upper side
    return np.linalg.norm(ways, axis=2) - np.where(upper, above, below)
