"""A plan of the plies with the places marked where a run is beyond its limits."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from warpdrape.errors import InputError
from warpdrape.results.judgement import Fault, verdict
from warpdrape.results.quantities import QUANTITIES
from warpdrape.results.usd_reader import find_scene, read_scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes

LINE, CHARACTERS = 0.18, 13
"""Height of a line of text [inch], and characters in an inch of it."""
_FAULT, _CREST, _BRIDGE = "#d62728", "white", "#ff9d5c"


def draw_judgement(
    run_folder: Path, summary: Mapping[str, Any], faults: Sequence[Fault], out: Path
) -> Path:
    """Draw each ply's flat blank with shear, crests of wrinkles, bridges, and faults by number.

    Args:
        run_folder: the run folder.
        summary: as in its ``summary.json``.
        faults: what is beyond its limits.
        out: the PNG (or PDF) to write.

    Raises:
        InputError: if it cannot be written.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    scene = read_scene(find_scene(run_folder), None, -1, QUANTITIES["shear"])
    columns = min(len(scene.plies), 4)
    rows, width = -(-len(scene.plies) // columns), max(5.2 * columns, 7.0)
    text = _words(faults, int(CHARACTERS * width))
    below = LINE * (text.count("\n") + 2)
    figure = Figure(figsize=(width, 5.2 * rows + below))
    FigureCanvasAgg(figure)
    axes = figure.subplots(rows, columns, squeeze=False).ravel()
    top = max(QUANTITIES["shear"].scale(ply.values)[1] for ply in scene.plies)
    for at, ply, entry in zip(axes, scene.plies, summary["plies"], strict=False):
        flat = 1e3 * ply.rest[:, :2]
        color = at.tripcolor(*flat.T, ply.triangles, ply.values, cmap="viridis", vmin=0, vmax=top)
        figure.colorbar(color, ax=at, shrink=0.7, label="shear angle [°]")
        at.set(title=entry["name"], aspect="equal", xlabel="x [mm]", ylabel="y [mm]")
        low, high = flat.min(axis=0), flat.max(axis=0)
        rim = 0.04 * (high - low).max()
        at.set(xlim=(low[0] - rim, high[0] + rim), ylim=(low[1] - rim, high[1] + rim))
        _mark(at, entry["name"], entry["defects"], faults)
    for empty in axes[len(scene.plies) :]:
        empty.set_axis_off()
    figure.text(0.02, 0.01, text, size=8.5, va="bottom")
    figure.tight_layout(rect=(0.0, below / figure.get_figheight(), 1.0, 0.98))
    try:
        figure.savefig(out, dpi=130)
    except (OSError, ValueError) as error:
        raise InputError(f"--out {out} cannot be written ({error}): give another place") from error
    return out


def _words(faults: Sequence[Fault], width: int) -> str:
    """What is under the plans: the faults by number, and what the marks mean."""
    lines = [verdict([])] if not faults else []
    for number, fault in enumerate(faults, start=1):
        lines += textwrap.wrap(f"{number}  {fault.words()}", width, subsequent_indent="    ")
    lines.append(
        "flat blanks; white lines: crests of wrinkles, dotted those too short for the mesh;"
    )
    lines.append("squares: bridges, points those too small for the mesh")
    return "\n".join(lines)


def _mark(at: Axes, ply: str, defects: Mapping[str, Any], faults: Sequence[Fault]) -> None:
    """Draw crests and bridges on a plan, and the numbers of its ply's faults."""
    for wrinkle in (defects["wrinkles"] or {"list": ()})["list"]:
        x, y = 1e3 * np.array(wrinkle["on_blank_m"])
        dx, dy = 500.0 * wrinkle["length_m"] * np.array(wrinkle["axis_on_blank"])
        style = "-" if wrinkle["resolved"] else ":"
        at.plot([x - dx, x + dx], [y - dy, y + dy], style, color=_CREST, linewidth=1.2)
    for bridge in defects.get("bridging", {}).get("list", ()):
        mark = "s" if bridge["resolved"] else "."
        at.plot(*(1e3 * np.array(bridge["on_blank_m"])), mark, color=_BRIDGE, fillstyle="none")
    for number, fault in enumerate(faults, start=1):
        if fault.who == ply and fault.on_blank is not None:
            place = 1e3 * np.array(fault.on_blank)
            at.plot(*place, "o", color=_FAULT, markersize=14, fillstyle="none", markeredgewidth=2)
            at.annotate(
                str(number), tuple(place), color=_FAULT, weight="bold", ha="center", va="center"
            )
