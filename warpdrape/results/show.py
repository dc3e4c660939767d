"""How a result shows itself: a few lines; in a notebook a table and a picture; and its curves."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from html import escape
from typing import TYPE_CHECKING

import numpy as np

from warpdrape.results.summary_text import ply_rows, tool_rows, verdict

if TYPE_CHECKING:
    from warpdrape.results.figures import Figure
    from warpdrape.results.result import FormedPly, Result

MOST_PLIES = 8
"""Plies that a result shows by itself; `Result.picture` draws all."""
_ENERGIES = ("internal", "kinetic", "friction", "external_work")


def text(result: Result) -> str:
    """Return a result in a few lines: how it ended, and the plies."""
    lines = [f"Result: {verdict(result.summary)}"]
    if not result.completed:
        lines.append(f"  {result.summary['message']}")
    if not _at_the_end(result):
        lines[0] += f"; shown at {1e3 * result.time_s:.4g} ms"
    shown = result.plies[:MOST_PLIES]
    lines += [
        f"  {ply.name}: {len(ply.triangles):,} triangles, shear up to {ply.max_shear_deg:.1f}°"
        for ply in shown
    ]
    if len(result.plies) > len(shown):
        lines.append(f"  … and {len(result.plies) - len(shown)} more plies")
    return "\n".join(lines)


def html(result: Result) -> str:
    """Return a result as a table and a picture."""
    summary = result.summary
    parts = [f"<p><b>{escape(verdict(summary))}</b></p>"]
    words = [f"Warning: {warning}" for warning in summary["warnings"]]
    words = words if result.completed else [summary["message"]]
    if not _at_the_end(result):
        words.append(f"Tables: at the end. Picture: at {1e3 * result.time_s:.4g} ms.")
    parts += [f"<p>{escape(line)}</p>" for line in words]
    parts.append(_table(ply_rows(summary["plies"])))
    if summary["tools"]:
        parts.append(_table(tool_rows(summary["tools"])))
    plies = result.plies[:MOST_PLIES]
    image = base64.b64encode(picture(result, plies, "shear", tools=False)._repr_png_()).decode()
    parts.append(f'<img alt="formed plies, coloured by shear" src="data:image/png;base64,{image}">')
    return "\n".join(parts)


def _at_the_end(result: Result) -> bool:
    return result.frame in (-1, len(result.history["time_s"]) - 1)


def picture(result: Result, plies: Sequence[FormedPly], field: str, *, tools: bool) -> Figure:
    """Draw plies of a result side by side; see `Result.picture`."""
    from warpdrape.errors import InputError
    from warpdrape.results.fields import fields_of
    from warpdrape.results.picture import draw_views
    from warpdrape.results.quantities import QUANTITIES, quantity_named
    from warpdrape.results.tool_distance import TOOL_DISTANCE, ToolDistances
    from warpdrape.results.usd_reader import PlyView, SceneView

    quantity = quantity_named(field)
    surfaces = [(tool.vertices, np.asarray(tool.triangles, np.int64)) for tool in result.tools]
    views = []
    for ply in plies:
        values = {of.primvar: array for of, array in fields_of(ply).items()}
        if quantity.primvar == TOOL_DISTANCE and surfaces:
            placed = [vertices for vertices, _ in surfaces]
            values[TOOL_DISTANCE] = ToolDistances(surfaces).of(ply.points, placed)
        if quantity.primvar not in values:
            there = [name for name, known in QUANTITIES.items() if known.primvar in values]
            raise InputError(
                f"ply {ply.name!r} has no {quantity.title} in this run; it has: {', '.join(there)}"
            )
        shown = quantity.of(values[quantity.primvar])
        triangles = np.asarray(ply.triangles, np.int64)
        views.append(
            PlyView(ply.name, ply.points, ply.rest_points, triangles, ply.warp, ply.weft, shown)
        )
    return draw_views(SceneView(result.time_s, views, surfaces if tools else []), quantity)


def plot(result: Result) -> Figure:
    """Draw forces, shear and energies of a result over time; see `Result.plot`."""
    from warpdrape.results.figures import Figure

    history = result.history
    time = 1e3 * np.asarray(history["time_s"])
    moving = {
        name.removesuffix("_force_n").replace("_", " "): history[name]
        for name in history
        if name.endswith("_force_n")
    }
    shear = {
        ply.name: history[f"{ply.name}_max_shear_deg"]
        for ply in result.plies
        if f"{ply.name}_max_shear_deg" in history
    }
    energies = {
        name.replace("_", " "): history[f"{name}_j"] for name in _ENERGIES if f"{name}_j" in history
    }
    panels = [("force [N]", moving)] if moving else []
    panels.append(("largest shear angle [°]", shear))
    panels += [("energy [J]", energies)] if energies else []
    figure = Figure(figsize=(8.0, 2.5 * len(panels)), layout="constrained")
    axes = figure.subplots(len(panels), sharex=True, squeeze=False)[:, 0]
    for axis, (label, curves) in zip(axes, panels, strict=True):
        _draw_curves(axis, time, label, curves)
    axes[-1].set_xlabel("time [ms]")
    return figure


def _draw_curves(axis, time: np.ndarray, label: str, curves: Mapping[str, np.ndarray]) -> None:
    for name, values in curves.items():
        axis.plot(time, values, lw=1.5, label=name)
    axis.set_ylabel(label)
    axis.grid(alpha=0.3)
    axis.legend(frameon=False, fontsize=8)


def _table(rows: Sequence[tuple[str, ...]]) -> str:
    head, *body = rows
    lines = ["<tr>" + "".join(f"<th>{escape(cell)}</th>" for cell in head) + "</tr>"]
    lines += [
        "<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in body
    ]
    return "<table>" + "".join(lines) + "</table>"
