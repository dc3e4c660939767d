"""Triangles two by two: the pairs that feel one strain per yarn family.

A pair is an edge of the dual graph (triangles are nodes, shared edges join them), so a pairing is
a matching of that graph: the heaviest, where a pair weighs its shape plus a bonus. It is not the
largest. To pair two triangles that are left over far from each other, a largest matching shifts
every pair on a path between them, and ill-shaped pairs then run through the mesh, along which yarns
lock: with one patch for every two triangles a mesh has as many constraints as unknowns, and needs a
few less. Triangles left over join a pair instead.

The heaviest links first pair nearly all; then the library finds the heaviest matching. That takes
more than linear time, so it is given one block of the mesh after the other, cut elsewhere in each
round.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from warpdrape.blanks.flat_mesh import FlatMesh

BLOCK = 256
"""Triangles per block: the library takes 12 µs a triangle for 256, 40 µs for 800."""
WHOLE = 2000
"""A mesh of no more triangles is one block: the best there is, for 0.2 s."""
ROUNDS = ((0, 0.0), (1, 0.5), (0, 0.25))
"""Axis across which strips are cut, and the share of a block by which cuts move on."""
INNER_BONUS = -0.2
"""Weight of a pair beside its shape. Below 0, it lets a random mesh keep some 2 % of its triangles
over instead of pairing them badly; measured in docs/verification.md."""
BORDER_BONUS = 1.1
"""The same where a triangle has an edge on the border. Above 1, two flat pairs (shape 0) may take
the place of one rectangle (shape 1), as along the border of a regular mesh, where the patches of
three that would be there instead make the whole strip soft."""
WEIGHT_STEPS = 1000
"""Integer steps of the weight for one unit of shape."""


@dataclass(frozen=True, eq=False)
class Pairing:
    """Patches of triangles that share their yarn strains; every triangle is in one.

    Patches of two come first; then the few others: of three or more where a triangle joins a
    pair because pairing it would have cost others their shape, and of one where a triangle has
    no neighbour.

    Args:
        offsets: patch i holds triangles[offsets[i]:offsets[i + 1]], shape [patch + 1].
        triangles: triangle indices, shape [triangle].
    """

    offsets: NDArray[np.int32]
    triangles: NDArray[np.int32]

    @property
    def sizes(self) -> NDArray[np.int32]:
        """Triangles in each patch, shape [patch]."""
        return np.diff(self.offsets)

    @property
    def n_pairs(self) -> int:
        """Number of patches of exactly two, the first ones."""
        return int(np.count_nonzero(self.sizes == 2))

    @property
    def pairs(self) -> NDArray[np.int32]:
        """The patches of two, shape [pair, 2]."""
        return self.triangles[: 2 * self.n_pairs].reshape(-1, 2)

    def patch_of(self) -> NDArray[np.int32]:
        """The patch of every triangle, shape [triangle]."""
        patch = np.empty(len(self.triangles), np.int32)
        patch[self.triangles] = np.repeat(np.arange(len(self.sizes)), self.sizes)
        return patch


@lru_cache(maxsize=32)
def pair_triangles(mesh: FlatMesh) -> Pairing:
    """Pair triangles over shared edges into well-shaped quads; no two neighbours are left over.

    Kept for the meshes asked for last.
    """
    dual = _dual_graph(mesh)
    mate = np.full(len(mesh.triangles), -1)
    _pair_heaviest_links(dual, mate)
    centres = mesh.vertices[mesh.triangles].mean(axis=1)
    if len(mate) <= WHOLE:
        _match_blocks(dual, mate, np.zeros(len(mate), np.int64))
    else:
        for axis, shift in ROUNDS:
            _match_blocks(dual, mate, _blocks(centres, mate, axis, shift))
        _pair_heaviest_links(dual, mate)  # neighbours left over on two sides of a cut
    return _patches(dual, mate)


def quad_shape(mesh: FlatMesh) -> NDArray[np.float64]:
    """Shape of the quad that two neighbours make: 1 for a rectangle, 0 with an angle of 180°.

    1 − (2/π) max |π/2 − α| over its four angles α, negative if it is not convex; one value an
    inner edge, in the order of ``mesh.edges``.
    """
    at = mesh.edges.triangles[:, 1] >= 0
    ends, pair, corner = (rows[at] for rows in mesh.edges)
    angles = _corner_angles(mesh)
    facing = angles[pair, corner]
    shared = [
        sum(
            (angles[pair[:, s]] * (mesh.triangles[pair[:, s]] == ends[:, [e]])).sum(axis=1)
            for s in (0, 1)
        )
        for e in (0, 1)
    ]
    quad = np.column_stack([facing, *shared])
    return 1.0 - (2.0 / np.pi) * np.abs(0.5 * np.pi - quad).max(axis=1)


class _Dual(NamedTuple):
    """Triangles that share an edge [link, 2], and the weight of pairing them [link]."""

    links: NDArray[np.int64]
    weights: NDArray[np.int64]


def _dual_graph(mesh: FlatMesh) -> _Dual:
    """Weigh every inner edge, in whole numbers as the library wants them.

    Weights are positive, so that a heaviest matching leaves no two neighbours over.
    """
    links = mesh.edges.triangles
    inner = links[:, 1] >= 0
    at_border = np.zeros(len(mesh.triangles), bool)
    at_border[links[~inner, 0]] = True
    pairs = links[inner].astype(np.int64)
    bonus = np.where(at_border[pairs].any(axis=1), BORDER_BONUS, INNER_BONUS)
    weights = np.rint(WEIGHT_STEPS * (quad_shape(mesh) + bonus)).astype(np.int64)
    return _Dual(pairs, np.maximum(1, weights))


def _corner_angles(mesh: FlatMesh) -> NDArray[np.float64]:
    """Angle at every corner [rad], shape [triangle, 3]."""
    p = mesh.vertices[mesh.triangles]
    u, v = np.roll(p, -1, axis=1) - p, np.roll(p, 1, axis=1) - p
    cross = u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]
    return np.arctan2(cross, (u * v).sum(axis=2))


def _pair_heaviest_links(dual: _Dual, mate: NDArray[np.int64]) -> None:
    """Pair, again and again, the triangles whose best free link is the same one."""
    links = dual.links[np.argsort(dual.weights, kind="stable")]
    links = links[(mate[links] < 0).all(axis=1)]
    while len(links):
        best = np.full(len(mate), -1)
        number = np.arange(len(links))
        for side in (0, 1):
            np.maximum.at(best, links[:, side], number)
        pairs = links[(best[links] == number[:, None]).all(axis=1)]
        mate[pairs[:, 0]], mate[pairs[:, 1]] = pairs[:, 1], pairs[:, 0]
        links = links[(mate[links] < 0).all(axis=1)]


def _match_blocks(dual: _Dual, mate: NDArray[np.int64], block: NDArray[np.int64]) -> None:
    """Replace the matching inside every block by its heaviest one; ``mate`` is updated.

    Blocks must hold whole pairs of the matching that is there; then it never gets lighter.
    """
    import rustworkx

    for triangles, links in _block_graphs(dual, block):
        graph = rustworkx.PyGraph(multigraph=False)
        graph.extend_from_weighted_edge_list(links)
        matched = rustworkx.max_weight_matching(graph, weight_fn=int)
        pairs = triangles[np.array(sorted(matched)).reshape(-1, 2)]
        mate[triangles] = -1
        mate[pairs[:, 0]], mate[pairs[:, 1]] = pairs[:, 1], pairs[:, 0]


def _blocks(
    centres: NDArray[np.float64], mate: NDArray[np.int64], axis: int, shift: float
) -> NDArray[np.int64]:
    """Cut the mesh into strips across one axis and these into blocks; returns triangle → block.

    Cuts move on by ``shift`` of a block.
    """
    triangles = np.arange(len(mate))
    unit = np.where((mate >= 0) & (mate < triangles), mate, triangles)
    units = np.flatnonzero(unit == triangles)
    size = 1 + (mate[units] >= 0)
    n_strips = max(1, round(np.sqrt(len(mate) / BLOCK)))
    strip = np.empty(len(units), np.int64)
    order = np.argsort(centres[units, axis], kind="stable")
    strip[order] = _runs(size[order], len(mate) / n_strips, shift)
    order = np.lexsort([centres[units, 1 - axis], strip])
    block = np.empty(len(mate), np.int64)
    block[units[order]] = _runs(size[order], BLOCK, shift)
    return block[unit]


def _runs(sizes: NDArray[np.int64], target: float, shift: float) -> NDArray[np.int64]:
    """Number consecutive entries so that those of one number hold ``target`` in all.

    Counted in twos, because an even number can be paired completely.
    """
    before = (np.cumsum(sizes) - sizes) // 2
    return np.floor(before / max(1, round(target / 2)) + shift).astype(np.int64)


def _block_graphs(
    dual: _Dual, block: NDArray[np.int64]
) -> Iterator[tuple[NDArray[np.int64], list[tuple[int, int, int]]]]:
    """Yield each block's triangles and its links (in the block's own numbers, with weights)."""
    order = np.argsort(block, kind="stable")
    first = np.searchsorted(block[order], np.arange(block.max() + 2))
    local = np.empty(len(block), np.int64)
    local[order] = np.arange(len(block)) - first[block[order]]
    home = block[dual.links]
    inner = np.flatnonzero(home[:, 0] == home[:, 1])
    inner = inner[np.argsort(home[inner, 0], kind="stable")]
    until = np.searchsorted(home[inner, 0], np.arange(block.max() + 2))
    a, b = local[dual.links[inner]].T.tolist()
    weights = dual.weights[inner].tolist()
    for k in range(len(first) - 1):
        span = slice(until[k], until[k + 1])
        if until[k + 1] > until[k]:
            links = list(zip(a[span], b[span], weights[span], strict=True))
            yield order[first[k] : first[k + 1]], links


def _patches(dual: _Dual, mate: NDArray[np.int64]) -> Pairing:
    """Number the pairs, and let what is left over join the neighbour that suits it best."""
    triangles = np.arange(len(mate))
    leader = np.where(mate >= 0, np.minimum(triangles, mate), triangles)
    size = np.bincount(leader, minlength=len(mate))
    for single, hosts in _hosts(dual, mate):
        best = min(hosts, key=lambda host: size[leader[host]])  # hosts come best shape first
        leader[single] = leader[best]
        size[leader[best]] += 1
        size[single] = 0
    order = np.lexsort([leader, size[leader] != 2])
    starts = np.flatnonzero(np.r_[True, np.diff(leader[order]) != 0])
    offsets = np.r_[starts, len(mate)]
    return Pairing(offsets.astype(np.int32), order.astype(np.int32))


def _hosts(dual: _Dual, mate: NDArray[np.int64]) -> list[tuple[int, list[int]]]:
    """Each single triangle with its neighbours, best quad first; fewest neighbours first."""
    touching = (mate[dual.links] < 0).any(axis=1)
    links, weights = dual.links[touching], dual.weights[touching]
    hosts: dict[int, list[int]] = {}
    for k in np.argsort(-weights, kind="stable"):
        a, b = links[k].tolist()
        single, host = (a, b) if mate[a] < 0 else (b, a)
        hosts.setdefault(single, []).append(host)
    return sorted(hosts.items(), key=lambda item: len(item[1]))
