"""Nearest points on triangles by plain numpy, to check contact without the code under test."""

import numpy as np


def nearest_on_triangles(points, corners, k=12):
    """Nearest point of a triangle soup to each point, among the k triangles of nearest centroid.

    Returns the points [m], shape (n, 3), the triangles, shape (n,), and whether the nearest point
    lies inside its triangle, off all edges, shape (n,).
    """
    from scipy.spatial import cKDTree

    k = min(k, len(corners))
    _, candidates = cKDTree(corners.mean(axis=1)).query(points, k=k)
    candidates = candidates.reshape(len(points), k)
    best = np.full(len(points), np.inf)
    nearest, triangle = np.zeros_like(points), np.zeros(len(points), int)
    inside = np.zeros(len(points), bool)
    for column in range(k):
        t = candidates[:, column]
        q, within = _nearest_on_triangle(points, corners[t])
        distance = np.linalg.norm(points - q, axis=1)
        closer = distance < best
        best[closer], nearest[closer], triangle[closer] = distance[closer], q[closer], t[closer]
        inside[closer] = within[closer]
    return nearest, triangle, inside


def _nearest_on_triangle(p, corners):
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    foot = p - ((p - a) * normal).sum(1, keepdims=True) * normal
    within = np.ones(len(p), bool)
    for start, end in ((a, b), (b, c), (c, a)):
        within &= (np.cross(end - start, foot - start) * normal).sum(1) > 0.0
    best, distance = foot.copy(), np.where(within, np.linalg.norm(p - foot, axis=1), np.inf)
    for start, end in ((a, b), (b, c), (c, a)):
        along = end - start
        share = np.clip(((p - start) * along).sum(1) / (along**2).sum(1), 0.0, 1.0)
        on_edge = start + share[:, None] * along
        reach = np.linalg.norm(p - on_edge, axis=1)
        closer = reach < distance
        best[closer], distance[closer] = on_edge[closer], reach[closer]
    return best, within


def heights(points, corners, k=12):
    """Signed distance [m] of points whose nearest point lies inside a triangle; NaN for others."""
    nearest, triangle, inside = nearest_on_triangles(points, corners, k)
    a, b, c = corners[triangle, 0], corners[triangle, 1], corners[triangle, 2]
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    height = ((points - nearest) * normal).sum(axis=1)
    return np.where(inside, height, np.nan)


class Facing:
    """Normals whose sign tells the side at places of a surface, however sharply it is folded.

    The facet's inside it; the sum over the triangles of an edge; at a corner that over those round
    it, each by its angle there (Baerentzen and Aanaes 2005).
    """

    def __init__(self, triangles, points):
        corners = points[triangles]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        self.normals = normals / np.linalg.norm(normals, axis=1, keepdims=True)
        self.triangles, self.at_corners, self.at_edges = triangles, np.zeros_like(points), {}
        for t, triangle in enumerate(triangles):
            for k in range(3):
                a, b, c = (points[triangle[(k + j) % 3]] for j in range(3))
                one, other = (b - a) / np.linalg.norm(b - a), (c - a) / np.linalg.norm(c - a)
                angle = np.arccos(np.clip(one @ other, -1.0, 1.0))
                self.at_corners[triangle[k]] += angle * self.normals[t]
                edge = frozenset((int(triangle[k]), int(triangle[k - 2])))
                self.at_edges[edge] = self.at_edges.get(edge, 0.0) + self.normals[t]

    def at(self, t, weights):
        """At the place of a triangle that has these weights."""
        on = self.triangles[t][weights > 0.0]
        if len(on) == 3:
            return self.normals[t]
        return self.at_corners[on[0]] if len(on) == 1 else self.at_edges[frozenset(map(int, on))]
