"""Flat triangles: yarn gradients D[α,a] = t_α · ∇N_a, stable step, percentiles by area."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from warpdrape.blanks.ply import Ply


def yarn_gradients(
    points: np.ndarray, triangles: np.ndarray, warp: np.ndarray, weft: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Gradients of the yarn families and areas of flat triangles.

    Args:
        points: flat vertices [m], shape [n, 2].
        triangles: vertices, shape [m, 3].
        warp: unit vector t1, shape [2].
        weft: unit vector t2, shape [2].

    Returns:
        (D1b, D1c, D2b, D2c) [1/m], shape [m, 4], and areas [m²], shape [m].
    """
    a, b, c = (points[triangles[:, k]] for k in range(3))
    e1, e2 = b - a, c - a
    twice = e1[:, 0] * e2[:, 1] - e1[:, 1] * e2[:, 0]
    grad_b = np.stack([e2[:, 1], -e2[:, 0]], 1) / twice[:, None]
    grad_c = np.stack([-e1[:, 1], e1[:, 0]], 1) / twice[:, None]
    gradients = np.stack([grad_b @ warp, grad_c @ warp, grad_b @ weft, grad_c @ weft], 1)
    return gradients, 0.5 * np.abs(twice)


@lru_cache(maxsize=32)
def flat_gradients(ply: Ply) -> tuple[np.ndarray, np.ndarray]:
    """`yarn_gradients` of a ply, found once and not to be written to."""
    found = yarn_gradients(ply.mesh.vertices, ply.mesh.triangles, *ply.yarn_directions)
    for values in found:
        values.setflags(write=False)
    return found


def two_sides(points: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Sides from a triangle's first corner to its second and third [m], each shape [3, m].

    By components, as sums and products of rows of three are slow in numpy.

    Args:
        points: [m], shape [n, 3].
        triangles: vertices, shape [m, 3].
    """
    columns = np.ascontiguousarray(points.T)
    a, b, c = (columns.take(corner, axis=1) for corner in triangles.T)
    return b - a, c - a


def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Products of vectors by components, each shape [3, m]."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Vector products of vectors by components, each shape [3, m]."""
    return np.stack(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )


def gradient_products(gradients: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Σ_a D1a², Σ_a D2a² and |Σ_a D1a D2a| [1/m²], each shape [m]."""
    d1 = np.column_stack([-gradients[:, 0] - gradients[:, 1], gradients[:, 0], gradients[:, 1]])
    d2 = np.column_stack([-gradients[:, 2] - gradients[:, 3], gradients[:, 2], gradients[:, 3]])
    return (d1**2).sum(1), (d2**2).sum(1), np.abs((d1 * d2).sum(1))


def highest_frequency_squared(
    gradients: np.ndarray, areal_density: float, yarns: tuple[float, float], shear: float
) -> np.ndarray:
    """Bound on ω² [1/s²] of each triangle on its lumped mass, at any shear and rotation.

    The yarns' part is the larger eigenvalue of the Gram matrix of D_α ⊗ k̂_α with |k̂1·k̂2| taken
    as 1; the largest over the triangles bounds the assembled mesh (Hughes 2000, 9.1), and pairs,
    whose mean strain stores no more than the two triangles' own.

    Args:
        gradients: (D1b, D1c, D2b, D2c) [1/m], shape [m, 4].
        areal_density: [kg/m²].
        yarns: line stiffness of warp and weft [N/m].
        shear: largest shear stiffness dC/dγ [N/m].
    """
    d1, d2, d12 = gradient_products(gradients)
    g1, g2, g12 = yarns[0] * d1, yarns[1] * d2, np.sqrt(yarns[0] * yarns[1]) * d12
    largest = 0.5 * (g1 + g2) + np.sqrt(0.25 * (g1 - g2) ** 2 + g12**2)
    return 3.0 / areal_density * (largest + shear * (np.sqrt(d1) + np.sqrt(d2)) ** 2)


def area_percentile(values: np.ndarray, areas: np.ndarray, share: float) -> float:
    """Value that a share of the area lies below, whatever the sizes of the triangles.

    Each triangle stands at the middle of its area in the sorted row; between, linear.

    Args:
        values: shape [triangle].
        areas: flat areas [m²], shape [triangle].
        share: of the area, from 0 to 1.
    """
    order = np.argsort(values, kind="stable")
    ends = np.cumsum(areas[order])
    middles = (ends - 0.5 * areas[order]) / ends[-1]
    return float(np.interp(share, middles, values[order]))


def longest_sides(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Longest side of each triangle [m], shape [triangle]."""
    corners = points[np.asarray(triangles)]
    return np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
