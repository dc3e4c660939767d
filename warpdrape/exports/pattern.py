"""The flat plies as a cutter takes them: outlines with axes of the yarns, notches and labels.

The outline is the blank's or, where the part ends before it, what is kept of the formed ply, mapped
back. All in millimetres. Plies lie side by side in their order from the bottom up, each as it was
laid on the table, seen from above. Vertices that lie on a straight piece are left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from warpdrape.blanks.loops import loop_area
from warpdrape.errors import InputError
from warpdrape.exports.cutting import trimmed
from warpdrape.exports.outlines import border_loops, inside, without_straight
from warpdrape.exports.pattern_drawing import write_dxf, write_svg
from warpdrape.exports.trim import MM, Curves, Side, read_trim
from warpdrape.results.read_run import RunReader
from warpdrape.results.result import FormedPly

GAP = 0.1
"""Gap between blanks, as a share of the widest."""
ARM = 0.3
"""Length of an axis either way, over the smaller side of the blank."""
NOTCH = 4.0
"""Length of a notch [mm], or a tenth of the blank's smaller side if that is less."""


@dataclass(frozen=True)
class Pattern:
    """A blank on the sheet [mm].

    Attributes:
        name: the ply's.
        loops: closed outlines, each shape [n, 2]; holes run clockwise.
        axes: ends of the axes of warp and weft, by family, each shape [2, 2].
        notches: cuts from the outline inwards where the axes meet it, from the outline on, each
            shape [2, 2].
        angle: from the x axis to the warp [deg], within ±90°.
        low: lowest corner of the box round it, shape [2].
        high: highest one.
        cut: whether the outline is what is kept of the formed ply, not the blank's.
    """

    name: str
    loops: Sequence[np.ndarray]
    axes: dict[str, np.ndarray]
    notches: Sequence[np.ndarray]
    angle: float
    low: np.ndarray
    high: np.ndarray
    cut: bool = False


def write(
    reader: RunReader,
    out: Path,
    frames: Sequence[int],
    *,
    trim: str | None = None,
    along: str | None = None,
) -> None:
    """Write the flat plies; the frame matters only where they are trimmed.

    Args:
        reader: the run.
        out: the file to write; its ending says the format.
        frames: one number, when the part is cut.
        trim: where the part ends, as `trim.read_trim` takes it; the whole blanks if None.
        along: axis along which curves cut.
    """
    if trim is None and along is not None:
        raise InputError(f"along = {along} goes with trim: say where the part ends")
    flat = reader.result(0).plies
    if trim is None:
        patterns = patterns_of(flat)
    else:
        formed = reader.result(frames[0])
        patterns = patterns_of(flat, formed.plies, read_trim(trim, formed.tools, along))
    {".dxf": write_dxf, ".svg": write_svg}[out.suffix.lower()](out, patterns)


def patterns_of(
    plies: Sequence[FormedPly],
    formed: Sequence[FormedPly] = (),
    trim: Side | Curves | None = None,
) -> list[Pattern]:
    """Lay blanks side by side.

    Args:
        plies: as they are before forming, from the bottom up.
        formed: the same as they are when the part is cut.
        trim: where it is cut; nowhere if None.
    """
    if trim is None:
        every = [_blank(ply) for ply in plies]
    else:
        every = [trimmed(ply, trim) for ply in formed]
    gap = GAP * max(float(np.ptp(np.concatenate(loops)[:, 0])) for loops in every)
    patterns, at = [], 0.0
    for ply, loops in zip(plies, every, strict=True):
        pattern = _pattern(ply, loops, at, cut=trim is not None)
        patterns.append(pattern)
        at = float(pattern.high[0]) + gap
    return patterns


def _blank(ply: FormedPly) -> list[np.ndarray]:
    flat = MM * np.asarray(ply.rest_points)[:, :2]
    return [
        without_straight(flat[loop]) for loop in border_loops(np.asarray(ply.triangles).tolist())
    ]


def _pattern(ply: FormedPly, loops: Sequence[np.ndarray], at: float, *, cut: bool) -> Pattern:
    """A pattern with its left side at x = ``at`` [mm]."""
    corners = np.concatenate(loops)
    low, high = corners.min(axis=0), corners.max(axis=0)
    shift = np.array([at - low[0], 0.0])
    loops = [loop + shift for loop in loops]
    low, high = low + shift, high + shift
    center, side = 0.5 * (low + high), float((high - low).min())
    axes, notches = {}, []
    for family, directions in (("WARP", ply.warp), ("WEFT", ply.weft)):
        along = directions[:, :2].mean(axis=0)
        along /= np.linalg.norm(along)
        axes[family] = np.stack([center - ARM * side * along, center + ARM * side * along])
        notches += _notches(loops, center, along, min(NOTCH, 0.1 * side))
    x, y = axes["WARP"][1] - axes["WARP"][0]
    angle = float(np.degrees(np.arctan2(y, x)))
    angle = round(angle - 180.0 * round(angle / 180.0), 3) + 0.0  # no −0
    return Pattern(ply.name, loops, axes, notches, angle, low, high, cut)


def _notches(
    loops: Sequence[np.ndarray], center: np.ndarray, along: np.ndarray, length: float
) -> list[np.ndarray]:
    """Cuts inwards along an axis where it leaves the outer outline for good, one at either end."""
    outer = max(loops, key=loop_area)
    here, sides = outer - center, np.roll(outer, -1, axis=0) - outer
    turned = np.array([-along[1], along[0]])
    across, slope = here @ turned, sides @ turned
    with np.errstate(divide="ignore", invalid="ignore"):
        share = -across / slope
    met = (share >= 0.0) & (share < 1.0)  # false too where a side runs along the axis
    ways = (here @ along + share * (sides @ along))[met]
    if not len(ways):
        return []
    ends = []
    for way, inwards in ((ways.max(), -1.0), (ways.min(), 1.0)):
        start = center + way * along
        end = start + inwards * length * along
        if inside(0.5 * (start + end)[None], loops)[0]:
            ends.append(np.stack([start, end]))
    return ends
