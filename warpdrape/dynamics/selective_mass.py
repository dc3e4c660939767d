"""Selective mass scaling: which polynomial of which Laplacian makes the step as large as asked.

With λ an eigenvalue of M⁻¹L over a bound on all, a mode of frequency ω gets ω² p(λ), where

    λ p(λ) = A (1 − T_n(w0 − w1 λ)/T_n(w0)),   w1 = w0 + 1,   p(0) = 1

T_n is Chebyshev's polynomial: flat at the top over the whole range, so n − 1 products with M⁻¹L
make the step almost n times larger. T_n(w0) = 2 keeps p above a third of its envelope: no mode
gets an inertia without bound. (The same polynomials stabilise explicit methods for heat conduction:
van der Houwen & Sommeijer 1980; scaled mass: Olovsson, Simonsson & Unosson 2005.)
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sparse
import warp as wp

from warpdrape.blanks.ply import Ply
from warpdrape.blanks.triangles import flat_gradients, highest_frequency_squared
from warpdrape.dynamics.interactions import membrane_of
from warpdrape.errors import InputError
from warpdrape.kernels.dynamics.selective_mass import Filter, Power
from warpdrape.setup import Setup

DAMPING = 2.0
"""T_n(w0): more of it keeps p further from zero, and takes some of the step [-]."""
HIGHEST_ORDER = 12
"""Order n beyond which more is refused: a step costs n − 1 products."""


@dataclass(frozen=True)
class Polynomial:
    """p by its order; order 1 is p = 1, no scaling.

    Attributes:
        order: n, one more than the products that a step takes.
    """

    order: int

    @property
    def _shift(self) -> float:
        return math.cosh(math.acosh(DAMPING) / self.order)

    @property
    def _scale(self) -> float:
        w0, n = self._shift, self.order
        angle = math.acosh(w0)
        slope = n * math.sinh(n * angle) / math.sinh(angle)  # T_n'(w0)
        return DAMPING / ((w0 + 1.0) * slope)

    @property
    def peak(self) -> float:
        """Largest λ p(λ): by what the largest ω² shrinks [-]."""
        return 1.0 if self.order == 1 else self._scale * (1.0 + 1.0 / DAMPING)

    def __call__(self, share: np.ndarray) -> np.ndarray:
        """Value at eigenvalues over the largest [-], by the recurrence of the kernels."""
        share = np.asarray(share, dtype=float)
        if self.order == 1:
            return np.ones_like(share)
        start, powers = self.recurrence()
        old, now = np.zeros_like(share), np.full_like(share, start)
        for own, spread, source, before in powers:
            old, now = now, own * now + spread * share * now + source - before * old
        return now

    def recurrence(self) -> tuple[float, list[tuple[float, float, float, float]]]:
        """First term over w, and (own, spread, source, before) of each step after it.

        With y_j = (A/T_n(w0)) (T_j(w0) − T_j(x))/λ and x = w0 − w1 λ:
        y_1 = (A/T_n(w0)) w1 and y_{j+1} = 2 x y_j + 2 w1 T_j(w0) A/T_n(w0) − y_{j−1}.
        """
        w0, factor = self._shift, self._scale / DAMPING
        w1, angle = w0 + 1.0, math.acosh(w0)
        powers = [
            (2.0 * w0, -2.0 * w1, 2.0 * w1 * math.cosh(j * angle) * factor, float(j > 1))
            for j in range(1, self.order)
        ]
        return factor * w1, powers


def laplacian_bound(scene: Setup) -> float:
    """Bound on the eigenvalues of M⁻¹L [1/s²], each triangle on its own lumped mass."""
    highest = 0.0
    for ply in scene.plies:
        gradients, _ = flat_gradients(ply)
        stiffness = _scalar_stiffness(ply, scene)
        frequency = highest_frequency_squared(gradients, ply.fabric.areal_density, stiffness, 0.0)
        highest = max(highest, float(frequency.max()))
    return highest


def _scalar_stiffness(ply: Ply, scene: Setup) -> tuple[float, float]:
    """Stiffness of L along the yarns [N/m]: no motion stores more in the ply than L makes of it.

    Of shear, (g1·∂u/∂1 + g2·∂u/∂2)² ≤ 2 g² (‖∂u/∂1‖² + ‖∂u/∂2‖²).
    """
    yarns, shear = membrane_of(scene).sheet_stiffness(ply, scene.numerics)
    return yarns[0] + 2.0 * shear, yarns[1] + 2.0 * shear


def choose_polynomial(bound: float, allowed: float, step: float) -> Polynomial:
    """Lowest order that brings the largest ω² down to what is allowed.

    Args:
        bound: on the eigenvalues of M⁻¹L [1/s²].
        allowed: largest ω² at the step asked for [1/s²].
        step: asked for [s].

    Raises:
        InputError: if that takes too high an order.
    """
    for order in range(1, HIGHEST_ORDER + 1):
        if Polynomial(order).peak * bound <= allowed:
            return Polynomial(order)
    reached = step * math.sqrt(allowed / (Polynomial(HIGHEST_ORDER).peak * bound))
    raise InputError(
        f"minimum_time_step = {step:.4g} s is {math.sqrt(bound / allowed):.3g} times the step "
        f"without it, beyond the reach of selective mass scaling: give {0.995 * reached:.3g} s or "
        "less"
    )


@dataclass(frozen=True, eq=False)
class SelectiveMass:
    """What the launches need of it.

    Attributes:
        polynomial: p.
        matrix: M⁻¹L over `laplacian_bound`.
        start: first term of the recurrence over w [-].
        powers: the steps of the recurrence after it.
    """

    polynomial: Polynomial
    matrix: Filter
    start: float
    powers: tuple[Power, ...]


@dataclass(frozen=True, eq=False)
class ScaledState:
    """What selective mass scaling carries along [m/s], each of shape [vertex].

    Attributes:
        w: momenta over lumped mass.
        mean_w: their mean over the step, where there is damping.
        power_now: a term of the recurrence from momenta to velocities.
        power_old: the term before.
    """

    w: wp.array
    mean_w: wp.array
    power_now: wp.array
    power_old: wp.array


def start_scaled(vertices: int, device: str) -> ScaledState:
    """At rest."""
    return ScaledState(*(wp.zeros(vertices, dtype=wp.vec3d, device=device) for _ in range(4)))


def build_selective_mass(
    scene: Setup, mass: np.ndarray, polynomial: Polynomial, device: str
) -> SelectiveMass | None:
    """Put M⁻¹L on a device; None where nothing is scaled.

    Args:
        scene: what is computed.
        mass: lumped [kg], shape [vertex].
        polynomial: p.
        device: Warp device.
    """
    if polynomial.order == 1:
        return None
    rows = (_laplacian(scene) / laplacian_bound(scene)).tocsr()
    rows.setdiag(0.0)
    rows.eliminate_zeros()
    rows.sort_indices()
    weights = -rows.data / np.repeat(mass, np.diff(rows.indptr))
    matrix = Filter()
    matrix.offsets = wp.array(rows.indptr, dtype=wp.int32, device=device)
    matrix.neighbours = wp.array(rows.indices, dtype=wp.int32, device=device)
    matrix.weights = wp.array(weights, dtype=wp.float64, device=device)
    start, steps = polynomial.recurrence()
    return SelectiveMass(polynomial, matrix, start, tuple(_power(*step) for step in steps))


def _power(own: float, spread: float, source: float, before: float) -> Power:
    power = Power()
    power.own, power.spread, power.source, power.before = own, spread, source, before
    return power


def _laplacian(scene: Setup) -> sparse.coo_matrix:
    """L [N/m], shape [vertex, vertex]: Σ_triangles A Σ_α n_α D_α D_αᵀ."""
    rows, columns, entries, first = [], [], [], 0
    for ply in scene.plies:
        gradients, areas = flat_gradients(ply)
        at = np.asarray(ply.mesh.triangles) + first
        for stiffness, (b, c) in zip(_scalar_stiffness(ply, scene), ((0, 1), (2, 3)), strict=True):
            d = np.column_stack(
                [-gradients[:, b] - gradients[:, c], gradients[:, b], gradients[:, c]]
            )
            local = stiffness * areas[:, None, None] * d[:, :, None] * d[:, None, :]
            rows.append(np.repeat(at, 3, axis=1).ravel())
            columns.append(np.tile(at, (1, 3)).ravel())
            entries.append(local.ravel())
        first += len(ply.mesh.vertices)
    index = (np.concatenate(rows), np.concatenate(columns))
    return sparse.coo_matrix((np.concatenate(entries), index), shape=(first, first))
