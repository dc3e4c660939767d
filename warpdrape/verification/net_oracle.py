"""A net on a surface z = F(x, y) by other means than the fishnet's: chords on the true surface.

Generators are the surface's geodesics, by their differential equation; crossovers lie at a chord's
length from both neighbours, by Newton's method. No facets, no unfolding: errors are of second order
in the spacing.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

SUBSTEPS = 8
"""Steps of Runge and Kutta's method from one crossover of a generator to the next."""


@dataclass(frozen=True)
class Graph:
    """A surface z = F(x, y).

    Attributes:
        height: F(x, y) [m].
        slopes: its first derivatives F_x and F_y [-].
        bends: its second ones F_xx, F_xy and F_yy [1/m].
    """

    height: Callable
    slopes: Callable
    bends: Callable


def saddle(twist: float) -> Graph:
    """The hyperbolic paraboloid z = c x y; c [1/m]."""
    return Graph(
        lambda x, y: twist * x * y,
        lambda x, y: (twist * y, twist * x),
        lambda x, y: (0.0 * x, twist + 0.0 * x, 0.0 * x),
    )


DOUBLE_CURVED = Graph(
    lambda x, y: (
        1.004 * x
        + 1.089 * y
        - 3.667 * x**2
        - 4.4 * x * y
        - 3.75 * y**2
        + 3.086 * x**3
        + 8.889 * x**2 * y
        + 4.321 * y**3
    ),
    lambda x, y: (
        1.004 - 7.334 * x - 4.4 * y + 9.258 * x**2 + 17.778 * x * y,
        1.089 - 4.4 * x - 7.5 * y + 8.889 * x**2 + 12.963 * y**2,
    ),
    lambda x, y: (
        -7.334 + 18.516 * x + 17.778 * y,
        -4.4 + 17.778 * x,
        -7.5 + 25.926 * y,
    ),
)
"""The double-curved mould of Krogh et al. (2021, KinDrape), for x and y from 0 to 0.5 m."""


def net_on_graph(
    graph: Graph, start: tuple[float, float], angle: float, spacing: float, counts: tuple[int, ...]
) -> np.ndarray:
    """Crossovers of a net [m], shape [along warp, along weft, 3].

    Args:
        graph: the surface.
        start: x and y at which the generators cross [m].
        angle: from x to the warp, seen from above [rad].
        spacing: of the crossovers [m].
        counts: crossovers from the start, warp forth and back, weft forth and back.
    """
    forth, back, up, down = counts
    flat = np.zeros((forth + back + 1, up + down + 1, 2))
    flat[back, down] = start
    fx, fy = graph.slopes(*start)
    along = np.array([math.cos(angle), math.sin(angle)])
    warp = along / math.sqrt(along @ along + (fx * along[0] + fy * along[1]) ** 2)
    normal = np.array([-fx, -fy, 1.0]) / math.sqrt(1.0 + fx**2 + fy**2)
    weft = np.cross(normal, np.append(warp, fx * warp[0] + fy * warp[1]))[:2]
    flat[back:, down] = _geodesic(graph, start, warp, spacing, forth)
    flat[back::-1, down] = _geodesic(graph, start, -warp, spacing, back)
    flat[back, down:] = _geodesic(graph, start, weft, spacing, up)
    flat[back, down::-1] = _geodesic(graph, start, -weft, spacing, down)
    for ways in ((1, 1), (-1, 1), (1, -1), (-1, -1)):
        _fill(graph, flat[back :: ways[0], down :: ways[1]], spacing)
    return np.concatenate([flat, graph.height(flat[..., 0], flat[..., 1])[..., None]], axis=-1)


def shear_of_cells(points: np.ndarray) -> np.ndarray:
    """Signed shear angle of each cell from its middle lines [rad], shape [cell, cell]."""
    a, b, c, d = points[:-1, :-1], points[1:, :-1], points[:-1, 1:], points[1:, 1:]
    warp, weft = b + d - a - c, c + d - a - b
    lengths = np.linalg.norm(warp, axis=-1) * np.linalg.norm(weft, axis=-1)
    return 0.5 * math.pi - np.arccos((warp * weft).sum(axis=-1) / lengths)


def _geodesic(
    graph: Graph, start: tuple[float, float], along: np.ndarray, spacing: float, count: int
) -> np.ndarray:
    """Points of a geodesic a spacing apart, seen from above [m], shape [count + 1, 2]."""

    def rate(state: np.ndarray) -> np.ndarray:
        (x, y), (u, v) = state
        fx, fy = graph.slopes(x, y)
        fxx, fxy, fyy = graph.bends(x, y)
        bend = (fxx * u * u + 2.0 * fxy * u * v + fyy * v * v) / (1.0 + fx**2 + fy**2)
        return np.array([[u, v], [-fx * bend, -fy * bend]])

    state, found = np.array([start, along], dtype=float), [np.asarray(start, dtype=float)]
    h = spacing / SUBSTEPS
    for _ in range(count):
        for _ in range(SUBSTEPS):
            k1 = rate(state)
            k2 = rate(state + 0.5 * h * k1)
            k3 = rate(state + 0.5 * h * k2)
            k4 = rate(state + h * k3)
            state = state + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
        found.append(state[0])
    return np.array(found)


def _fill(graph: Graph, flat: np.ndarray, spacing: float) -> None:
    """Fill one quadrant, seen from above, diagonal by diagonal."""

    def lift(p: np.ndarray) -> np.ndarray:
        return np.column_stack([p, graph.height(p[:, 0], p[:, 1])])

    for diagonal in range(2, sum(flat.shape[:2]) - 1):
        i = np.arange(max(1, diagonal - flat.shape[1] + 1), min(diagonal, flat.shape[0]))
        j = diagonal - i
        a, b = lift(flat[i - 1, j]), lift(flat[i, j - 1])
        p = flat[i - 1, j] + flat[i, j - 1] - flat[i - 1, j - 1]
        for _ in range(12):
            at = lift(p)
            fx, fy = graph.slopes(p[:, 0], p[:, 1])
            to_a, to_b = at - a, at - b
            short = np.stack(
                [spacing**2 - (to_a**2).sum(axis=1), spacing**2 - (to_b**2).sum(axis=1)], axis=1
            )
            rows = [
                np.stack([t[:, 0] + t[:, 2] * fx, t[:, 1] + t[:, 2] * fy], 1) for t in (to_a, to_b)
            ]
            p = p + np.linalg.solve(2.0 * np.stack(rows, axis=1), short[..., None])[..., 0]
        flat[i, j] = p
