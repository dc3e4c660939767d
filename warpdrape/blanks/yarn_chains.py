"""A net's yarns as chains: bars from crossover to crossover, and where each yarn ends.

A chain is a bundle of as many yarns from one end to the other, so that it can slide through its
crossovers: its bars stand for their mean width. A crossover's share of the ply's area says how many
crossings of single yarns it stands for.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from warpdrape.blanks.yarn_net import YarnNet

NONE = -1
"""In the place of a bar that is not there."""


@dataclass(frozen=True, eq=False)
class YarnChains:
    """Bars of both families, and the crossovers between them.

    Attributes:
        ends: vertices of each bar, in the direction of its family, shape [bar, 2].
        family: 0 warp, 1 weft, shape [bar].
        lengths: of the flat bars [m], shape [bar].
        widths: of the sheet that each stands for [m], alike along a chain, shape [bar].
        quadrants: bar of the warp and of the weft in each quadrant of the net, shape [quadrant, 2].
        vertices: of the crossovers, shape [crossover].
        bars: before and after each on the warp, before and after it on the weft, `NONE` where a
            yarn ends, shape [crossover, 4].
        areas: flat area that each stands for [m²], shape [crossover].
        below: yarn that lies before each, along warp and weft [m], shape [crossover, 2].
        above: yarn that lies after it, likewise.
        reach: halves of the bars before and after it [m], shape [crossover, 2, 2].
    """

    ends: NDArray[np.int32]
    family: NDArray[np.int32]
    lengths: NDArray[np.float64]
    widths: NDArray[np.float64]
    quadrants: NDArray[np.int64]
    vertices: NDArray[np.int32]
    bars: NDArray[np.int32]
    areas: NDArray[np.float64]
    below: NDArray[np.float64]
    above: NDArray[np.float64]
    reach: NDArray[np.float64]

    @property
    def numbers(self) -> NDArray[np.int32]:
        """Crossovers at each bar's ends, shape [bar, 2]."""
        return np.searchsorted(self.vertices, self.ends).astype(np.int32)

    @property
    def span(self) -> NDArray[np.float64]:
        """Length of warp and of weft that belongs to each crossover [m], shape [crossover, 2]."""
        return self.reach.sum(axis=2)

    @property
    def passed(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Yarn before the upper and after the lower end of that length [m], shape as of `span`."""
        return self.below + self.reach[..., 1], self.above + self.reach[..., 0]

    def left(self, slide: NDArray[np.float64]) -> NDArray[np.float64]:
        """Share of each crossover in which there still is yarn [-], shape [crossover, 2].

        Args:
            slide: warp and weft that has gone through it [m], shape [crossover, 2].
        """
        below, above = self.passed
        span = np.maximum(self.span, 1e-300)
        both = np.clip((below + slide) / span, 0, 1) + np.clip((above - slide) / span, 0, 1)
        return np.where(self.span > 0.0, np.maximum(both - 1.0, 0.0), 0.0)


def chain_yarns(net: YarnNet) -> YarnChains:
    """Join the bars of a net to chains."""
    vertices = np.unique(net.quadrants)
    count = len(vertices)
    bars: list[tuple[np.ndarray, ...]] = []
    of_quadrants: list[np.ndarray] = []
    for which in (0, 1):
        found, places = _bars(net, which)
        of_quadrants.append(places + sum(len(b[0]) for b in bars))
        bars.append(found)
    ends, lengths, areas = (np.concatenate([b[k] for b in bars]) for k in range(3))
    family = np.repeat([0, 1], [len(b[0]) for b in bars]).astype(np.int32)
    number = np.searchsorted(vertices, ends)
    beside = np.full((count, 4), NONE, np.int32)
    beside[number[:, 1], 2 * family] = np.arange(len(ends))
    beside[number[:, 0], 2 * family + 1] = np.arange(len(ends))
    halves = np.where(beside == NONE, 0.0, 0.5 * lengths[beside]).reshape(count, 2, 2)
    widths = np.empty(len(ends))
    below, above = np.zeros((count, 2)), np.zeros((count, 2))
    for which in (0, 1):
        own = family == which
        chain = _chains(number[own], count)
        of_bars = chain[number[own, 0]]
        total = np.bincount(of_bars, lengths[own], count)
        widths[own] = (np.bincount(of_bars, areas[own], count)[of_bars]) / total[of_bars]
        below[:, which] = _run_up(number[own], lengths[own], beside[:, 2 * which])
        above[:, which] = total[chain] - below[:, which]
    first = np.searchsorted(vertices, net.quadrants[:, 0])
    share = np.asarray(np.bincount(first, net.areas, count), np.float64)
    return YarnChains(
        ends,
        family,
        lengths,
        widths,
        np.column_stack(of_quadrants),
        vertices,
        beside,
        share,
        below,
        above,
        halves,
    )


def _bars(net: YarnNet, family: int) -> tuple[tuple[np.ndarray, ...], np.ndarray]:
    """Bars of a family (ends, lengths, areas), and the bar of each quadrant."""
    pair = net.quadrants[:, [0, 1 + family]]
    lengths = net.lengths[:, family]
    forward = np.where((lengths > 0.0)[:, None], pair, pair[:, ::-1])
    ends, first, places = np.unique(forward, axis=0, return_index=True, return_inverse=True)
    places = places.ravel()
    areas = np.bincount(places, net.areas, len(ends))
    return (ends.astype(np.int32), np.abs(lengths[first]), areas), places


def _chains(number: np.ndarray, count: int) -> np.ndarray:
    """Chain of every crossover, given the two at each bar's ends."""
    joined = sparse.coo_matrix((np.ones(len(number)), number.T), shape=(count, count))
    return connected_components(joined, directed=False)[1]


def _run_up(number: np.ndarray, lengths: np.ndarray, before: np.ndarray) -> np.ndarray:
    """Length of yarn before every crossover [m]: bar by bar from where its chain begins."""
    following = np.full(len(before), NONE)
    following[number[:, 0]] = number[:, 1]
    ahead = np.zeros(len(before))
    ahead[number[:, 0]] = lengths
    found = np.zeros(len(before))
    at = np.flatnonzero(before == NONE)
    while len(at := at[following[at] != NONE]):
        found[following[at]] = found[at] + ahead[at]
        at = following[at]
    return found
