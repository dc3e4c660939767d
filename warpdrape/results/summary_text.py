"""The result in words for the person at the terminal: what ``warpdrape run`` prints at the end."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from warpdrape.results.defect_text import defect_lines, judgement_lines
from warpdrape.results.numerical_error import numerical_error_text
from warpdrape.results.process_clock import process_words
from warpdrape.results.quasi_static import QUASI_STATIC_MEAN
from warpdrape.results.run_folder import COUPON, COUPON_PLOT, HISTORY, RUN, SCENE, SUMMARY

WIDTH = 96
"""Columns after which a line is folded."""
_UNITS = {
    "_deg": (1.0, "°", ".1f"),
    "_mm": (1.0, " mm", ".4g"),
    "_m": (1e3, " mm", ".4g"),
    "_n": (1.0, " N", ".4g"),
    "_n_per_m": (1.0, " N/m", ".4g"),
    "_n_m": (1e3, " N·mm", ".4g"),
    "_j": (1.0, " J", ".4g"),
    "_s": (1e3, " ms", ".4g"),
    "_kg": (1e3, " g", ".4g"),
}
"""Ending of an entry's name → factor, unit and format in which it is shown."""


def summary_text(summary: Mapping[str, Any], folder: Path | None = None) -> str:
    """Return a summary as lines for a terminal, the verdict first.

    Args:
        summary: as in ``summary.json``.
        folder: the run folder.
    """
    parts = [verdict(summary), table_text(ply_rows(summary["plies"]))]
    parts += defect_lines(summary["plies"])
    parts += judgement_lines(summary)
    if summary["tools"]:
        parts.append(table_text(tool_rows(summary["tools"])))
    if summary["interfaces"]:
        parts.append(table_text(interface_rows(summary["interfaces"])))
    parts.append(quality(summary))
    if words := numerical_error_text(summary):
        parts[-1] += "\n" + textwrap.fill(words, WIDTH, subsequent_indent="  ")
    if summary["reported"]:
        parts.append("\n".join(reported_lines(summary)))
    if summary["warnings"]:
        parts.append("\n".join(f"warning: {warning}" for warning in summary["warnings"]))
    if folder is not None:
        parts.append(_files(folder))
    return "\n\n".join(parts)


def verdict(summary: Mapping[str, Any]) -> str:
    """How a run ended, in a line."""
    took = f"{summary['steps']:,} steps, {summary['triangles']:,} triangles"
    took += f", {duration_text(summary['wall_s'])}"
    if "not_given" in summary and summary["status"] == "completed":
        return f"Completed: draped by {summary['approach']} ({took.partition(', ')[2]})"
    if summary["status"] == "completed":
        return f"Completed: {1e3 * summary['simulated_s']:.4g} ms simulated ({took})"
    return (
        f"Failed after {1e3 * summary['simulated_s']:.4g} ms ({took}); "
        "what follows is the last good frame"
    )


def ply_rows(plies: Sequence[Mapping[str, Any]]) -> list[tuple[str, ...]]:
    """Rows of a table of the plies, its head first."""
    rows: list[tuple[str, ...]] = [
        (
            "ply",
            "shear: max",
            "95 %",
            "mean",
            "strain: warp",
            "weft",
            "draw-in: warp",
            "weft",
            "bias",
        )
    ]
    for ply in plies:
        drawn = ply["draw_in_m"]
        rows.append(
            (
                ply["name"],
                f"{ply['max_shear_deg']:.1f}°",
                f"{ply['p95_shear_deg']:.1f}°",
                f"{ply['mean_abs_shear_deg']:.1f}°",
                f"{100 * ply['max_strain_warp']:.3g} %",
                f"{100 * ply['max_strain_weft']:.3g} %",
                *(millimetres(drawn.get(where)) for where in ("warp", "weft", "bias")),
            )
        )
    return rows


def tool_rows(tools: Sequence[Mapping[str, Any]]) -> list[tuple[str, ...]]:
    """Rows of a table of the tools, its head first."""
    rows: list[tuple[str, ...]] = [
        (
            "tool",
            "moved",
            "force: end",
            "largest",
            "deepest in a ply",
            "between vertices",
            "covered",
        )
    ]
    for tool in tools:
        turned = f", {tool['angle_deg']:.1f}°" if "angle_deg" in tool else ""
        rows.append(
            (
                tool["name"],
                f"{1e3 * tool['displacement_m']:.2f} mm{turned}",
                "-" if tool["force_n"] is None else f"{tool['force_n']:.1f} N",
                "-" if tool["max_force_n"] is None else f"{tool['max_force_n']:.1f} N",
                _depth(tool["max_penetration_m"]),
                _depth(tool.get("max_face_penetration_m")),
                f"{100 * tool['coverage']:.0f} %" if "coverage" in tool else "-",
            )
        )
    return rows


def interface_rows(interfaces: Sequence[Mapping[str, Any]]) -> list[tuple[str, ...]]:
    """Rows of a table of what lies between plies, its head first."""
    rows: list[tuple[str, ...]] = [
        ("between plies", "slip: mean", "largest", "pressure: mean", "largest")
    ]
    for pair in interfaces:
        rows.append(
            (
                f"{pair['vertices_of']} on {pair['on']}",
                f"{1e3 * pair['mean_slip_m']:.2f} mm",
                f"{1e3 * pair['max_slip_m']:.2f} mm",
                f"{1e-3 * pair['mean_pressure_pa']:.3g} kPa",
                f"{1e-3 * pair['max_pressure_pa']:.3g} kPa",
            )
        )
    return rows


def _depth(length: float | None) -> str:
    return "-" if length is None else f"{1e3 * length:.3f} mm"


def quality(summary: Mapping[str, Any]) -> str:
    """How far a run can be trusted, in a line."""
    if "not_given" in summary:
        return textwrap.fill(
            f"approach {summary['approach']}, which gives no {', '.join(summary['not_given'])}",
            WIDTH,
        )
    parts = [
        f"energy error {100 * summary['energy_error']:.3g} %",
        _calm(summary) if summary["loaded"] else "no ply was stretched, sheared or bent",
        f"deepest penetration {1e3 * summary['max_penetration_m']:.3f} mm",
    ]
    if summary["added_mass_kg"] > 0.0:
        share = summary["added_mass_kg"] / (summary["mass_kg"] - summary["added_mass_kg"])
        parts.append(f"mass scaling added {100 * share:.3g} % of mass")
    if summary["mass_scaling_order"] > 1:
        ratio = summary["added_mass_kinetic_ratio"]
        parts.append(f"selectively added mass carried {_percent(ratio)} of the internal energy")
    if "kinetic_limit" in summary:
        parts.append(_loading(summary))
    parts += process_words(summary)
    if summary["yarn_softening"] > 1.0:
        words = f"yarns softened {summary['yarn_softening']:.3g} times: strains up to "
        words += f"{100 * summary['softening_strain']:.2g} % too large"
        if "mean_softening_strain" in summary:
            words += f" at the end, {100 * summary['mean_softening_strain']:.2g} % over the run"
        parts.append(words)
    return "; ".join(parts)


def _calm(summary: Mapping[str, Any]) -> str:
    """Whether a run was slow enough, with the share of kinetic energy that says so."""
    words = f"kinetic over internal energy {_percent(summary['kinetic_ratio'])} at the end"
    if summary["quasi_static"]:
        return f"{words}: quasi-static"
    mean = summary.get("kinetic_ratio_loaded", 0.0)
    if mean >= QUASI_STATIC_MEAN:
        words += f", {_percent(mean)} in the mean under load"
    return f"{words}: NOT quasi-static"


def _loading(summary: Mapping[str, Any]) -> str:
    pace = summary["slowest_pace"]
    slowed = f"slowed to {pace:.2g} of their speed" if pace < 1.0 else "not slowed"
    return (
        f"motions {slowed}: kinetic energy at most {summary['kinetic_over_limit']:.2g} times what "
        f"kinetic_limit ({_percent(summary['kinetic_limit'])} of the internal) allows"
    )


def reported_lines(summary: Mapping[str, Any]) -> list[str]:
    """Return what a scene reports about itself, a line each."""
    lines = []
    for name in summary["reported"]:
        value = summary[name]
        if isinstance(value, Mapping):
            inside = ", ".join(" ".join(_entry(*item)) for item in value.items())
            words, text = _words(name), inside
        else:
            words, text = _entry(name, value)
        lines.append(textwrap.fill(f"{words}: {text}", WIDTH, subsequent_indent="  "))
    return lines


def _entry(name: str, value: Any) -> tuple[str, str]:
    """Return the words for a name and its value; the unit is in the name's ending."""
    ending = max((e for e in _UNITS if name.endswith(e)), key=len, default="")
    if ending and isinstance(value, int | float) and not isinstance(value, bool):
        factor, unit, form = _UNITS[ending]
        return _words(name.removesuffix(ending)), f"{factor * value:{form}}{unit}"
    if name.endswith("_error") and isinstance(value, float):
        return _words(name), f"{100 * value:.2g} %"
    if value is None:
        return _words(name.removesuffix(ending)), "never" if "_from_" in name else "none"
    if isinstance(value, Mapping | list) and len(value) > 6:
        return _words(name), f"{len(value)} values, in {SUMMARY}"
    return _words(name), f"{value:.4g}" if isinstance(value, float) else str(value)


def _files(folder: Path) -> str:
    lines = [
        f"Results in {folder}",
        f"  {SCENE:13} the animation, for USD viewers; a picture: warpdrape picture {folder}",
        f"  {HISTORY:13} forces, shear and energies over time",
        f"  {SUMMARY:13} these numbers and more; {RUN} says how to do it again",
    ]
    if (folder / COUPON).is_file():
        lines.append(f"  {COUPON:13} the curve beside its closed form; {COUPON_PLOT} shows it")
    return "\n".join(lines)


def millimetres(length: float | None) -> str:
    """A length in millimetres, "-" for None."""
    return "-" if length is None else f"{round(1e3 * length, 1) + 0.0:.1f} mm"


def _percent(share: float) -> str:
    return f"{100 * share:.2g} %" if share < 1.0 else "above 100 %"


def _words(name: str) -> str:
    return name.replace("_", " ")


def duration_text(seconds: float) -> str:
    """A time in words."""
    if seconds < 60.0:
        return f"{seconds:.1f} s"
    return f"{int(seconds // 60)} min {int(seconds % 60):02d} s"


def table_text(rows: Sequence[tuple[str, ...]]) -> str:
    """Rows as lines, columns under each other, the first to the left."""
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    return "\n".join(
        f"{row[0]:{widths[0]}}  "
        + "  ".join(f"{cell:>{width}}" for cell, width in zip(row[1:], widths[1:], strict=True))
        for row in rows
    )
