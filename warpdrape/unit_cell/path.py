"""The way of a yarn through the weave as it comes off the loom."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np


def climb(amplitude: float, spacing: float, width: float) -> float:
    """Slope of the straight part between two crossovers where the yarn changes sides [-].

    Over half the width of each yarn that it crosses it follows a parabola, and goes straight in
    between: a = m (L/2 − w/4).
    """
    return amplitude / (0.5 * spacing - 0.25 * width)


def woven_height(
    places: np.ndarray, signs: Sequence[int], amplitude: float, spacing: float, width: float
) -> np.ndarray:
    """Height z [m] of a yarn's middle line at places along it.

    Args:
        places: along the yarn from its first crossover [m].
        signs: 1 where it lies over, −1 where under, one a crossover of the repeat.
        amplitude: |z| at a crossover [m].
        spacing: between crossovers [m].
        width: of the yarns that it crosses [m].
    """
    position = np.asarray(places, dtype=float) / spacing
    at = np.rint(position).astype(int)
    off = position - at
    sign = np.asarray(signs)
    here, there = sign[at % len(sign)], sign[(at + np.where(off < 0.0, -1, 1)) % len(sign)]
    slope, half = climb(amplitude, spacing, width), 0.5 * width
    way = np.abs(off) * spacing
    fall = np.where(way < half, 0.5 * slope * way**2 / half, slope * (way - 0.5 * half))
    return here * np.where(here == there, amplitude, amplitude - fall)


def crimp_of(amplitude: float, spacing: float, width: float, changes: float) -> float:
    """Length of the woven path over its length along the sheet, less one [-].

    Args:
        amplitude: |z| at a crossover [m].
        spacing: between crossovers [m].
        width: of the yarns that it crosses [m].
        changes: share of the spacings over which it changes sides [-].
    """
    m, r = climb(amplitude, spacing, width), 0.5 * width
    root = math.sqrt(1.0 + m * m)
    arc = 0.5 * r * (root + (math.asinh(m) / m if m > 0.0 else 1.0))
    whole = 2.0 * arc + (spacing - 2.0 * r) * root
    return changes * (whole / spacing - 1.0)


def amplitude_of(crimp: float, spacing: float, width: float, changes: float) -> float:
    """Amplitude [m] that gives a crimp; see `crimp_of`."""
    from scipy.optimize import brentq

    if crimp == 0.0:
        return 0.0
    return brentq(
        lambda a: crimp_of(a, spacing, width, changes) - crimp, 0.0, 10.0 * spacing, xtol=1e-15
    )
