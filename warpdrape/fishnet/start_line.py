"""A start line: the warp generator led through given points of the surface."""

from __future__ import annotations

import math

import numpy as np

from warpdrape.fishnet.solver import Begin, lay_out
from warpdrape.fishnet.surface import NetSurface


def turns_along(
    surface: NetSurface,
    begin: Begin,
    spacing: float,
    counts: tuple[int, int, int, int],
    points: np.ndarray,
    limit: float,
) -> np.ndarray:
    """Turns of the generators that lead the warp from the start through points [rad], [4, n].

    At each crossover the yarn heads for the next point, which counts as reached within half a
    spacing; after the last it goes straight on, as it does backwards from the start.

    Args:
        surface: to lie on.
        begin: the start, the first of the line.
        spacing: of the net [m].
        counts: crossovers of the halves.
        points: the others, in order [m], shape [n, 3].
        limit: largest shear angle [rad].
    """
    turns = np.zeros((4, max(*counts, 1)))
    facet, place, arrive = begin.facet, begin.place, begin.warp
    aims = list(points)
    for node in range(counts[0]):
        at = surface.in_space(np.array([facet]), np.asarray(place)[None])[0]
        while aims and np.linalg.norm(aims[0] - at) < 0.5 * spacing:
            aims.pop(0)
        if not aims:
            break
        flat = surface.frames[facet] @ (aims[0] - at)
        turns[0, node] = math.remainder(math.atan2(flat[1], flat[0]) - arrive, 2 * math.pi)
        line = lay_out(surface, begin, spacing, (node + 1, 0, 0, 0), limit=limit, turns=turns)
        if not line.placed[-1, 0]:
            break
        facet, place = int(line.facets[-1, 0]), line.places[-1, 0]
        arrive = float(line.warp_arrive[-1, 0])
    return turns
