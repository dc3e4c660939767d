"""In which triangle of a flat mesh a point lies, and where in it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

NEAR = 12
"""Triangles, the nearest by their middles, that are looked at before all of them."""
_RIM = 1e-6  # of barycentric weights below 0 that still count as inside


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
