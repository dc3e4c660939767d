"""What contact between plies knows of their triangles: which lie beside which, and the borders."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import warp as wp

from warpdrape.contact.adjacency import across_edges, border_bits
from warpdrape.kernels.contact.facets import PlyFacets


def build_facets(
    triangles: Sequence[np.ndarray], first_vertex: np.ndarray, device: str
) -> PlyFacets:
    """Put the triangles of all plies, one ply after the other, on a device.

    Args:
        triangles: vertices of each ply's triangles, numbered within the ply, shape [m, 3] each.
        first_vertex: number of each ply's first vertex, and last of all their total.
        device: Warp device.
    """
    corners = np.concatenate([t + v for t, v in zip(triangles, first_vertex, strict=False)])
    vertices = int(first_vertex[-1])
    fan_vertex = corners.ravel()
    fans = np.argsort(fan_vertex, kind="stable")
    sides = np.concatenate([corners[:, [k, k - 1]] for k in range(3)])
    both_ways = np.concatenate([sides, sides[:, ::-1]]).astype(np.int64)
    key = np.sort(both_ways @ (vertices, 1))  # np.unique takes ten times as long
    ring_vertex, rings = np.divmod(key[np.r_[True, key[1:] != key[:-1]]], vertices)

    def integers(values: np.ndarray, dtype: type = wp.int32) -> wp.array:
        return wp.array(values, dtype=dtype, device=device)

    facets = PlyFacets()
    facets.corners = integers(corners, wp.vec3i)
    beside = across_edges(corners)
    facets.borders = integers(border_bits(corners, beside))
    facets.beside = integers(beside, wp.vec3i)
    facets.first_of_fan = integers(_starts(fan_vertex, vertices))
    facets.fans = integers(fans // 3)
    facets.first_of_ring = integers(_starts(ring_vertex, vertices))
    facets.rings = integers(rings)
    return facets


def _starts(owners: np.ndarray, count: int) -> np.ndarray:
    """Where the entries of each of ``count`` owners begin once they are sorted, and their end."""
    return np.r_[0, np.cumsum(np.bincount(owners, minlength=count))]
