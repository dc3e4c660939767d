"""Make a matching as large as it can be: Edmonds' search for augmenting paths.

J. Edmonds, Paths, trees, and flowers, Canadian Journal of Mathematics 17 (1965) 449-467.
A matching is largest if and only if no path leads from one unmatched node to another that is
alternately outside and inside the matching. One search from every unmatched node is enough: a
node from which none is found has none later either, and the tree that its search has grown can
be left out of all other searches. So failures cost no more than one walk over the graph, and
successes as much as the region that they explore.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

NONE = -1
"""No node."""


def augment(neighbours: NDArray[np.int64], mate: list[int]) -> list[int]:
    """Return a largest matching, grown from the one given.

    Args:
        neighbours: adjacent nodes, shape [node, most neighbours], -1 where there is none.
        mate: the partner of every node, or -1.
    """
    mate = list(mate)
    closed: set[int] = set()
    for root in [node for node, partner in enumerate(mate) if partner == NONE]:
        if mate[root] == NONE:
            tree = _Tree(root, neighbours, mate, closed)
            if not tree.augment():
                closed |= tree.nodes
    return mate


class _Tree:
    """The alternating tree that grows from one unmatched node.

    Outer nodes are an even number of links from the root, inner nodes an odd number. Two outer
    nodes that are adjacent close an odd cycle, a blossom: its nodes all become outer, and count
    as one node, their base.
    """

    def __init__(
        self, root: int, neighbours: NDArray[np.int64], mate: list[int], closed: set[int]
    ) -> None:
        self.root = root
        self.neighbours = neighbours
        self.mate = mate
        self.closed = closed
        self.parent: dict[int, int] = {}  # inner node (or one in a blossom) → outer node
        self.base: dict[int, int] = {root: root}  # union-find over the nodes of the tree
        self.outer = {root}
        self.queue = deque([root])

    @property
    def nodes(self) -> set[int]:
        """All nodes reached."""
        return set(self.base)

    def augment(self) -> bool:
        """Search breadth first; where an unmatched node is met, flip the path to it."""
        mate = self.mate
        while self.queue:
            node = self.queue.popleft()
            for other in self.neighbours[node].tolist():
                if other == NONE or other in self.closed or other == mate[node]:
                    continue
                if other in self.outer:
                    self._shrink(node, other)
                elif other not in self.base:
                    self.parent[other] = node
                    if mate[other] == NONE:
                        self._flip(other)
                        return True
                    self.base[other] = other
                    self._make_outer(mate[other])
        return False

    def _make_outer(self, node: int) -> None:
        self.base.setdefault(node, node)
        self.outer.add(node)
        self.queue.append(node)

    def _find(self, node: int) -> int:
        """The base of the blossom that holds a node."""
        base = self.base
        while base[node] != node:
            base[node] = base[base[node]]
            node = base[node]
        return node

    def _shrink(self, one: int, two: int) -> None:
        """Make one node of the cycle that the link between two outer nodes closes."""
        if self._find(one) == self._find(two):
            return
        top = self._meeting(one, two)
        for node, other in ((one, two), (two, one)):
            while self._find(node) != top:
                self.parent[node] = other
                other = self.mate[node]
                if other not in self.outer:
                    self._make_outer(other)
                for member in (node, other):
                    if self.base[member] == member:
                        self.base[member] = top
                node = self.parent[other]

    def _bases_up(self, node: int) -> Iterator[int]:
        """Bases on the way from a node to the root."""
        while True:
            node = self._find(node)
            yield node
            if node == self.root or self.mate[node] == NONE:
                return
            node = self.parent[self.mate[node]]

    def _meeting(self, one: int, two: int) -> int:
        """The first base that is on both ways to the root, found in step from both sides."""
        seen: set[int] = set()
        ways = [self._bases_up(one), self._bases_up(two)]
        while True:
            for way in ways:
                node = next(way, NONE)
                if node in seen:
                    return node
                if node != NONE:
                    seen.add(node)

    def _flip(self, node: int) -> None:
        """Match along the path from an unmatched node back to the root."""
        while node != NONE:
            outer = self.parent[node]
            following = self.mate[outer]
            self.mate[node], self.mate[outer] = outer, node
            node = following
