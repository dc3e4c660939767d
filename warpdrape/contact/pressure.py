"""How hard and deep contacts press at one instant: forces spread over vertices, and their areas."""

from __future__ import annotations

import numpy as np

from warpdrape.blanks.triangles import cross, dot, two_sides

LOWER, UPPER = 0, 1
"""Rows of forces on a ply's faces."""


def on_corners(contacts: np.ndarray, forces: np.ndarray, vertices: int) -> np.ndarray:
    """What contacts with triangles bring to their corners [N], shape [vertices].

    Args:
        contacts: records of `PlyContact`, shape [slot].
        forces: of the contacts [N], shape [slot].
        vertices: so many in all.
    """
    (at,) = np.nonzero(forces)
    total = np.zeros(vertices)
    for corner, name in enumerate("abc"):
        share = contacts["weights"][at, corner] * forces[at]
        total += np.bincount(contacts[name][at], weights=share, minlength=vertices)
    return total


def depths_now(contacts: np.ndarray, points: np.ndarray, x: np.ndarray) -> np.ndarray:
    """How deep points lie in triangles, what is allowed of it included [m], shape [slot].

    Args:
        contacts: records of `PlyContact`, shape [slot].
        points: that touch [m], shape [slot, 3].
        x: positions [m], shape [vertex, 3].
    """
    (at,) = np.nonzero(contacts["near"])
    found = contacts[at]
    corners = x[np.stack([found[name] for name in "abc"], axis=1)]
    nearest = np.einsum("nk,nkd->nd", found["weights"], corners)
    height = ((points[at] - nearest) * found["normal"]).sum(axis=1)
    depths = np.zeros(len(contacts))
    depths[at] = np.maximum(found["thickness"] + found["rise"] - height, 0.0)
    return depths


def vertex_shapes(x: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Unit normals [-], shape [n, 3], and areas of vertices, thirds of triangles [m²], shape [n].

    Args:
        x: positions [m], shape [n, 3].
        triangles: vertices, shape [m, 3].
    """
    normal = cross(*two_sides(x, triangles))
    count, corners = len(x), triangles.T.ravel()
    areas, *normals = (
        np.bincount(corners, weights=np.tile(part, 3), minlength=count)
        for part in (_length(normal) / 6.0, *normal)
    )
    length = _length(np.stack(normals))
    return np.stack([normal / length for normal in normals], axis=1), areas


def _length(vector: np.ndarray) -> np.ndarray:
    return np.sqrt(dot(vector, vector))
