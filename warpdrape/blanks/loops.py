"""Closed ways along borders: put together from their ends, and the area inside."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np


def closed_loops(ends: Iterable[tuple[int, int]]) -> list[np.ndarray]:
    """Loops of vertices, shape [k] each; where a border touches itself any of its ways goes on.

    Args:
        ends: from where to where the border's edges go; as many leave a vertex as come to it.
    """
    following: dict[int, list[int]] = {}
    for a, b in ends:
        following.setdefault(int(a), []).append(int(b))
    loops = []
    while following:
        first = vertex = next(iter(following))
        loop: list[int] = []
        while vertex != first or not loop:
            loop.append(vertex)
            ways = following[vertex]
            vertex = ways.pop()
            if not ways:
                del following[loop[-1]]
        loops.append(np.array(loop))
    return loops


def loop_area(loop: np.ndarray) -> float:
    """Area inside a loop of points, negative where it runs clockwise; shape [n, 2]."""
    x, y = (loop - loop[0]).T
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))
