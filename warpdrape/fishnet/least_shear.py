"""Generators of least shear: bent so that the cells of the net shear least, by optimisation."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy.optimize import minimize

from warpdrape.fishnet.net import Net
from warpdrape.fishnet.solver import Begin, lay_out
from warpdrape.fishnet.surface import NetSurface

COARSE_NODES = 24
"""Crossovers along a generator of the net on which they are sought."""
TRIES = 800
"""Nets that are laid out at most."""


def mean_square_shear(net: Net, cells: int) -> float:
    """Mean square of the shear angle over as many cells as there could be [rad²].

    A cell that is missing counts as one that is sheared flat, so that covering pays.
    """
    shear = net.shear_angle[net.cells]
    missing = max(cells - len(shear), 0)
    return float((shear**2).sum() + missing * (0.5 * math.pi) ** 2) / max(cells, 1)


def least_shear_turns(
    surface: NetSurface,
    begin: Begin,
    spacing: float,
    counts: Sequence[int],
    limit: float,
) -> np.ndarray:
    """Turns of the generators at their nodes [rad], shape [4, n], that make the cells shear least.

    Each half generator has a geodesic curvature that changes linearly along it: eight numbers,
    sought from none on a coarse net by Powell's method.

    Args:
        surface: to lie on.
        begin: where it begins.
        spacing: of the net [m].
        counts: crossovers of the halves.
        limit: largest shear angle [rad].
    """
    factor = max(1.0, max(counts) / COARSE_NODES)
    coarse = [max(1, math.ceil(count / factor)) for count in counts]
    wide = spacing * factor
    reach = wide * np.array(coarse)

    def turns(numbers: np.ndarray, n: int, step: float) -> np.ndarray:
        level, slope = numbers.reshape(2, 4) / reach
        along = (np.arange(n) + 0.5) * step
        return step * (level[:, None] + slope[:, None] * along / reach[:, None])

    straight = lay_out(surface, begin, wide, coarse, limit=limit)
    cells = int(np.count_nonzero(straight.cells))

    def cost(numbers: np.ndarray) -> float:
        bent = turns(numbers, max(coarse), wide)
        net = lay_out(surface, begin, wide, coarse, limit=limit, turns=bent)
        return mean_square_shear(net, cells)

    options = {"maxfev": TRIES, "xtol": 1e-3, "ftol": 1e-6}
    found = minimize(cost, np.zeros(8), method="Powell", options=options)
    best = found.x if found.fun < cost(np.zeros(8)) else np.zeros(8)
    return turns(best, max(*counts, 1), spacing)
