"""Yarns along themselves: tension uniform along a yarn, and bending out of the ply's plane.

A yarn slides through its crossovers without friction, so that its strain is that of its whole
length: W = EA l (L/l − 1)²/2 + ∫ B (κ − κ₀)² ds/2, L = ∫ √(λ² + z'²) dx, with λ the ply's stretch
along the yarn and κ = λ z''/(λ² + z'²)^{3/2}.
"""

from __future__ import annotations

import numpy as np

from warpdrape.unit_cell.model import Scalar, Yarn


def yarn_strain(yarn: Yarn, path: np.ndarray, stretch: Scalar) -> Scalar:
    """Strain of the yarn itself [-], over its length as woven."""
    root = np.sqrt(stretch**2 + (yarn.slopes @ path) ** 2)
    return yarn.weights @ root / yarn.rest_length - 1.0


def yarn_energy(yarn: Yarn, path: np.ndarray, stretch: Scalar) -> Scalar:
    """Energy of one repeat of a yarn [J].

    Args:
        yarn: the yarn.
        path: coefficients of its path [m].
        stretch: of the sheet along it [-]; a complex one gives the derivative.
    """
    strain = yarn_strain(yarn, path, stretch)
    stiffness = yarn.stiffness * (1.0 if np.real(strain) >= 0.0 else yarn.slack)
    root = np.sqrt(stretch**2 + (yarn.slopes @ path) ** 2)
    bent = stretch * (yarn.curvatures @ path) / root**3 - yarn.rest_curvature
    return 0.5 * stiffness * yarn.rest_length * strain**2 + 0.5 * yarn.bending * (
        yarn.rest_weights @ bent**2
    )


def add_yarn(
    yarn: Yarn,
    path: np.ndarray,
    stretch: float,
    gradient: np.ndarray,
    hessian: np.ndarray | None = None,
) -> None:
    """Add first, and second, derivatives of `yarn_energy` by the path, shapes [n], [n, n]."""
    slope, curve = yarn.slopes @ path, yarn.curvatures @ path
    root = np.sqrt(stretch**2 + slope**2)
    strain = yarn.weights @ root / yarn.rest_length - 1.0
    stiffness = yarn.stiffness * (1.0 if strain >= 0.0 else yarn.slack)
    longer = (yarn.weights * slope / root) @ yarn.slopes
    gradient += stiffness * strain * longer
    bent = stretch * curve / root**3 - yarn.rest_curvature
    by_curve = stretch / root**3
    by_slope = -3.0 * stretch * curve * slope / root**5
    moment = yarn.bending * yarn.rest_weights * bent
    gradient += (moment * by_curve) @ yarn.curvatures + (moment * by_slope) @ yarn.slopes
    if hessian is None:
        return
    hessian += stiffness / yarn.rest_length * np.outer(longer, longer)
    size = yarn.bending * yarn.rest_weights
    cross = size * by_curve * by_slope - 3.0 * moment * stretch * slope / root**5
    both = size * by_slope**2 + moment * (
        15.0 * stretch * curve * slope**2 / root**7 - 3.0 * stretch * curve / root**5
    )
    both = both + stiffness * strain * yarn.weights * stretch**2 / root**3
    mixed = (yarn.curvatures.T * cross) @ yarn.slopes
    hessian += (yarn.curvatures.T * (size * by_curve**2)) @ yarn.curvatures
    hessian += mixed + mixed.T + (yarn.slopes.T * both) @ yarn.slopes
