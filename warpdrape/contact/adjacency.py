"""Which triangles of a surface lie beside which, where its borders are, and how it bends there."""

from __future__ import annotations

import numpy as np


def _edge_keys(triangles: np.ndarray) -> np.ndarray:
    """A number for the edge across from each corner, the same in both triangles, shape [m, 3]."""
    edges = np.sort(triangles[:, [[1, 2], [2, 0], [0, 1]]], axis=2).astype(np.int64)
    return edges[..., 0] * (int(triangles.max()) + 1) + edges[..., 1]


def across_edges(triangles: np.ndarray) -> np.ndarray:
    """Triangle beyond the edge across from each corner, −1 where there is none, shape [m, 3]."""
    key = _edge_keys(np.asarray(triangles)).ravel()
    order = np.argsort(key, kind="stable")
    same = key[order][1:] == key[order][:-1]
    one, other = order[:-1][same], order[1:][same]
    beside = np.full(key.size, -1)
    beside[one], beside[other] = other // 3, one // 3
    return beside.reshape(-1, 3)


def edge_bits(triangles: np.ndarray, marked: np.ndarray) -> np.ndarray:
    """Bit e where the edge across from corner e is marked, 3 + k where corner k ends such an edge.

    Args:
        triangles: vertices, shape [m, 3].
        marked: edges, shape [m, 3].

    Returns:
        shape [m].
    """
    at_end = np.zeros(triangles.max() + 1, dtype=bool)
    for k in range(3):
        at_end[triangles[marked[:, k]][:, [k - 2, k - 1]]] = True
    bits = np.hstack([marked, at_end[triangles]]) @ (1, 2, 4, 8, 16, 32)
    return bits.astype(np.int32)


def border_bits(triangles: np.ndarray, beside: np.ndarray) -> np.ndarray:
    """`edge_bits` of the edges beyond which nothing lies; ``beside`` is from `across_edges`."""
    return edge_bits(triangles, beside < 0)


def facet_hollows(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """How far from a facet's edges a point must lie for no facet beside it to be nearer, shape [m].

    Beyond an edge that rises by φ nearer facets begin d tan φ inside of it, d the distance. Over an
    edge of length l that is a corner's weight of d tan φ l/2A; this is tan φ l/2A at its largest.

    Args:
        points: vertices [m], shape [n, 3].
        triangles: vertices, counter-clockwise seen from outside, shape [m, 3].

    Returns:
        Weight of a corner over the distance [1/m]: 0 where all fall away, infinite from φ = 90° on.
    """
    points, triangles = np.asarray(points), np.asarray(triangles)
    a, b, c = (points[triangles[:, k]] for k in range(3))
    area = np.cross(b - a, c - a)
    twice = np.linalg.norm(area, axis=1)
    longest = np.sqrt(np.max([((q - p) ** 2).sum(axis=1) for p, q in ((a, b), (b, c), (c, a))], 0))
    steepest = np.zeros(len(triangles))
    for other in across_edges(triangles).T:
        rise = ((points[triangles[other]] - a[:, None]) * area[:, None]).sum(axis=2).max(axis=1)
        cosine = np.einsum("ij,ij->i", area, area[other])
        sine = np.linalg.norm(np.cross(area, area[other]), axis=1)
        with np.errstate(divide="ignore", invalid="ignore"):
            slope = np.where(cosine > 0.0, sine / cosine, np.inf)
        steepest = np.where((other >= 0) & (rise > 0.0), np.maximum(steepest, slope), steepest)
    with np.errstate(divide="ignore", invalid="ignore"):
        hollow = steepest * longest / twice
    return np.where(np.isfinite(hollow), hollow, np.inf)
