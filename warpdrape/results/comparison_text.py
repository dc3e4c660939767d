"""One scene by several approaches as tables for a terminal; "-" is what one does not give."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from typing import Any

from warpdrape.results.comparison import Compared, figures, reference_of
from warpdrape.results.summary_text import WIDTH, duration_text, millimetres, table_text

_LARGEST = "_max_force_n"
_WHOLE = 0.9995
"""Share of a ply that is told as all of it [-]."""


def comparison_text(runs: Sequence[Compared], ply: str) -> str:
    """Return tables of a ply's figures by each approach, and what is to be known of them.

    Args:
        runs: of one scene, the first with a result being that which differences are taken from.
        ply: name of the ply.
    """
    rows = figures(runs, ply)
    parts = [table_text(_shapes(rows, ply)), table_text(_efforts(rows))]
    notes = _notes(runs, rows)
    if notes:
        parts.append("\n".join(textwrap.fill(n, WIDTH, subsequent_indent="  ") for n in notes))
    return "\n\n".join(parts)


def _shapes(rows: Sequence[Mapping[str, Any]], ply: str) -> list[tuple[str, ...]]:
    """Rows of a table of shear and draw-in, its head first."""
    other = next((row["off"] for row in rows if row["off"]), "the first")
    off = (f"off {other}", "95 %")
    table: list[tuple[str, ...]] = [
        (ply, "shear: max", "95 %", *off, "draw-in: warp", "weft", "bias")
    ]
    shear = ("max_shear_deg", "p95_shear_deg", "off_median_shear_deg", "off_p95_shear_deg")
    drawn = ("draw_in_warp_m", "draw_in_weft_m", "draw_in_bias_m")
    for row in rows:
        lengths = (millimetres(row[name]) for name in drawn)
        table.append((row["approach"], *(_degrees(row[name]) for name in shear), *lengths))
    return table


def _efforts(rows: Sequence[Mapping[str, Any]]) -> list[tuple[str, ...]]:
    """Rows of a table of wrinkles, forces, energy and time, its head first."""
    tools = [name for name in rows[0] if name.endswith(_LARGEST)]
    forces = [f"force: {name.removesuffix(_LARGEST)}" for name in tools]
    table = [("approach", "wrinkles", "yarn strain", *forces, "energy error", "time")]
    for row in rows:
        table.append(
            (
                row["approach"],
                _wrinkles(row),
                _strain(row),
                *("-" if row[name] is None else f"{row[name]:.1f} N" for name in tools),
                "-" if row["energy_error"] is None else f"{100 * row['energy_error']:.2g} %",
                "-" if row["wall_s"] is None else duration_text(row["wall_s"]),
            )
        )
    return table


def _degrees(angle: float | None) -> str:
    if angle is None:
        return "-"
    return f"{angle:.1f}°" if angle >= 0.1 or angle == 0.0 else f"{angle:.1g}°"


def _wrinkles(row: Mapping[str, Any]) -> str:
    """How many there are, and how high; waves too short for the mesh are told apart."""
    if row["wrinkles"] is None:
        return "-"
    words = "none"
    if row["wrinkles"]:
        words = f"{row['wrinkles']} to {1e3 * row['wrinkle_amplitude_m']:.2g} mm"
    return f"{words}, {row['short_wrinkles']} short" if row["short_wrinkles"] else words


def _strain(row: Mapping[str, Any]) -> str:
    strains = [row[f"max_strain_{family}"] for family in ("warp", "weft")]
    known = [strain for strain in strains if strain is not None]
    return f"{100 * max(known):.2g} %" if known else "-"


def _notes(runs: Sequence[Compared], rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """What failed, what is not given, what is not compared, and warnings."""
    reference = reference_of(runs)
    notes = [f"{run.approach} has no result: {run.failure}" for run in runs if run.failure]
    if notes and reference not in (None, runs[0]):
        notes.append(f"Differences are from {reference.approach}, the first that has a result.")
    if any(name.endswith(_LARGEST) for name in rows[0]):
        notes.append(
            "Forces are each tool's largest of all frames, strains the larger of both families'."
        )
    for run in runs:
        if "not_given" in run.summary:
            notes.append(f"{run.approach} gives no {', '.join(run.summary['not_given'])}.")
    for row in rows:
        share = row["off_area_share"]
        if share is not None and share < _WHOLE:
            notes.append(
                f"{row['approach']}: {100 * share:.1f} % of its ply has a counterpart in "
                f"{row['off']}, the rest is not compared."
            )
    for run in runs:
        notes += [f"warning: {run.approach}: {words}" for words in run.summary.get("warnings", ())]
    if any(row["short_wrinkles"] for row in rows):
        notes.append("short: waves too short for the mesh; refine the ply to be sure.")
    return notes
