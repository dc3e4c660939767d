"""The yarns of a ply as chains of bars: the edges of its mesh that follow warp and weft.

Where a bar of the warp and one of the weft meet, they bound a corner of a mesh of the net, a cell.
Such a corner is a quadrant (o, a, b): the crossover o, the next one a along the warp, the next one
b along the weft, both with the sign of the direction in which they lie. A whole cell has four. A
triangle with a side along each family that is not in one, as at the border of a ply cut at 45°,
has one.

Every triangle's area is that of quadrants: a cell's of its four in equal parts, any other's of the
nearest. So the net has the mass, the yarns and the cells of the ply, also along a border that
follows no yarn. Vertices in no quadrant, such as the middles of squares of four triangles, are
carried by crossovers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.spatial import cKDTree

from warpdrape.blanks.flat_mesh import FlatMesh

ALONG = 1e-6
"""Sine of the largest angle between an edge and the yarn that it follows [-]."""
FULL = 1e-6
"""How far the triangles of a cell may be from filling it, relative."""
NEAREST_CELLS = 9
"""Cells among which that of a triangle is sought: its own middle is never farther than theirs."""


@dataclass(frozen=True, eq=False)
class YarnNet:
    """Quadrants of a net, and what it carries.

    Attributes:
        quadrants: vertices (o, a, b), shape [quadrant, 3].
        lengths: from o to a along t1 and from o to b along t2, signed [m], shape [quadrant, 2].
        areas: flat area that each stands for [m²], shape [quadrant].
        home: the quadrants of each triangle as weights, rows of sum 1, shape [triangle, quadrant].
        ties: x_v − Σ w x of every carried vertex v, which vanishes on the flat ply and in every
            uniform deformation, shape [carried, vertex].
        carried: these vertices, shape [carried].
        inside: which of them lie in cells, not in the rim, shape [carried].
        rim: share of the ply's area in no cell and no quadrant's own triangle [-].
    """

    quadrants: NDArray[np.int32]
    lengths: NDArray[np.float64]
    areas: NDArray[np.float64]
    home: sparse.csr_matrix
    ties: sparse.csr_matrix
    carried: NDArray[np.int64]
    inside: NDArray[np.bool_]
    rim: float

    @property
    def gradients(self) -> NDArray[np.float64]:
        """D of quadrants as of triangles: k1 = (x_a − x_o)/l1, k2 = (x_b − x_o)/l2 [1/m]."""
        found = np.zeros((len(self.quadrants), 4))
        found[:, 0], found[:, 3] = 1.0 / self.lengths.T
        return found


def lay_yarns(mesh: FlatMesh, yarns: Sequence[np.ndarray]) -> YarnNet | None:
    """Find the net in a mesh; None where no cell of it follows both families.

    Args:
        mesh: flat triangles.
        yarns: t1, t2 of warp and weft, unit vectors, each shape [2].
    """
    along = [_next_vertices(mesh, yarn) for yarn in yarns]
    cells, members = _cells(mesh, *along)
    if not len(cells):
        return None
    in_cell = members >= 0
    alone, owners = _single_quadrants(mesh, along, ~in_cell)
    of_cells = cells[:, [[0, 1, 3], [1, 0, 2], [2, 3, 1], [3, 2, 0]]].reshape(-1, 3)
    quadrants = np.concatenate([of_cells, alone]).astype(np.int32)
    points = mesh.vertices
    lengths = np.column_stack(
        [(points[quadrants[:, k + 1]] - points[quadrants[:, 0]]) @ yarns[k] for k in (0, 1)]
    )
    home = _homes(mesh, members, quadrants, owners, len(of_cells))
    areas = home.T @ mesh.areas
    carried = np.setdiff1d(np.arange(len(points)), quadrants)
    rim = mesh.areas[~in_cell].sum() - mesh.areas[owners].sum()
    return YarnNet(
        quadrants,
        lengths,
        np.asarray(areas).ravel(),
        home,
        _ties(mesh, carried, cells, np.unique(quadrants)),
        carried,
        ~np.isin(carried, mesh.triangles[~in_cell]),
        float(rim / mesh.areas.sum()),
    )


def _next_vertices(mesh: FlatMesh, yarn: np.ndarray) -> NDArray[np.int64]:
    """The vertex at the other end of the edge that leaves each along +yarn, or -1."""
    ends = mesh.edges.vertices.astype(np.int64)
    way = mesh.vertices[ends[:, 1]] - mesh.vertices[ends[:, 0]]
    across = np.abs(way[:, 0] * yarn[1] - way[:, 1] * yarn[0])
    follows = across <= ALONG * np.hypot(*way.T)
    ends, forward = ends[follows], way[follows] @ yarn > 0.0
    ends[~forward] = ends[~forward, ::-1]
    found = np.full(len(mesh.vertices), -1)
    found[ends[:, 0]] = ends[:, 1]
    return found


def _cells(
    mesh: FlatMesh, warp: NDArray[np.int64], weft: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Cells (o, along the warp, across, along the weft) that triangles fill; each triangle's or -1.

    Args:
        mesh: the mesh.
        warp: from `_next_vertices`.
        weft: likewise.
    """
    none = np.full(len(mesh.triangles), -1)
    o = np.arange(len(warp))
    a, b = warp[o], weft[o]
    there = (a >= 0) & (b >= 0)
    there &= (weft[a] == warp[b]) & (weft[a] >= 0)
    cells = np.column_stack([o, a, weft[a], b])[there]
    if not len(cells):
        return cells, none
    corners = mesh.vertices[cells]
    u, v = corners[:, 1] - corners[:, 0], corners[:, 3] - corners[:, 0]
    full = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    at = mesh.vertices[mesh.triangles].mean(axis=1)
    near = min(NEAREST_CELLS, len(cells))
    _, nearest = cKDTree(corners.mean(axis=1)).query(at, k=near)
    nearest = nearest.reshape(len(at), near)
    off = at[:, None] - corners[nearest, 0]
    one = (off[..., 0] * v[nearest, 1] - off[..., 1] * v[nearest, 0]) / full[nearest]
    two = (u[nearest, 0] * off[..., 1] - u[nearest, 1] * off[..., 0]) / full[nearest]
    inside = (one > 0.0) & (one < 1.0) & (two > 0.0) & (two < 1.0)
    members = np.where(inside.any(axis=1), nearest[np.arange(len(at)), inside.argmax(axis=1)], -1)
    held = members >= 0
    covered = np.bincount(members[held], mesh.areas[held], len(cells))
    whole = np.abs(covered - full) <= FULL * full
    number = np.where(whole, np.cumsum(whole) - 1, -1)
    return cells[whole], np.where(held, number[members], -1)


def _single_quadrants(
    mesh: FlatMesh, along: Sequence[NDArray[np.int64]], free: NDArray[np.bool_]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Quadrants of free triangles with a side along each family, and these triangles."""
    rows = np.flatnonzero(free)
    triangles = mesh.triangles[rows].astype(np.int64)
    found, owners = [], []
    for corner in range(3):
        o = triangles[:, corner]
        others = triangles[:, (corner + 1) % 3], triangles[:, (corner + 2) % 3]
        for a, b in (others, others[::-1]):
            fits = _joined(along[0], o, a) & _joined(along[1], o, b)
            found.append(np.column_stack([o, a, b])[fits])
            owners.append(rows[fits])
    return np.concatenate(found), np.concatenate(owners)


def _joined(following: NDArray[np.int64], o: NDArray, a: NDArray) -> NDArray[np.bool_]:
    return (following[o] == a) | (following[a] == o)


def _homes(mesh, members, quadrants, owners, of_cells: int) -> sparse.csr_matrix:
    """Quadrants of each triangle as weights; see `YarnNet`."""
    points = mesh.vertices
    in_cell = np.flatnonzero(members >= 0)
    rest = np.setdiff1d(np.flatnonzero(members < 0), owners)
    corners = points[quadrants]
    middles = 0.5 * corners[:, 0] + 0.25 * (corners[:, 1] + corners[:, 2])
    _, nearest = cKDTree(middles).query(points[mesh.triangles[rest]].mean(axis=1))
    rows = np.concatenate([np.repeat(in_cell, 4), owners, rest])
    four = (4 * members[in_cell][:, None] + np.arange(4)).ravel()
    columns = np.concatenate([four, of_cells + np.arange(len(owners)), nearest])
    values = np.concatenate([np.full(len(four), 0.25), np.ones(len(owners) + len(rest))])
    shape = (len(mesh.triangles), len(quadrants))
    return sparse.csr_matrix((values, (rows, columns)), shape=shape)


def _ties(mesh: FlatMesh, carried, cells, crossovers) -> sparse.csr_matrix:
    """Rows x_v − Σ w x: by the crossovers around v, or by the corners of the nearest cell.

    Whichever has the smaller weights: large ones would be levers.
    """
    points, n = mesh.vertices, len(mesh.vertices)
    ends = mesh.edges.vertices
    ones = np.ones(len(ends))
    beside = sparse.coo_matrix((ones, (ends[:, 0], ends[:, 1])), shape=(n, n)).tocsr()
    beside = (beside + beside.T).tocsr()
    is_crossover = np.zeros(n, bool)
    is_crossover[crossovers] = True
    rows, columns, values = [], [], []
    _, nearest = cKDTree(points[cells].mean(axis=1)).query(points[carried])
    for row, (vertex, cell) in enumerate(zip(carried, nearest, strict=True)):
        around = beside.indices[beside.indptr[vertex] : beside.indptr[vertex + 1]]
        choices = []
        for carriers in (around[is_crossover[around]], cells[cell]):
            weights = affine_weights(points[carriers], points[vertex])
            if weights is not None:
                choices.append((np.abs(weights).max(), carriers, weights))
        _, carriers, weights = min(choices, key=lambda choice: choice[0])
        rows += [row] * (len(carriers) + 1)
        columns += [vertex, *carriers]
        values += [1.0, *-weights]
    return sparse.csr_matrix((values, (rows, columns)), shape=(len(carried), n))


def affine_weights(points: np.ndarray, place: np.ndarray) -> np.ndarray | None:
    """The smallest weights that give a place from points, Σ w = 1; None if none do.

    Args:
        points: [m], shape [n, 2].
        place: [m], shape [2].
    """
    if len(points) < 3:
        return None
    size = np.abs(points - place).max()
    matrix = np.vstack([np.ones(len(points)), ((points - place) / size).T])
    weights = np.linalg.lstsq(matrix, np.array([1.0, 0.0, 0.0]), rcond=None)[0]
    misses = np.abs(matrix @ weights - (1.0, 0.0, 0.0)).max() > 1e-9
    return None if misses else weights
