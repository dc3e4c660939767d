"""Least squares under linear bounds, by way of non-negative least squares."""

from __future__ import annotations

import numpy as np
from scipy.optimize import nnls


def bounded_least_squares(
    product: np.ndarray, side: np.ndarray, rows: np.ndarray, least: float | np.ndarray = 0.0
) -> np.ndarray:
    """The c of least ½ c·P c − s·c with G c ≥ g: Lawson and Hanson's least distance programming.

    With P = L Lᵀ and z = Lᵀc − L⁻¹s the least |z| under E z ≥ f is sought, E = G L⁻ᵀ,
    f = g − G P⁻¹ s; it follows from u ≥ 0 of least |[Eᵀ; fᵀ] u − (0, …, 0, 1)|.

    Args:
        product: P, positive definite, shape [n, n].
        side: s, shape [n].
        rows: G, shape [m, n].
        least: g, shape [m] or one for all.
    """
    root = np.linalg.cholesky(product)
    half = np.linalg.solve(root, side)
    free = np.linalg.solve(root.T, half)
    size = np.maximum(np.linalg.norm(rows, axis=1), 1e-300)
    rows, least = rows / size[:, None], np.broadcast_to(least, len(rows)) / size
    missing = least - rows @ free
    if (missing <= 0.0).all():
        return free
    seen = np.linalg.solve(root, rows.T)  # Eᵀ
    scale = max(float(np.abs(missing).max()), 1e-300)
    system = np.vstack([seen / np.abs(seen).max(), missing / scale])
    target = np.zeros(len(system))
    target[-1] = 1.0
    shares, _ = nnls(system, target, maxiter=50 * system.shape[1])
    left = system @ shares - target
    step = -left[:-1] / left[-1] * scale / np.abs(seen).max()
    return np.linalg.solve(root.T, half + step)
