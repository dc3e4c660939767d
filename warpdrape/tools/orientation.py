"""Which side of a tool's facets is its outside: facets of one sense, and solids turned outward."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import breadth_first_order, connected_components

Facets = NDArray[np.int64]
"""Vertices, shape [facet, 3]."""


def without_doubles(facets: Facets) -> Facets:
    """Each facet once, where a file has some twice, in one sense or in both."""
    _, first = np.unique(np.sort(facets, axis=1), axis=0, return_index=True)
    return facets[np.sort(first)]


def oriented(points: NDArray[np.float64], facets: Facets) -> tuple[Facets, NDArray[np.bool_]]:
    """Give the facets of each connected piece one sense, and that of closed pieces outward.

    Facets are neighbours across edges that belong to two. In an open piece the sense of the larger
    part of its area stays.

    Args:
        points: vertices [m], shape [vertex, 3].
        facets: their facets.

    Returns:
        The facets, and which of them were turned, shape [facet].
    """
    ends = facets[:, [[1, 2], [2, 0], [0, 1]]].reshape(-1, 2)
    low, high = ends.min(axis=1), ends.max(axis=1)
    _, edge, shared = np.unique(low * len(points) + high, return_inverse=True, return_counts=True)
    order = np.argsort(edge, kind="stable")
    start = np.cumsum(shared) - shared
    two = shared == 2
    one, other = order[start[two]], order[start[two] + 1]
    a, b = one // 3, other // 3
    against = ends[one, 0] == ends[other, 0]  # neighbours of one sense run in opposite ways
    size = (len(facets), len(facets))
    graph = coo_array((np.ones(len(a)), (a, b)), shape=size).tocsr()
    count, piece = connected_components(graph, directed=False)
    turned = _by_tree(a, b, against, piece, graph)
    corners = points[facets]
    area = np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    sign = np.where(turned, -1.0, 1.0)
    wrong = np.bincount(piece, sign * area, count) < 0.0
    closed = np.bincount(piece, (shared[edge] != 2).reshape(-1, 3).sum(axis=1), count) == 0
    volume = sign * np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
    wrong = np.where(closed, np.bincount(piece, volume, count) < 0.0, wrong)
    turned ^= wrong[piece]
    return np.where(turned[:, None], facets[:, ::-1], facets), turned


def clash(facets: Facets) -> NDArray[np.int64] | None:
    """An edge that two oriented facets run along in one way, shape [2]; None where there is none.

    There is one where a surface has one side only, like a Möbius strip.
    """
    ends = facets[:, [[1, 2], [2, 0], [0, 1]]].reshape(-1, 2)
    low, high = ends.min(axis=1), ends.max(axis=1)
    key = low * (int(facets.max()) + 1) + high
    _, first, edge, shared = np.unique(
        key, return_index=True, return_inverse=True, return_counts=True
    )
    ways = np.bincount(edge, np.where(ends[:, 0] == low, 1.0, -1.0))
    at_odds = np.flatnonzero((shared == 2) & (ways != 0.0))
    return ends[first[at_odds[0]]] if len(at_odds) else None


def _by_tree(
    a: NDArray[np.int64],
    b: NDArray[np.int64],
    against: NDArray[np.bool_],
    piece: NDArray[np.int32],
    graph: csr_array,
) -> NDArray[np.bool_]:
    """Which facets differ in sense from the first of their piece, shape [facet].

    Args:
        a: one of two neighbours, shape [pair].
        b: the other.
        against: whether they differ, shape [pair].
        piece: number of each facet's piece, shape [facet].
        graph: the neighbours.
    """
    turned = np.zeros(len(piece), dtype=bool)
    if not against.any():
        return turned
    senses = dict(zip(zip(a.tolist(), b.tolist(), strict=True), against.tolist(), strict=True))
    touched = np.unique(piece[a[against]])
    _, first = np.unique(piece, return_index=True)
    for root in first[touched]:
        reached, before = breadth_first_order(graph, root, directed=False)
        for facet in reached[1:].tolist():
            parent = int(before[facet])
            sense = senses.get((facet, parent), senses.get((parent, facet)))
            turned[facet] = turned[parent] ^ sense
    return turned
