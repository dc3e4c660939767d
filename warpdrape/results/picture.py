"""A picture of a formed ply, coloured by a quantity, drawn from nothing but the run folder."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from warpdrape.errors import InputError, positive
from warpdrape.results.quantities import Quantity, quantity_named
from warpdrape.results.raster import Camera, find_visible, vertex_normals
from warpdrape.results.usd_reader import PlyView, SceneView, Surface, find_scene, read_scene
from warpdrape.results.yarn_lines import on_blank, round_spacing

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WIDTH = 1600
"""Width of every picture [pixels]."""
ABREAST = 4
"""Most plies in a row of a picture of a stack."""
DEFAULT_VIEW = (32.0, -62.0)
"""Elevation and azimuth of the eye [deg]."""
NOTEBOOK = 0.5
"""Pixels of a picture in a notebook over those of one in a file, along each side [-]."""
_DPI = 160
_SAMPLES = 2  # along each side of a pixel
_LIGHT = np.array([-0.42, 0.62, 0.66])  # right, up, towards the viewer
_LINE_STRENGTH = 0.5
_TOOL_GREY = np.array([0.45, 0.48, 0.52])
_INK, _FAINT = "#1a1d21", "#5b6470"


@dataclass(frozen=True)
class _Paint:
    """How a quantity becomes colour.

    Args:
        quantity: that is shown.
        bottom: its value at the start of the scale.
        top: at its end.
        smooth: blend over the triangles, from the mean at each vertex.
        spacing: of the yarns drawn [m]; 0 for none.
    """

    quantity: Quantity
    bottom: float
    top: float
    smooth: bool
    spacing: float

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


def draw_ply(
    run_folder: str | os.PathLike[str],
    ply: str | None = None,
    *,
    frame: int = -1,
    out: str | os.PathLike[str] | None = None,
    view: tuple[float, float] = DEFAULT_VIEW,
    field: str = "shear",
    top: float | None = None,
    yarns: bool = True,
    smooth: bool = True,
    tools: bool = False,
) -> Path:
    """Draw one ply, coloured by its shear angle or another quantity; return the file's path.

    Args:
        run_folder: the run folder, or a USD file like the one in it.
        ply: name of the ply; the middle one of the stack when None.
        frame: which frame; negative ones count from the end.
        out: the PNG (or PDF) to write; ``NAME.png`` in the run folder when None.
        view: elevation and azimuth of the eye [deg]. A ply that hangs down is turned over.
        field: what to colour by, one of `warpdrape.results.quantities.QUANTITIES`.
        top: value at the end of the scale, in the unit shown; from the data when None.
        yarns: draw some of the yarns as lines.
        smooth: colour by the mean round each vertex; else a flat colour per triangle.
        tools: draw the tools, translucent.

    Raises: InputError for a missing run, an unknown ply or quantity, or a frame out of range.
    """
    scene_path, quantity = find_scene(run_folder), quantity_named(field)
    scene = read_scene(scene_path, [ply] if ply else None, frame, quantity)
    middle = scene.plies[len(scene.plies) // 2]
    out = _named(scene_path, middle.name, field) if out is None else Path(out)
    paint = _paint(quantity, [middle], top, smooth, yarns)
    return _draw(scene, [middle], out, view, paint, tools)


def draw_stack(
    run_folder: str | os.PathLike[str],
    *,
    frame: int = -1,
    out: str | os.PathLike[str] | None = None,
    view: tuple[float, float] = DEFAULT_VIEW,
    field: str = "shear",
    top: float | None = None,
    yarns: bool = True,
    smooth: bool = True,
    tools: bool = False,
) -> Path:
    """Draw every ply of the stack beside the others on one scale; return the file's path.

    Arguments and errors as `draw_ply`; ``out`` is ``stack.png`` in the run folder when None.
    """
    scene_path, quantity = find_scene(run_folder), quantity_named(field)
    scene = read_scene(scene_path, None, frame, quantity)
    out = _named(scene_path, "stack", field) if out is None else Path(out)
    paint = _paint(quantity, scene.plies, top, smooth, yarns)
    return _draw(scene, scene.plies, out, view, paint, tools)


def _named(scene_path: Path, name: str, field: str) -> Path:
    """Where a picture goes: shear under the plain name, others with theirs."""
    return scene_path.with_name(f"{name}.png" if field == "shear" else f"{name}_{field}.png")


def draw_views(scene: SceneView, quantity: Quantity) -> Figure:
    """Draw plies and tools as `draw_stack` does, for a notebook's width; return the figure."""
    paint = _paint(quantity, scene.plies, None, smooth=True, yarns=True)
    return _figure(scene, scene.plies, DEFAULT_VIEW, paint, scene.tools, NOTEBOOK)


def _draw(
    scene: SceneView,
    plies: list[PlyView],
    out: Path,
    view: tuple[float, float],
    paint: _Paint,
    tools: bool,
) -> Path:
    figure = _figure(scene, plies, view, paint, scene.tools if tools else [])
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(out, dpi=_DPI, facecolor="white")
    except (OSError, ValueError) as error:
        raise InputError(
            f"out = {out} cannot be written ({error}): give another place, ending in .png"
        ) from error
    return out


def _figure(
    scene: SceneView,
    plies: list[PlyView],
    view: tuple[float, float],
    paint: _Paint,
    surfaces: list[Surface],
    share: float = 1.0,
) -> Figure:
    """Return the figure; its images have ``share`` of the pixels along each side."""
    shown = np.concatenate([p.points for p in plies] + [points for points, _ in surfaces])
    width = int(share * 0.84 * WIDTH / _grid(len(plies))[0]) * _SAMPLES
    camera = Camera.around(shown, *view, width, upside_down=_hangs_down(plies[0]))
    images = [_render(ply, surfaces, camera, paint) for ply in plies]
    return _compose(images, plies, _note(scene, paint, camera), paint, share)


def _paint(
    quantity: Quantity, plies: list[PlyView], top: float | None, smooth: bool, yarns: bool
) -> _Paint:
    bottom, highest = quantity.scale(np.concatenate([ply.values for ply in plies]))
    if top is not None:
        highest = positive("top", top, unit=quantity.unit)
    return _Paint(quantity, bottom, highest, smooth, round_spacing(plies[0].rest) if yarns else 0.0)


def _note(scene: SceneView, paint: _Paint, camera: Camera) -> str:
    """Return the line under the picture: what is shown, and how."""
    parts = [] if np.isnan(scene.time_s) else [f"t = {1e3 * scene.time_s:.1f} ms"]
    if paint.spacing:
        parts.append(f"lines follow the yarns, {1e3 * paint.spacing:g} mm apart on the blank")
    if paint.smooth:
        parts.append("colour averaged at the vertices")
    if paint.quantity.spiky:
        parts.append(f"scale up to {paint.quantity.text(paint.top)}")
    if camera.axes[1, 2] < 0.0:
        parts.append("turned over: z points down")
    return " · ".join(parts)


def _hangs_down(ply: PlyView) -> bool:
    """Say whether the middle of the blank lies clearly below the rest of it."""
    reach = np.linalg.norm(ply.rest - ply.rest.mean(axis=0), axis=1)
    middle = ply.points[reach <= np.quantile(reach, 0.1), 2].mean()
    return bool(np.median(ply.points[:, 2]) - middle > 0.02 * reach.max())


def _render(
    ply: PlyView, tools: list[Surface], camera: Camera, paint: _Paint
) -> NDArray[np.float32]:
    """Return the image of one ply, shape (height, width, 3), sRGB 0 … 1."""
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
    blocks = np.clip(image, 0.0, 1.0).reshape(height, width, 3)[: height - height % _SAMPLES]
    return blocks.reshape(-1, _SAMPLES, width // _SAMPLES, _SAMPLES, 3).mean(axis=(1, 3))


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
    image: NDArray[np.float64],
    depth: NDArray[np.float64],
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


def _compose(
    images: list[NDArray[np.float32]],
    plies: list[PlyView],
    note: str,
    paint: _Paint,
    share: float,
) -> Figure:
    """Set the images in rows, with their captions and one colour bar."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize
    from matplotlib.ticker import MaxNLocator

    from warpdrape.results.figures import Figure

    head, foot, pad = 118, 58, 20  # pixels
    tall, wide = (round(pixels / share) for pixels in images[0].shape[:2])
    columns, rows = _grid(len(plies))
    height = rows * (head + tall) + foot
    figure = Figure(figsize=(WIDTH / _DPI, height / _DPI), dpi=_DPI)
    FigureCanvasAgg(figure)
    for i, (image, ply) in enumerate(zip(images, plies, strict=True)):
        row, column = divmod(i, columns)
        left, top_edge = pad + column * wide, height - row * (head + tall)
        bottom = (top_edge - head - tall) / height
        axes = figure.add_axes((left / WIDTH, bottom, wide / WIDTH, tall / height))
        axes.imshow(image, interpolation="none", aspect="auto")
        axes.set_axis_off()
        text = (left + pad) / WIDTH
        name_at, below = (top_edge - 30) / height, (top_edge - 74) / height
        figure.text(text, name_at, ply.name, size=13, weight="bold", color=_INK, va="top")
        caption = _caption(paint.quantity, ply, short=len(plies) > 1)
        figure.text(text, below, caption, size=9.5, color=_FAINT, va="top")
    figure.text(2 * pad / WIDTH, 22 / height, note, size=8.5, color=_FAINT)
    long = min(0.7 * tall, 620) / height
    middle = (foot + 0.5 * tall) / height
    bar = figure.add_axes((0.915, middle - 0.5 * long, 0.016, long))
    scale = figure.colorbar(ScalarMappable(Normalize(paint.bottom, paint.top), "viridis"), cax=bar)
    scale.outline.set_visible(False)
    degrees = paint.quantity.unit == "°"
    scale.ax.yaxis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10], integer=degrees))
    scale.ax.yaxis.set_major_formatter("{x:.0f}°" if degrees else "{x:g}")
    scale.ax.tick_params(length=0, labelsize=9, colors=_INK, pad=5)
    unit = "" if degrees else f"\n{paint.quantity.unit}"
    scale.ax.set_title(paint.quantity.title + unit, size=9, color=_INK, pad=12)
    return figure


def _grid(count: int) -> tuple[int, int]:
    """Columns and rows in which so many plies are shown."""
    rows = math.ceil(count / ABREAST)
    return math.ceil(count / rows), rows


def _caption(quantity: Quantity, ply: PlyView, *, short: bool) -> str:
    a, b, c = (ply.rest[ply.triangles[:, k]] for k in range(3))
    areas = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return quantity.caption(ply.values, ply.triangles, areas, short=short)
