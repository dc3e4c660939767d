"""The nearest point of a formed ply, and where it lies on the flat blank."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import trimesh
from scipy.spatial import cKDTree

from warpdrape.results.result import FormedPly

PORTION = 2_000_000
"""Pairs of point and triangle looked at together: some 200 MB."""


@dataclass(frozen=True)
class Feet:
    """Points of a ply.

    Attributes:
        triangle: that each lies in, shape [k].
        weights: of its corners, shape [k, 3].
        distance: from the points asked for [m], shape [k].
    """

    triangle: np.ndarray
    weights: np.ndarray
    distance: np.ndarray

    def of(self, values: np.ndarray, triangles: np.ndarray) -> np.ndarray:
        """Values at vertices taken to the points; shape [k] or [k, c]."""
        at_corners = values[triangles[self.triangle]]
        return np.einsum("kc,kc...->k...", self.weights, at_corners)


class PlySearch:
    """Finds the nearest points of a ply."""

    def __init__(self, ply: FormedPly) -> None:
        """Sort the triangles by place."""
        self.corners = np.asarray(ply.points, float)[np.asarray(ply.triangles)]
        middles = self.corners.mean(axis=1)
        self.reach = float(np.linalg.norm(self.corners - middles[:, None], axis=2).max())
        self.tree = cKDTree(middles)

    def nearest(self, points: np.ndarray) -> Feet:
        """The nearest point of the ply for each of some points [m], shape [k, 3]."""
        found = [np.empty(0, int), np.empty((0, 3)), np.empty(0)]
        parts = [tuple(found)]
        around = self.tree.query(points)[0] + self.reach  # a triangle beyond is not the nearest
        counts = self.tree.query_ball_point(points, around, return_length=True)
        ends = np.searchsorted(np.cumsum(counts), np.arange(PORTION, counts.sum(), PORTION)) + 1
        for some in np.split(np.arange(len(points)), np.unique(ends)):
            if len(some):
                parts.append(self._some(points[some], around[some]))
        return Feet(*(np.concatenate(each) for each in zip(*parts, strict=True)))

    def _some(self, points: np.ndarray, around: np.ndarray) -> tuple[np.ndarray, ...]:
        lists = self.tree.query_ball_point(points, around)
        count = np.array([len(near) for near in lists])
        triangle = np.concatenate(lists).astype(int)
        point = np.repeat(np.arange(len(points)), count)
        feet = trimesh.triangles.closest_point(self.corners[triangle], points[point])
        distance = np.linalg.norm(feet - points[point], axis=1)
        order = np.lexsort((triangle, distance, point))  # the first of a point is its nearest
        best = order[np.concatenate([[0], np.cumsum(count)[:-1]])]
        return triangle[best], _weights(self.corners[triangle[best]], feet[best]), distance[best]


def _weights(corners: np.ndarray, feet: np.ndarray) -> np.ndarray:
    """Weights of the corners that give points of triangles, shape [k, 3]."""
    weights = trimesh.triangles.points_to_barycentric(corners, feet, method="cross")
    weights = np.clip(weights, 0.0, 1.0)
    return weights / weights.sum(axis=1, keepdims=True)
