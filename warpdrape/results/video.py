"""A run as a film: its picture at every frame, on one scale and by one camera."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warpdrape.errors import InputError, RunFailed
from warpdrape.results.leftovers import STACK
from warpdrape.results.picture import DEFAULT_VIEW, WIDTH, camera_of, drawn, named, paint_of
from warpdrape.results.picture_layout import DPI, image_width
from warpdrape.results.pyvista_mesh import needed
from warpdrape.results.quantities import quantity_named
from warpdrape.results.rendering import Paint
from warpdrape.results.run_folder import write_whole
from warpdrape.results.usd_reader import SceneView, find_scene, read_moments

SHARE = 0.7
"""Pixels of a film over those of a picture, along each side [-]."""
FRAMES_PER_SECOND = 12
"""Pictures that a film shows in a second."""
HOLD_S = 1.5
"""Time for which the last picture stays [s]."""
_QUALITY = 8  # of an MP4, from 0 to 10
_COLOURS = 128  # of a GIF


def draw_video(
    run_folder: str | os.PathLike[str],
    ply: str | None = None,
    *,
    stack: bool = False,
    out: str | os.PathLike[str] | None = None,
    view: tuple[float, float] = DEFAULT_VIEW,
    field: str = "shear",
    tools: bool = False,
    arrows: bool = False,
) -> Path:
    """Draw one ply, or the stack, at every frame; return the film's path.

    Args:
        run_folder: the run folder, or a USD file like the one in it.
        ply: name of the ply; the middle one of the stack when None.
        stack: draw all plies, beside each other.
        out: the MP4 or GIF to write; ``NAME.mp4`` in the run folder when None.
        view: elevation and azimuth of the eye [deg]. A ply that hangs down is turned over.
        field: what to colour by, one of `warpdrape.results.quantities.QUANTITIES`.
        tools: draw the tools, translucent.
        arrows: draw arrows along warp and weft, in place of lines.

    Raises:
        InputError: for a missing run, an unknown ply or quantity, a file that cannot be written, or
            a package that is missing.
    """
    scene_path, quantity = find_scene(run_folder), quantity_named(field)
    if out is not None and Path(out).suffix.lower() not in _WRITERS:
        raise InputError(f"out = {out} must end in .mp4 or .gif")
    moments = read_moments(scene_path, [ply] if ply else None, None, quantity)
    middle = len(moments[0].plies) // 2
    shown = slice(None) if stack else slice(middle, middle + 1)
    name = STACK if stack else moments[0].plies[middle].name
    path = named(scene_path, name, field, ".mp4") if out is None else Path(out)
    write = _WRITERS[path.suffix.lower()]
    package = needed(*_NEEDED[path.suffix.lower()])
    every = [ply for moment in moments for ply in moment.plies[shown]]
    paint = paint_of(quantity, every, None, arrows=arrows)
    pictures = _pictures(moments, shown, view, tools, paint)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, lambda partial: write(package, partial, pictures))
    except (OSError, RunFailed) as error:
        raise InputError(f"out = {path} cannot be written ({error}): give another place") from error
    return path


def _pictures(
    moments: Sequence[SceneView], shown: slice, view: tuple[float, float], tools: bool, paint: Paint
) -> Iterator[NDArray[np.uint8]]:
    """Yield the pictures, shape (height, width, 3), both even; the last one for longer."""
    plies = [moment.plies[shown] for moment in moments]
    surfaces = [moment.tools if tools else [] for moment in moments]
    camera = camera_of(plies, surfaces, view, image_width(WIDTH, len(plies[0]), SHARE))
    picture = np.zeros((2, 2, 3), np.uint8)
    for moment, each, tool in zip(moments, plies, surfaces, strict=True):
        figure = drawn(moment, each, tool, camera, paint, SHARE)
        figure.set_dpi(SHARE * DPI)
        canvas: Any = figure.canvas  # Agg's, as a figure of ours has it
        canvas.draw()
        whole = np.asarray(canvas.buffer_rgba())[..., :3]
        height, width = (size - size % 2 for size in whole.shape[:2])
        picture = np.ascontiguousarray(whole[:height, :width])
        yield picture
    for _ in range(round(HOLD_S * FRAMES_PER_SECOND)):
        yield picture


def _write_mp4(ffmpeg: Any, path: Path, pictures: Iterator[NDArray[np.uint8]]) -> None:
    first = next(pictures)
    size = (first.shape[1], first.shape[0])
    options = {"fps": FRAMES_PER_SECOND, "quality": _QUALITY, "macro_block_size": 2}
    film = ffmpeg.write_frames(str(path), size, codec="libx264", **options)
    film.send(None)
    try:
        film.send(first)
        for picture in pictures:
            film.send(picture)
    finally:
        film.close()


def _write_gif(pillow: Any, path: Path, pictures: Iterator[NDArray[np.uint8]]) -> None:
    images = [
        pillow.fromarray(picture).quantize(_COLOURS, dither=pillow.Dither.NONE)
        for picture in pictures
    ]
    images[0].save(
        path, save_all=True, append_images=images[1:], duration=1000 // FRAMES_PER_SECOND, loop=0
    )


_WRITERS = {".mp4": _write_mp4, ".gif": _write_gif}
_NEEDED = {".mp4": ("imageio_ffmpeg", "video"), ".gif": ("PIL.Image", "video")}
"""Package that writes each, and the extra of ours which brings it."""
