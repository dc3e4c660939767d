"""Plies cut into patches, for `warpdrape.kernels.contact.folds`."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import warp as wp

from warpdrape.blanks.ply import Ply
from warpdrape.interaction import Run, Span
from warpdrape.kernels.contact.folds import Patches

TRIANGLES = 50
"""Triangles of a patch, about."""
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
    runs, cells, of_triangle, of_vertex = [], [], [], []
    count = 0
    for ply, span in zip(plies, spans, strict=True):
        cell = _cells(ply)
        used, number = np.unique(cell, axis=0, return_inverse=True)
        number = number.reshape(-1) + count
        runs.append(Run(count, len(used)))
        count += len(used)
        cells.append(used)
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
    patches.of_vertex = integers(np.concatenate(of_vertex))
    patches.low, patches.high, patches.normal = (
        wp.zeros(count, dtype=wp.vec3d, device=device) for _ in range(3)
    )
    patches.spread = wp.zeros(count, dtype=wp.float64, device=device)
    return patches, tuple(runs)


def _cells(ply: Ply) -> np.ndarray:
    """Column and row of the patch of each triangle, shape [m, 2]."""
    triangles = np.asarray(ply.mesh.triangles)
    centres = np.asarray(ply.mesh.vertices)[triangles, :2].mean(axis=1)
    low, size = centres.min(axis=0), np.ptp(centres, axis=0)
    abreast = min(max(round(math.sqrt(len(triangles) / TRIANGLES)), 1), ABREAST)
    side = max(float(size.max()) / abreast, 1e-12)
    return np.floor((centres - low) / side * (1.0 - 1e-9)).astype(int)
