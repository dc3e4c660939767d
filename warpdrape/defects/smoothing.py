"""A ply's smooth shape: filters on its flat mesh, of known transfer, that leave a free edge alone.

The low-pass filter is a thin plate on springs, (M + ℓ⁴ Σ_ij D_ijᵀ M⁻¹ D_ij) s = M x, with D_ij u
the weak second derivatives of a linear field at inner vertices. It passes 1/(1 + (ℓk)⁴) of a wave
of wave number k, and every plane unchanged, tilted ones too: the plate's edges are free. Source of
the operator: Stein, Grinspun, Wardetzky & Jacobson 2018, "Natural boundary conditions for smoothing
in geometry processing", with the mixed areas of Meyer, Desbrun, Schröder & Barr 2003 as masses.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from warpdrape.blanks.flat_mesh import FlatMesh

NEIGHBOURHOOD = 1.0
"""Reach of means over ℓ: a sixth of the longest wave [-]."""
DIRECTIONS = 8
"""In which the filter is measured on a mesh."""


@dataclass(frozen=True, eq=False)
class Smoothing:
    """Filters and derivatives on a flat mesh.

    Attributes:
        mesh: the flat blank.
        longest: wavelength of which half passes as a wave and half as shape [m].
    """

    mesh: FlatMesh
    longest: float

    @property
    def length(self) -> float:
        """ℓ of the filter [m]."""
        return self.longest / (2.0 * math.pi)

    @cached_property
    def masses(self) -> np.ndarray:
        """Area nearest to each vertex [m²], shape [n]: with these Δ is exact for a dome."""
        triangles = np.asarray(self.mesh.triangles)
        corners = np.asarray(self.mesh.vertices)[triangles]
        sides = np.roll(corners, -1, axis=1) - np.roll(corners, 1, axis=1)  # opposite a corner
        squares = (sides**2).sum(axis=2)
        areas = np.asarray(self.mesh.areas)[:, None]
        cotangents = (squares.sum(axis=1, keepdims=True) - 2.0 * squares) / (4.0 * areas)
        weights = squares * cotangents / 8.0
        nearest = weights.sum(axis=1, keepdims=True) - weights
        obtuse = cotangents < 0.0
        nearest = np.where(
            obtuse.any(axis=1, keepdims=True), areas * np.where(obtuse, 0.5, 0.25), nearest
        )
        return np.bincount(triangles.ravel(), nearest.ravel(), len(self.mesh.vertices))

    @cached_property
    def shapes(self) -> np.ndarray:
        """Gradients of the corners' shape functions [1/m], shape [m, 3, 2]."""
        corners = np.asarray(self.mesh.vertices)[self.mesh.triangles]
        across = np.roll(corners, -1, axis=1) - np.roll(corners, 1, axis=1)
        turned = np.stack([across[..., 1], -across[..., 0]], axis=2)
        return -turned / (2.0 * np.asarray(self.mesh.areas))[:, None, None]

    @cached_property
    def gradient(self) -> sparse.csr_matrix:
        """Values at vertices to gradients [1/m]: rows of x, then of y, shape [2m, n]."""
        m = len(self.mesh.triangles)
        rows = np.repeat(np.arange(2 * m), 3)
        columns = np.tile(np.asarray(self.mesh.triangles).ravel(), 2)
        values = np.moveaxis(self.shapes, 2, 0).ravel()
        return sparse.csr_matrix((values, (rows, columns)), (2 * m, len(self.masses)))

    @cached_property
    def at_vertices(self) -> sparse.csr_matrix:
        """Values of triangles to their means at vertices, by area, shape [n, m]."""
        triangles = np.asarray(self.mesh.triangles)
        thirds = np.asarray(self.mesh.vertex_areas)[triangles.ravel()]
        shares = np.repeat(np.asarray(self.mesh.areas) / 3.0, 3) / thirds
        columns = np.repeat(np.arange(len(triangles)), 3)
        return sparse.csr_matrix(
            (shares, (triangles.ravel(), columns)), (len(self.masses), len(triangles))
        )

    @cached_property
    def _weak(self) -> tuple[sparse.csr_matrix, ...]:
        """−∫ ∂_i φ_v ∂_j u for (i, j) = xx, yy, xy [-], each shape [n, n]."""
        m = len(self.mesh.triangles)
        along = self.gradient[:m], self.gradient[m:]
        area = sparse.diags(np.asarray(self.mesh.areas))
        return tuple(-(along[i].T @ area @ along[j]).tocsr() for i, j in ((0, 0), (1, 1), (0, 1)))

    @cached_property
    def inner(self) -> np.ndarray:
        """1 at vertices inside, 0 on the edge, shape [n]."""
        inside = np.ones(len(self.masses))
        inside[self.mesh.boundary_vertices] = 0.0
        return inside

    @cached_property
    def curvature(self) -> tuple[sparse.csr_matrix, ...]:
        """Values to second derivatives xx, yy, xy [1/m²], zero on the edge; each shape [n, n]."""
        inverse = sparse.diags(self.inner / self.masses)
        return tuple(inverse @ weak for weak in self._weak)

    @cached_property
    def _mean_curvature(self) -> sparse.csr_matrix:
        """Values to second derivatives [1/m²], means over vertices and neighbours, [3 · n, n].

        The middle of crossed squares alone cannot tell xx from yy. Rows of xx, then yy, then xy.
        """
        m = len(self.mesh.triangles)
        rows, columns = np.repeat(np.arange(m), 3), np.asarray(self.mesh.triangles).ravel()
        thirds = sparse.csr_matrix(
            (np.full(3 * m, 1.0 / 3.0), (rows, columns)), (m, len(self.inner))
        )
        mean = self.at_vertices @ thirds
        there = sparse.diags(self.inner / np.maximum(mean @ self.inner, 1e-300))
        single = sparse.diags(self.inner / np.asarray(self.mesh.vertex_areas))
        return sparse.vstack([there @ mean @ single @ weak for weak in self._weak], format="csr")

    def curvatures(self, values: np.ndarray) -> np.ndarray:
        """Second derivatives xx, yy, xy of fields, means near by, zero on the edge [1/m²].

        Args:
            values: of the fields, shape [n, field].

        Returns:
            Shape [n, field, 3] per metre squared of what the values are in.
        """
        found = (self._mean_curvature @ values).reshape(3, *values.shape)
        return np.ascontiguousarray(np.moveaxis(found, 0, 2))

    @cached_property
    def _plate(self) -> Any:
        derivatives = self.curvature
        mass = sparse.diags(self.masses)
        xx, yy, xy = (each.T @ mass @ each for each in derivatives)
        stray = float(self._stray.mean()) or 1.0
        stiffness = (xx + yy + 2.0 * xy) * (self.length**4 / stray)
        return splu((mass + stiffness).tocsc())

    @cached_property
    def _stray(self) -> np.ndarray:
        """Energy of cylinders on this mesh over the true one [-], by direction, shape [direction].

        Derivatives at the vertices of crossed squares stray to either side of the true ones.
        """
        points, mass = np.asarray(self.mesh.vertices), self.masses * self.inner
        found = []
        for angle in np.arange(DIRECTIONS) * (math.pi / DIRECTIONS):
            across = points @ [math.cos(angle), math.sin(angle)]
            xx, yy, xy = (each @ (0.5 * across**2) for each in self.curvature)
            found.append(mass @ (xx**2 + yy**2 + 2.0 * xy**2) / max(mass.sum(), 1e-300))
        return np.array(found)

    @cached_property
    def _spread(self) -> Any:
        stiffness = -((NEIGHBOURHOOD * self.length) ** 2) * (self._weak[0] + self._weak[1])
        matrix = (sparse.diags(self.masses) + stiffness).tocsc()
        symmetric = {"SymmetricMode": True}  # half the entries, with the diagonal for pivots
        return splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=symmetric)

    def smooth(self, values: np.ndarray) -> np.ndarray:
        """Values without their waves: what the low-pass filter leaves, shape [n, …]."""
        return self._plate.solve(self._weighted(values))

    def around(self, values: np.ndarray) -> np.ndarray:
        """Means of values over the neighbourhood of ℓ, none negative that was not."""
        return self._spread.solve(self._weighted(values))

    def gain(self, wave_number: np.ndarray, angle: np.ndarray | None = None) -> np.ndarray:
        """What of a wave is left beside the smooth shape [-].

        Args:
            wave_number: on the flat ply [1/m].
            angle: from x to the direction across its crests [rad], where it is known.
        """
        # Beyond a billion nothing is left out any more: that of noise on a flat ply has no bound.
        passed = np.minimum(self.length * wave_number, 1e9) ** 4
        if angle is not None:
            stray = np.append(self._stray, self._stray[0]) / self._stray.mean()
            at = np.linspace(0.0, math.pi, DIRECTIONS + 1)
            passed = passed * np.interp(np.mod(angle, math.pi), at, stray)
        return passed / (1.0 + passed)

    def _weighted(self, values: np.ndarray) -> np.ndarray:
        return self.masses.reshape(-1, *[1] * (values.ndim - 1)) * values
