"""Plies cut into patches, for `warpdrape.kernels.contact.folds`."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import warp as wp
from scipy.spatial import ConvexHull

from warpdrape.blanks.ply import Ply
from warpdrape.interaction import Run, Span
from warpdrape.kernels.contact.folds import Patches

TRIANGLES = 50
"""Triangles of a patch, about."""
ON_HULL = 1e-3
"""Distance from a blank's convex hull, over its size, up to which a border lies on it [-]."""
ABREAST = 16
"""Patches across a ply at most: each is held against each."""


def cut_into_patches(
    plies: Sequence[Ply], spans: Sequence[Span], device: str
) -> tuple[Patches, tuple[Run, ...]]:
    """Cut the plies along a grid over each flat one.

    Args:
        plies: all plies.
        spans: where they are.
        device: Warp device.

    Returns:
        The patches, and which are of each ply.
    """
    runs, cells, gaping, of_triangle, of_vertex = [], [], [], [], []
    count = 0
    for ply, span in zip(plies, spans, strict=True):
        cell = _cells(ply)
        used, number = np.unique(cell, axis=0, return_inverse=True)
        number = number.reshape(-1) + count
        runs.append(Run(count, len(used)))
        count += len(used)
        cells.append(used)
        lips = used[np.unique(number[_at_lips(ply)] - runs[-1].first)]
        beside = np.abs(used[:, None] - lips[None]).max(axis=2, initial=0) <= 1
        gaping.append(beside.any(axis=1))
        of_triangle.append(number)
        of_its = np.zeros(span.vertex_count, dtype=int)
        for corner in ply.mesh.triangles.T:
            of_its[corner] = number
        of_vertex.append(of_its)
    owner = np.concatenate(of_triangle)
    column, row = np.concatenate(cells).T

    def integers(values: np.ndarray) -> wp.array:
        return wp.array(values, dtype=wp.int32, device=device)

    patches = Patches()
    patches.first = integers(np.r_[0, np.cumsum(np.bincount(owner, minlength=count))])
    patches.triangles = integers(np.argsort(owner, kind="stable"))
    patches.column, patches.row = integers(column), integers(row)
    patches.gaping = integers(np.concatenate(gaping))
    patches.of_vertex = integers(np.concatenate(of_vertex))
    patches.low, patches.high, patches.normal = (
        wp.zeros(count, dtype=wp.vec3d, device=device) for _ in range(3)
    )
    patches.spread = wp.zeros(count, dtype=wp.float64, device=device)
    patches.folded = wp.ones(count, dtype=wp.int32, device=device)
    return patches, tuple(runs)


def _at_lips(ply: Ply) -> np.ndarray:
    """Triangles at borders that are not the blank's convex hull: holes, notches, darts, slots.

    Lips of such a border can lie on each other without a bend between them.
    """
    mesh = ply.mesh
    hull = ConvexHull(mesh.vertices[:, :2]).equations
    ends = mesh.boundary_edges
    middle = mesh.vertices[ends, :2].mean(axis=1)
    within = -(middle @ hull[:, :2].T + hull[:, 2]).max(axis=1)
    size = float(np.ptp(mesh.vertices[:, :2], axis=0).max())
    lips = np.zeros(len(mesh.vertices), dtype=bool)
    lips[ends[within > ON_HULL * size]] = True
    return np.flatnonzero(lips[mesh.triangles].any(axis=1))


def _cells(ply: Ply) -> np.ndarray:
    """Column and row of the patch of each triangle, shape [m, 2]."""
    triangles = np.asarray(ply.mesh.triangles)
    centres = np.asarray(ply.mesh.vertices)[triangles, :2].mean(axis=1)
    low, size = centres.min(axis=0), np.ptp(centres, axis=0)
    abreast = min(max(round(math.sqrt(len(triangles) / TRIANGLES)), 1), ABREAST)
    side = max(float(size.max()) / abreast, 1e-12)
    return np.floor((centres - low) / side * (1.0 - 1e-9)).astype(int)
