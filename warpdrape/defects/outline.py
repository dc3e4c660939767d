"""Draw-in all along the outline of a blank."""

from __future__ import annotations

from typing import Any

import numpy as np

from warpdrape.blanks.flat_mesh import FlatMesh
from warpdrape.blanks.loops import closed_loops, loop_area


def outline_draw_in(mesh: FlatMesh, points: np.ndarray) -> dict[str, Any]:
    """How far the edge has moved in, at every vertex of the outer outline.

    Draw-in is the way inwards, across the flat outline and seen from above. It is given in the
    outline's order, counter-clockwise, from the vertex of the largest x on.

    Args:
        mesh: the flat blank.
        points: formed positions [m], shape [n, 3].

    Returns:
        ``min_m``, ``mean_m`` (over the outline's length), ``max_m``, ``max_at_m`` (flat x and y),
        and the lists ``along_m``, ``x_m``, ``y_m``, ``draw_in_m``.
    """
    flat = np.asarray(mesh.vertices)
    loop = outer_loop(mesh)
    here, after = flat[loop], flat[np.roll(loop, -1)]
    sides = after - here
    lengths = np.linalg.norm(sides, axis=1)
    normals = np.stack([sides[:, 1], -sides[:, 0]], axis=1)  # outwards, as long as the side
    at_vertices = normals + np.roll(normals, 1, axis=0)
    at_vertices /= np.maximum(np.linalg.norm(at_vertices, axis=1, keepdims=True), 1e-300)
    drawn = ((here - points[loop, :2]) * at_vertices).sum(axis=1)
    weights = 0.5 * (lengths + np.roll(lengths, 1))
    most = int(np.argmax(drawn))
    return {
        "min_m": float(drawn.min()),
        "mean_m": float(np.average(drawn, weights=weights)),
        "max_m": float(drawn[most]),
        "max_at_m": here[most].tolist(),
        "along_m": np.concatenate([[0.0], np.cumsum(lengths)[:-1]]).tolist(),
        "x_m": here[:, 0].tolist(),
        "y_m": here[:, 1].tolist(),
        "draw_in_m": drawn.tolist(),
    }


def outer_loop(mesh: FlatMesh) -> np.ndarray:
    """Vertices of the outer outline in order, counter-clockwise, shape [k]."""
    points = np.asarray(mesh.vertices)
    outer = max(closed_loops(mesh.boundary_edges), key=lambda loop: loop_area(points[loop]))
    start = max(range(len(outer)), key=lambda k: (points[outer[k], 0], -abs(points[outer[k], 1])))
    return np.roll(outer, -start)
