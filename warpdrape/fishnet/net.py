"""A net on a surface: its crossovers, the shear angle in its cells, and why it ends."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from warpdrape.fishnet.surface import NetSurface
from warpdrape.kernels.fishnet import nodes
from warpdrape.wording import heading

REASONS = {
    int(nodes.BORDER): "border",
    int(nodes.SHEARED): "sheared",
    int(nodes.COARSE): "coarse",
    int(nodes.FINE): "fine",
}
"""Why a net ends at a node, by its status."""
WORDS = {
    "border": "the surface ends there",
    "sheared": "no place at the spacing from both neighbours below the shear limit",
    "coarse": "the spacing is too coarse for the surface there",
    "fine": "too many facets between crossovers there: take a smaller spacing or larger facets",
}
"""The same in words."""


@dataclass(frozen=True)
class NetEnd:
    """Why a net ends, and where first.

    Attributes:
        reason: "border", "sheared", "coarse" or "fine".
        nodes: how many crossovers could not be placed for it.
        node: that nearest to the start, in yarns along warp and weft from it.
        place: where the search for it had come to [m], shape [3].
    """

    reason: str
    nodes: int
    node: tuple[int, int]
    place: tuple[float, float, float]

    @property
    def words(self) -> str:
        """A sentence."""
        at = ", ".join(f"{1e3 * v:.4g}" for v in self.place)
        return f"{WORDS[self.reason]}: {self.nodes} crossovers, the first near ({at}) mm"


@dataclass(frozen=True, eq=False)
class Net:
    """Crossovers of a net; arrays have shape [along warp, along weft].

    Attributes:
        surface: on which it lies.
        spacing: length of a yarn between crossovers, along the facets [m].
        yarn_angle: from warp to weft in the flat ply [rad].
        middle: node of the start.
        status: what became of each node; 1 where it is there.
        facets: on which they lie.
        places: in the facets [m], shape […, 2].
        warp_leave: direction of the warp segment at its end nearer to the start [rad].
        warp_arrive: … and at the node itself.
        weft_leave: the same of the weft.
        weft_arrive: likewise.
        seen: where searches that failed had come to [m], shape […, 3].
    """

    surface: NetSurface
    spacing: float
    yarn_angle: float
    middle: tuple[int, int]
    status: np.ndarray
    facets: np.ndarray
    places: np.ndarray
    warp_leave: np.ndarray
    warp_arrive: np.ndarray
    weft_leave: np.ndarray
    weft_arrive: np.ndarray
    seen: np.ndarray

    def __repr__(self) -> str:
        return (
            f"{heading(self)}: {self.count} crossovers every {1e3 * self.spacing:.4g} mm, shear up "
            f"to {self.max_shear_deg:.1f}°"
        )

    @cached_property
    def placed(self) -> np.ndarray:
        """Whether each node is there, boolean."""
        return self.status == int(nodes.PLACED)

    @property
    def count(self) -> int:
        """Crossovers that are there."""
        return int(np.count_nonzero(self.placed))

    @cached_property
    def points(self) -> np.ndarray:
        """Crossovers [m], shape […, 3]; zero where there is none (see ``placed``)."""
        points = np.zeros((*self.status.shape, 3))
        there = self.placed
        points[there] = self.surface.in_space(self.facets[there], self.places[there])
        return points

    @cached_property
    def flat_points(self) -> np.ndarray:
        """All nodes in the flat blank, the start at its origin, x along the warp [m], […, 2]."""
        i, j = np.indices(self.status.shape) - np.array(self.middle)[:, None, None]
        weft = np.array([math.cos(self.yarn_angle), math.sin(self.yarn_angle)])
        return self.spacing * (i[..., None] * np.array([1.0, 0.0]) + j[..., None] * weft)

    def within(self, wanted: np.ndarray) -> Net:
        """The same net without the nodes that are not wanted; ``wanted`` is boolean."""
        return replace(self, status=np.where(wanted, self.status, int(nodes.OPEN)))

    @cached_property
    def cells(self) -> np.ndarray:
        """Whether each cell has its four corners and sides, shape [along warp − 1, … − 1]."""
        warp, weft = self.segments
        return warp[:, :-1] & warp[:, 1:] & weft[:-1] & weft[1:]

    @cached_property
    def segments(self) -> tuple[np.ndarray, np.ndarray]:
        """Whether neighbours along the warp, and along the weft, are joined by a yarn segment."""
        ok = self.placed
        warp, weft = ok[:-1] & ok[1:], ok[:, :-1] & ok[:, 1:]
        return warp & ~self._loose("warp"), weft & ~self._loose("weft")

    def _loose(self, family: str) -> np.ndarray:
        """Neighbours that no yarn of a family joins: the yarn ended at a border between them."""
        leave = getattr(self, f"{family}_leave")
        far, _ = self._far(leave, 0 if family == "warp" else 1)
        return np.isnan(far)

    def _far(self, values: np.ndarray, axis: int) -> tuple[np.ndarray, np.ndarray]:
        """Values of each segment along an axis, and the sign in which the net grows there."""
        count, middle = values.shape[axis], self.middle[axis]
        number = np.arange(count - 1)
        at = np.where(number >= middle, number + 1, number)
        sign = np.where(number >= middle, 1, -1)
        return np.take(values, at, axis=axis), np.expand_dims(sign, 1 - axis)

    @cached_property
    def corner_angles(self) -> np.ndarray:
        """Angle from warp to weft at the corners of each cell [rad], shape [cell, cell, 4].

        Of the yarn segments themselves, in the facets of the corners: in the order (0, 0), (1, 0),
        (0, 1), (1, 1).
        """
        warp_near, warp_far = self._ends("warp")
        weft_near, weft_far = self._ends("weft")
        angles = [
            weft_near[:-1] - warp_near[:, :-1],
            weft_near[1:] - warp_far[:, :-1],
            weft_far[:-1] - warp_near[:, 1:],
            weft_far[1:] - warp_far[:, 1:],
        ]
        whole = 2 * math.pi
        return (
            (np.stack(angles, -1) - self.yarn_angle + math.pi) % whole - math.pi + self.yarn_angle
        )

    def _ends(self, family: str) -> tuple[np.ndarray, np.ndarray]:
        """Directions of each segment at its lower and its upper node, both towards the upper."""
        axis = 0 if family == "warp" else 1
        leave, sign = self._far(getattr(self, f"{family}_leave"), axis)
        arrive, _ = self._far(getattr(self, f"{family}_arrive"), axis)
        forth = sign > 0
        return np.where(forth, leave, arrive + math.pi), np.where(forth, arrive, leave + math.pi)

    @cached_property
    def shear_angle(self) -> np.ndarray:
        """Signed shear angle of each cell [rad], the mean over its corners; zero where none is.

        The yarns' own angle at the crossovers, which on a surface that can be unrolled is exact.
        """
        shear = self.yarn_angle - self.corner_angles.mean(axis=-1)
        return np.where(self.cells, shear, 0.0)

    @property
    def max_shear_deg(self) -> float:
        """Largest shear angle either way [deg]."""
        return float(np.degrees(np.abs(self.shear_angle)).max(initial=0.0))

    @cached_property
    def ends(self) -> tuple[NetEnd, ...]:
        """Why the net ends, a reason each, those nearest to the start first."""
        found = []
        i, j = np.indices(self.status.shape)
        i, j = i - self.middle[0], j - self.middle[1]
        for status, reason in REASONS.items():
            at = np.flatnonzero(self.status == status)
            if len(at):
                near = at[np.argmin((np.abs(i) + np.abs(j)).flat[at])]
                node = (int(i.flat[near]), int(j.flat[near]))
                x, y, z = map(float, self.seen.reshape(-1, 3)[near])
                found.append(NetEnd(reason, len(at), node, (x, y, z)))
        return tuple(sorted(found, key=lambda end: sum(map(abs, end.node))))
