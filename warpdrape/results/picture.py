"""A picture of a formed ply, coloured by a quantity, drawn from nothing but the run folder."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from warpdrape.errors import InputError, RunFailed, positive
from warpdrape.results.leftovers import STACK, picture_name
from warpdrape.results.picture_layout import DPI, Frame, compose, image_width
from warpdrape.results.quantities import Quantity, quantity_named
from warpdrape.results.raster import Camera
from warpdrape.results.rendering import Paint, render
from warpdrape.results.run_folder import write_whole
from warpdrape.results.usd_reader import PlyView, SceneView, Surface, find_scene, read_scene
from warpdrape.results.yarn_lines import round_spacing

if TYPE_CHECKING:
    from warpdrape.results.figures import Figure

WIDTH = 1600
"""Width of every picture [pixels]."""
DEFAULT_VIEW = (32.0, -62.0)
"""Elevation and azimuth of the eye [deg]."""
NOTEBOOK = 0.5
"""Pixels of a picture in a notebook over those of one in a file, along each side [-]."""


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
    arrows: bool = False,
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
        arrows: draw arrows along warp and weft, in place of lines.

    Raises: InputError for a missing run, an unknown ply or quantity, or a frame out of range.
    """
    scene_path, quantity = find_scene(run_folder), quantity_named(field)
    scene = read_scene(scene_path, [ply] if ply else None, frame, quantity)
    middle = scene.plies[len(scene.plies) // 2]
    out = named(scene_path, middle.name, field) if out is None else Path(out)
    paint = paint_of(quantity, [middle], top, smooth, yarns, arrows)
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
    arrows: bool = False,
) -> Path:
    """Draw every ply of the stack beside the others on one scale; return the file's path.

    Arguments and errors as `draw_ply`; ``out`` is ``stack.png`` in the run folder when None.
    """
    scene_path, quantity = find_scene(run_folder), quantity_named(field)
    scene = read_scene(scene_path, None, frame, quantity)
    out = named(scene_path, STACK, field) if out is None else Path(out)
    paint = paint_of(quantity, scene.plies, top, smooth, yarns, arrows)
    return _draw(scene, scene.plies, out, view, paint, tools)


def named(scene_path: Path, name: str, field: str, ending: str = ".png") -> Path:
    """Where a picture goes."""
    return scene_path.with_name(picture_name(name, field, ending))


def draw_views(scene: SceneView, quantity: Quantity) -> Figure:
    """Draw plies and tools as `draw_stack` does, for a notebook's width; return the figure."""
    paint = paint_of(quantity, scene.plies, None)
    return _figure(scene, scene.plies, DEFAULT_VIEW, paint, scene.tools, NOTEBOOK)


def _draw(
    scene: SceneView,
    plies: list[PlyView],
    out: Path,
    view: tuple[float, float],
    paint: Paint,
    tools: bool,
) -> Path:
    figure = _figure(scene, plies, view, paint, scene.tools if tools else [])
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        write_whole(out, lambda partial: figure.savefig(partial, dpi=DPI, facecolor="white"))
    except (OSError, ValueError, RunFailed) as error:
        raise InputError(
            f"out = {out} cannot be written ({error}): give another place, ending in .png"
        ) from error
    return out


def _figure(
    scene: SceneView,
    plies: list[PlyView],
    view: tuple[float, float],
    paint: Paint,
    surfaces: list[Surface],
    share: float = 1.0,
) -> Figure:
    """Return the figure; its images have ``share`` of the pixels along each side."""
    camera = camera_of([plies], [surfaces], view, image_width(WIDTH, len(plies), share))
    return drawn(scene, plies, surfaces, camera, paint, share)


def camera_of(
    moments: Sequence[Sequence[PlyView]],
    tools: Sequence[Sequence[Surface]],
    view: tuple[float, float],
    width: int,
) -> Camera:
    """A camera that sees plies and tools at all moments; plies that hang at the last are turned.

    Args:
        moments: plies at each moment.
        tools: that are drawn at each.
        view: elevation and azimuth of the eye [deg].
        width: of the image [samples].
    """
    shown = [ply.points for plies in moments for ply in plies]
    shown += [points for surfaces in tools for points, _ in surfaces]
    turned = hangs_down(moments[-1][0])
    return Camera.around(np.concatenate(shown), *view, width, upside_down=turned)


def drawn(
    scene: SceneView,
    plies: Sequence[PlyView],
    surfaces: list[Surface],
    camera: Camera,
    paint: Paint,
    share: float,
) -> Figure:
    """The figure of plies and tools at one moment, seen by a camera."""
    images = [render(ply, surfaces, camera, paint) for ply in plies]
    note = _note(scene, paint, camera)
    return compose(images, plies, paint, Frame(WIDTH, share, camera, note))


def paint_of(
    quantity: Quantity,
    plies: Sequence[PlyView],
    top: float | None,
    smooth: bool = True,
    yarns: bool = True,
    arrows: bool = False,
) -> Paint:
    """How a quantity of plies, which may be of several moments, becomes colour."""
    bottom, highest = quantity.scale(np.concatenate([ply.values for ply in plies]))
    if top is not None:
        highest = positive("top", top, unit=quantity.unit)
    spacing = round_spacing(plies[0].rest) if yarns and not arrows else 0.0
    return Paint(quantity, bottom, highest, smooth, spacing, arrows)


def _note(scene: SceneView, paint: Paint, camera: Camera) -> str:
    """Return the line under the picture: what is shown, and how."""
    parts = [] if np.isnan(scene.time_s) else [f"t = {1e3 * scene.time_s:.1f} ms"]
    if paint.spacing:
        parts.append(f"lines follow the yarns, {1e3 * paint.spacing:g} mm apart on the blank")
    if paint.arrows:
        parts.append("arrows: warp black, weft white")
    if paint.smooth:
        parts.append("colour averaged at the vertices")
    if paint.quantity.spiky:
        parts.append(f"scale up to {paint.quantity.text(paint.top)}")
    if camera.axes[1, 2] < 0.0:
        parts.append("turned over: z points down")
    return " · ".join(parts)


def hangs_down(ply: PlyView) -> bool:
    """Say whether the middle of the blank lies clearly below the rest of it."""
    reach = np.linalg.norm(ply.rest - ply.rest.mean(axis=0), axis=1)
    middle = ply.points[reach <= np.quantile(reach, 0.1), 2].mean()
    return bool(np.median(ply.points[:, 2]) - middle > 0.02 * reach.max())
