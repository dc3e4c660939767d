"""Edges of the plies' meshes as contact between edges knows them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import warp as wp

from warpdrape.interaction import Span
from warpdrape.kernels.contact.ridges import PlyEdges


def build_edges(triangles: Sequence[np.ndarray], spans: Sequence[Span], device: str) -> PlyEdges:
    """Put the edges of all plies, one ply after the other, on a device.

    Args:
        triangles: vertices of each ply's triangles, numbered within the ply, shape [m, 3] each.
        spans: where plies are.
        device: Warp device.
    """
    corners = np.concatenate(
        [np.asarray(t) + span.first_vertex for t, span in zip(triangles, spans, strict=True)]
    )
    vertices = spans[-1].vertices.stop
    sides = np.sort(corners[:, [[1, 2], [2, 0], [0, 1]]], axis=2).reshape(-1, 2).astype(np.int64)
    keys, first, number = np.unique(sides @ (vertices, 1), return_index=True, return_inverse=True)
    ends, number = sides[first], number.ravel()
    beside = np.full((len(keys), 2), -1)
    beside[:, 0] = first // 3
    second = np.ones(len(number), dtype=bool)
    second[first] = False
    beside[number[second], 1] = np.flatnonzero(second) // 3
    at_ends = ends.ravel()
    stars = np.argsort(at_ends, kind="stable") // 2

    def starts(owners: np.ndarray) -> np.ndarray:
        return np.r_[0, np.cumsum(np.bincount(owners, minlength=vertices))]

    def integers(values: np.ndarray, dtype: type = wp.int32) -> wp.array:
        return wp.array(values.astype(np.int32), dtype=dtype, device=device)

    edges = PlyEdges()
    edges.ends = integers(ends, wp.vec2i)
    edges.sides = integers(beside, wp.vec2i)
    edges.of_triangle = integers(number.reshape(-1, 3), wp.vec3i)
    edges.first_of_own = integers(starts(ends[:, 0]))
    edges.first_of_star = integers(starts(at_ends))
    edges.stars = integers(stars)
    return edges
