"""Gradients of a function at the vertices of a flat mesh, from its values there.

They come from a quadratic least-squares fit through each vertex over its neighbours, so that they
are exact on quadratics.
"""

from __future__ import annotations

import math

import numpy as np
from scipy import sparse

CORE = 0.2
"""Weights of the fit are 1/(CORE + d²/h²) at distance d, with h² the area of a vertex [-]."""
POOREST_FIT = 1e-3
"""Share of its largest eigenvalue from which one of a fit's normal matrix counts [-]."""
INEXACT = 1e-6
"""Error of a gradient on quadratics, over 1, above which the ring round a vertex grows [-]. A ring
of four that is symmetric leaves a quadratic undetermined, and gives the gradient all the same."""
FEWEST = 4
"""Others that a fit takes at least [-]."""
LARGEST_WEIGHTS = 3.5
"""… and it takes more while its weights, times h, add up to more than this [-]."""
WIDEST = 3
"""Rings beyond which a fit is taken as it is: a mesh of so few vertices shows no curvature."""
TIE = 1e-6
"""Others whose distances differ by less than this share are taken together, or not at all [-]."""


def vertex_gradients(
    points: np.ndarray, triangles: np.ndarray
) -> tuple[sparse.csr_matrix, sparse.csr_matrix]:
    """∂/∂X and ∂/∂Y at vertices [1/m], exact on quadratics, each shape [vertex, vertex]."""
    n = len(points)
    sides = np.concatenate([triangles[:, [k, k - 1]] for k in range(3)])
    beside = sparse.csr_matrix((np.ones(len(sides)), (sides[:, 0], sides[:, 1])), shape=(n, n))
    beside = ((beside + beside.T) > 0).astype(np.int8).tocsr()
    thirds = np.repeat(signed_areas(points, triangles) / 3.0, 3)
    size = np.sqrt(np.bincount(triangles.ravel(), thirds, n))
    reach, left = beside, np.arange(n)
    found: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []
    for ring in range(1, WIDEST + 1):
        rest = []
        counts = np.diff(reach.indptr)[left] - (reach.diagonal()[left] != 0)
        for count in np.unique(counts):
            group = left[counts == count]
            others, apart = _rings(points, reach, group, int(count))
            for some in range(min(FEWEST, int(count)), int(count) + 1):
                coefficients, good = _fits(points, size, group, others[:, :some])
                good &= apart[:, some - 1]
                if ring == WIDEST and some == count:
                    poor = ~good
                    coefficients[poor] = _poor_fits(points, size, group[poor], others[poor])
                    good[:] = True
                found.append((group[good], others[good, :some], coefficients[good]))
                group, others, apart = group[~good], others[~good], apart[~good]
            rest.append(group)
        left = np.concatenate(rest)
        if not len(left):
            break
        reach = ((reach @ beside + reach) > 0).astype(np.int8).tocsr()
    across, along = (_matrix(found, axis, n) for axis in (0, 1))
    return across, along


def _matrix(
    found: list[tuple[np.ndarray, np.ndarray, np.ndarray]], axis: int, n: int
) -> sparse.csr_matrix:
    """∂/∂X or ∂/∂Y at all vertices, from groups of them, their others and the weights of these."""
    entries = [np.r_[c[:, axis].ravel(), -c[:, axis].sum(axis=1)] for _, _, c in found]
    at = [np.r_[np.repeat(g, o.shape[1]), g] for g, o, _ in found]
    of = [np.r_[o.ravel(), g] for g, o, _ in found]
    index = (np.concatenate(at), np.concatenate(of))
    return sparse.csr_matrix((np.concatenate(entries), index), shape=(n, n))


def _rings(
    points: np.ndarray, reach: sparse.csr_matrix, group: np.ndarray, count: int
) -> tuple[np.ndarray, np.ndarray]:
    """The others within reach of each of a group, all with so many, nearest first.

    Returns:
        Vertices, shape [k, count], and whether the next one is farther off, likewise.
    """
    rows = reach[group]
    own = np.repeat(group, np.diff(rows.indptr))
    others = rows.indices[rows.indices != own].reshape(len(group), count)
    distance = np.linalg.norm(points[others] - points[group][:, None], axis=2)
    order = np.argsort(distance, axis=1, kind="stable")
    distance = np.take_along_axis(distance, order, axis=1)
    apart = np.ones(distance.shape, dtype=bool)
    apart[:, :-1] = distance[:, 1:] > (1.0 + TIE) * distance[:, :-1]
    return np.take_along_axis(others, order, axis=1), apart


def _fits(
    points: np.ndarray, size: np.ndarray, group: np.ndarray, others: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Gradient weights of quadratic fits through each vertex of a group, and which are good.

    Returns:
        Weights of (x_j − x_v) for ∂/∂X and ∂/∂Y [1/m], shape [k, 2, others], and a mask [k].
    """
    scale = size[group][:, None]
    design, weight = _quadratics(points, scale, group, others)
    transposed = np.swapaxes(design * weight[..., None], 1, 2)
    normal = transposed @ design
    values, modes = np.linalg.eigh(normal)
    counted = values > POOREST_FIT * values[:, -1:]
    inverse = counted / np.where(counted, values, 1.0)
    gradient = (modes * inverse[:, None]) @ np.swapaxes(modes, 1, 2) @ transposed
    gradient = gradient[:, :2]
    miss = np.abs(gradient @ design - np.eye(5)[:2]).max(axis=(1, 2))
    weights = np.linalg.norm(gradient, axis=1).sum(axis=1)
    good = (miss < INEXACT) & (weights < LARGEST_WEIGHTS)
    return gradient / scale[..., None], good


def _poor_fits(
    points: np.ndarray, size: np.ndarray, group: np.ndarray, others: np.ndarray
) -> np.ndarray:
    """Weights likewise where quadratics are not all seen, as on a strip one triangle wide.

    Exact on linear fields all the same, so that the flat ply has no curvature: what of a quadratic
    looks linear there counts as linear.
    """
    scale = size[group][:, None]
    design, weight = _quadratics(points, scale, group, others)
    root = np.sqrt(weight)[..., None]
    linear, square = root * design[..., :2], root * design[..., 2:]
    slopes = np.linalg.pinv(linear)
    beyond = np.linalg.pinv(square - linear @ (slopes @ square), rcond=math.sqrt(POOREST_FIT))
    gradient = slopes - slopes @ square @ beyond  # beyond @ linear is none
    return gradient * np.swapaxes(root, 1, 2) / scale[..., None]


def _quadratics(
    points: np.ndarray, scale: np.ndarray, group: np.ndarray, others: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Values of u, v and their products at the others, shape [k, others, 5], and their weights."""
    d = (points[others] - points[group][:, None]) / scale[..., None]
    u, v = d[..., 0], d[..., 1]
    # √½ makes the eigenvalues of the fit the same for a blank that lies turned
    design = np.stack([u, v, 0.5 * u * u, math.sqrt(0.5) * u * v, 0.5 * v * v], axis=2)
    return design, 1.0 / (CORE + u * u + v * v)


def signed_areas(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Areas of flat triangles [m²], shape [m], above zero counter-clockwise."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    e, f = b - a, c - a
    return 0.5 * (e[:, 0] * f[:, 1] - e[:, 1] * f[:, 0])
