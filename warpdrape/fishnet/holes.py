"""Holes of a surface, and the facets by which a ply spans them: flat as far as their rims are."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from warpdrape.fishnet.edges import ends_of, twins_of

STEEP = 0.5
"""Mean cosine between the facets round a hole and those that would span it below which it is an end
of the surface, such as that of a tube [-]: 60°."""


def border_loops(facets: np.ndarray) -> list[np.ndarray]:
    """Borders of facets of one sense, each as its vertices along the facets' own sense."""
    open_ends = ends_of(facets)[twins_of(facets, int(facets.max()) + 1) < 0]
    after: dict[int, list[int]] = {}
    for a, b in open_ends.tolist():
        after.setdefault(a, []).append(b)
    loops = []
    while after:
        start = next(iter(after))
        loop = [start]
        while (following := after.get(loop[-1])) is not None:
            to = following.pop()
            if not following:
                del after[loop[-1]]
            if to == start:
                break
            loop.append(to)
        loops.append(np.array(loop))
    return loops


def span_holes(points: np.ndarray, facets: np.ndarray) -> np.ndarray:
    """Facets that close the holes of a surface, shape [new, 3].

    A ply lies straight across a hole; what of it lies there may be trimmed later. A hole is every
    border but the longest one of each piece where it can be spanned without a sharp bend.

    Args:
        points: vertices [m], shape [vertex, 3].
        facets: of one sense, shape [facet, 3].
    """
    loops = border_loops(facets)
    if not loops:
        return np.zeros((0, 3), dtype=np.int64)
    ends = facets[:, [[0, 1], [1, 2]]].reshape(-1, 2)
    links = coo_array((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), shape=(len(points),) * 2)
    piece = connected_components(links, directed=False)[1]
    lengths = [np.linalg.norm(points[p] - points[np.roll(p, 1)], axis=1).sum() for p in loops]
    outer: dict[int, int] = {}
    for number, loop in enumerate(loops):
        best = outer.setdefault(int(piece[loop[0]]), number)
        if lengths[number] > lengths[best]:
            outer[int(piece[loop[0]])] = number
    holes = [loop for number, loop in enumerate(loops) if number not in outer.values()]
    spans = [clip_ears(points, loop[::-1]) for loop in holes]
    spans = [span for span in spans if _goes_on(points, facets, span)]
    return np.concatenate([np.zeros((0, 3), dtype=np.int64), *spans])


def _goes_on(points: np.ndarray, facets: np.ndarray, span: np.ndarray) -> bool:
    """Whether facets across a hole go on as those round it do: not so at the end of a tube."""
    normals = np.concatenate([_normals(points, span), _normals(points, facets)])
    both = np.concatenate([span, facets])
    ends = ends_of(both)
    rim = {(b, a): f // 3 for f, (a, b) in enumerate(ends[: 3 * len(span)].tolist())}
    pairs = [(rim[side], f // 3) for f, side in enumerate(map(tuple, ends.tolist())) if side in rim]
    own, other = np.array([pair for pair in pairs if pair[1] >= len(span)]).T
    return bool((normals[own] * normals[other]).sum(axis=1).mean() > STEEP)


def _normals(points: np.ndarray, facets: np.ndarray) -> np.ndarray:
    a, b, c = np.moveaxis(points[facets], 1, 0)
    normal = np.cross(b - a, c - a)
    return normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)


def clip_ears(points: np.ndarray, loop: np.ndarray) -> np.ndarray:
    """Triangles of a closed line of vertices, seen along its mean normal, shape [n − 2, 3].

    Args:
        points: vertices [m], shape [vertex, 3].
        loop: vertices, counter-clockwise seen from outside.
    """
    at = points[loop] - points[loop].mean(axis=0)
    normal = np.cross(at, np.roll(at, -1, axis=0)).sum(axis=0)
    first = np.linalg.svd(normal[None])[2][1]
    second = np.cross(normal / max(np.linalg.norm(normal), 1e-300), first)
    flat = np.stack([at @ first, at @ second], 1)
    left = list(range(len(loop)))
    found = []
    while len(left) > 3:
        ear = _best_ear(flat, left)
        a, b, c = left[ear - 1], left[ear], left[(ear + 1) % len(left)]
        found.append([a, b, c])
        del left[ear]
    found.append(left)
    return loop[np.array(found, dtype=np.int64)]


def _best_ear(flat: np.ndarray, left: list[int]) -> int:
    """Number of the corner with nothing in its triangle whose triangle has the best shape."""
    best, shape = 0, -np.inf
    ring = np.array(left)
    before, after = np.roll(ring, 1), np.roll(ring, -1)
    for number in range(len(left)):
        a, b, c = flat[before[number]], flat[ring[number]], flat[after[number]]
        area = _cross(b - a, c - b)
        size = ((b - a) ** 2).sum() + ((c - b) ** 2).sum() + ((a - c) ** 2).sum()
        quality = area / size
        if quality <= shape or area <= 0.0:
            continue
        others = flat[[p for p in left if p not in (before[number], left[number], after[number])]]
        inside = np.ones(len(others), dtype=bool)
        for one, other in ((a, b), (b, c), (c, a)):
            inside &= _cross(other - one, others - one) > 0.0
        if not inside.any():
            best, shape = number, quality
    return best


def _cross(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    return u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]
