"""A spline energy for a table of biaxial tensions, so that they come from a potential.

W(ε1, ε2) = Σ c[i, j] B_i(ε1) B_j(ε2), uniform cubic B-splines, ∂W/∂ε_α fitted to N_α = T_α/b_α.
Gradients at the knots do not see coefficients of alternating sign: where tension sets in within a
step of the table, ripples of it would go on for ever through yarns that are slack. So knots lie
half as far apart as the table's strains, the tensions between are those of monotone interpolation
(Fritsch and Carlson), and fourth differences of the coefficients carry a weight by which ripples
are gone two or three knots on. They vanish for tensions that are quadratic in the strains.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warpdrape.errors import InputError
from warpdrape.materials.laws import TabulatedTension

SMOOTHING = 0.05
"""Weight of fourth differences of the coefficients over that of a tension [-]: of 16 times the
amplitude of a ripple, where a tension sees it by how far its wave number is from π, so that it
falls by e over 1/(16 · 0.05) = 1.25 knots."""
NO_POTENTIAL = 0.2
"""Misfit above which a table is refused [-]."""
POOR_POTENTIAL = 0.02
"""Misfit above which a table is warned about [-]."""


@dataclass(frozen=True, eq=False)
class SplineEnergy:
    """Cubic-spline energy per area over a grid of strains, as `kernels.tension` reads it.

    Attributes:
        coefficients: [J/m²], shape [intervals_1 + 3, intervals_2 + 3].
        origin: strains at the first knots [-].
        spacing: strains between knots [-].
        intervals: number of intervals along ε1, ε2.
        misfit: largest |fitted − tabulated| tension at the table's strains over the largest [-].
        warning: what is doubtful about the fit; empty where nothing is.
    """

    coefficients: np.ndarray
    origin: tuple[float, float]
    spacing: tuple[float, float]
    intervals: tuple[int, int]
    misfit: float
    warning: str = ""

    def derivative(self, warp: np.ndarray, weft: np.ndarray, order: tuple[int, int]) -> np.ndarray:
        """∂ᵐ⁺ⁿW/∂ε1ᵐ∂ε2ⁿ [J/m²] on the grid ``warp`` × ``weft`` of strains inside the table."""
        rows = _basis(warp, self.origin[0], self.spacing[0], self.intervals[0], order[0])
        columns = _basis(weft, self.origin[1], self.spacing[1], self.intervals[1], order[1])
        return rows @ (columns @ self.coefficients.T).T


def fit_energy(table: TabulatedTension, yarn_width: tuple[float, float]) -> SplineEnergy:
    """Fit an energy [J/m²] to a table of tensions [N per yarn], zero at zero strain.

    Args:
        table: the tensions.
        yarn_width: width of sheet that one warp, one weft yarn carries [m].

    Raises:
        InputError: the tensions are all zero, or far from having a potential.
    """
    warp, weft = (_halved(np.asarray(each)) for each in (table.strain_warp, table.strain_weft))
    origin = (float(warp[0]), float(weft[0]))
    intervals = (len(warp) - 1, len(weft) - 1)
    spacing = (float(np.ptp(warp)) / intervals[0], float(np.ptp(weft)) / intervals[1])
    tensions = np.asarray(table.tension_warp), np.asarray(table.tension_weft)
    lines = np.stack([_between(t) / b for t, b in zip(tensions, yarn_width, strict=True)])
    largest = np.abs(lines).max()
    if largest == 0.0:
        raise InputError("tension_warp and tension_weft are all zero: give tensions [N per yarn]")

    coefficients = _least_squares(lines / largest, spacing) * largest
    fitted = SplineEnergy(coefficients, origin, spacing, intervals, 0.0)
    misfit = _misfit(fitted, table, yarn_width)
    if misfit > NO_POTENTIAL:
        raise InputError(
            f"tension_warp and tension_weft have no potential (misfit {misfit:.0%}, at most "
            f"{NO_POTENTIAL:.0%}): L1 ∂T1/∂ε2 must equal L2 ∂T2/∂ε1; check that rows are ε1 and "
            "columns ε2, and the units"
        )
    warning = ""
    if misfit > POOR_POTENTIAL:
        warning = f"the tabulated tensions have a potential only within {misfit:.1%}"
    zero = np.zeros(1)
    coefficients = coefficients - fitted.derivative(zero, zero, (0, 0))[0, 0]
    return SplineEnergy(coefficients, origin, spacing, intervals, misfit, warning)


def _halved(strains: np.ndarray) -> np.ndarray:
    """Evenly spaced strains and those half way between them, shape [2 n - 1]."""
    return np.linspace(strains[0], strains[-1], 2 * len(strains) - 1)


def _between(tensions: np.ndarray) -> np.ndarray:
    """Tensions, and those half way between them, shape [2 n - 1, 2 m - 1]: rising where they rise.

    Args:
        tensions: at evenly spaced strains, shape [n, m].
    """
    from scipy.interpolate import PchipInterpolator

    for axis in (0, 1):
        place = np.arange(float(tensions.shape[axis]))
        tensions = PchipInterpolator(place, tensions, axis=axis)(_halved(place))
    return tensions


def _misfit(
    energy: SplineEnergy, table: TabulatedTension, yarn_width: tuple[float, float]
) -> float:
    """Largest error of a yarn's tension over the largest tension of a yarn [-]."""
    strains = np.asarray(table.strain_warp), np.asarray(table.strain_weft)
    warp = energy.derivative(*strains, (1, 0)) * yarn_width[0]
    weft = energy.derivative(*strains, (0, 1)) * yarn_width[1]
    error = max(np.abs(warp - table.tension_warp).max(), np.abs(weft - table.tension_weft).max())
    return float(error / max(np.abs(table.tension_warp).max(), np.abs(table.tension_weft).max()))


def _least_squares(lines: np.ndarray, spacing: tuple[float, float]) -> np.ndarray:
    """Coefficients, shape [n + 2, m + 2], whose gradient at the knots is ``lines`` [2, n, m]."""
    from scipy import sparse
    from scipy.sparse.linalg import splu

    n, m = lines.shape[1:]
    value_1, slope_1 = (sparse.csr_array(_knot_basis(n, order)) for order in (0, 1))
    value_2, slope_2 = (sparse.csr_array(_knot_basis(m, order)) for order in (0, 1))
    h = min(spacing)
    rough_1 = sparse.kron(_fourth_difference(n + 2), sparse.eye_array(m + 2))
    rough_2 = sparse.kron(sparse.eye_array(n + 2), _fourth_difference(m + 2))
    anchor = sparse.csr_array(([1.0], ([0], [0])), shape=(1, (n + 2) * (m + 2)))
    matrix = sparse.vstack(
        [
            sparse.kron(slope_1, value_2) * (h / spacing[0]),
            sparse.kron(value_1, slope_2) * (h / spacing[1]),
            SMOOTHING * rough_1,
            SMOOTHING * rough_2,
            anchor,
        ]
    )
    right = np.zeros(matrix.shape[0])
    right[: lines.size] = lines.ravel()
    # The augmented form keeps the small smoothing weight from being squared.
    rows, columns = matrix.shape
    augmented = sparse.block_array(
        [[sparse.eye_array(rows), matrix], [matrix.T, None]], format="csc"
    )
    solution = splu(augmented).solve(np.concatenate([right, np.zeros(columns)]))
    return h * solution[rows:].reshape(n + 2, m + 2)


def _fourth_difference(size: int):
    """Sparse matrix of fourth differences, shape [size - 4, size]."""
    from scipy import sparse

    weights = [1.0, -4.0, 6.0, -4.0, 1.0]
    return sparse.diags_array(weights, offsets=[0, 1, 2, 3, 4], shape=(size - 4, size))


def _knot_basis(knots: int, order: int) -> np.ndarray:
    """Splines at the knots of a unit grid, shape [knot, knots + 2]."""
    return _basis(np.arange(float(knots)), 0.0, 1.0, knots - 1, order)


def _basis(
    strain: np.ndarray, origin: float, spacing: float, intervals: int, order: int
) -> np.ndarray:
    """Value, first or second derivative of every spline at strains, shape [strain, spline]."""
    place = (np.asarray(strain, dtype=float) - origin) / spacing
    first = np.clip(np.floor(place).astype(int), 0, intervals - 1)
    u = place - first
    w = 1.0 - u
    local = {
        0: (w**3 / 6, u**3 / 2 - u**2 + 2 / 3, w**3 / 2 - w**2 + 2 / 3, u**3 / 6),
        1: (-(w**2) / 2, 1.5 * u**2 - 2 * u, 2 * w - 1.5 * w**2, u**2 / 2),
        2: (w, 3 * u - 2, 3 * w - 2, u),
    }[order]
    basis = np.zeros((place.size, intervals + 3))
    for slot, value in enumerate(local):
        basis[np.arange(place.size), first + slot] = value
    return basis / spacing**order
