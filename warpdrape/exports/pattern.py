"""The flat blanks as a cutter takes them: outlines with the axes of the yarns, in millimetres.

Plies lie side by side in their order from the bottom up, each as it was laid on the table, seen
from above. Vertices of the mesh that lie on a straight piece of the outline are left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.sax.saxutils import escape

import numpy as np

from warpdrape.results.pyvista_mesh import needed
from warpdrape.results.read_run import RunReader
from warpdrape.results.result import FormedPly

MM = 1e3
"""Millimetres in a metre."""
STRAIGHT = 1e-3
"""Distance from the line between corners below which a vertex is left out [mm]."""
GAP = 0.1
"""Gap between blanks, as a share of the widest."""
ARM = 0.3
"""Length of an axis either way, over the smaller side of the blank."""
_COLORS = {"BLANK": 7, "WARP": 1, "WEFT": 5, "TEXT": 8}  # of DXF: black or white, red, blue, grey
_STROKES = {"BLANK": "#1a1d21", "WARP": "#c62828", "WEFT": "#1565c0"}


@dataclass(frozen=True)
class Pattern:
    """A blank on the sheet [mm].

    Attributes:
        name: the ply's.
        loops: closed outlines, each shape [n, 2]; holes run clockwise.
        axes: ends of the axes of warp and weft, by family, each shape [2, 2].
        angle: from the x axis to the warp [deg], within ±90°.
        low: lowest corner of the box round it, shape [2].
        high: highest one.
    """

    name: str
    loops: Sequence[np.ndarray]
    axes: dict[str, np.ndarray]
    angle: float
    low: np.ndarray
    high: np.ndarray


def write(reader: RunReader, out: Path, frames: Sequence[int]) -> None:
    """Write the flat blanks; the frame does not matter.

    Args:
        reader: the run.
        out: the file to write; its ending says the format.
        frames: of no concern.
    """
    patterns = patterns_of(reader.result(0).plies)
    {".dxf": _write_dxf, ".svg": _write_svg}[out.suffix.lower()](out, patterns)


def patterns_of(plies: Sequence[FormedPly]) -> list[Pattern]:
    """Lay blanks side by side.

    Args:
        plies: as they are before forming, from the bottom up.
    """
    gap = GAP * MM * max(float(np.ptp(ply.rest_points[:, 0])) for ply in plies)
    patterns, at = [], 0.0
    for ply in plies:
        flat = MM * ply.rest_points[:, :2]
        low, high = flat.min(axis=0), flat.max(axis=0)
        shift = np.array([at - low[0], 0.0])
        center = 0.5 * (low + high) + shift
        arm = ARM * float((high - low).min())
        axes = {}
        for family, directions in (("WARP", ply.warp), ("WEFT", ply.weft)):
            along = directions[:, :2].mean(axis=0)
            along *= arm / np.linalg.norm(along)
            axes[family] = np.stack([center - along, center + along])
        x, y = axes["WARP"][1] - axes["WARP"][0]
        loops = [_without_straight(flat[loop]) + shift for loop in _loops(ply.triangles)]
        angle = float(np.degrees(np.arctan2(y, x)))
        angle = round(angle - 180.0 * round(angle / 180.0), 3) + 0.0  # no −0
        patterns.append(Pattern(ply.name, loops, axes, angle, low + shift, high + shift))
        at += float(high[0] - low[0]) + gap
    return patterns


def _loops(triangles: np.ndarray) -> list[np.ndarray]:
    """Vertices of the border, loop by loop, the sheet on their left."""
    ends = np.asarray(triangles)[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    inner = {(b, a) for a, b in ends.tolist()}
    following: dict[int, list[int]] = {}
    for a, b in ends.tolist():
        if (a, b) not in inner:
            following.setdefault(a, []).append(b)
    loops = []
    while following:
        first = vertex = next(iter(following))
        loop = []
        while True:
            loop.append(vertex)
            after = following[vertex]
            vertex = after.pop()
            if not after:
                del following[loop[-1]]
            if vertex == first:
                break
        loops.append(np.array(loop))
    return loops


def _without_straight(loop: np.ndarray) -> np.ndarray:
    """A loop [mm] without the vertices that lie on the line from one corner to the next."""
    first = np.lexsort((loop[:, 1], loop[:, 0]))[0]  # an outermost one, so a corner
    loop = np.roll(loop, -first, axis=0)
    closed = np.concatenate([loop, loop[:1]])
    kept = [0]
    for k in range(1, len(loop)):
        along = closed[k + 1] - closed[kept[-1]]
        to = closed[kept[-1] + 1 : k + 1] - closed[kept[-1]]
        off = np.abs(along[0] * to[:, 1] - along[1] * to[:, 0])
        if (off > STRAIGHT * np.hypot(*along)).any():
            kept.append(k)
    return loop[kept]


def _write_dxf(out: Path, patterns: Sequence[Pattern]) -> None:
    ezdxf = needed("ezdxf", "dxf")
    drawing = ezdxf.new("R2010", units=ezdxf.units.MM)
    sheet = drawing.modelspace()
    for pattern in patterns:
        layers = {kind: f"{kind}_{pattern.name}" for kind in _COLORS}
        for kind, layer in layers.items():
            drawing.layers.add(layer, color=_COLORS[kind])
        for loop in pattern.loops:
            sheet.add_lwpolyline(loop.tolist(), close=True, dxfattribs={"layer": layers["BLANK"]})
        for family, ends in pattern.axes.items():
            sheet.add_line(*ends.tolist(), dxfattribs={"layer": layers[family]})
        size = 0.04 * float((pattern.high - pattern.low).min())
        options = {"layer": layers["TEXT"], "height": size}
        place = (float(pattern.low[0]), float(pattern.low[1]) - 2.0 * size)
        sheet.add_text(_label(pattern), dxfattribs=options).set_placement(place)
    drawing.saveas(out)


def _write_svg(out: Path, patterns: Sequence[Pattern]) -> None:
    low = np.min([pattern.low for pattern in patterns], axis=0)
    high = np.max([pattern.high for pattern in patterns], axis=0)
    letter = 0.04 * float(min((pattern.high - pattern.low).min() for pattern in patterns))
    margin = 2.5 * letter
    width, height = high - low + 2.0 * margin
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.6g}mm" height="{height:.6g}mm" '
        f'viewBox="{low[0] - margin:.6g} {-high[1] - margin:.6g} {width:.6g} {height:.6g}" '
        f'fill="none" stroke-width="{0.02 * letter:.3g}">'
    ]
    for pattern in patterns:
        lines.append(f'<g id="{escape(pattern.name)}">')
        for loop in pattern.loops:
            points = " ".join(f"{x:.7g},{-y:.7g}" for x, y in loop)  # y points down in SVG
            lines.append(f'<polygon class="BLANK" stroke="{_STROKES["BLANK"]}" points="{points}"/>')
        for family, ((x1, y1), (x2, y2)) in pattern.axes.items():
            lines.append(
                f'<line class="{family}" stroke="{_STROKES[family]}" x1="{x1:.7g}" '
                f'y1="{-y1:.7g}" x2="{x2:.7g}" y2="{-y2:.7g}"/>'
            )
        x, y = pattern.low
        lines.append(
            f'<text x="{x:.7g}" y="{-y + 1.5 * letter:.7g}" font-size="{letter:.3g}" '
            f'font-family="sans-serif" fill="{_STROKES["WARP"]}">{escape(_label(pattern))}</text>'
        )
        lines.append("</g>")
    out.write_text("\n".join([*lines, "</svg>"]) + "\n", encoding="utf-8")


def _label(pattern: Pattern) -> str:
    return f"{pattern.name}: warp (red) at {pattern.angle:.4g} deg"
