"""Normals by which a viewer shades plies and tools: unit length wherever there is a face at all."""

from __future__ import annotations

import numpy as np
import trimesh
from numpy.typing import NDArray

from warpdrape.defects.wrinkle_field import vertex_normals
from warpdrape.tools.tool_mesh import creased_normals

UPWARDS = (0.0, 0.0, 1.0)
"""What stands where no face has a normal: a vertex of no triangle, or of ones without area."""


def ply_normals(points: NDArray[np.float32], triangles: NDArray) -> NDArray[np.float32]:
    """Return normals at the vertices, on the side from which triangles run anticlockwise.

    Args:
        points: positions [m], shape (n, 3).
        triangles: vertex numbers, shape (m, 3).
    """
    return _whole(vertex_normals(np.asarray(points, np.float64), triangles))


def tool_normals(points: NDArray[np.float32], triangles: NDArray) -> NDArray[np.float32]:
    """Return a normal at each corner of each facet, so that sharp edges stay sharp.

    Args:
        points: positions [m], shape (n, 3).
        triangles: vertex numbers, shape (m, 3).

    Returns:
        facet by facet, shape (3 m, 3).
    """
    mesh = trimesh.Trimesh(np.asarray(points, np.float64), triangles, process=False)
    return _whole(creased_normals(mesh).reshape(-1, 3))


def _whole(normals: NDArray[np.float64]) -> NDArray[np.float32]:
    none = np.linalg.norm(normals, axis=1) < 0.5
    return np.where(none[:, None], UPWARDS, normals).astype(np.float32)
