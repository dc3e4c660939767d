"""Curves that start at nothing and never fall, fitted by least squares.

f(x) = Σ a_k S_k(x), a_k ≥ 0, where S_k = Σ_{j ≥ k} B_j are sums of cubic B-splines: they rise from
0 to 1, so that f does not fall, whatever the data (Ramsay 1988, "Monotone regression splines in
action", has them as integrated splines).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BSpline
from scipy.optimize import nnls

DEGREE = 3
INTERVALS = 12
"""Most intervals between knots of a curve."""
FLOOR = 0.02
"""Share of a curve's largest value below which errors are no longer taken as shares of it [-]."""
RIDGE = 1e-9
"""Weight that keeps coefficients determined where there is no data, over the mean of theirs [-]."""


@dataclass(frozen=True, eq=False)
class RisingBasis:
    """Functions S_k on 0 … end.

    Attributes:
        end: of the data.
        intervals: between knots, evenly spaced.
    """

    end: float
    intervals: int = INTERVALS

    @property
    def knots(self) -> np.ndarray:
        """With the ends repeated, shape [intervals + 7]."""
        inner = np.linspace(0.0, self.end, self.intervals + 1)
        return np.concatenate([[0.0] * DEGREE, inner, [self.end] * DEGREE])

    @property
    def size(self) -> int:
        """Number of functions."""
        return self.intervals + DEGREE - 1

    def rows(self, at: np.ndarray) -> np.ndarray:
        """S_k, shape [n, size]; beyond the end their values there."""
        inside = np.clip(np.asarray(at, dtype=float), 0.0, self.end)
        splines = BSpline.design_matrix(inside, self.knots, DEGREE).toarray()
        return np.cumsum(splines[:, ::-1], axis=1)[:, ::-1][:, 1:]

    def slopes(self, at: np.ndarray) -> np.ndarray:
        """dS_k/dx within the data, shape [n, size]."""
        step = 1e-4 * self.end
        low, high = np.maximum(at - step, 0.0), np.minimum(at + step, self.end)
        return (self.rows(high) - self.rows(low)) / (high - low)[:, None]


@dataclass(frozen=True, eq=False)
class LeastSquares:
    """Sums of squares of one specimen after another, from which weighted fits are quick.

    Attributes:
        products: AᵀA of each, shape [specimen, size, size].
        sides: Aᵀy of each, shape [specimen, size].
        squares: yᵀy of each, shape [specimen].
    """

    products: np.ndarray
    sides: np.ndarray
    squares: np.ndarray

    @classmethod
    def of(cls, parts: list[tuple[np.ndarray, np.ndarray, np.ndarray]]) -> LeastSquares:
        """From (rows [n, size], values [n], errors expected [n]) of each specimen, weighing one."""
        products, sides, squares = [], [], []
        for rows, values, errors in parts:
            weight = 1.0 / (errors**2 * max(len(values), 1))
            products.append(rows.T @ (weight[:, None] * rows))
            sides.append(rows.T @ (weight * values))
            squares.append(float(weight @ values**2))
        return cls(np.array(products), np.array(sides), np.array(squares))

    def fit(self, weights: np.ndarray) -> np.ndarray:
        """Coefficients, none negative, for weights of the specimens; shape [size]."""
        product = np.tensordot(weights, self.products, 1)
        side = weights @ self.sides
        level = RIDGE * float(np.trace(product)) / len(side)
        root = np.linalg.cholesky(product + level * np.eye(len(side)))
        return nnls(root.T, np.linalg.solve(root, side))[0]

    def misfit(self, weights: np.ndarray, coefficients: np.ndarray) -> float:
        """Weighted sum of squared errors over those expected."""
        product = np.tensordot(weights, self.products, 1)
        side = weights @ self.sides
        c = coefficients
        return float(weights @ self.squares - 2.0 * side @ c + c @ product @ c)


def errors_expected(fitted: np.ndarray, largest: float) -> np.ndarray:
    """Errors that grow with what is measured, and keep a floor of ``FLOOR`` of the largest."""
    return np.abs(fitted) + FLOOR * largest
