"""Which triangle a camera sees at each pixel: a small z-buffer, exact where plies lie close."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

_PORTION = 500_000
"""Pixels, or pixels that a triangle may cover, worked on at a time: some 100 MB."""


@dataclass(frozen=True)
class Camera:
    """A perspective camera that looks at a point from afar.

    Args:
        axes: unit vectors to the right, up, and towards the viewer, shape (3, 3).
        target: the point looked at [m], shape (3,).
        distance: from target to eye [m].
        scale: pixels per metre at the target.
        origin: pixel of the target (column, row), shape (2,).
        size: width and height of the image [pixels].
    """

    axes: NDArray[np.float64]
    target: NDArray[np.float64]
    distance: float
    scale: float
    origin: NDArray[np.float64]
    size: tuple[int, int]

    @staticmethod
    def around(
        points: NDArray[np.float64],
        elevation_deg: float,
        azimuth_deg: float,
        width: int,
        *,
        upside_down: bool = False,
    ) -> Camera:
        """Return the camera whose image of ``width`` pixels just holds ``points``.

        Args:
            points: what must be seen [m], shape (n, 3).
            elevation_deg: height of the eye over the horizon [deg].
            azimuth_deg: direction of the eye round z, from x [deg].
            width: of the image [pixels].
            upside_down: turn the object over, so that -z points up.
        """
        e, a = np.radians(elevation_deg), np.radians(azimuth_deg)
        toward = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
        up = np.array([-np.sin(e) * np.cos(a), -np.sin(e) * np.sin(a), np.cos(e)])
        if upside_down:  # half a turn about x, of the camera instead of the object
            toward, up = toward * [1.0, -1.0, -1.0], up * [1.0, -1.0, -1.0]
        axes = np.stack([np.cross(up, toward), up, toward])
        low, high = points.min(axis=0), points.max(axis=0)
        target, reach = (low + high) / 2.0, float(np.linalg.norm(high - low))
        unit = Camera(axes, target, 3.0 * max(reach, 1e-9), 1.0, np.zeros(2), (width, 1))
        seen = unit.project(points)[:, :2]
        low, high = seen.min(axis=0), seen.max(axis=0)
        scale = width / max(high[0] - low[0], 1e-9)
        height = max(int(np.ceil((high[1] - low[1]) * scale)), 1)
        return Camera(axes, target, unit.distance, scale, -low * scale, (width, height))

    def project(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return column, row and depth (less is nearer, linear over the image), shape (n, 3)."""
        right, up, toward = self.axes @ (points - self.target).T
        shrink = 1.0 / (1.0 - toward / self.distance)
        column = self.origin[0] + self.scale * right * shrink
        row = self.origin[1] - self.scale * up * shrink
        return np.stack([column, row, -shrink], axis=1)


@dataclass(frozen=True)
class Visible:
    """What is seen: values per seen pixel, in one order.

    Args:
        pixel: row · width + column, shape (p,).
        triangle: the triangle seen there, shape (p,).
        weight: barycentric weights of its three vertices, shape (p, 3).
        depth: as from `Camera.project`, shape (p,).
    """

    pixel: NDArray[np.int64]
    triangle: NDArray[np.int64]
    weight: NDArray[np.float64]
    depth: NDArray[np.float64]

    def parts(self) -> Iterator[Visible]:
        """Yield the pixels in portions that bound the memory of what is worked out per pixel."""
        for i in range(0, len(self.pixel), _PORTION):
            at = slice(i, i + _PORTION)
            yield Visible(self.pixel[at], self.triangle[at], self.weight[at], self.depth[at])

    def blend(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return values at the pixels from those at their triangle's corners.

        Args:
            values: shape (p, 3 corners, k).
        """
        w = self.weight
        return w[:, :1] * values[:, 0] + w[:, 1:2] * values[:, 1] + w[:, 2:] * values[:, 2]


def find_visible(
    screen: NDArray[np.float64], triangles: NDArray[np.int64], size: tuple[int, int]
) -> Visible:
    """Find the nearest triangle at each pixel's centre.

    Args:
        screen: column, row and depth of the vertices, shape (n, 3).
        triangles: vertex numbers, shape (m, 3).
        size: width and height [pixels].
    """
    width, height = size
    corners = screen[triangles]
    plane, proper = _planes(corners)
    low = np.ceil(corners[:, :, :2].min(axis=1) - 0.5).astype(np.int64)
    high = np.floor(corners[:, :, :2].max(axis=1) - 0.5).astype(np.int64)
    low, high = np.maximum(low, 0), np.minimum(high, [width - 1, height - 1])
    box = np.maximum(high - low + 1, 0)
    count = np.where(proper, box[:, 0] * box[:, 1], 0)
    nearest = np.full(width * height, np.inf)
    owner = np.full(width * height, -1, np.int64)
    ends = np.cumsum(count)
    for first, last in _chunks(ends):
        t = np.repeat(np.arange(first, last), count[first:last])
        local = np.arange(len(t)) + (ends[first] - count[first]) - (ends[t] - count[t])
        row, column = np.divmod(local, box[t, 0])
        row, column = row + low[t, 1], column + low[t, 0]
        one, two, depth = _evaluate(plane[t], column, row)
        inside = (one >= 0.0) & (two >= 0.0) & (one + two <= 1.0)
        t, pixel, depth = t[inside], (row * width + column)[inside], depth[inside]
        np.minimum.at(nearest, pixel, depth)
        wins = depth == nearest[pixel]
        owner[pixel[wins]] = t[wins]
    pixel = np.flatnonzero(owner >= 0)
    t = owner[pixel]
    one, two, depth = _evaluate(plane[t], pixel % width, pixel // width)
    return Visible(pixel, t, np.stack([1.0 - one - two, one, two], axis=1), depth)


def _planes(corners: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Return weight 1, weight 2 and depth as linear functions of the pixel, shape (m, 3, 3)."""
    a, u, v = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    proper = np.abs(area) > 1e-9
    area = np.where(proper, area, 1.0)
    one = np.stack([v[:, 1], -v[:, 0]], axis=1) / area[:, None]
    two = np.stack([-u[:, 1], u[:, 0]], axis=1) / area[:, None]
    slope = one * u[:, 2:] + two * v[:, 2:]
    at_a = np.stack([np.zeros(len(a)), np.zeros(len(a)), a[:, 2]], axis=1)
    slopes = np.stack([one, two, slope], axis=1)
    constant = at_a - np.einsum("mij,mj->mi", slopes, a[:, :2])
    return np.concatenate([constant[:, :, None], slopes], axis=2), proper


def _evaluate(
    plane: NDArray[np.float64], column: NDArray[np.int64], row: NDArray[np.int64]
) -> NDArray[np.float64]:
    x, y = column + 0.5, row + 0.5
    return (plane[:, :, 0] + plane[:, :, 1] * x[:, None] + plane[:, :, 2] * y[:, None]).T


def _chunks(ends: NDArray[np.int64]) -> list[tuple[int, int]]:
    """Return ranges of triangles of about `_PORTION` candidates each."""
    if not len(ends):
        return []
    wanted = np.arange(_PORTION, ends[-1] + _PORTION, _PORTION)
    cuts = np.unique(np.append(np.searchsorted(ends, wanted), [0, len(ends)]))
    cuts = cuts[cuts <= len(ends)]
    return list(zip(cuts[:-1].tolist(), cuts[1:].tolist(), strict=True))
