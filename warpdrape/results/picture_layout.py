"""How a picture is set: images in rows, captions, arrows, colour bar, scale bar, a note."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from warpdrape.results.quantities import Quantity
from warpdrape.results.raster import Camera
from warpdrape.results.rendering import SAMPLES, Paint
from warpdrape.results.usd_reader import PlyView
from warpdrape.results.yarn_arrows import yarn_arrows

if TYPE_CHECKING:
    from warpdrape.results.figures import Figure

ABREAST = 4
"""Most plies in a row of a picture of a stack."""
DPI = 160
"""Pixels per inch, which decides how large letters are."""
SCALE_BAR = 0.12
"""Longest scale bar over the picture's width [-]."""
_HEAD, _FOOT, _PAD = 118, 58, 20  # pixels
_INK, _FAINT = "#1a1d21", "#5b6470"
_ARROWS = (("#111111", "#ffffff"), ("#ffffff", "#111111"))  # of warp and weft: inside, rim


@dataclass(frozen=True)
class Frame:
    """What a picture's parts are placed in.

    Attributes:
        width: of the picture [pixels].
        share: pixels of the images over those of the picture, along each side [-].
        camera: of the images.
        note: the line at the foot.
    """

    width: int
    share: float
    camera: Camera
    note: str


def grid(count: int) -> tuple[int, int]:
    """Columns and rows in which so many plies are shown."""
    rows = math.ceil(count / ABREAST)
    return math.ceil(count / rows), rows


def image_width(width: int, plies: int, share: float = 1.0) -> int:
    """Samples across the image of one of so many plies in a picture of ``width`` pixels."""
    return int(share * 0.84 * width / grid(plies)[0]) * SAMPLES


def compose(
    images: Sequence[NDArray[np.float32]], plies: Sequence[PlyView], paint: Paint, frame: Frame
) -> Figure:
    """Set the images in rows, with their captions, one colour bar and one scale bar."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    from warpdrape.results.figures import Figure

    width = frame.width
    tall, wide = (round(pixels / frame.share) for pixels in images[0].shape[:2])
    columns, rows = grid(len(plies))
    height = rows * (_HEAD + tall) + _FOOT
    figure = Figure(figsize=(width / DPI, height / DPI), dpi=DPI)
    FigureCanvasAgg(figure)
    for i, (image, ply) in enumerate(zip(images, plies, strict=True)):
        row, column = divmod(i, columns)
        left, top_edge = _PAD + column * wide, height - row * (_HEAD + tall)
        bottom = (top_edge - _HEAD - tall) / height
        axes = figure.add_axes((left / width, bottom, wide / width, tall / height))
        axes.imshow(image, interpolation="none", aspect="auto")
        axes.set_axis_off()
        if paint.arrows:
            _draw_arrows(axes, ply, frame.camera, image.shape)
        text = (left + _PAD) / width
        name_at, below = (top_edge - 30) / height, (top_edge - 74) / height
        figure.text(text, name_at, ply.name, size=13, weight="bold", color=_INK, va="top")
        caption = _caption(paint.quantity, ply, short=len(plies) > 1)
        figure.text(text, below, caption, size=9.5, color=_FAINT, va="top")
    figure.text(2 * _PAD / width, 22 / height, frame.note, size=8.5, color=_FAINT)
    _draw_scale_bar(figure, frame, height)
    _draw_colour_bar(figure, paint, (_FOOT + 0.5 * tall) / height, min(0.7 * tall, 620) / height)
    return figure


def _draw_arrows(axes: Any, ply: PlyView, camera: Camera, shape: tuple[int, ...]) -> None:
    """Draw arrows along the yarns, so that they go neither out of the image nor change it."""
    arrows = yarn_arrows(ply, camera)
    column, row = arrows.starts.T / SAMPLES - 0.5
    for ways, (inside, rim) in zip(arrows.ways, _ARROWS, strict=True):
        axes.quiver(
            column,
            row,
            *(ways.T / SAMPLES),
            angles="xy",
            scale_units="xy",
            scale=1.0,
            units="dots",
            width=3.0,
            headwidth=4.2,
            headlength=4.6,
            headaxislength=4.2,
            minlength=0.0,
            facecolor=inside,
            edgecolor=rim,
            linewidth=0.5,
        )
    axes.set(xlim=(-0.5, shape[1] - 0.5), ylim=(shape[0] - 0.5, -0.5))


def scale_bar(frame: Frame) -> tuple[float, float]:
    """A round length [m], and how long it is in the middle of the picture [pixels]."""
    metre = frame.camera.scale / SAMPLES / frame.share
    longest = SCALE_BAR * frame.width / metre
    power = 10.0 ** math.floor(math.log10(longest))
    length = power * max(digit for digit in (1.0, 2.0, 5.0) if digit * power <= longest)
    return length, length * metre


def _draw_scale_bar(figure: Figure, frame: Frame, height: float) -> None:
    from matplotlib.lines import Line2D

    length, pixels = scale_bar(frame)
    right, y = (frame.width - 2 * _PAD) / frame.width, 30 / height
    left = right - pixels / frame.width
    ends = 7 / height
    for xs, ys in (
        ((left, right), (y, y)),
        ((left, left), (y - ends, y + ends)),
        ((right, right), (y - ends, y + ends)),
    ):
        figure.add_artist(Line2D(xs, ys, color=_INK, linewidth=1.3))
    text = f"{1e3 * length:g} mm"
    figure.text(left - 8 / frame.width, y, text, size=8.5, color=_INK, ha="right", va="center")


def _draw_colour_bar(figure: Figure, paint: Paint, middle: float, long: float) -> None:
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize
    from matplotlib.ticker import MaxNLocator

    bar = figure.add_axes((0.915, middle - 0.5 * long, 0.016, long))
    scale = figure.colorbar(ScalarMappable(Normalize(paint.bottom, paint.top), "viridis"), cax=bar)
    scale.outline.set_visible(False)
    degrees = paint.quantity.unit == "°"
    scale.ax.yaxis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10], integer=degrees))
    scale.ax.yaxis.set_major_formatter("{x:.0f}°" if degrees else "{x:g}")
    scale.ax.tick_params(length=0, labelsize=9, colors=_INK, pad=5)
    unit = "" if degrees else f"\n{paint.quantity.unit}"
    title = paint.quantity.title.replace(" from ", "\nfrom ")  # so that it is not cut off
    scale.ax.set_title(title + unit, size=9, color=_INK, pad=12)


def _caption(quantity: Quantity, ply: PlyView, *, short: bool) -> str:
    a, b, c = (ply.rest[ply.triangles[:, k]] for k in range(3))
    areas = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return quantity.caption(ply.values, ply.triangles, areas, short=short)
