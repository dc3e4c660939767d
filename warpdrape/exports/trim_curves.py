"""Closed curves near a formed ply, on the flat blank: at each point the ply's nearest one."""

from __future__ import annotations

import warnings

import numpy as np

from warpdrape.errors import InputError
from warpdrape.exports.on_ply import Feet, PlySearch
from warpdrape.exports.trim import MM, Curves
from warpdrape.results.result import FormedPly

STEP = 5e-4
"""Greatest way from one point of a curve to the next that is looked for on a ply [m]."""
FARTHEST = 0.1
"""How far off a ply a curve may lie, as a share of the ply's size."""
ON_IT = 1e-7
"""Weight of a corner below which a point lies on the edge across from it, but for rounding."""
OUTSIDE = 1e-4
"""How far beyond a ply's edge a curve counts as outside [m]."""


def on_blank(ply: FormedPly, trim: Curves) -> list[np.ndarray]:
    """Closed curves taken to the flat blank, loops [mm] of shape [n, 2].

    Args:
        ply: the formed ply.
        trim: the curves.

    Raises:
        InputError: if a curve lies too far off, or jumps.
    """
    search, edges = PlySearch(ply), border_edges(ply.triangles)
    size = float(np.linalg.norm(np.ptp(ply.points, axis=0)))
    found, beyond, way, most = [], 0.0, 0.0, 0.0
    for loop in trim.loops:
        points = stepped(loop)
        feet = search.nearest(points)
        out = _overhang(points, feet, search, ply, edges)
        off = feet.distance[out <= OUTSIDE]
        if len(off) and off.max() > FARTHEST * size:
            raise InputError(
                f"{trim.name} lies up to {MM * off.max():.3g} mm off {ply.name}: give it in the "
                "run's coordinates, where the formed part is"
            )
        flat = feet.of(np.asarray(ply.rest_points)[:, :2], ply.triangles)
        if trim.along is None:  # along a line of sight a curve drops down walls, and folds are seen
            _refuse_jumps(points, flat, out > OUTSIDE, ply, trim)
        steps = np.linalg.norm(points - np.roll(points, 1, axis=0), axis=1)
        way += float(steps.sum())
        beyond += float(steps[out > OUTSIDE].sum())
        most = max(most, float(out.max()))
        found.append(MM * flat)
    if beyond > 0.0:
        warnings.warn(
            f"{trim.name} leaves {ply.name} on {MM * beyond:.0f} mm of its {MM * way:.0f} mm, by "
            f"up to {MM * most:.3g} mm: the pattern follows the blank's edge there; make it larger",
            stacklevel=2,
        )
    return found


def border_edges(triangles: np.ndarray) -> np.ndarray:
    """Whether the edge across from each corner is the ply's border, shape [triangle, 3]."""
    ends = np.sort(np.asarray(triangles)[:, [[1, 2], [2, 0], [0, 1]]], axis=2).reshape(-1, 2)
    _, of, count = np.unique(ends, axis=0, return_inverse=True, return_counts=True)
    return (count[of.reshape(-1)] == 1).reshape(-1, 3)


def stepped(loop: np.ndarray) -> np.ndarray:
    """Points along a closed curve, its corners among them, `STEP` or less apart."""
    sides = np.roll(loop, -1, axis=0) - loop
    counts = np.maximum(np.ceil(np.linalg.norm(sides, axis=1) / STEP), 1.0).astype(int)
    shares = np.concatenate([np.arange(count) / count for count in counts])
    return np.repeat(loop, counts, axis=0) + shares[:, None] * np.repeat(sides, counts, axis=0)


def _overhang(
    points: np.ndarray, feet: Feet, search: PlySearch, ply: FormedPly, edges: np.ndarray
) -> np.ndarray:
    """How far points lie beyond the ply's edge along the ply [m], 0 where over it, shape [k]."""
    corners = search.corners[feet.triangle]
    places = np.einsum("kc,kci->ki", feet.weights, corners)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    offset = points - places
    along = offset - (offset * normal).sum(axis=1, keepdims=True) * normal
    ends = np.asarray(ply.triangles)[:, [[1, 2], [2, 0], [0, 1]]][edges]
    at_end = np.isin(np.asarray(ply.triangles)[feet.triangle], ends) & (feet.weights > 1.0 - ON_IT)
    at_border = ((feet.weights < ON_IT) & edges[feet.triangle] | at_end).any(axis=1)
    return np.where(at_border, np.linalg.norm(along, axis=1), 0.0)


def _refuse_jumps(
    points: np.ndarray, flat: np.ndarray, outside: np.ndarray, ply: FormedPly, trim: Curves
) -> None:
    """Raise `InputError` where a curve goes from one leaf of a fold to another."""
    corners = np.asarray(ply.rest_points)[ply.triangles]
    edge = float(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).mean())
    way = np.linalg.norm(flat - np.roll(flat, 1, axis=0), axis=1)
    jumps = (way > edge + 5.0 * STEP) & ~outside & ~np.roll(outside, 1)
    if jumps.any():
        x, y, z = MM * points[np.argmax(jumps)]
        raise InputError(
            f"{trim.name} jumps on {ply.name} at ({x:.0f}, {y:.0f}, {z:.0f}) mm from one leaf of a "
            "fold to another, or lies beyond where the ply bends round: give it closer to the ply"
        )
