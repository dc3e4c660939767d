"""Periodic cubic B-splines: the path z(x) of a yarn over a repeat, smooth in its curvature."""

from __future__ import annotations

import numpy as np


def _local(
    places: np.ndarray, count: int, step: float, order: int
) -> tuple[np.ndarray, np.ndarray]:
    """Numbers of the four splines at places, and their values there, shape [*places, 4] each."""
    place = np.asarray(places) / step
    first = np.floor(place.real).astype(int)
    u = place - first
    w = 1.0 - u
    values = {
        0: (w**3 / 6, u**3 / 2 - u**2 + 2 / 3, w**3 / 2 - w**2 + 2 / 3, u**3 / 6),
        1: (-(w**2) / 2, 1.5 * u**2 - 2 * u, 2 * w - 1.5 * w**2, u**2 / 2),
        2: (w, 3 * u - 2, 3 * w - 2, u),
    }[order]
    numbers = (first[..., None] + np.arange(-1, 3)) % count
    return numbers, np.stack(values, axis=-1) / step**order


def spline_value(
    coefficients: np.ndarray, places: np.ndarray, step: float, order: int = 0
) -> np.ndarray:
    """A spline, or a derivative of it, at places.

    Args:
        coefficients: one an element of the period [m], shape [count].
        places: along the yarn [m], any shape, inside the period or not; complex ones give the
            derivative by a complex step.
        step: an element's length [m].
        order: of the derivative, 0 to 2.
    """
    numbers, values = _local(places, len(coefficients), step, order)
    return np.sum(coefficients[numbers] * values, axis=-1)


def spline_basis(places: np.ndarray, count: int, step: float, order: int = 0) -> np.ndarray:
    """Every spline at places as in `spline_value`, shape [*places, count]."""
    numbers, values = _local(places, count, step, order)
    basis = np.zeros((*np.shape(places), count))
    np.put_along_axis(basis, numbers, values, axis=-1)
    return basis


def through(heights: np.ndarray, step: float) -> np.ndarray:
    """Coefficients of the spline that has given heights [m] where elements meet, shape [count]."""
    count = len(heights)
    return np.linalg.solve(spline_basis(step * np.arange(count), count, step), heights)
