"""How much of a tool's surface has a ply on it."""

from __future__ import annotations

import math

import numpy as np

from warpdrape.defects.gaps import SurfaceGaps
from warpdrape.tools.pose import Pose
from warpdrape.tools.tool import Tool

SAMPLES = 20000
"""Points of a tool's surface at which it is asked for a ply."""


def coverage(tool: Tool, pose: Pose, plies: list[SurfaceGaps], reach: float) -> float:
    """Share of a tool's surface within a distance of any ply [-].

    Args:
        tool: where it stands at the start.
        pose: where it is.
        plies: the formed plies' surfaces.
        reach: distance to the middle of the farthest ply that still lies on the tool [m].
    """
    points, shares = surface_points(tool, SAMPLES)
    covered = np.zeros(len(points), dtype=bool)
    for ply in plies:
        open_points = np.flatnonzero(~covered)
        way = ply.ways(pose.place(points[open_points]), 2.0 * reach)
        covered[open_points] = np.linalg.norm(way, axis=1) < reach
    return float(shares[covered].sum() / shares.sum())


def surface_points(tool: Tool, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Points spread evenly over a tool's facets [m], and the area that each stands for [m²].

    Args:
        tool: where it stands at the start.
        count: points, about.

    Returns:
        Points, shape [p, 3], and areas, shape [p].
    """
    corners = tool.vertices[tool.triangles]
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    areas = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    each = np.maximum(np.ceil(areas / areas.sum() * count), 1).astype(int)
    facet = np.repeat(np.arange(len(areas)), each)
    number = np.arange(len(facet)) - np.repeat(np.cumsum(each) - each, each)
    golden = 0.5 * (math.sqrt(5.0) - 1.0)  # a lattice: one way even, one by the golden ratio
    u, v = (number + 0.5) / each[facet], np.mod((number + 0.5) * golden, 1.0)
    root = np.sqrt(u)
    weights = np.stack([1.0 - root, root * (1.0 - v), root * v], axis=1)
    return np.einsum("pk,pkd->pd", weights, corners[facet]), (areas / each)[facet]
