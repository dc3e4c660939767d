"""Errors of a way to compute a case: means of its runs against those of the reference's."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from one_run import FRAMES


@dataclass(frozen=True)
class Row:
    """Errors of a way of computing a case, largest of its runs' mean over all plies and places.

    Attributes:
        case: its name.
        way: its name.
        runs: so many, for mean and scatter.
        seconds: processor time of the steps, median [s].
        ratio: to the reference's.
        steps: of a run.
        p95_deg: change of the 95th percentile of shear [deg].
        largest_deg: change of the largest shear [deg].
        draw_in_mm: change of the draw-in, in any of eight directions [mm].
        end_force: change of the punch's force while it stands at the end [-].
        force: root mean square change of the punch's force over its way, over the largest [-].
        wrinkle_mm: change of the largest wrinkle amplitude of the run [mm].
        scatter_deg: largest less smallest 95th percentile of one ply among the runs [deg]; None
            for one run.
        scatter_mm: likewise of one draw-in [mm].
        penetration_mm: deepest [mm].
        kinetic: over internal energy while loaded [-].
        softening_strain: strain owed to softer yarns [-].
        said_deg: the runs' own estimate of ``p95_deg``, the smallest; None where they have none.
        said_mm: likewise of ``draw_in_mm``.
    """

    case: str
    way: str
    runs: int
    seconds: float
    ratio: float
    steps: int
    p95_deg: float
    largest_deg: float
    draw_in_mm: float
    end_force: float
    force: float
    wrinkle_mm: float
    scatter_deg: float | None
    scatter_mm: float | None
    penetration_mm: float
    kinetic: float
    softening_strain: float
    said_deg: float | None
    said_mm: float | None


COLUMNS = {
    "case": ("case", "{}"),
    "way": ("way", "{}"),
    "runs": ("runs", "{}"),
    "steps": ("steps", "{:,}"),
    "ratio": ("time", "{:.2f}"),
    "p95_deg": ("95 %", "{:.2f}°"),
    "said_deg": ("said", "{:.2f}°"),
    "scatter_deg": ("scatter", "{:.2f}°"),
    "draw_in_mm": ("draw-in", "{:.2f} mm"),
    "said_mm": ("said", "{:.2f} mm"),
    "scatter_mm": ("scatter", "{:.2f} mm"),
    "largest_deg": ("largest", "{:.2f}°"),
    "force": ("force: way", "{:.1%}"),
    "end_force": ("end", "{:+.0%}"),
    "wrinkle_mm": ("wrinkle", "{:.2f} mm"),
    "kinetic": ("kinetic", "{:.1%}"),
    "softening_strain": ("strain", "{:.2%}"),
    "penetration_mm": ("deepest", "{:.3f} mm"),
}
"""Heading and format of the table's columns."""


def row_of(
    case: str, way: str, runs: Sequence[Mapping], exact: Sequence[Mapping], full: float
) -> Row:
    """Errors of the mean of some runs against the mean of others."""

    def mean(of: Sequence[Mapping], name: str) -> np.ndarray:
        return np.mean([run[name] for run in of], axis=0)

    def error(name: str) -> float:
        return float(np.abs(mean(runs, name) - mean(exact, name)).max())

    def scatter(name: str) -> float | None:
        if len(runs) < 2:
            return None
        return float(np.ptp([run[name] for run in runs], axis=0).max())

    seconds = float(np.median([run["seconds"] for run in runs]))
    said = [run["said"] for run in runs]
    said_deg, said_mm = np.min(said, axis=0).tolist() if None not in said else (None, None)
    end, over = force_errors(runs, exact) if "force" in runs[0] else (0.0, 0.0)
    return Row(
        case=case,
        way=way,
        runs=len(runs),
        seconds=seconds,
        ratio=seconds / full,
        steps=runs[0]["steps"],
        p95_deg=error("p95"),
        largest_deg=error("largest"),
        draw_in_mm=error("draw_in"),
        end_force=end,
        force=over,
        wrinkle_mm=error("wrinkle"),
        scatter_deg=scatter("p95"),
        scatter_mm=scatter("draw_in"),
        penetration_mm=float(mean(runs, "penetration")),
        kinetic=float(mean(runs, "kinetic")),
        softening_strain=float(mean(runs, "strain")),
        said_deg=said_deg,
        said_mm=said_mm,
    )


def force_errors(runs: Sequence[Mapping], exact: Sequence[Mapping]) -> tuple[float, float]:
    """Change of the punch's force at the end, and root mean square over its way [-].

    Forces tremble from frame to frame: over the way both are means over a twentieth of it.
    """
    ends, curves = [], []
    for group in (runs, exact):
        ends.append(np.mean([np.mean(run["force"][-FRAMES // 12 :]) for run in group]))
        curves.append(np.mean([over_way(run) for run in group], axis=0))
    rms = np.sqrt(np.nanmean((curves[0] - curves[1]) ** 2)) / np.nanmax(curves[1])
    return float(ends[0] / ends[1] - 1.0), float(rms)


def over_way(run: Mapping) -> np.ndarray:
    """A punch's force at the middles of twentieths of its way [N], shape [20]."""
    way, force = np.asarray(run["way"]), np.asarray(run["force"])
    moving = np.flatnonzero(way < way[-1] * (1.0 - 1e-6))[-1] + 2
    fine = np.linspace(0.0, way[-1], 401)
    smooth = np.interp(fine, way[:moving], force[:moving])
    return smooth[:-1].reshape(20, 20).mean(axis=1)


def markdown(rows: Sequence[Row]) -> str:
    """The table."""
    lines = [[heading for heading, _ in COLUMNS.values()], ["---"] * len(COLUMNS)]
    lines += [[_cell(getattr(row, n), form) for n, (_, form) in COLUMNS.items()] for row in rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def _cell(value: object, form: str) -> str:
    return "–" if value is None else form.format(value)
