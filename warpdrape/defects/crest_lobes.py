"""Crests of a wrinkled ply as connected regions, each one wrinkle."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from warpdrape.blanks.flat_mesh import FlatMesh
from warpdrape.defects.crests import Neighbourhood
from warpdrape.defects.smoothing import Smoothing
from warpdrape.defects.wrinkle_field import WrinkleField

NEAR_CREST = 0.7
"""Least height over amplitude where a crest is tested: within 45° of its phase [-]."""
MOST_OF_THEM = 0.5
"""Share of tested vertices near by that must turn back for a crest to be one [-]."""


@dataclass(frozen=True, eq=False)
class Lobes:
    """Halves of waves, on one side of a ply's smooth shape.

    Attributes:
        side: 1 for crests, −1 for troughs, shape [lobe].
        of_vertex: the lobe of each vertex, −1 for none, shape [n].
        folded: which of them are folds that lie on the ply, shape [lobe].
    """

    side: np.ndarray
    of_vertex: np.ndarray
    folded: np.ndarray

    def __len__(self) -> int:
        return len(self.side)

    def kept(self, keep: np.ndarray) -> Lobes:
        """Those of them that are to be kept, by a mask, shape [lobe]."""
        number = np.append(np.where(keep, np.cumsum(keep) - 1, -1), -1)
        of = number[self.of_vertex]
        return Lobes(self.side[keep], of, self.folded[keep])


def edge_graph(mesh: FlatMesh) -> sparse.csr_matrix:
    """Which vertices share an edge, shape [n, n]."""
    ends = np.asarray(mesh.edges.vertices)
    n = len(mesh.vertices)
    graph = sparse.csr_matrix((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), (n, n))
    return graph + graph.T


def find_lobes(
    smoothing: Smoothing, near: Neighbourhood, graph: sparse.csr_matrix, field: WrinkleField
) -> Lobes:
    """Find the crests and troughs of waves that turn back on both sides.

    Args:
        smoothing: filters of the ply.
        near: its vertices by place.
        graph: which vertices share an edge.
        field: where it is wrinkled.
    """
    of_vertex = np.full(len(field.high), -1)
    sides: list[float] = []
    tested, crest = _crests(near, field)
    for side in (1.0, -1.0):
        region = _turning(smoothing, field, side, tested, crest)
        count, label = components(graph, region)
        of_vertex = np.where(region, label + len(sides), of_vertex)
        sides += count * [side]
    lobes = Lobes(np.array(sides), of_vertex, np.zeros(len(sides), dtype=bool))
    return _with_folds(graph, lobes, field.turned)


def components(graph: sparse.csr_matrix, region: np.ndarray) -> tuple[int, np.ndarray]:
    """Number of connected parts of a region, and the part of each vertex, −1 outside."""
    label = np.full(len(region), -1)
    if not region.any():
        return 0, label
    count, label[region] = connected_components(graph[region][:, region], directed=False)
    return count, label


def _crests(near: Neighbourhood, field: WrinkleField) -> tuple[np.ndarray, np.ndarray]:
    """Which vertices are near enough to a crest or a trough's bottom to be tested, which are so."""
    waves = field.waves
    tested = field.high & (np.abs(waves.filtered) / waves.gain >= NEAR_CREST * waves.amplitude)
    crest = np.zeros(len(tested), dtype=bool)
    crest[tested] = near.are_crests(waves, np.flatnonzero(tested))
    return tested, crest


def _turning(
    smoothing: Smoothing, field: WrinkleField, side: float, tested: np.ndarray, crest: np.ndarray
) -> np.ndarray:
    """Vertices on one side of the smooth shape, without those where bends go one way only."""
    region = field.high & (side * field.waves.filtered > 0.0)
    crest, tested = crest & region, tested & region
    if not crest.any():
        return crest
    means = np.stack([crest, tested], axis=1).astype(float)
    for _ in range(2):
        a, b, c = (means[corner] for corner in smoothing.mesh.triangles.T)  # faster than by rows
        means = smoothing.at_vertices @ ((a + b + c) / 3.0)
    return region & (means[:, 0] >= MOST_OF_THEM * means[:, 1]) & (means[:, 0] > 0.0)


def _with_folds(graph: sparse.csr_matrix, lobes: Lobes, turned: np.ndarray) -> Lobes:
    """Lobes that meet in a fold become one, with what is turned over and its neighbours."""
    if not turned.any():
        return lobes
    around = turned | (graph @ turned.astype(float) > 0.0)
    count, fold = components(graph, around)
    of_vertex, first = lobes.of_vertex.copy(), len(lobes)
    for number in range(count):
        inside = fold == number
        met = np.unique(of_vertex[inside])
        inside |= np.isin(of_vertex, met[met >= 0])
        of_vertex[inside] = first + number
    sides = np.concatenate([lobes.side, np.ones(count)])
    folded = np.arange(len(sides)) >= first
    there = np.isin(np.arange(len(sides)), of_vertex)
    return Lobes(sides, of_vertex, folded).kept(there)


def of_one_side(graph: sparse.csr_matrix, lobes: Lobes, weight: np.ndarray) -> np.ndarray:
    """Which lobes to count: of waves that hang together those of the weightier side.

    Args:
        graph: which vertices share an edge.
        lobes: on both sides.
        weight: of each, shape [lobe].
    """
    _, cluster = components(graph, lobes.of_vertex >= 0)
    of = np.zeros(len(lobes), dtype=int)
    inside = lobes.of_vertex >= 0
    of[lobes.of_vertex[inside]] = cluster[inside]
    balance = np.bincount(of, weight * lobes.side)
    main = np.where(balance[of] < -1e-9 * weight.sum(), -1.0, 1.0)
    return (lobes.side == main) | lobes.folded


def belonging(
    smoothing: Smoothing, lobes: Lobes, high: np.ndarray, wavelengths: np.ndarray
) -> np.ndarray:
    """The lobe that each vertex belongs to: its own or the nearest within half a wave; else −1.

    Args:
        smoothing: filters of the ply.
        lobes: of one side.
        high: whether vertices are part of waves, shape [n].
        wavelengths: of the lobes on the flat ply [m], shape [lobe].
    """
    points, inside = np.asarray(smoothing.mesh.vertices), lobes.of_vertex >= 0
    distance, nearest = cKDTree(points[inside]).query(points)
    lobe = lobes.of_vertex[inside][nearest]
    return np.where(inside | (high & (distance <= 0.5 * wavelengths[lobe])), lobe, -1)
