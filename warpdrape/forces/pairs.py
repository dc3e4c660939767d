"""Pairs of triangles as their kernel reads them: two at a time, numbered over a shared edge."""

from __future__ import annotations

import numpy as np

from warpdrape.blanks.flat_mesh import FlatMesh
from warpdrape.blanks.pairing import pair_triangles
from warpdrape.kernels.forces.pairs import TwoPairs


def patches_of(mesh: FlatMesh, averaging: str) -> tuple[np.ndarray, np.ndarray, int]:
    """Triangles that share yarn strains: pairs first, then those of three.

    Args:
        mesh: of a ply.
        averaging: "pairs"; or "plain", where each triangle has its own.

    Returns:
        First member of each patch and their number, shape [patch + 1]; triangles by patch, shape
        [triangle]; how many patches are pairs.
    """
    if averaging == "pairs":
        pairing = pair_triangles(mesh)
        return pairing.offsets, pairing.triangles, pairing.n_pairs
    count = len(mesh.triangles)
    return np.arange(count + 1), np.arange(count), 0


def arrange_pairs(
    triangles: np.ndarray,
    gradients: np.ndarray,
    areas: np.ndarray,
    pairs: np.ndarray,
    stabiliser: np.ndarray,
    first_vertex: int = 0,
) -> np.ndarray:
    """Arrange a ply's pairs for `kernels.forces.pairs`.

    Args:
        triangles: vertices, counter-clockwise, shape [m, 3].
        gradients: (D1b, D1c, D2b, D2c) [1/m], shape [m, 4].
        areas: initial areas [m²], shape [m].
        pairs: triangles, an even number of pairs, shape [p, 2].
        stabiliser: κ C'(0) of each [N/m], shape [p].
        first_vertex: number of the ply's first vertex in the model.

    Returns:
        Structured array of `TwoPairs`, shape [p / 2].
    """
    quads, da, db = pair_gradients(triangles, gradients, pairs)
    return two_by_two(quads + first_vertex, da, db, areas[pairs], stabiliser)


def two_by_two(
    quads: np.ndarray, da: np.ndarray, db: np.ndarray, areas: np.ndarray, stabiliser: np.ndarray
) -> np.ndarray:
    """Arrange pairs two by two as the kernels' `TwoPairs`.

    Args:
        quads: vertices (i, j, k, l), an even number of pairs, shape [p, 4].
        da: D of (i, j, k) [1/m], shape [p, 4].
        db: D of (i, l, j) [1/m], shape [p, 4].
        areas: initial areas [m²], shape [p, 2].
        stabiliser: κ C'(0) of each [N/m], shape [p].

    Returns:
        Structured array, shape [p / 2].
    """

    def lanes(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return np.column_stack([a, b]).reshape(-1, 4)

    two = np.zeros(len(quads) // 2, dtype=TwoPairs.numpy_dtype())
    two["vertices_p"], two["vertices_q"] = quads[0::2], quads[1::2]
    two["warp_at_j"], two["warp_at_tip"] = lanes(da[:, 0], db[:, 1]), lanes(da[:, 1], db[:, 0])
    two["weft_at_j"], two["weft_at_tip"] = lanes(da[:, 2], db[:, 3]), lanes(da[:, 3], db[:, 2])
    two["areas"] = areas.reshape(-1, 4)
    two["stabiliser"] = np.repeat(stabiliser, 2).reshape(-1, 4)
    return two


def pair_gradients(
    triangles: np.ndarray, gradients: np.ndarray, pairs: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Number a pair's vertices (i, j, k, l), its triangles being (i, j, k) and (i, l, j).

    Args:
        triangles: vertices, counter-clockwise, shape [m, 3].
        gradients: (D1b, D1c, D2b, D2c) [1/m], shape [m, 4].
        pairs: triangles, shape [p, 2].

    Returns:
        Vertices, shape [p, 4]; gradients of the two triangles in that order, each shape [p, 4].
    """
    ta, tb = triangles[pairs[:, 0]], triangles[pairs[:, 1]]
    shared = (ta[:, :, None] == tb[:, None, :]).any(2)
    tip = np.argmin(shared, axis=1)  # the one corner of a that b lacks
    rows = np.arange(len(pairs))
    i, j, k = (ta[rows, (tip + s) % 3] for s in (1, 2, 0))
    tip_b = np.argmin((tb[:, :, None] == ta[:, None, :]).any(2), axis=1)
    quads = np.column_stack([i, j, k, tb[rows, tip_b]])
    full = np.stack(
        [
            np.column_stack(
                [-gradients[:, c] - gradients[:, c + 1], gradients[:, c], gradients[:, c + 1]]
            )
            for c in (0, 2)
        ],
        1,
    )  # D[triangle, family, corner]
    in_a, in_b = full[pairs[:, 0]], full[pairs[:, 1]]
    da = [in_a[rows, family, (tip + s) % 3] for family in (0, 1) for s in (2, 0)]
    # In b, counter-clockwise: tip l, then j, then i, as b runs along the shared edge from j to i.
    at_j = np.argmax(tb == j[:, None], axis=1)
    db = [in_b[rows, family, at] for family in (0, 1) for at in (tip_b, at_j)]
    return quads.astype(np.int32), np.column_stack(da), np.column_stack(db)
