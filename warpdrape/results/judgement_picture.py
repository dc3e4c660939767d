"""A plan of the plies with the places marked where a run is beyond its limits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from warpdrape.errors import InputError
from warpdrape.results.judgement import Fault
from warpdrape.results.quantities import QUANTITIES
from warpdrape.results.usd_reader import find_scene, read_scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes

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
    rows = -(-len(scene.plies) // columns)
    figure = Figure(figsize=(5.2 * columns, 5.0 * rows + 0.22 * len(faults) + 0.4))
    FigureCanvasAgg(figure)
    axes = figure.subplots(rows, columns, squeeze=False).ravel()
    top = max(QUANTITIES["shear"].scale(ply.values)[1] for ply in scene.plies)
    for at, ply, entry in zip(axes, scene.plies, summary["plies"], strict=False):
        flat = 1e3 * ply.rest[:, :2]
        color = at.tripcolor(*flat.T, ply.triangles, ply.values, cmap="viridis", vmin=0, vmax=top)
        figure.colorbar(color, ax=at, shrink=0.7, label="shear angle [°]")
        at.set(title=entry["name"], aspect="equal", xlabel="x [mm]", ylabel="y [mm]")
        _mark(at, entry["name"], entry["defects"], faults)
    for empty in axes[len(scene.plies) :]:
        empty.set_axis_off()
    lines = [f"{number}  {fault.words()}" for number, fault in enumerate(faults, start=1)]
    text = "\n".join(lines) or "Fit: no defect is beyond its limit"
    figure.text(0.02, 0.01, text, size=8.5, va="bottom")
    figure.tight_layout(rect=(0.0, (0.22 * len(faults) + 0.3) / figure.get_figheight(), 1.0, 1.0))
    try:
        figure.savefig(out, dpi=130)
    except (OSError, ValueError) as error:
        raise InputError(f"--out {out} cannot be written ({error}): give another place") from error
    return out


def _mark(at: Axes, ply: str, defects: Mapping[str, Any], faults: Sequence[Fault]) -> None:
    """Draw crests and bridges on a plan, and the numbers of its ply's faults."""
    for wrinkle in defects["wrinkles"]["list"]:
        x, y = 1e3 * np.array(wrinkle["on_blank_m"])
        dx, dy = 500.0 * wrinkle["length_m"] * np.array(wrinkle["axis_on_blank"])
        style = "-" if wrinkle["resolved"] else ":"
        at.plot([x - dx, x + dx], [y - dy, y + dy], style, color=_CREST, linewidth=1.2)
    for bridge in defects.get("bridging", {}).get("list", ()):
        at.plot(*(1e3 * np.array(bridge["on_blank_m"])), "s", color=_BRIDGE, fillstyle="none")
    for number, fault in enumerate(faults, start=1):
        if fault.who == ply and fault.on_blank is not None:
            place = 1e3 * np.array(fault.on_blank)
            at.plot(*place, "o", color=_FAULT, markersize=14, fillstyle="none", markeredgewidth=2)
            at.annotate(str(number), place, color=_FAULT, weight="bold", ha="center", va="center")
