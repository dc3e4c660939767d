"""A table T(ε1, ε2) from biaxial tests at any ratios: slopes of one energy, so that it has one.

W(ε1, ε2) = Σ c_ij B_i(ε1) B_j(ε2), cubic; ∂W/∂ε fitted to the line tensions measured; third
differences of c carry a small weight, as in `materials.spline`. No tension falls with its own
strain where the table has a point.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BSpline

from warpdrape.calibration.bands import Band, bootstrap
from warpdrape.calibration.bounded import bounded_least_squares
from warpdrape.calibration.tension import BiaxialPoints

INTERVALS = 5
"""Along each strain; a table has one point more."""
SMOOTHING = 1e-3
"""Weight of third differences over that of a tension [-]."""
AT_REST = 1e2
"""Weight of no tension at no strain, over that of third differences [-]."""
NEAR = 0.75
"""Distance in table steps within which a point of the table has data [-]."""


@dataclass(frozen=True, eq=False)
class TableFit:
    """Tensions on an even grid of strains.

    Attributes:
        strains: ε1 and ε2 of the grid [-], shape [n] each.
        tensions: (T1, T2) [N per yarn], shape [n · n · 2] in a band.
        beyond: points of the grid without data near them, shape [n, n].
    """

    strains: tuple[np.ndarray, np.ndarray]
    tensions: Band
    beyond: np.ndarray

    def table(self, family: int) -> np.ndarray:
        """Tension of one family on the grid [N per yarn], shape [n, n]."""
        return self.tensions.value.reshape(*self.beyond.shape, 2)[..., family]


def fit_table(
    points: Sequence[BiaxialPoints], yarn_width: tuple[float, float], draws: int
) -> TableFit:
    """Fit an energy per area to biaxial tests, and read tensions off it.

    Args:
        points: specimens, those of a test together.
        yarn_width: width of sheet that one warp, one weft yarn carries [m].
        draws: of the bootstrap.
    """
    strains = np.concatenate([p.strains for p in points])
    ends = np.maximum(strains.max(axis=0), 1e-6)
    warp, weft = (np.linspace(0.0, end, INTERVALS + 1) for end in ends)
    width = np.array(yarn_width)
    largest = max(float(np.abs(p.tensions / width).max()) for p in points)
    parts = [_rows(p.strains, ends) for p in points]
    sides = [(p.tensions / width).T.ravel() / largest for p in points]
    products = [r.T @ r / len(y) for r, y in zip(parts, sides, strict=True)]
    targets = [r.T @ y / len(y) for r, y in zip(parts, sides, strict=True)]
    grid = np.stack([g.ravel() for g in np.meshgrid(warp, weft, indexing="ij")], axis=1)
    at_grid = _rows(grid, ends)
    steeper = _own_slopes(grid, ends)
    rest = _rows(np.zeros((1, 2)), ends)  # yarns at rest carry nothing
    smooth = _roughness() + AT_REST * np.min(ends) ** 2 * rest.T @ rest
    names = [p.test for p in points]
    groups = [names.count(n) for n in dict.fromkeys(names)]
    weights = np.array([p.weight for p in points])
    scale = float(np.trace(np.tensordot(weights, products, 1))) / smooth.shape[0]

    def solve(counts: np.ndarray) -> np.ndarray:
        product = sum(c * m for c, m in zip(counts, products, strict=True))
        product = product + SMOOTHING * scale * smooth
        side = sum(c * t for c, t in zip(counts, targets, strict=True))
        return _rising(product, side, steeper)

    def tensions(counts: np.ndarray) -> np.ndarray:
        both = (at_grid @ solve(counts)).reshape(2, -1) * largest
        return (both.T * width).ravel()

    band = bootstrap(groups, tensions, weights=weights, draws=draws, positive=False)
    steps = ends / INTERVALS
    gap = np.abs(grid[:, None] - strains[None]) / steps
    beyond = gap.max(axis=2).min(axis=1) > NEAR
    return TableFit((warp, weft), band, beyond.reshape(INTERVALS + 1, INTERVALS + 1))


def _splines(at: np.ndarray, end: float, order: int) -> np.ndarray:
    """Uniform cubic B-splines or derivatives of an ``order`` of them, shape [n, INTERVALS + 3]."""
    step = end / INTERVALS
    knots = step * np.arange(-3, INTERVALS + 4)
    count = INTERVALS + 3
    splines = BSpline(knots, np.eye(count), 3, extrapolate=True)
    return (splines.derivative(order) if order else splines)(np.clip(at, 0.0, end))


def _rows(strains: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """∂W/∂ε1 of all points, then ∂W/∂ε2, shape [2 n, coefficients]."""
    flat = [
        [_splines(strains[:, axis], ends[axis], order) for order in (0, 1)] for axis in range(2)
    ]
    first = np.einsum("ni,nj->nij", flat[0][1], flat[1][0])
    second = np.einsum("ni,nj->nij", flat[0][0], flat[1][1])
    return np.concatenate([first, second]).reshape(2 * len(strains), -1)


def _own_slopes(strains: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """∂²W/∂ε1² and ∂²W/∂ε2², shape [2 n, coefficients]."""
    flat = [
        [_splines(strains[:, axis], ends[axis], order) for order in (0, 2)] for axis in range(2)
    ]
    first = np.einsum("ni,nj->nij", flat[0][1], flat[1][0])
    second = np.einsum("ni,nj->nij", flat[0][0], flat[1][1])
    return np.concatenate([first, second]).reshape(2 * len(strains), -1)


def _roughness() -> np.ndarray:
    """Squares of third differences along both axes, and of the coefficient that no slope sees."""
    count = INTERVALS + 3
    third = np.diff(np.eye(count), 3, axis=0)
    square = third.T @ third
    even = np.full((count * count, count * count), 1.0 / count**2)
    return np.kron(square, np.eye(count)) + np.kron(np.eye(count), square) + even


def _rising(product: np.ndarray, side: np.ndarray, steeper: np.ndarray) -> np.ndarray:
    """Least squares under slopes that are nowhere negative."""
    product = product + 1e-12 * np.trace(product) * np.eye(len(side))
    return bounded_least_squares(product, side, steeper)
