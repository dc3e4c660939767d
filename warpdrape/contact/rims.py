"""Borders of open tools over which a ply may bend: its vertices would miss them like sharp edges.

A rim that turns away from a ply, like that of a punch above its pole or of a die below its hole, is
there because a surface must end somewhere; so is one beside the plies. The others are felt.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from warpdrape.blanks.outlines import enclosed
from warpdrape.blanks.ply import Ply
from warpdrape.contact.adjacency import across_edges
from warpdrape.setup import Setup
from warpdrape.tools.tool import Tool

AWAY = -0.5
"""Component towards the ply of the direction in which a surface ends at a rim, below which that
turns away from it [-]."""
MOMENTS = 5
"""Moments of a run at which it is looked which rims lie over or under plies."""


def exposed_rims(tool: Tool, scene: Setup) -> np.ndarray:
    """Edges of an open tool's border that plies may bend over [m], shape [edge, 2 ends, 3].

    Args:
        tool: the tool.
        scene: what is computed.

    Returns:
        Ends, where the tool stands at first.
    """
    ends, outward = rims(tool)
    found = np.zeros(len(ends), dtype=bool)
    for places, ply, facing in _looks(tool, scene, ends, outward):
        asked = np.flatnonzero(facing & ~found)
        points = np.concatenate([places[asked].mean(axis=1), places[asked, 0], places[asked, 1]])
        found[asked] |= over_ply(ply, points).reshape(3, -1).any(axis=0)
    return ends[found]


def rims_hold(tool: Tool, scene: Setup) -> bool:
    """Whether an open tool has no rim that turns away from the plies: what it holds ends there."""
    ends, outward = rims(tool)
    found = np.zeros(len(ends), dtype=bool)
    for _, _, facing in _looks(tool, scene, ends, outward):
        found |= facing
    return bool(len(ends)) and bool(found.all())


def _looks(
    tool: Tool, scene: Setup, ends: np.ndarray, outward: np.ndarray
) -> Iterator[tuple[np.ndarray, Ply, np.ndarray]]:
    """At some moments where rims are, and for each ply which do not turn away from it.

    On which side of a ply a rim is it says where it stands at first.
    """
    heights = tool.pose(0.0).place(ends.mean(axis=1))[:, 2]
    for time in np.linspace(0.0, scene.duration, MOMENTS) if len(ends) else ():
        pose = tool.pose(float(time))
        places = pose.place(ends.reshape(-1, 3)).reshape(-1, 2, 3)
        ways = pose.direct(outward)[:, 2]
        for ply in scene.plies:
            yield places, ply, ways * np.where(heights <= ply.z, 1.0, -1.0) > AWAY


def rims(tool: Tool) -> tuple[np.ndarray, np.ndarray]:
    """Edges of a tool's border [m], shape [edge, 2, 3], and the directions in which it ends there.

    These are unit vectors along the facet and across the edge, shape [edge, 3].
    """
    triangles, points = np.asarray(tool.triangles), np.asarray(tool.vertices)
    facet, corner = np.nonzero(across_edges(triangles) < 0)
    ends = points[np.stack([triangles[facet, (corner + k) % 3] for k in (1, 2)], axis=1)]
    along = ends[:, 1] - ends[:, 0]
    outward = ends[:, 0] - points[triangles[facet, corner]]
    square = np.maximum((along**2).sum(axis=1), np.finfo(float).tiny)
    outward -= ((outward * along).sum(axis=1) / square)[:, None] * along
    size = np.linalg.norm(outward, axis=1, keepdims=True)
    return ends, outward / np.maximum(size, np.finfo(float).tiny)


def over_ply(ply: Ply, points: np.ndarray) -> np.ndarray:
    """Whether points [n, 3] lie over or under the ply's area, shape [n]."""
    flat = np.asarray(ply.mesh.vertices)
    near = ((points[:, :2] >= flat.min(axis=0)) & (points[:, :2] <= flat.max(axis=0))).all(axis=1)
    found = np.zeros(len(points), dtype=bool)
    if near.any():
        found[near] = enclosed(points[near, :2], flat[np.asarray(ply.mesh.boundary_edges)])
    return found
