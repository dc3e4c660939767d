"""Arrows along the yarns of a formed ply, for a picture."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from warpdrape.blanks.places import locate
from warpdrape.results.raster import Camera, find_visible
from warpdrape.results.usd_reader import PlyView
from warpdrape.results.yarn_lines import on_blank

ABREAST = 9
"""About how many arrows lie across a blank."""
LENGTH = 0.55
"""Length of an arrow over the distance of their starts [-]."""
_NEAR = 0.01
"""How far behind what is seen an arrow may start and still be drawn, over the ply's size [-]."""


@dataclass(frozen=True)
class Arrows:
    """Arrows that are seen, on the image.

    Attributes:
        starts: column and row [pixels], shape (k, 2).
        ways: of warp and of weft from there [pixels], each shape (k, 2).
    """

    starts: NDArray[np.float64]
    ways: tuple[NDArray[np.float64], NDArray[np.float64]]


def yarn_arrows(ply: PlyView, camera: Camera) -> Arrows:
    """Arrows of warp and weft from even places on the blank, where these are seen.

    Args:
        ply: the ply.
        camera: of the image.
    """
    places, spacing = _even_places(ply)
    found = locate(places, ply.rest[:, :2], ply.triangles)
    on = found.triangles >= 0
    triangles, weights = found.triangles[on], found.weights[on]
    starts = np.einsum("kw,kwx->kx", weights, ply.points[ply.triangles[triangles]])
    seen = _is_seen(ply, starts, camera)
    starts, triangles = starts[seen], triangles[seen]
    at = camera.project(starts)[:, :2]
    warp, weft = (
        camera.project(starts + LENGTH * spacing * directions[triangles])[:, :2] - at
        for directions in (ply.warp, ply.weft)
    )
    return Arrows(at, (warp, weft))


def _even_places(ply: PlyView) -> tuple[NDArray[np.float64], float]:
    """Places on the blank in rows along the warp, and their distance [m]."""
    flat = ply.rest[:, :2]
    spacing = float(np.ptp(flat, axis=0).max()) / ABREAST
    warp = on_blank(ply.rest, ply.points, ply.triangles, ply.warp)
    axes = np.stack([warp, [-warp[1], warp[0]]])
    middle = flat.mean(axis=0)
    reach = int(np.ceil(np.linalg.norm(flat - middle, axis=1).max() / spacing))
    steps = spacing * np.arange(-reach, reach + 1)
    one, two = np.meshgrid(steps, steps, indexing="ij")
    return middle + np.stack([one.ravel(), two.ravel()], axis=1) @ axes, spacing


def _is_seen(ply: PlyView, starts: NDArray[np.float64], camera: Camera) -> NDArray[np.bool_]:
    """Whether no part of the ply lies before a point of it, shape (k,)."""
    width, height = camera.size
    depth = np.full(width * height, np.inf)
    seen = find_visible(camera.project(ply.points), ply.triangles, camera.size)
    depth[seen.pixel] = seen.depth
    column, row, own = camera.project(starts).T
    column = np.clip(column.astype(np.int64), 0, width - 1)
    row = np.clip(row.astype(np.int64), 0, height - 1)
    near = _NEAR * float(np.ptp(ply.points, axis=0).max()) / camera.distance
    return own <= depth[row * width + column] + near
