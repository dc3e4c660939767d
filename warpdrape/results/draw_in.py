"""How far the edge of a blank has been drawn in, along the yarns and between them."""

from __future__ import annotations

import math

import numpy as np

from warpdrape.blanks.ply import Ply


def draw_in(ply: Ply, points: np.ndarray) -> dict[str, float]:
    """Draw-in [m] of the edge points that lay in eight directions from the blank's centre.

    The draw-in of a point of the edge is how much nearer, seen from above, it has come to where the
    blank's centre was. Directions are those of the flat blank: along the yarns and between them.

    Args:
        ply: the flat ply.
        points: formed positions [m], shape [n, 3].

    Returns:
        ``warp_plus``, ``warp_minus``, ``weft_plus``, … and the means ``warp``, ``weft``, ``bias``.
        A direction in which the edge is not met (a hole, a blank off centre) is left out.
    """
    flat = np.asarray(ply.mesh.vertices)
    center = 0.5 * (flat.min(axis=0) + flat.max(axis=0))
    warp, weft = ply.yarn_directions
    bias = [warp + weft, weft - warp]
    rays = {"warp": [warp, -warp], "weft": [weft, -weft], "bias": [*bias, -bias[0], -bias[1]]}
    signs = {"warp": ("plus", "minus"), "weft": ("plus", "minus"), "bias": ("1", "2", "3", "4")}
    result = {}
    for family, directions in rays.items():
        found = []
        for sign, direction in zip(signs[family], directions, strict=True):
            moved = _moved_inwards(ply, points, center, direction / np.linalg.norm(direction))
            if math.isfinite(moved):
                result[f"{family}_{sign}"] = moved
                found.append(moved)
        if found:
            result[family] = float(np.mean(found))
    return result


def _moved_inwards(ply: Ply, points: np.ndarray, center: np.ndarray, ray: np.ndarray) -> float:
    edges = np.asarray(ply.mesh.boundary_edges)
    start, end = (np.asarray(ply.mesh.vertices)[edges[:, k]] - center for k in (0, 1))
    side_start = ray[0] * start[:, 1] - ray[1] * start[:, 0]
    side_end = ray[0] * end[:, 1] - ray[1] * end[:, 0]
    crosses = (side_start * side_end <= 0.0) & (side_start != side_end)
    if not crosses.any():
        return math.nan
    share = side_start[crosses] / (side_start[crosses] - side_end[crosses])
    flat = start[crosses] + share[:, None] * (end - start)[crosses]
    farthest = int(np.argmax(flat @ ray))
    if flat[farthest] @ ray <= 0.0:
        return math.nan
    a, b = edges[crosses][farthest]
    now = (1.0 - share[farthest]) * points[a] + share[farthest] * points[b]
    return float(np.linalg.norm(flat[farthest]) - np.linalg.norm(now[:2] - center))
