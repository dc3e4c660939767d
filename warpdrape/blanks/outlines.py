"""The shapes a blank is cut to: rectangle, disc, polygon with holes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
import shapely
from numpy.typing import ArrayLike, NDArray

from warpdrape.blanks.loops import loop_area
from warpdrape.errors import SIZES, InputError, length, numbers, said

Points = NDArray[np.float64]
"""Positions [m], shape [point, 2]."""
Bounds = tuple[float, float, float, float]
"""Lowest x, lowest y, highest x, highest y [m]."""


class Outline(Protocol):
    """What the mesher asks of a shape; equal ones are the same shape, and hash alike."""

    def __hash__(self) -> int: ...

    @property
    def area(self) -> float:
        """Area [m²]."""

    @property
    def bounds(self) -> Bounds:
        """Bounding box [m]."""

    def contains(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Whether each point [m], shape [point, 2], lies inside."""

    def loops(self, edge: float) -> list[Points]:
        """Closed loops of points about ``edge`` [m] apart: outer counter-clockwise, then holes."""


@dataclass(frozen=True)
class Rectangle:
    """A rectangle with its centre at the origin; sizes along x and y [m]."""

    width: float
    height: float

    def __post_init__(self) -> None:
        length("width", self.width)
        length("height", self.height)

    @property
    def area(self) -> float:
        """Area [m²]."""
        return self.width * self.height

    @property
    def bounds(self) -> Bounds:
        """Bounding box [m]."""
        return (-self.width / 2, -self.height / 2, self.width / 2, self.height / 2)

    def contains(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Whether each point [m], shape [point, 2], lies inside."""
        p = np.asarray(points, np.float64)
        return np.all(np.abs(p) <= (self.width / 2, self.height / 2), axis=-1)

    def loops(self, edge: float) -> list[Points]:
        """The four sides, in equal parts of about ``edge`` [m]."""
        x0, y0, x1, y1 = self.bounds
        return [_divide(np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)]), edge)]


@dataclass(frozen=True)
class Disc:
    """A disc with its centre at the origin; radius [m]."""

    radius: float

    def __post_init__(self) -> None:
        length("radius", self.radius)

    @property
    def area(self) -> float:
        """Area [m²]."""
        return math.pi * self.radius**2

    @property
    def bounds(self) -> Bounds:
        """Bounding box [m]."""
        return (-self.radius, -self.radius, self.radius, self.radius)

    def contains(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Whether each point [m], shape [point, 2], lies inside."""
        return np.linalg.norm(np.asarray(points, np.float64), axis=-1) <= self.radius

    def loops(self, edge: float) -> list[Points]:
        """Points on the circle; their number is a multiple of four, so that it is symmetric."""
        count = 4 * max(2, round(math.tau * self.radius / (4.0 * edge)))
        angle = math.tau * np.arange(count) / count
        return [self.radius * np.column_stack([np.cos(angle), np.sin(angle)])]


@dataclass(frozen=True)
class Polygon:
    """A polygon, with holes if any; coordinates as given [m].

    Args:
        points: corners [m], shape [corner, 2], in either sense; not closed by a repeated point.
        holes: the same for each hole; inside the polygon, apart from it and from each other.
    """

    points: Sequence[Sequence[float]]
    holes: Sequence[Sequence[Sequence[float]]] = ()

    def __post_init__(self) -> None:
        outer = _corners("points", self.points)
        scalar = isinstance(self.holes, np.ndarray) and self.holes.ndim == 0
        if scalar or not isinstance(self.holes, Sequence | np.ndarray):
            raise InputError(f"holes = {said(self.holes)} must be a list of outlines")
        holes = [_corners(f"holes[{i}]", hole) for i, hole in enumerate(self.holes)]
        names = ["points", *(f"holes[{i}]" for i in range(len(holes)))]
        loops = [outer, *holes]
        _refuse_crossings(names, loops)
        _refuse_misplaced(names, loops)
        object.__setattr__(self, "points", _as_tuple(outer, ccw=True))
        object.__setattr__(self, "holes", tuple(_as_tuple(hole, ccw=False) for hole in holes))

    @cached_property
    def _shape(self) -> shapely.Polygon:
        shape = shapely.Polygon(self.points, self.holes)
        shapely.prepare(shape)
        return shape

    @property
    def area(self) -> float:
        """Area without the holes [m²]."""
        return float(self._shape.area)

    @property
    def bounds(self) -> Bounds:
        """Bounding box [m]."""
        return self._shape.bounds

    def contains(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Whether each point [m], shape [point, 2], lies inside."""
        x, y = np.moveaxis(np.asarray(points, np.float64), -1, 0)
        return shapely.contains_xy(self._shape, x, y)

    def loops(self, edge: float) -> list[Points]:
        """All corners, the sides between them in equal parts of about ``edge`` [m]."""
        return [_divide(np.array(loop), edge) for loop in (self.points, *self.holes)]


def closed_segments(loops: Sequence[Points]) -> NDArray[np.float64]:
    """Segments [m], shape [segment, 2 ends, 2], of closed loops."""
    return np.concatenate([np.stack([loop, np.roll(loop, -1, axis=0)], axis=1) for loop in loops])


def enclosed(points: Points, segments: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Whether a ray from each point crosses an odd number of the segments.

    Args:
        points: positions [m], shape [point, 2].
        segments: closed loops [m], shape [segment, 2 ends, 2], in any order and sense.
    """
    return windings(points, segments) % 2 == 1


def windings(points: Points, segments: NDArray[np.float64]) -> NDArray[np.int64]:
    """How often closed loops go round each point, counter-clockwise; shape [point].

    Args:
        points: positions [m], shape [point, 2].
        segments: of the loops [m], shape [segment, 2 ends, 2], in any order.
    """
    segments = segments[segments[:, 0, 1] != segments[:, 1, 1]]  # no ray crosses a level one
    lower, upper = segments[:, 0], segments[:, 1]
    swap = lower[:, 1] > upper[:, 1]
    lower, upper = np.where(swap[:, None], upper, lower), np.where(swap[:, None], lower, upper)
    run, up = upper - lower, np.where(swap, -1, 1)
    times = np.zeros(len(points), np.int64)
    step = max(1, 2_000_000 // max(1, len(segments)))
    for start in range(0, len(points), step):
        x, y = points[start : start + step].T
        point, at = np.nonzero((lower[:, 1] <= y[:, None]) & (y[:, None] < upper[:, 1]))
        right = run[at, 0] * (y[point] - lower[at, 1]) > run[at, 1] * (x[point] - lower[at, 0])
        np.add.at(times, start + point[right], up[at[right]])
    return times


def _divide(corners: Points, edge: float) -> Points:
    """Divide every side of a loop into equal parts of about ``edge`` [m]."""
    sides = np.roll(corners, -1, axis=0) - corners
    parts = np.maximum(1, np.rint(np.linalg.norm(sides, axis=1) / edge)).astype(int)
    at = np.repeat(np.arange(len(corners)), parts)
    share = (np.arange(len(at)) - np.repeat(np.cumsum(parts) - parts, parts)) / parts[at]
    return corners[at] + share[:, None] * sides[at]


def _as_tuple(loop: Points, *, ccw: bool) -> tuple[tuple[float, float], ...]:
    turned = loop if (loop_area(loop) > 0.0) == ccw else loop[::-1]
    return tuple((x, y) for x, y in turned.tolist())


def _corners(name: str, values: ArrayLike) -> Points:
    """Return a loop's corners; raise `InputError` where it is none."""
    try:
        loop = numbers(name, values)
    except InputError:
        raise InputError(f"{name} must be pairs of numbers (x, y) [m]") from None
    if loop.ndim != 2 or loop.shape[1] != 2 or not np.isfinite(loop).all():
        raise InputError(f"{name} must be finite pairs (x, y) [m]; it has shape {loop.shape}")
    if np.abs(loop).max(initial=0.0) > SIZES[1]:
        raise InputError(f"{name} reaches {np.abs(loop).max():.4g} m: give metres, as in 300 * mm")
    if len(loop) > 1 and (loop[0] == loop[-1]).all():
        loop = loop[:-1]
    if len(loop) < 3:
        raise InputError(f"{name} has {len(loop)} different points; a polygon needs at least 3")
    repeated = np.flatnonzero((loop == np.roll(loop, -1, axis=0)).all(axis=1))
    if len(repeated):
        raise InputError(f"{name}: corner {repeated[0]} is repeated by the next: remove one")
    return loop


def _refuse_crossings(names: Sequence[str], loops: Sequence[Points]) -> None:
    """Raise `InputError` where two sides, not neighbours in a loop, touch or cross."""
    sides = shapely.linestrings(closed_segments(loops))
    sizes = [len(loop) for loop in loops]
    loop_of, size_of = np.repeat(np.arange(len(loops)), sizes), np.repeat(sizes, sizes)
    corner = np.concatenate([np.arange(size) for size in sizes])
    one, other = shapely.STRtree(sides).query(sides, predicate="intersects")
    gap = corner[other] - corner[one]
    next_to = (loop_of[one] == loop_of[other]) & ((gap == 1) | (gap == size_of[one] - 1))
    met = (one < other) & ~next_to
    if met.any():
        i, j = min(zip(one[met].tolist(), other[met].tolist(), strict=True))
        raise InputError(
            f"polygon: side {corner[i]} of {names[loop_of[i]]} meets side {corner[j]} of "
            f"{names[loop_of[j]]}: sides may share a corner with the next one only"
        )
    for name, loop in zip(names, loops, strict=True):
        if abs(loop_area(loop)) <= 1e-12 * np.ptp(loop, axis=0).max() ** 2:
            raise InputError(f"polygon: {name} encloses no area")
        turns = np.roll(loop, -1, axis=0) - loop
        back = np.roll(turns, -1, axis=0)
        across = turns[:, 0] * back[:, 1] - turns[:, 1] * back[:, 0]
        folded = (across == 0.0) & ((turns * back).sum(axis=1) < 0.0)
        if folded.any():
            corner_at = (int(np.flatnonzero(folded)[0]) + 1) % len(loop)
            raise InputError(f"polygon: {name} folds back on itself at corner {corner_at}")


def _refuse_misplaced(names: Sequence[str], loops: Sequence[Points]) -> None:
    """Raise `InputError` for a hole outside the polygon or inside another hole."""
    outer, *holes = map(shapely.Polygon, loops)
    if not holes:
        return
    for name, hole in zip(names[1:], holes, strict=True):
        if not outer.contains(hole):
            raise InputError(f"polygon: {name} lies outside the outer loop: move or remove it")
    inner, around = shapely.STRtree(holes).query(holes, predicate="within")
    for i, j in zip(inner.tolist(), around.tolist(), strict=True):
        if i != j:
            raise InputError(
                f"polygon: {names[1 + i]} lies inside {names[1 + j]}: remove one of them"
            )
