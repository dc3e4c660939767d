"""A blank's outline from a drawing: curves become sides of the mesh's size, corners stay."""

from __future__ import annotations

import math
import os
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
import shapely
from numpy.typing import ArrayLike, NDArray

from warpdrape.blanks.dxf_curves import WELD, Drawing, layers_of, read_drawing
from warpdrape.blanks.loops import loop_area
from warpdrape.blanks.outlines import Bounds, Points, Polygon
from warpdrape.errors import InputError, numbers, positive

CORNER = math.radians(20.0)
"""Turn at a point of an outline from which on it is a corner [rad]; less is part of a curve."""
FLAT = 1e-6
"""How far the chords of a curve may lie off it [m]: 5° each on a radius of 1 mm."""
LEVEL = 1e-6
"""How far an outline may be from flat [m]."""


@dataclass(frozen=True, eq=False)
class Drawn:
    """An outline with curves, as fine polygons.

    Attributes:
        polygon: the outline and its holes [m].
        source: the drawing.
        unit: of the drawing.
        states_unit: whether the drawing states it itself.
        welded: the largest gap between its curves that was closed [m].
    """

    polygon: Polygon
    source: str
    unit: str
    states_unit: bool
    welded: float

    @property
    def area(self) -> float:
        """Area without the holes [m²]."""
        return self.polygon.area

    @property
    def bounds(self) -> Bounds:
        """Bounding box [m]."""
        return self.polygon.bounds

    def contains(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Whether each point [m], shape [point, 2], lies inside."""
        return self.polygon.contains(points)

    def loops(self, edge: float) -> list[Points]:
        """Points about ``edge`` [m] apart along each curve, all corners among them."""
        return [_resampled(loop, edge) for loop in self._fine]

    @cached_property
    def _fine(self) -> list[Points]:
        return [np.array(loop) for loop in (self.polygon.points, *self.polygon.holes)]

    def centred(self, at: Sequence[float]) -> Drawn:
        """The outline with the middle of its box at a place [m], shape [2]."""
        middle = numbers("centre", at)
        if middle.shape != (2,) or not np.isfinite(middle).all():
            raise InputError(f"centre = {at!r} must be two finite numbers, x and y [m]")
        low, high = np.reshape(self.bounds, (2, 2))
        way = middle - 0.5 * (low + high)
        points, *holes = (loop + way for loop in self._fine)
        return replace(self, polygon=Polygon(points.tolist(), [hole.tolist() for hole in holes]))

    def without_small_holes(self, edge: float) -> Drawn:
        """The outline without holes narrower than the mesh's sides [m], with a warning for them."""
        outer, *holes = self._fine
        wide = [2.0 * math.sqrt(abs(loop_area(hole)) / math.pi) for hole in holes]
        kept = [hole.tolist() for hole, width in zip(holes, wide, strict=True) if width >= edge]
        if len(kept) == len(holes):
            return self
        dropped = ", ".join(
            f"{1e3 * width:.3g} mm at ({1e3 * x:.4g}, {1e3 * y:.4g}) mm"
            for width, (x, y) in zip(wide, (hole.mean(axis=0) for hole in holes), strict=True)
            if width < edge
        )
        warnings.warn(
            f"blank {self.source}: holes narrower than the mesh's sides of {1e3 * edge:.3g} mm are "
            f"left out: {dropped}; give a shorter edge to have them",
            stacklevel=4,
        )
        return replace(self, polygon=Polygon(outer.tolist(), kept))


def read_outline(
    path: str | os.PathLike[str],
    *,
    unit: str | None = None,
    layer: str | None = None,
    weld: float = WELD,
) -> Drawn:
    """Read a blank's outline, with its holes, from a DXF drawing.

    Args:
        path: the drawing.
        unit: "mm", "cm", "m" or "inch" of one that states none.
        layer: the one that is read; None reads all.
        weld: gap between two ends of curves that is closed [m].

    Raises:
        InputError: if it cannot be read, or is not one closed outline with holes.
    """
    file = Path(path)
    if not file.is_file():
        raise InputError(f"blank = {file} does not exist: give a .dxf with the blank's outline")
    positive("weld", weld, unit="m", zero=True)
    drawing = read_drawing("blank", file, flat=FLAT, unit=unit, layer=layer, weld=weld)
    outer, holes = _sorted(file, drawing, layer)
    try:
        polygon = Polygon(outer.tolist(), [hole.tolist() for hole in holes])
    except InputError as error:
        raise InputError(f"blank = {file}: {error}") from None
    return Drawn(polygon, str(file), drawing.unit, drawing.states_unit, drawing.welded)


def _sorted(file: Path, drawing: Drawing, layer: str | None) -> tuple[Points, list[Points]]:
    """The outline, and its holes."""
    if drawing.loose:
        named = "" if layer is not None else f"; layers: {', '.join(layers_of(file))}"
        raise InputError(f"blank = {file}: {drawing.loose}{named}")
    if not drawing.loops:
        raise InputError(
            f"blank = {file} holds no closed curve: it needs a closed polyline, or lines and arcs "
            "that meet"
        )
    heights = np.concatenate([loop[:, 2] for loop in drawing.loops])
    if np.ptp(heights) > LEVEL:
        raise InputError(
            f"blank = {file}: z varies by {1e3 * np.ptp(heights):.3g} mm: draw the blank flat, in "
            "x and y"
        )
    loops = [loop[:, :2] for loop in drawing.loops if len(loop) > 2]
    outer, *holes = sorted(loops, key=lambda loop: -abs(loop_area(loop)))
    around = shapely.Polygon(outer).buffer(1e-9)
    beside = [hole for hole in holes if not around.contains(shapely.Polygon(hole))]
    if beside:
        named = "" if layer is not None else f"; layers: {', '.join(layers_of(file))}"
        raise InputError(
            f"blank = {file} holds {len(beside) + 1} outlines beside each other: leave one, or "
            f"name the layer of one{named}"
        )
    return outer, holes


def _resampled(loop: Points, edge: float) -> Points:
    """Points of a fine closed loop about ``edge`` [m] apart, its corners among them."""
    ways = np.roll(loop, -1, axis=0) - loop
    before = np.roll(ways, 1, axis=0)
    turn = np.arctan2(
        before[:, 0] * ways[:, 1] - before[:, 1] * ways[:, 0], (before * ways).sum(axis=1)
    )
    corners = np.flatnonzero(np.abs(turn) > CORNER)
    steps = np.linalg.norm(ways, axis=1)
    along = np.concatenate([[0.0], np.cumsum(steps)])
    if len(corners) == 0:  # a circle has as many points in each quarter
        wanted = along[-1] * np.linspace(0.0, 1.0, 4 * max(2, round(along[-1] / (4.0 * edge))) + 1)
        return _at(loop, along, wanted[:-1])
    starts = along[corners]
    ends = np.append(starts[1:], starts[0] + along[-1])
    parts = np.maximum(1, np.rint((ends - starts) / edge)).astype(int)
    wanted = np.concatenate(
        [
            start + (end - start) * np.arange(count) / count
            for start, end, count in zip(starts, ends, parts, strict=True)
        ]
    )
    return _at(loop, along, wanted % along[-1])


def _at(loop: Points, along: NDArray[np.float64], wanted: NDArray[np.float64]) -> Points:
    """Places on a closed loop at lengths along it [m]."""
    closed = np.concatenate([loop, loop[:1]])
    return np.column_stack([np.interp(wanted, along, closed[:, k]) for k in (0, 1)])
