"""Where the material points of one run's plies lie on the plies of another: by place on the blank.

Runs are compared at points of the flat sheet. Where two meshes are the same, vertices and triangles
are those of the same number. Where not, a vertex has a place in a triangle of the other mesh, whose
corners' values are blended linearly, and the middle of a triangle has a triangle of the other mesh,
whose value is taken as it is: what is constant in triangles is not smoothed. A point beside the
other blank has no counterpart.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warpdrape.report.packing import Blocks
from warpdrape.report.run_data import PlyFrames

NEAR = 12
"""Triangles, the nearest by their middles, that are looked at before all of them."""
_RIM = 1e-6  # of barycentric weights below 0 that still count as inside
_SAME = 1e-6  # of a blank's size, within which two flat places are one


@dataclass(frozen=True, eq=False)
class Places:
    """Places of points in a mesh.

    Attributes:
        triangles: that each lies in, -1 where in none, shape [k].
        weights: of its corners, shape [k, 3].
    """

    triangles: NDArray[np.int64]
    weights: NDArray[np.float64]


def locate(
    points: NDArray[np.float64], rest: NDArray[np.float64], triangles: NDArray[np.int64]
) -> Places:
    """Find the triangles of a flat mesh that points lie in.

    Args:
        points: flat places [m], shape [k, 2].
        rest: vertices of the mesh [m], shape [n, 2].
        triangles: shape [m, 3].
    """
    from scipy.spatial import cKDTree

    corners = rest[triangles]
    near = min(NEAR, len(triangles))
    _, nearest = cKDTree(corners.mean(axis=1)).query(points, k=near)
    nearest = np.reshape(nearest, (len(points), near))
    weights = _weights(points[:, None], corners[nearest])
    best = np.argmax(weights.min(axis=2), axis=1)
    row = np.arange(len(points))
    found, weights = nearest[row, best], weights[row, best]
    for k in np.flatnonzero(weights.min(axis=1) < -_RIM):  # few: beside large triangles, or outside
        every = _weights(points[k], corners)
        found[k] = np.argmax(every.min(axis=1))
        weights[k] = every[found[k]]
    outside = weights.min(axis=1) < -_RIM
    weights = np.clip(weights, 0.0, 1.0)
    return Places(np.where(outside, -1, found), weights / weights.sum(axis=1, keepdims=True))


def _weights(points: NDArray[np.float64], corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """Barycentric weights of points in triangles of corners [..., 3, 2], shape [..., 3]."""
    a, u, v = corners[..., 0, :], corners[..., 1, :], corners[..., 2, :]
    u, v, p = u - a, v - a, points - a
    area = u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]
    area = np.where(area == 0.0, np.inf, area)
    one = (p[..., 0] * v[..., 1] - p[..., 1] * v[..., 0]) / area
    two = (u[..., 0] * p[..., 1] - u[..., 1] * p[..., 0]) / area
    return np.stack([1.0 - one - two, one, two], axis=-1)


def match_plies(
    plies: Sequence[PlyFrames], first: Sequence[PlyFrames], blocks: Blocks
) -> list[dict[str, Any] | None]:
    """Counterparts of a run's plies in the first run, as the page holds them; None for none.

    Plies of one name belong together; where no names agree, those of one place in their stacks.
    """
    names = [ply.name for ply in first]
    by_name = any(ply.name in names for ply in plies)
    found: list[dict[str, Any] | None] = []
    for k, ply in enumerate(plies):
        at = names.index(ply.name) if ply.name in names else None if by_name else k
        if at is None or at >= len(first):
            found.append(None)
        elif _one_mesh(ply, first[at]):
            found.append({"ply": at, "same": True})
        else:
            found.append({"ply": at, "same": False, **_pack(ply, first[at], blocks)})
    return found


def _one_mesh(ply: PlyFrames, other: PlyFrames) -> bool:
    if ply.rest.shape != other.rest.shape or not np.array_equal(ply.triangles, other.triangles):
        return False
    off = np.abs(ply.rest[:, :2] - other.rest[:, :2]).max()
    return bool(off <= _SAME * np.ptp(other.rest, axis=0).max())


def _pack(ply: PlyFrames, other: PlyFrames, blocks: Blocks) -> dict[str, Any]:
    """Blocks of where vertices and middles of triangles lie; a triangle's number is one more."""
    flat = ply.rest[:, :2]
    vertices = locate(flat, other.rest[:, :2], other.triangles)
    middles = locate(flat[ply.triangles].mean(axis=1), other.rest[:, :2], other.triangles)
    return {
        "vertices": blocks.whole_numbers(vertices.triangles + 1),
        "weights": blocks.values(vertices.weights[None, :, 1:], 0.0, 1.0),
        "middles": blocks.whole_numbers(middles.triangles + 1),
    }
