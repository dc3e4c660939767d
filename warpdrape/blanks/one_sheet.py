"""Whether a flat mesh is one sheet: not torn where it looks joined, and not on top of itself."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from warpdrape.blanks.outlines import Points, windings
from warpdrape.errors import InputError

JOINED = 1e-3
"""Distance of a vertex from an edge, over the edge, at which they are meant to be joined [-]."""
INSIDE = 1e-3
"""Distance from a boundary edge, over its length, at which the sheet is looked for [-]."""


def check_one_sheet(points: Points, boundary: NDArray[np.int32]) -> None:
    """Raise `InputError` where a mesh is torn, or lies on itself.

    Args:
        points: vertices [m], shape [vertex, 2].
        boundary: boundary edges, the sheet on their left, shape [edge, 2].
    """
    _refuse_overlaps(points, boundary)
    _refuse_seams(points, boundary)
    _refuse_hanging_vertices(points, boundary)


def _refuse_seams(points: Points, boundary: NDArray[np.int32]) -> None:
    """Raise where two boundary vertices are one but for rounding."""
    rim = np.unique(boundary)
    side = np.linalg.norm(points[boundary[:, 1]] - points[boundary[:, 0]], axis=1)
    shortest = np.full(len(points), np.inf)
    np.minimum.at(shortest, boundary, side[:, None])
    distance, nearest = cKDTree(points[rim]).query(points[rim], k=2)
    itself = nearest[:, 0] == np.arange(len(rim))
    other = np.where(itself, nearest[:, 1], nearest[:, 0])
    torn = np.flatnonzero(distance[:, 1] < JOINED * shortest[rim])
    if len(torn):
        a, b = rim[torn[0]], rim[other[torn[0]]]
        raise InputError(
            f"vertices {a} and {b} lie {1e3 * distance[torn[0], 1]:.2g} mm apart at "
            f"{_place(points[a])} and are not joined ({len(torn)} such): make them one vertex, or "
            f"open the cut by {JOINED:g} of an edge or more"
        )


def _refuse_hanging_vertices(points: Points, boundary: NDArray[np.int32]) -> None:
    """Raise where a boundary vertex lies on a boundary edge that does not end in it."""
    rim = np.unique(boundary)
    start, run = points[boundary[:, 0]], points[boundary[:, 1]] - points[boundary[:, 0]]
    length = np.linalg.norm(run, axis=1)
    near = cKDTree(points[rim]).query_ball_point(start + 0.5 * run, 0.5 * length)
    edge = np.repeat(np.arange(len(boundary)), [len(each) for each in near])
    vertex = rim[np.concatenate(near).astype(int)]
    away = points[vertex] - start[edge]
    along = (away * run[edge]).sum(axis=1) / length[edge] ** 2
    off = np.abs(run[edge, 0] * away[:, 1] - run[edge, 1] * away[:, 0]) / length[edge] ** 2
    ends = (boundary[edge] == vertex[:, None]).any(axis=1)
    hanging = np.flatnonzero((along > JOINED) & (along < 1 - JOINED) & (off < JOINED) & ~ends)
    if len(hanging):
        v, (a, b) = vertex[hanging[0]], boundary[edge[hanging[0]]]
        raise InputError(
            f"vertex {v} at {_place(points[v])} lies on edge {a}-{b} and is not joined to it (a "
            f"T-junction; {len(hanging)} such): divide the triangle of that edge at the vertex"
        )


def _refuse_overlaps(points: Points, boundary: NDArray[np.int32]) -> None:
    """Raise where the sheet covers a place twice: there its boundary winds round it twice.

    Where an overlap begins there is a boundary edge, so that it is enough to look beside these.
    """
    start, run = points[boundary[:, 0]], points[boundary[:, 1]] - points[boundary[:, 0]]
    left = np.column_stack([-run[:, 1], run[:, 0]])
    places = np.concatenate([start + part * run + INSIDE * left for part in (0.25, 0.5, 0.75)])
    twice = np.flatnonzero(windings(places, points[boundary]) > 1)
    if len(twice):
        a, b = boundary[twice[0] % len(boundary)]
        raise InputError(
            f"the mesh lies on itself at {_place(places[twice[0]])}, beside edge {a}-{b}: a ply is "
            "one sheet; make a ply of each, or cut them apart"
        )


def _place(point: NDArray[np.float64]) -> str:
    return f"({1e3 * point[0]:.4g}, {1e3 * point[1]:.4g}) mm"
