"""An odd polynomial for the shear couple that rises everywhere."""

from __future__ import annotations

import math

import numpy as np

from warpdrape.calibration.bands import Band, bootstrap
from warpdrape.calibration.bounded import bounded_least_squares
from warpdrape.calibration.monotone import FLOOR, LeastSquares
from warpdrape.calibration.shear import ShearFit, ShearSpecimen, group_sizes

TERMS = 4
"""Of γ, γ³, γ⁵, γ⁷: as many as a card takes."""
UP_TO = math.radians(80.0)
"""Shear angle up to which the polynomial must not fall, data or not [rad]."""
LEAST_SLOPE = 1e-2
"""Slope anywhere over the mean slope of the data, at least: room between the angles at which it is
held, and what a card wants at 0° [-]."""


def fit_polynomial(fit: ShearFit, draws: int = 100) -> tuple[Band, float]:
    """Coefficients of C = Σ c_i γ^(2i+1) [N/m], fitted to what the specimens say.

    The slope is held above zero up to ``UP_TO``.

    Args:
        fit: the free curve fitted before: its range, and errors in proportion to it.
        draws: of the bootstrap.

    Returns:
        The coefficients' band, and how far the polynomial is from the free curve at most, over the
        largest couple [-].
    """
    end = fit.basis.end
    specimens = fit.specimens
    largest = float(fit.couple(np.array([end]))[0])
    offset = 0.0 if fit.kept else float(fit.offset.value[0])
    parts = [_part(fit, s, end, largest, offset) for s in specimens]
    squares = LeastSquares.of(parts)
    weights = np.array([s.weight for s in specimens])

    def solve(counts: np.ndarray) -> np.ndarray:
        return _rising(squares, counts, end, largest) / end ** np.arange(1, 2 * TERMS, 2)

    band = bootstrap(group_sizes(specimens), solve, weights=weights, draws=draws, positive=False)
    angles = np.linspace(0.0, end, 60)
    off = np.abs(powers(angles) @ band.value - fit.couple(angles)).max() / largest
    return band, float(off)


def powers(angle: np.ndarray) -> np.ndarray:
    """γ, γ³, γ⁵, γ⁷, shape [n, TERMS]."""
    return np.asarray(angle, dtype=float)[:, None] ** np.arange(1, 2 * TERMS, 2)


def _part(
    fit: ShearFit, specimen: ShearSpecimen, end: float, largest: float, offset: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rows in powers of γ/end, so that coefficients are alike in size."""
    inside = specimen.angle <= end * (1.0 + 1e-9)
    angle, share = specimen.angle[inside], specimen.share[inside]
    rows = powers(angle / end) + share[:, None] * powers(angle / (2 * end))
    expected = fit.couple(angle) + share * fit.couple(angle / 2)
    said = specimen.said[inside] - offset * (1.0 + share)
    return rows, said, expected + FLOOR * largest


def _rising(squares: LeastSquares, counts: np.ndarray, end: float, largest: float) -> np.ndarray:
    """Least squares under slopes that are nowhere negative, in units of the largest couple."""
    product = np.tensordot(counts, squares.products, 1) * largest**2
    side = counts @ squares.sides * largest
    scale = float(np.trace(product))
    product, side = product / scale, side / scale
    at = np.linspace(0.0, UP_TO / end, 121)
    order = np.arange(1, 2 * TERMS, 2)
    slopes = order * at[:, None] ** (order - 1)
    product = product + 1e-13 * np.eye(TERMS)
    return bounded_least_squares(product, side, slopes, LEAST_SLOPE) * largest
