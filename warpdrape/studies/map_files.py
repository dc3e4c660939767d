"""Maps as pictures and as a table, a row a place."""

from __future__ import annotations

import csv
import io
from pathlib import Path

import numpy as np
from matplotlib.collections import PolyCollection

from warpdrape.results.figures import Figure
from warpdrape.results.run_folder import write_whole
from warpdrape.studies.maps import QUANTITIES, PlyMap

INK, FAINT = "#1a1d21", "#5b6470"
NOTHING = "#e4e7eb"
"""Colour of places that no run has, or of which nothing is known."""


def draw_map(ply: PlyMap, runs: int) -> Figure:
    """Draw the maps of a ply side by side.

    Args:
        ply: its maps.
        runs: that went into them.
    """
    values = ply.values()
    figure = Figure(figsize=(11.0, 9.4), dpi=110)
    axes = figure.subplots(2, 2)
    for each, (name, words) in zip(axes.flat, QUANTITIES.items(), strict=True):
        _draw(figure, each, ply, values[name], name, words)
    figure.suptitle(f"{ply.name}, {runs} runs, on the flat blank", size=12, color=INK)
    figure.subplots_adjust(0.06, 0.05, 0.94, 0.92, wspace=0.16, hspace=0.22)
    return figure


def _draw(figure: Figure, axes, ply: PlyMap, values: np.ndarray, name: str, words: str) -> None:
    from matplotlib import colormaps

    chance = name.endswith("chance")
    known = np.isfinite(values)
    largest = float(np.abs(values[known]).max()) if known.any() else 0.0
    signed = name == "mean_shear_deg"
    ends = (0.0, 1.0) if chance else (-largest, largest) if signed else (0.0, largest)
    if ends[0] == ends[1]:
        ends = (ends[0], ends[1] + 1.0)
    colours = colormaps["RdBu_r" if signed else "viridis"].with_extremes(bad=NOTHING)
    corners = 1e3 * ply.points[ply.places]
    drawn = PolyCollection(
        corners, array=np.ma.masked_invalid(values), cmap=colours, edgecolors="face", linewidths=0.2
    )
    drawn.set_clim(*ends)
    axes.add_collection(drawn)
    axes.autoscale_view()
    axes.set_aspect("equal")
    axes.set_title(words if known.any() else f"{words}: not known", size=10, color=INK)
    axes.tick_params(labelsize=8, colors=FAINT)
    axes.set_xlabel("x, mm", size=8, color=FAINT)
    axes.set_ylabel("y, mm", size=8, color=FAINT)
    for side in axes.spines.values():
        side.set_visible(False)
    if known.any():
        bar = figure.colorbar(drawn, ax=axes, fraction=0.045, pad=0.03)
        bar.outline.set_visible(False)
        bar.ax.tick_params(length=0, labelsize=8, colors=INK)
        if chance:
            bar.ax.yaxis.set_major_formatter(lambda x, _: f"{100 * x:.0f} %")


def write_map(ply: PlyMap, out: Path) -> None:
    """Write a row a place: its centre on the flat blank, runs, and what maps show.

    Raises:
        RunFailed: when the disk refuses.
    """
    values = ply.values()
    centres = ply.points[ply.places].mean(axis=1)
    columns = {"x_m": centres[:, 0], "y_m": centres[:, 1], "runs": ply.runs.astype(int), **values}
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow(columns)
    cells = [[_cell(v) for v in column.tolist()] for column in columns.values()]
    rows.writerows(zip(*cells, strict=True))
    write_whole(out, lambda p: p.write_text(text.getvalue(), "utf-8", newline="\n"))


def _cell(value: float | int) -> str:
    if isinstance(value, int):
        return str(value)
    return "" if value != value else f"{value:.9g}"
