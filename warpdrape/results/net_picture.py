"""A net as a picture, and as a ply: its cells cut into triangles."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from warpdrape.errors import InputError
from warpdrape.fishnet.net import Net
from warpdrape.results.quantities import QUANTITIES

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BELOW = 3e-3
"""How far below the net its surface is drawn, over the surface's size [-]: cells cut its bends."""


def net_picture(net: Net, *, surface: bool = True) -> Figure:
    """Draw a net, coloured by the shear angle of its cells; a matplotlib figure.

    Args:
        net: the net.
        surface: draw the surface under it, translucent.

    Raises:
        InputError: if the net has no cell.
    """
    from warpdrape.results.picture import draw_views
    from warpdrape.results.usd_reader import PlyView, SceneView

    if not net.cells.any():
        raise InputError("the net has no cell to draw: see net.ends for why it ends")
    triangles, cell = cell_triangles(net)
    points, flat = net.points.reshape(-1, 3), net.flat_points.reshape(-1, 2)
    used, corners = np.unique(triangles, return_inverse=True)
    corners = corners.reshape(-1, 3)
    rest = np.column_stack([flat[used], np.zeros(len(used))])
    shown = QUANTITIES["shear"].of(np.degrees(net.shear_angle.ravel()[cell]))
    warp, weft = _directions(net, cell)
    view = PlyView("net", points[used], rest, corners.astype(np.int64), warp, weft, shown)
    below = net.surface.offset(-BELOW * net.surface.size)
    surfaces = [(below.points, below.facets[~below.spanned])] if surface else []
    return draw_views(SceneView(float("nan"), [view], surfaces), QUANTITIES["shear"])


def cell_triangles(net: Net) -> tuple[np.ndarray, np.ndarray]:
    """Two triangles of nodes for each cell, shape [m, 3], and the cell of each, shape [m]."""
    number = np.arange(net.status.size).reshape(net.status.shape)
    a, b, c, d = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
    both = np.stack([np.stack([a, b, c], -1), np.stack([a, c, d], -1)], axis=2)
    cell = np.broadcast_to(np.arange(a.size).reshape(a.shape)[..., None], both.shape[:3])
    there = np.broadcast_to(net.cells[..., None], both.shape[:3])
    return both[there], cell[there]


def _directions(net: Net, cell: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Unit directions of both yarns in cells, each shape [m, 3]."""
    p = net.points
    a, b, c, d = p[:-1, :-1], p[1:, :-1], p[1:, 1:], p[:-1, 1:]
    found = []
    for along in (b + c - a - d, c + d - a - b):
        chosen = along.reshape(-1, 3)[cell]
        found.append(chosen / np.linalg.norm(chosen, axis=1, keepdims=True))
    return found[0], found[1]
