"""The image of a formed ply: colour of a quantity, light, lines along yarns, translucent tools."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from warpdrape.defects.wrinkle_field import vertex_normals
from warpdrape.results.quantities import Quantity
from warpdrape.results.raster import Camera, find_visible
from warpdrape.results.usd_reader import PlyView, Surface
from warpdrape.results.yarn_lines import on_blank

SAMPLES = 2
"""Samples along each side of a pixel."""
_LIGHT = np.array([-0.42, 0.62, 0.66])  # right, up, towards the viewer
_LINE_STRENGTH = 0.5
_TOOL_GREY = np.array([0.45, 0.48, 0.52])


@dataclass(frozen=True)
class Paint:
    """How a quantity becomes colour.

    Args:
        quantity: that is shown.
        bottom: its value at the start of the scale.
        top: at its end.
        smooth: blend over the triangles, from the mean at each vertex.
        spacing: of the yarns drawn [m]; 0 for none.
        arrows: draw arrows along the yarns.
    """

    quantity: Quantity
    bottom: float
    top: float
    smooth: bool
    spacing: float
    arrows: bool = False

    def colors_at_corners(self, ply: PlyView) -> NDArray[np.float64]:
        """Return sRGB at each triangle's corners, shape (m, 3, 3)."""
        from matplotlib import colormaps

        if len(ply.values) == len(ply.points):
            at = ply.values[ply.triangles]
        else:
            at = np.repeat(ply.values[:, None], 3, axis=1)
        if self.smooth and len(ply.values) == len(ply.triangles):
            vertices, n = ply.triangles.ravel(), len(ply.points)
            total = np.bincount(vertices, at.ravel(), n)
            at = (total / np.maximum(np.bincount(vertices, minlength=n), 1))[ply.triangles]
        share = (at - self.bottom) / (self.top - self.bottom)
        return colormaps["viridis"](share)[..., :3]


def render(ply: PlyView, tools: list[Surface], camera: Camera, paint: Paint) -> NDArray[np.float32]:
    """Return the image of one ply, shape (height, width, 3), sRGB 0 … 1.

    Args:
        ply: what is drawn.
        tools: drawn over it, translucent.
        camera: of an image of `SAMPLES` times as many pixels along each side.
        paint: colours and lines.
    """
    width, height = camera.size
    image = np.ones((width * height, 3), np.float32)
    depth = np.full(width * height, np.inf)
    seen = find_visible(camera.project(ply.points), ply.triangles, camera.size)
    depth[seen.pixel] = seen.depth
    colors = paint.colors_at_corners(ply)
    normals = vertex_normals(ply.points, ply.triangles) @ camera.axes.T
    along = [on_blank(ply.rest, ply.points, ply.triangles, ways) for ways in (ply.warp, ply.weft)]
    for part in seen.parts():
        corners = ply.triangles[part.triangle]
        color = part.blend(colors[part.triangle])
        if paint.spacing:
            rest = part.blend(ply.rest[corners, :2]) - ply.rest[:, :2].mean(axis=0)
            share = _line_share(rest, along, paint.spacing, 1.0 / camera.scale)
            color = color + (share * _LINE_STRENGTH)[:, None] * (1.0 - color)
        image[part.pixel] = color * _lit(part.blend(normals[corners]))[:, None]
    for points, triangles in tools:
        _lay_over(image, depth, points, triangles, camera)
    blocks = np.clip(image, 0.0, 1.0).reshape(height, width, 3)[: height - height % SAMPLES]
    return blocks.reshape(-1, SAMPLES, width // SAMPLES, SAMPLES, 3).mean(axis=(1, 3))


def _lit(normals: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the brightness of a surface seen from either side; normals in the camera's axes."""
    seen = normals / np.maximum(np.sqrt((normals**2).sum(axis=1)), 1e-300)[:, None]
    seen *= np.where(seen[:, 2:] < 0.0, -1.0, 1.0)
    light = _LIGHT / np.linalg.norm(_LIGHT)
    half = light + np.array([0.0, 0.0, 1.0])
    gloss = np.clip(seen @ (half / np.linalg.norm(half)), 0.0, 1.0) ** 24
    return 0.56 + 0.5 * np.clip(seen @ light, 0.0, 1.0) + 0.1 * gloss


def _line_share(
    rest: NDArray[np.float64],
    along: Sequence[NDArray[np.float64]],
    spacing: float,
    pixel: float,
) -> NDArray[np.float64]:
    """Return how much of each pixel a drawn yarn covers, 0 … 1.

    Args:
        rest: place on the blank, from its centre [m], shape (p, 2).
        along: yarn directions on the blank, each of shape (2,).
        spacing: of the lines [m].
        pixel: width of a pixel [m].
    """
    share = np.zeros(len(rest))
    for direction in along:
        across = rest @ [-direction[1], direction[0]] / spacing
        off = np.abs(across - np.round(across)) * spacing
        share = np.maximum(share, np.clip((0.045 * spacing - off) / pixel + 0.5, 0.0, 1.0))
    return share


def _lay_over(
    image: NDArray[np.floating],
    depth: NDArray[np.floating],
    points: NDArray[np.float64],
    triangles: NDArray[np.int64],
    camera: Camera,
) -> None:
    """Tint ``image`` where a tool is in front of what is there."""
    seen = find_visible(camera.project(points), triangles, camera.size)
    corner = [points[triangles[:, k]] for k in range(3)]
    normals = np.cross(corner[1] - corner[0], corner[2] - corner[0])
    normals = normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    normals = normals @ camera.axes.T
    grazing = 1.0 - np.abs(normals[:, 2])
    front = seen.depth < depth[seen.pixel]
    pixel, triangle = seen.pixel[front], seen.triangle[front]
    alpha = (0.18 + 0.4 * grazing**2)[triangle, None]
    grey = np.clip(_TOOL_GREY * _lit(normals)[:, None], 0.0, 1.0)[triangle]
    image[pixel] = (1.0 - alpha) * image[pixel] + alpha * grey
