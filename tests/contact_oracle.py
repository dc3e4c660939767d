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
