"""One scene by several approaches: the figures of each, side by side, and the file of them.

What an approach does not give is None: an empty cell, never zero.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from warpdrape.results.read_run import read_run
from warpdrape.results.result import FormedPly
from warpdrape.results.run_folder import as_json, write_whole
from warpdrape.results.shear_difference import shear_difference

COMPARISON_TABLE = "comparison.csv"
"""File of the figures, in the folder that holds the runs."""


@dataclass(frozen=True, eq=False)
class Compared:
    """A scene by one approach.

    Attributes:
        approach: its name.
        folder: of the run.
        failure: why there is no result; empty where there is one.
        summary: as in ``summary.json``; empty where there is no result.
        plies: as formed; none where there is no result.
    """

    approach: str
    folder: Path
    failure: str = ""
    summary: Mapping[str, Any] = field(default_factory=dict)
    plies: Sequence[FormedPly] = ()

    @property
    def completed(self) -> bool:
        """Whether there is a result."""
        return not self.failure

    def formed(self, name: str) -> FormedPly | None:
        """The ply of a name; None where there is none."""
        return next((ply for ply in self.plies if ply.name == name), None)


def read_compared(approach: str, folder: Path) -> Compared:
    """Read a finished run; raise `InputError` where the folder is none, or damaged."""
    run = read_run(folder)
    return Compared(approach, folder, "", run.summary, run.plies)


def reference_of(runs: Sequence[Compared]) -> Compared | None:
    """The run from which differences are taken: the first that has a result."""
    return next((run for run in runs if run.completed), None)


def figures(runs: Sequence[Compared], ply: str) -> list[dict[str, Any]]:
    """Figures of one ply and its run, for each approach: name with its unit → value in SI.

    Args:
        runs: of one scene.
        ply: name of the ply.
    """
    tools = list(dict.fromkeys(t["name"] for run in runs for t in run.summary.get("tools", ())))
    reference = reference_of(runs)
    return [
        {
            "approach": run.approach,
            "status": "completed" if run.completed else "failed",
            "ply": ply,
            **_of_ply(run, ply),
            **_off(run, reference, ply),
            **_of_run(run, tools),
            "message": run.failure or run.summary["message"],
        }
        for run in runs
    ]


def _of_ply(run: Compared, name: str) -> dict[str, float | None]:
    """Shear, strain, draw-in and wrinkles of a ply."""
    plies = run.summary.get("plies", ())
    entry: Mapping[str, Any] = next((each for each in plies if each["name"] == name), {})
    drawn = entry.get("draw_in_m", {})
    wrinkles = entry.get("defects", {}).get("wrinkles") or {}
    short = wrinkles.get("too_short_for_the_mesh", {})
    shear = ("max_shear_deg", "p95_shear_deg", "mean_abs_shear_deg")
    return {
        **{key: entry.get(key) for key in shear},
        **{key: entry.get(key) for key in ("max_strain_warp", "max_strain_weft")},
        **{f"draw_in_{way}_m": drawn.get(way) for way in ("warp", "weft", "bias")},
        "wrinkles": wrinkles.get("number"),
        "wrinkle_amplitude_m": wrinkles.get("max_amplitude_m"),
        "short_wrinkles": short.get("number"),
        "short_wrinkle_amplitude_m": short.get("max_amplitude_m"),
    }


def _off(run: Compared, reference: Compared | None, name: str) -> dict[str, Any]:
    """Differences of shear from the first run; of that run itself none."""
    own = run.formed(name)
    other = None if reference is None or reference is run else reference.formed(name)
    off = None if own is None or other is None else shear_difference(own, other)
    return {
        "off": None if off is None or reference is None else reference.approach,
        "off_median_shear_deg": None if off is None else off.median_deg,
        "off_p95_shear_deg": None if off is None else off.p95_deg,
        "off_area_share": None if off is None else off.share,
    }


def _of_run(run: Compared, tools: Sequence[str]) -> dict[str, Any]:
    """Forces, energy error and effort of a run."""
    largest = {tool["name"]: tool.get("max_force_n") for tool in run.summary.get("tools", ())}
    at_end = {tool["name"]: tool.get("force_n") for tool in run.summary.get("tools", ())}
    effort = ("energy_error", "steps", "wall_s", "triangles")
    found = {key: run.summary.get(key) for key in effort}
    if "not_given" in run.summary and not found["steps"]:
        found["steps"] = None  # such an approach takes none
    forces = {}
    for tool in tools:
        forces[f"{tool}_max_force_n"] = largest.get(tool)
        forces[f"{tool}_force_n"] = at_end.get(tool)
    return {**forces, **found, "warnings": _count(run.summary.get("warnings"))}


def _count(entries: Sequence[str] | None) -> int | None:
    return None if entries is None else len(entries)


def write_figures(runs: Sequence[Compared], plies: Sequence[str], out: Path) -> Path:
    """Write the figures of every ply as CSV, a row for each ply and approach; return the file.

    Raises:
        RunFailed: if the disk refuses.
    """
    rows = [row for ply in plies for row in figures(runs, ply)]
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(rows[0])
    for row in rows:
        table.writerow([as_json(value, f"{out.name}: {key}") for key, value in row.items()])
    write_whole(out, lambda partial: partial.write_text(text.getvalue(), "utf-8", newline="\n"))
    return out
