"""A flat ply laid onto a surface by a net: where its vertices come to lie."""

from __future__ import annotations

import numpy as np

from warpdrape.fishnet.drape import in_yarns
from warpdrape.fishnet.net import Net


def laid_on(net: Net, flat: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Places of flat points, bilinear in their cells and then put onto the surface.

    Args:
        net: the net.
        flat: points of the blank, the start at its origin, x along the warp [m], shape [n, 2].

    Returns:
        Points [m], shape [n, 3], and whether the net has a cell there, shape [n].
    """
    at = in_yarns(flat, net.yarn_angle) / net.spacing + np.array(net.middle)
    last = np.array(net.cells.shape) - 1
    cell = np.clip(np.floor(at + 1e-9).astype(int), 0, last)
    share = at - cell
    inside = ((share > -1e-6) & (share < 1.0 + 1e-6)).all(axis=1)
    cell = _beside(net.cells, cell, share)
    share = at - cell
    there = inside & net.cells[tuple(cell.T)]
    i, j = cell.T
    u, v = share[:, :1], share[:, 1:]
    corners = (net.points[i + a, j + b] for a in (0, 1) for b in (0, 1))
    weights = ((1 - u) * (1 - v), (1 - u) * v, u * (1 - v), u * v)
    between = sum(w * corner for w, corner in zip(weights, corners, strict=True))
    points = np.zeros((len(flat), 3))
    if there.any():
        points[there] = net.surface.nearest(between[there])[1]
    return points, there


def _beside(cells: np.ndarray, cell: np.ndarray, share: np.ndarray) -> np.ndarray:
    """The cell itself, or where it is missing the one on whose edge or corner a point lies."""
    found = cell.copy()
    for axis in (0, 1):
        missing = ~cells[tuple(found.T)]
        back = missing & (np.abs(share[:, axis]) < 1e-6) & (found[:, axis] > 0)
        found[back, axis] -= 1
    return found
