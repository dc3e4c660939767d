"""Where a line across a stack meets each of its plies."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from warpdrape.results.result import FormedPly

EDGE = 1e-9
"""How far beyond a triangle's side, as a share of it, a line still meets it."""
PORTION = 1_000_000
"""Pairs of line and triangle looked at together: some 200 MB."""


class PlyLines:
    """Finds the triangle of a ply that is nearest along a line."""

    def __init__(self, ply: FormedPly) -> None:
        """Sort the triangles by place."""
        self.corners = np.asarray(ply.points, float)[np.asarray(ply.triangles)]
        middles = self.corners.mean(axis=1)
        self.reach = float(np.linalg.norm(self.corners - middles[:, None], axis=2).max())
        self.tree = cKDTree(middles)

    def nearest(
        self, points: np.ndarray, directions: np.ndarray, farthest: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """The triangle that each line meets nearest to its point.

        Args:
            points: shape [k, 3].
            directions: unit vectors, shape [k, 3]; both ways count.
            farthest: distance along the line up to which is looked [m].

        Returns:
            Triangles, −1 where there is none, and signed ways along the lines [m], shape [k].
        """
        found, ways = np.full(len(points), -1), np.full(len(points), np.inf)
        counts = self.tree.query_ball_point(points, farthest + self.reach, return_length=True)
        ends = np.searchsorted(np.cumsum(counts), np.arange(PORTION, counts.sum(), PORTION)) + 1
        for some in np.split(np.arange(len(points)), np.unique(ends)):
            if len(some):
                found[some], ways[some] = self._some(points[some], directions[some], farthest)
        return found, ways

    def _some(
        self, points: np.ndarray, directions: np.ndarray, farthest: float
    ) -> tuple[np.ndarray, np.ndarray]:
        lists = self.tree.query_ball_point(points, farthest + self.reach)
        line = np.repeat(np.arange(len(points)), [len(near) for near in lists])
        triangle = np.concatenate([np.asarray(near, int) for near in lists])
        way = _meet(points[line], directions[line], self.corners[triangle])
        met = np.abs(way) <= farthest
        line, triangle, way = line[met], triangle[met], way[met]
        order = np.lexsort((triangle, np.abs(way), line))
        line, triangle, way = line[order], triangle[order], way[order]
        first = np.concatenate([[True], line[1:] != line[:-1]])[: len(line)]
        found, ways = np.full(len(points), -1), np.full(len(points), np.inf)
        found[line[first]], ways[line[first]] = triangle[first], way[first]
        return found, ways


def _meet(points: np.ndarray, directions: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Signed way along each line to its triangle, infinite where it passes by, shape [k].

    The weights of the corners are the volumes that the line spans with the sides (Möller and
    Trumbore 1997).
    """
    one, two = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    across = np.cross(directions, two)
    volume = (one * across).sum(axis=1)
    size = np.linalg.norm(np.cross(one, two), axis=1)
    flat = np.abs(volume) <= EDGE * size
    volume = np.where(flat, 1.0, volume)
    to = points - corners[:, 0]
    u = (to * across).sum(axis=1) / volume
    turned = np.cross(to, one)
    v = (directions * turned).sum(axis=1) / volume
    way = (two * turned).sum(axis=1) / volume
    inside = ~flat & (u >= -EDGE) & (v >= -EDGE) & (u + v <= 1.0 + EDGE)
    return np.where(inside, way, np.inf)
