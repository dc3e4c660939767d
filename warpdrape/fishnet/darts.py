"""Darts: where a net is sheared past locking, and the wedge that would let it lie.

The shear angle of a net grows by the surface's total curvature in the cells between a crossover and
the generators (the theorem of Gauss and Bonnet for its rhombi). A wedge of an angle δ cut out of
the ply, with its tip in a cell and its edges brought together, takes δ from the shear of all cells
beyond the tip, to first order. So a region past locking asks for δ of its largest excess, with the
tip where the excess begins.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import label

from warpdrape.errors import InputError, finite
from warpdrape.fishnet.net import Net

LEAST_CELLS = 3
"""Cells past locking of a region below which it is left to the fabric."""


@dataclass(frozen=True)
class Dart:
    """A wedge to cut out of a blank.

    Attributes:
        tip: on the flat blank, the start at its origin and x along the warp [m], shape [2].
        mouth: middle of the wedge at the net's edge [m], shape [2].
        angle: of the wedge [rad].
        tip_at: the tip on the surface [m], shape [3].
        max_shear: largest shear angle of the region, with its sign [rad].
        area: of the flat region that is past locking [m²].
    """

    tip: tuple[float, float]
    mouth: tuple[float, float]
    angle: float
    tip_at: tuple[float, float, float]
    max_shear: float
    area: float


def suggest_darts(net: Net, locking: float) -> tuple[Dart, ...]:
    """Suggest a dart for each region of a net that is sheared past locking, the largest first.

    Args:
        net: the net.
        locking: angle of the fabric [rad].

    Raises:
        InputError: if ``locking`` is no angle between 0 and 90°.
    """
    finite("locking", locking, unit="rad")
    if not 0.0 < locking < 0.5 * math.pi:
        raise InputError(
            f"locking = {locking:.4g} rad must lie between 0 and 90°: give radians, as in 50 * deg"
        )
    shear = net.shear_angle
    found = []
    for sign in (1.0, -1.0):
        regions, count = label((sign * shear > locking) & net.cells)
        for number in range(1, count + 1):
            region = regions == number
            if np.count_nonzero(region) >= LEAST_CELLS:
                found.append(_dart(net, region, locking))
    return tuple(sorted(found, key=lambda dart: -dart.area))


def _dart(net: Net, region: np.ndarray, locking: float) -> Dart:
    """The dart of one region of cells."""
    cells = np.argwhere(region)
    away = cells + 0.5 - np.array(net.middle)
    tip = cells[np.argmin(np.abs(away).sum(axis=1))]
    step = np.sign(tip + 0.5 - np.array(net.middle)).astype(int)
    mouth = tip
    while _is_cell(net, mouth + step):
        mouth = mouth + step
    shear = net.shear_angle[region]
    largest = float(shear[np.argmax(np.abs(shear))])
    corners = net.points[tip[0] : tip[0] + 2, tip[1] : tip[1] + 2].reshape(4, 3)
    x, y, z = corners.mean(axis=0).tolist()
    cell = net.spacing**2 * math.sin(net.yarn_angle)
    return Dart(
        _middle_of(net, tip),
        _middle_of(net, mouth),
        abs(largest) - locking,
        (x, y, z),
        largest,
        len(cells) * cell,
    )


def _is_cell(net: Net, cell: np.ndarray) -> bool:
    inside = (cell >= 0).all() and (cell < net.cells.shape).all()
    return bool(inside and net.cells[tuple(cell)])


def _middle_of(net: Net, cell: np.ndarray) -> tuple[float, float]:
    i, j = cell
    x, y = net.flat_points[i : i + 2, j : j + 2].reshape(4, 2).mean(axis=0)
    return float(x), float(y)
