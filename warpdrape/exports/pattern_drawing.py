"""Patterns as DXF for a cutter and SVG for the eye, in millimetres.

A ply has layers of its own, which a cutter's program tells apart: ``BLANK_`` or ``CUT_`` for the
outline, ``WARP_`` and ``WEFT_`` for the axes, ``NOTCH_``, and ``TEXT_``, each with the ply's name.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING
from xml.sax.saxutils import escape

import numpy as np

from warpdrape.results.pyvista_mesh import needed

if TYPE_CHECKING:
    from warpdrape.exports.pattern import Pattern

COLORS = {"BLANK": 7, "CUT": 7, "WARP": 1, "WEFT": 5, "NOTCH": 6, "TEXT": 8}
"""Of DXF: black or white, red, blue, magenta, grey."""
STROKES = {
    "BLANK": "#1a1d21",
    "CUT": "#1a1d21",
    "WARP": "#c62828",
    "WEFT": "#1565c0",
    "NOTCH": "#ad1457",
}
"""Of SVG."""
LETTER = 0.04
"""Height of the label over the smaller side of the smallest pattern."""


def write_dxf(out: Path, patterns: Sequence[Pattern]) -> None:
    """Write a drawing.

    Args:
        out: the file to write.
        patterns: side by side.
    """
    ezdxf = needed("ezdxf", "dxf")
    drawing = ezdxf.new("R2010", units=ezdxf.units.MM)
    sheet = drawing.modelspace()
    for pattern in patterns:
        outline = _outline(pattern)
        layers = {kind: f"{kind}_{pattern.name}" for kind in (outline, *pattern.axes, "TEXT")}
        if pattern.notches:
            layers["NOTCH"] = f"NOTCH_{pattern.name}"
        for kind, layer in layers.items():
            drawing.layers.add(layer, color=COLORS[kind])
        for loop in pattern.loops:
            sheet.add_lwpolyline(loop.tolist(), close=True, dxfattribs={"layer": layers[outline]})
        for kind, ends in _lines(pattern):
            sheet.add_line(*ends.tolist(), dxfattribs={"layer": layers[kind]})
        size = LETTER * float((pattern.high - pattern.low).min())
        options = {"layer": layers["TEXT"], "height": size}
        place = (float(pattern.low[0]), float(pattern.low[1]) - 2.0 * size)
        sheet.add_text(_label(pattern), dxfattribs=options).set_placement(place)
    drawing.saveas(out)


def write_svg(out: Path, patterns: Sequence[Pattern]) -> None:
    """Write a drawing; see `write_dxf`."""
    low = np.min([pattern.low for pattern in patterns], axis=0)
    high = np.max([pattern.high for pattern in patterns], axis=0)
    letter = LETTER * float(min((pattern.high - pattern.low).min() for pattern in patterns))
    margin = 2.5 * letter
    width, height = high - low + 2.0 * margin
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.6g}mm" height="{height:.6g}mm" '
        f'viewBox="{low[0] - margin:.6g} {-high[1] - margin:.6g} {width:.6g} {height:.6g}" '
        f'fill="none" stroke-width="{0.02 * letter:.3g}">'
    ]
    for pattern in patterns:
        lines += _group(pattern, letter)
    out.write_text("\n".join([*lines, "</svg>"]) + "\n", encoding="utf-8")


def _group(pattern: Pattern, letter: float) -> list[str]:
    lines, outline = [f'<g id="{escape(pattern.name)}">'], _outline(pattern)
    for loop in pattern.loops:
        points = " ".join(f"{_said(x)},{_said(-y)}" for x, y in loop)  # y points down in SVG
        lines.append(f'<polygon class="{outline}" stroke="{STROKES[outline]}" points="{points}"/>')
    for kind, ((x1, y1), (x2, y2)) in _lines(pattern):
        lines.append(
            f'<line class="{kind}" stroke="{STROKES[kind]}" x1="{_said(x1)}" '
            f'y1="{_said(-y1)}" x2="{_said(x2)}" y2="{_said(-y2)}"/>'
        )
    x, y = pattern.low
    lines.append(
        f'<text x="{_said(x)}" y="{_said(-y + 1.5 * letter)}" font-size="{letter:.3g}" '
        f'font-family="sans-serif" fill="{STROKES["WARP"]}">{escape(_label(pattern))}</text>'
    )
    return [*lines, "</g>"]


def _outline(pattern: Pattern) -> str:
    return "CUT" if pattern.cut else "BLANK"


def _lines(pattern: Pattern) -> list[tuple[str, np.ndarray]]:
    """Axes and notches with their kinds."""
    return [*pattern.axes.items(), *(("NOTCH", notch) for notch in pattern.notches)]


def _label(pattern: Pattern) -> str:
    return f"{pattern.name}: warp (red) at {pattern.angle:.4g} deg"


def _said(millimetres: float) -> str:
    """A coordinate to 10 nm, without what rounding leaves of zero."""
    return f"{round(millimetres, 5) + 0.0:.9g}"
