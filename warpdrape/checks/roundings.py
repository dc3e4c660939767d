"""The smallest rounding of a tool, from the normals at its facets' corners.

Per facet the second fundamental form is fitted to the changes of the normal along its three sides
(Rusinkiewicz 2004); its largest principal curvature is the facet's.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warpdrape.tools.tool import Tool

TELLING = 1e-3
"""Share of a tool's area whose roundings are left out as slips of single facets [-]."""
STRAIGHT = 1e-3
"""Turn of the normal over a facet below which it is flat [rad]."""
SHARP = np.cos(np.radians(35.0))
"""Cosine of the turn between neighbouring facets from which on their edge is sharp."""


@dataclass(frozen=True)
class Rounding:
    """The smallest rounding of what of a tool comes over the plies.

    Attributes:
        radius: [m]; infinite if all is flat.
        place: where [m], shape [3].
        sharp: length of sharp edges [m].
    """

    radius: float
    place: np.ndarray
    sharp: float


def smallest_rounding(tool: Tool, low: np.ndarray, high: np.ndarray) -> Rounding:
    """Find the smallest rounding of a tool within a box seen from above.

    Args:
        tool: at the start.
        low: corner of the box [m], shape [2].
        high: the opposite one.
    """
    corners, normals = tool.vertices[tool.triangles], np.asarray(tool.surface.normals)
    over = (corners.min(axis=1)[:, :2] <= high) & (corners.max(axis=1)[:, :2] >= low)
    kept = over.all(axis=1)
    sharp = _sharp_length(tool, kept)
    corners, normals = corners[kept], normals[kept]
    if not len(corners):
        return Rounding(np.inf, np.zeros(3), 0.0)
    bend = curvatures(corners, normals)
    area = 0.5 * np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    order = np.argsort(-bend)
    k = order[np.searchsorted(np.cumsum(area[order]), TELLING * area.sum())]
    radius = 1.0 / bend[k] if bend[k] > 0.0 else np.inf
    return Rounding(float(radius), corners[k].mean(axis=0), sharp)


def curvatures(corners: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Largest principal curvature of each facet, whichever way it bends [1/m], shape [facet].

    Args:
        corners: [m], shape [facet, 3, 3].
        normals: at the corners, shape [facet, 3, 3].
    """
    sides = np.roll(corners, -1, axis=1) - corners
    turns = np.roll(normals, -1, axis=1) - normals
    length = np.linalg.norm(sides, axis=2)
    first = sides[:, 0] / np.maximum(length[:, :1], 1e-300)
    across = np.cross(first, sides[:, 1])
    normal = across / np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-300)
    second = np.cross(normal, first)
    u, v = (np.einsum("fki,fi->fk", sides, axis) for axis in (first, second))
    du, dv = (np.einsum("fki,fi->fk", turns, axis) for axis in (first, second))
    zero = np.zeros_like(u)
    rows = np.concatenate([np.stack([u, v, zero], -1), np.stack([zero, u, v], -1)], axis=1)
    form = np.einsum("fij,fj->fi", np.linalg.pinv(rows), np.concatenate([du, dv], axis=1))
    e, f, g = form.T
    mean, half = 0.5 * (e + g), np.hypot(0.5 * (e - g), f)
    bend = np.maximum(np.abs(mean + half), np.abs(mean - half))
    turn = np.linalg.norm(turns, axis=2).max(axis=1)
    return np.where(turn > STRAIGHT, bend, 0.0)


def _sharp_length(tool: Tool, kept: np.ndarray) -> float:
    """Length of edges at which facets meet at an angle, but for those of no breadth [m]."""
    mesh = tool.surface.mesh
    pairs, ends = np.asarray(mesh.face_adjacency), np.asarray(mesh.face_adjacency_edges)
    if not len(pairs):
        return 0.0
    facing = mesh.face_normals[pairs]
    sharp = (facing[:, 0] * facing[:, 1]).sum(axis=1) < SHARP
    sharp &= kept[pairs].any(axis=1)
    ways = mesh.vertices[ends[sharp, 1]] - mesh.vertices[ends[sharp, 0]]
    return float(np.linalg.norm(ways, axis=1).sum())
