"""Laying out a net: arrays of its nodes, generators first, then row by row."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import warp as wp

from warpdrape.fishnet.net import Net
from warpdrape.fishnet.surface import NetSurface
from warpdrape.kernels.fishnet.facets import Place
from warpdrape.kernels.fishnet.layout import (
    compute_crossovers,
    compute_generators,
    compute_plane_generators,
)
from warpdrape.kernels.fishnet.nodes import Net as NetArrays
from warpdrape.kernels.fishnet.strips import Strips

LEAST_ROOM, ROOM_PER_FACET, MOST_ROOM = 1024, 24, 8192
"""Half-edges that a yarn segment may cross: at least, per mean facet along it, at most."""


@dataclass(frozen=True, eq=False)
class Begin:
    """Where a net begins.

    Attributes:
        facet: of the start.
        place: in it [m], shape [2].
        warp: direction of the warp there, an angle in the facet [rad].
        yarn_angle: from warp to weft in the flat ply [rad].
    """

    facet: int
    place: np.ndarray
    warp: float
    yarn_angle: float = 0.5 * math.pi

    @property
    def halves(self) -> np.ndarray:
        """Directions in which warp forth and back, weft forth and back leave [rad], shape [4]."""
        weft = self.warp + self.yarn_angle
        return np.array([self.warp, self.warp + math.pi, weft, weft + math.pi])


def lay_out(
    surface: NetSurface,
    begin: Begin,
    spacing: float,
    counts: Sequence[int],
    *,
    limit: float,
    turns: np.ndarray | None = None,
    planes: bool = False,
) -> Net:
    """Lay a net on a surface.

    Args:
        surface: to lie on.
        begin: where and how it begins.
        spacing: length of a yarn between crossovers [m].
        counts: crossovers from the start: warp forth and back, weft forth and back.
        limit: largest shear angle [rad].
        turns: of the generators at their nodes, to the left [rad], shape [4, n]; straight if None.
        planes: let the generators run along plane sections instead.
    """
    forth, back, up, down = (int(count) for count in counts)
    shape = (forth + back + 1, up + down + 1)
    middle = wp.vec2i(back, down)
    arrays = _arrays(shape)
    _set_start(arrays, begin, (back, down))
    strips = _strips(surface, spacing)
    start = Place()
    start.facet, start.at = begin.facet, wp.vec2d(*begin.place)
    halves: wp.array = wp.array([forth, back, up, down], dtype=wp.int32, device="cpu")
    if planes:
        normals: wp.array = wp.array(_plane_normals(surface, begin), dtype=wp.vec3d, device="cpu")
        given = [surface.arrays, arrays, middle, start, normals, halves, spacing, strips]
        wp.launch(compute_plane_generators, 4, given, device="cpu")
    else:
        longest = max(forth, back, up, down, 1)
        turns = np.zeros((4, longest)) if turns is None else turns
        angles: wp.array = wp.array(begin.halves, dtype=wp.float64, device="cpu")
        bends: wp.array = wp.array(turns, dtype=wp.float64, device="cpu")
        given = [surface.arrays, arrays, middle, start, angles, halves, bends, spacing, strips]
        wp.launch(compute_generators, 4, given, device="cpu")
    given = [surface.arrays, arrays, middle, spacing, begin.yarn_angle, limit, strips]
    wp.launch(compute_crossovers, 4, given, device="cpu")
    return _net(surface, arrays, spacing, begin, (back, down))


def _arrays(shape: tuple[int, int]) -> NetArrays:
    arrays = NetArrays()
    arrays.status = wp.zeros(shape, dtype=wp.int32, device="cpu")
    arrays.facets = wp.full(shape, -1, dtype=wp.int32, device="cpu")
    arrays.places = wp.zeros(shape, dtype=wp.vec2d, device="cpu")
    for name in ("warp_leave", "warp_arrive", "weft_leave", "weft_arrive"):
        setattr(arrays, name, wp.full(shape, math.nan, dtype=wp.float64, device="cpu"))
    arrays.seen = wp.zeros(shape, dtype=wp.vec3d, device="cpu")
    return arrays


def _set_start(arrays: NetArrays, begin: Begin, middle: tuple[int, int]) -> None:
    arrays.status.numpy()[middle] = 1
    arrays.facets.numpy()[middle] = begin.facet
    arrays.places.numpy()[middle] = begin.place


def _strips(surface: NetSurface, spacing: float) -> Strips:
    """Room for one thread: on the processor they take turns."""
    room = LEAST_ROOM + ROOM_PER_FACET * math.ceil(spacing / surface.edge)
    room = min(room, MOST_ROOM)
    strips = Strips()
    strips.edges = wp.zeros((1, 3, room), dtype=wp.int32, device="cpu")
    strips.counts = wp.zeros((1, 3), dtype=wp.int32, device="cpu")
    strips.left = wp.zeros((1, room), dtype=wp.vec2d, device="cpu")
    strips.right = wp.zeros((1, room), dtype=wp.vec2d, device="cpu")
    return strips


def _plane_normals(surface: NetSurface, begin: Begin) -> np.ndarray:
    """Normals of the planes to the left of each half generator, shape [4, 3]."""
    first, second, _ = surface.frames[begin.facet]
    left = begin.halves + 0.5 * math.pi
    return np.cos(left)[:, None] * first + np.sin(left)[:, None] * second


def _net(
    surface: NetSurface,
    arrays: NetArrays,
    spacing: float,
    begin: Begin,
    middle: tuple[int, int],
) -> Net:
    names = ("status", "facets", "places", "warp_leave", "warp_arrive", "weft_leave", "weft_arrive")
    found = {name: getattr(arrays, name).numpy() for name in (*names, "seen")}
    return Net(surface, spacing, begin.yarn_angle, middle, **found)
