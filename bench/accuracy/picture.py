"""Picture of errors over time."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from errors import Row

MARKS = "oXD^v<>Phd*p12348H+x|_"
"""Of the ways, in the picture."""
TICKS = (0.05, 0.1, 0.2, 0.5, 1.0)
"""Of the ratios of times."""
LEAST_DRAWN = 3e-3
"""Errors below which there is nothing to draw [deg], [mm]."""


def draw(rows: Sequence[Row], path: Path) -> None:
    """Errors of shear and draw-in over the ratio of times: a colour a case, a mark a way."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.ticker import NullFormatter

    figure = Figure(figsize=(11.0, 5.5), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(1, 2)
    cases, ways = (list(dict.fromkeys(getattr(row, n) for row in rows)) for n in ("case", "way"))
    kinds = (("p95_deg", "scatter_deg", "95th percentile of shear [°]"),)
    kinds += (("draw_in_mm", "scatter_mm", "draw-in, any place [mm]"),)
    for axis, (error, scatter, words) in zip(axes, kinds, strict=True):
        for row in rows:
            if getattr(row, error) > LEAST_DRAWN:
                color, mark = f"C{cases.index(row.case)}", MARKS[ways.index(row.way) % len(MARKS)]
                axis.plot(row.ratio, getattr(row, error), mark, color=color, alpha=0.8)
        for number, case in enumerate(cases):
            widest = max(getattr(row, scatter) or 0.0 for row in rows if row.case == case)
            if widest > LEAST_DRAWN:
                axis.axhline(widest, color=f"C{number}", linestyle=":", linewidth=0.9)
        axis.axhline(0.3, color="black", linewidth=0.8)
        axis.set(xscale="log", yscale="log", xlabel="time over the reference's", ylabel=words)
        axis.set_xticks(TICKS, [f"{tick:g}" for tick in TICKS])
        axis.xaxis.set_minor_formatter(NullFormatter())
        axis.grid(alpha=0.3)
    for number, case in enumerate(cases):
        axes[0].plot([], [], "s", color=f"C{number}", label=case.replace("_", " "))
    for number, way in enumerate(ways):
        axes[0].plot([], [], MARKS[number % len(MARKS)], color="grey", label=way)
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside right upper", fontsize=8)
    figure.suptitle("Errors; dotted what rounding alone does; black 0.3° and 0.3 mm")
    figure.savefig(path, dpi=110)
