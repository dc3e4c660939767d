"""Curvatures of yarns from positions: the rows of linear operators, constant during a run.

With X on the flat blank and x(X) the formed ply, the second derivatives of x are found per triangle
from slopes at its edges (the divergence theorem for ∇∇x):

    H_T = (1/A) Σ_e ℓ_e sym(θ_e ⊗ n_e),   θ_e = t_e (x_b − x_a)/ℓ_e + n_e g_e

t_e, n_e are an edge's direction and outward normal, g_e = n_e · ½ (G_a + G_b) the slope across it,
the mean of gradients G at its ends. Both triangles at an edge feel the same g_e, so that nothing is
left of it on a linear field; and as G is exact on quadratics, so is H. (A subspace of Morley's
plate element 1968, with its edge slopes tied to vertices.) G at a vertex comes from a fit
(`vertex_gradients`); where a clamp holds the slope, G is the clamp's.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy import sparse

from warpdrape.blanks.ply import Ply
from warpdrape.blanks.triangles import cross, dot, flat_gradients, two_sides
from warpdrape.forces.vertex_gradients import signed_areas, vertex_gradients
from warpdrape.setup import Setup


@dataclass(frozen=True, eq=False)
class CurvatureOperator:
    """Curvature rows of one ply.

    Attributes:
        rows: x ↦ second derivatives along t1, along t2 and across, triangle by triangle [1/m²],
            shape [3 · triangle, vertex].
        slopes: the same for the columns of each clamp's matrix [1/m], shape [3 · triangle,
            2 · clamp].
        areas: flat areas [m²], shape [triangle].
    """

    rows: sparse.csr_matrix
    slopes: sparse.csr_matrix
    areas: np.ndarray

    def stiffness(self, moduli: np.ndarray) -> tuple[sparse.csr_matrix, ...]:
        """Matrices of ½ Σ A κ·(D κ): (vertex, vertex), (vertex, slope) and (slope, slope).

        Args:
            moduli: D [N·m], symmetric, shape [3, 3].
        """
        weights = sparse.kron(sparse.diags(self.areas), moduli, format="csr")
        left, right = weights @ self.rows, weights @ self.slopes
        return tuple(
            sparse.csr_matrix(matrix)
            for matrix in (self.rows.T @ left, self.rows.T @ right, self.slopes.T @ right)
        )


def curvature_operator(
    points: np.ndarray,
    triangles: np.ndarray,
    directions: tuple[np.ndarray, np.ndarray],
    held: np.ndarray | None = None,
) -> CurvatureOperator:
    """Find the rows of a ply.

    Args:
        points: flat vertices [m], shape [n, 2].
        triangles: vertices, counter-clockwise, shape [m, 3].
        directions: unit vectors t1, t2 of warp and weft, each shape [2].
        held: clamp that holds the slope at a vertex, −1 if free, shape [n]; none by default.
    """
    n, m = len(points), len(triangles)
    held = np.full(n, -1) if held is None else held
    clamps = int(held.max(initial=-1)) + 1
    across, along = vertex_gradients(points, triangles)
    free = sparse.diags((held < 0).astype(float))
    fits = [free @ gradient for gradient in (across, along)]
    ends = _held_ends(held, clamps)
    areas = signed_areas(points, triangles)
    rows = [sparse.csr_matrix((m, n)) for _ in range(3)]
    slopes = [sparse.csr_matrix((m, 2 * clamps)) for _ in range(3)]
    pairs = ((0, 0), (1, 1), (0, 1))
    for corner in range(3):
        a, b = triangles[:, corner], triangles[:, (corner + 1) % 3]
        edge = points[b] - points[a]
        length = np.linalg.norm(edge, axis=1)
        t = edge / length[:, None]
        normal = np.column_stack([t[:, 1], -t[:, 0]])
        chord = _picked(b, n) - _picked(a, n)  # x_b − x_a
        mean = 0.5 * (_picked(a, n) + _picked(b, n))
        for number, (p, q) in enumerate(pairs):
            tp, tq, np_, nq = (v @ directions[k] for v in (t, normal) for k in (p, q))
            bent, turned = (0.5 * (u * nq + w * np_) / areas for u, w in ((tp, tq), (np_, nq)))
            rows[number] = rows[number] + sparse.diags(bent) @ chord
            for axis in (0, 1):
                share = sparse.diags(turned * length * normal[:, axis]) @ mean
                rows[number] = rows[number] + share @ fits[axis]
                slopes[number] = slopes[number] + share @ ends[axis]
    return CurvatureOperator(_interleaved(rows), _interleaved(slopes), areas)


def _held_ends(held: np.ndarray, clamps: int) -> list[sparse.csr_matrix]:
    """Columns of clamps' matrices ↦ ∂/∂X and ∂/∂Y at vertices, each shape [vertex, 2 · clamp]."""
    fixed = np.flatnonzero(held >= 0)
    return [
        sparse.csr_matrix(
            (np.ones(len(fixed)), (fixed, 2 * held[fixed] + axis)), shape=(len(held), 2 * clamps)
        )
        for axis in (0, 1)
    ]


def _picked(index: np.ndarray, n: int) -> sparse.csr_matrix:
    """X ↦ x[index], shape [m, n]."""
    m = len(index)
    return sparse.csr_matrix((np.ones(m), (np.arange(m), index)), shape=(m, n))


def _interleaved(blocks: list[sparse.csr_matrix]) -> sparse.csr_matrix:
    """Rows of three matrices in turn."""
    m = blocks[0].shape[0]
    order = np.arange(3 * m).reshape(3, m).T.ravel()
    return sparse.vstack(blocks).tocsr()[order]


def curvatures_of(scene: Setup, number: int) -> CurvatureOperator:
    """Curvature rows of a ply of a scene, with the slopes that its clamps hold."""
    ply = scene.plies[number]
    points = np.asarray(ply.mesh.vertices)
    held = np.full(len(points), -1)
    for index, clamp in enumerate(scene.clamps):
        if clamp.ply == ply.name and clamp.slope == "held":
            held[clamp.vertices(ply.rest_points)] = index
    return curvature_operator(points, np.asarray(ply.mesh.triangles), ply.yarn_directions, held)


def gershgorin(matrix: sparse.csr_matrix, triangles: np.ndarray, masses: np.ndarray) -> np.ndarray:
    """Bound on ω² [1/s²] of each triangle of a stiffness matrix [N/m].

    K ≤ diag Σ_j |K_ij|, shared out over the triangles at a vertex with their masses [kg], so that
    bounds of forces add up whatever mass scaling does to a triangle.
    """
    mass = np.bincount(triangles.ravel(), np.repeat(masses / 3.0, 3), matrix.shape[0])
    bound = np.asarray(abs(matrix).sum(axis=1)).ravel() / mass
    return bound[triangles].max(axis=1)


def out_of_plane(ply: Ply, points: np.ndarray, curvature: np.ndarray) -> np.ndarray:
    """Curvature of both yarns out of the ply's plane at vertices [1/m], shape [vertex, 2].

    Positive where a yarn is hollow on the side that faces up on the flat ply. Per length of the
    formed yarn: κ·n/‖∂x/∂y‖², averaged by flat area over the triangles at a vertex.

    Args:
        ply: the ply.
        points: formed positions [m], shape [vertex, 3].
        curvature: κ1 and κ2 of the triangles [1/m], shape [triangle, 2, 3].
    """
    triangles = np.asarray(ply.mesh.triangles)
    gradients, areas = flat_gradients(ply)
    ab, ac = two_sides(points, triangles)
    normal = cross(ab, ac)
    normal /= np.sqrt(dot(normal, normal))
    corners, found = triangles.ravel(), np.empty((len(points), 2))
    share = np.bincount(corners, np.repeat(areas, 3), len(points))
    for family, d in enumerate(gradients.T.reshape(2, 2, -1)):
        yarn = d[0] * ab + d[1] * ac
        bent = dot(curvature[:, family].T, normal) / dot(yarn, yarn)
        found[:, family] = np.bincount(corners, np.repeat(areas * bent, 3), len(points)) / share
    return found


def largest_curvatures(fields: Mapping[str, np.ndarray]) -> dict[str, float]:
    """What ``summary.json`` says of a ply's bending, given what is shown of it."""
    if "curvature" not in fields:
        return {}
    largest = np.abs(fields["curvature"]).max(axis=0)
    names = ("max_curvature_warp_per_m", "max_curvature_weft_per_m")
    return dict(zip(names, map(float, largest), strict=True))
