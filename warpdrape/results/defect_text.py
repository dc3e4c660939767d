"""Defects of plies in words, a line or two for each."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from typing import Any

from warpdrape.defects.limits import limits_of
from warpdrape.materials.fabric import MOST_FIBRES
from warpdrape.results.judgement import judge, verdict

WIDTH = 96
"""Columns after which a line is folded."""
OF_A_MOULD = 0.1
"""Share of a ply from which on the room between two tools is told [-]: less, as where a punch
passes the edge of an open die, is no mould."""


def defect_lines(plies: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return a paragraph with the defects of all plies, or none where nobody has looked.

    Args:
        plies: entries of ``summary.json``.
    """
    lines = [
        textwrap.fill(f"{ply['name']}: {'; '.join(_parts(ply))}", WIDTH, subsequent_indent="  ")
        for ply in plies
        if "defects" in ply
    ]
    return ["\n".join(lines)] if lines else []


def judgement_lines(summary: Mapping[str, Any]) -> list[str]:
    """Return the verdict by the scene's limits or default ones, for a run with tools that ended."""
    looked = all("defects" in ply for ply in summary["plies"])
    if "not_given" in summary:  # what it cannot show may be there
        return []
    if summary["status"] != "completed" or not summary["tools"] or not looked:
        return []
    faults = judge(summary, {}, limits_of(summary))
    return [verdict(faults) + (" (warpdrape judge marks where)" if faults else "")]


def _parts(ply: Mapping[str, Any]) -> list[str]:
    defects = ply["defects"]
    parts = [] if defects["wrinkles"] is None else [wrinkle_words(defects["wrinkles"])]
    parts += _bridges(defects.get("bridging"))
    parts += [*_shear(defects["shear"]), *_yarns(defects["yarns"])]
    drawn = defects["draw_in"]
    parts.append(f"edge drawn in {_mm(drawn['min_m'])} to {_mm(drawn['max_m'])}")
    parts += [
        f"{own['family']} off {own['name']} by {own['mean_deg']:.1f}° in the mean, up to "
        f"{own['max_deg']:.1f}°"
        for own in defects.get("misalignment", ())
    ]
    if "fibre_volume_fraction" in ply:
        volume = ply["fibre_volume_fraction"]
        words = f"fibre volume {100 * volume['min']:.3g} to {100 * volume['max']:.3g} %"
        if volume["max"] > MOST_FIBRES:
            words += ", more than fits: there the ply has thickened, which its laws do not tell"
        parts.append(words)
    else:
        parts.append("fibre volume unknown: the fabric has no fibre_density")
    return [*parts, *_cavities(defects.get("cavities", ()))]


def _cavities(cavities: Sequence[Mapping[str, Any]]) -> list[str]:
    """What is between two tools, filled; a holder on its flange is no mould."""
    found = []
    for cavity in cavities:
        if cavity["under_force"] or cavity["area_share"] < OF_A_MOULD:
            continue
        thick, volume = cavity["thickness_m"], cavity["fibre_volume_fraction"]
        words = f"between {' and '.join(cavity['tools'])} on {100 * cavity['area_share']:.3g} %: "
        words += f"if filled {_range(1e3 * thick['min'], 1e3 * thick['max'])} mm thick"
        if volume is not None:
            words += f", {_range(100 * volume['min'], 100 * volume['max'])} % fibres"
        found.append(words)
    return found


def _range(least: float, most: float) -> str:
    """Two numbers, or one where they are the same to three digits."""
    ends = (f"{least:.3g}", f"{most:.3g}")
    return ends[0] if ends[0] == ends[1] else " to ".join(ends)


def wrinkle_words(wrinkles: Mapping[str, Any]) -> str:
    """Say how many wrinkles there are, how high, on how much of the ply, and since when."""
    words, short = "no wrinkles", wrinkles["too_short_for_the_mesh"]
    if wrinkles["number"]:
        words = _wrinkled(wrinkles, "wrinkle")
    if short["number"]:
        words += f"; {_wrinkled(short, 'wave')}, too short for the mesh: refine the ply to be sure"
    return words


def _wrinkled(numbers: Mapping[str, Any], noun: str) -> str:
    count = numbers["number"]
    words = (
        f"{count} {noun}{'s' if count > 1 else ''}, the largest of amplitude "
        f"{_mm(numbers['max_amplitude_m'], '.3g')}, on {100 * numbers['area_share']:.2g} % of it"
    )
    first = numbers["first"]
    if first is None:
        return words
    words += f", the first at {1e3 * first['time_s']:.3g} ms"
    moved = {name: way for name, way in first["displacement_m"].items() if abs(way) > 0.0}
    if moved:
        name = max(moved, key=lambda tool: abs(moved[tool]))
        words += f", {name} {_mm(moved[name])}"
    return words


def _bridges(bridging: Mapping[str, Any] | None) -> list[str]:
    if not bridging:
        return []
    found = []
    for resolved, numbers, doubt in (
        (True, bridging, ""),
        (False, bridging["too_small_for_the_mesh"], ", too small for the mesh: it may be its own"),
    ):
        count = numbers["number"]
        if count:
            largest = next(b for b in bridging["list"] if b["resolved"] == resolved)
            found.append(
                f"{count} bridge{'s' if count > 1 else ''}, up to "
                f"{_mm(numbers['max_gap_m'], '.3g')} off {largest['tool']}, "
                f"{1e4 * numbers['area_m2']:.3g} cm² in all{doubt}"
            )
    return found


def _shear(shear: Mapping[str, Any]) -> list[str]:
    if shear["area_share"] is None:
        return []
    if shear["area_share"] == 0.0:
        return ["nowhere past locking"]
    return [
        f"{100 * shear['area_share']:.2g} % past locking at {shear['locking_angle_deg']:.3g}°, by "
        f"up to {shear['max_past_deg']:.2g}°"
    ]


def _yarns(yarns: Mapping[str, Any]) -> list[str]:
    found = []
    for family, own in yarns.items():
        if own["failed_area_share"]:
            found.append(
                f"{family} past its failure strain on {_percent(own['failed_area_share'])}"
            )
        if own["compressed_area_share"] >= 1e-3:
            found.append(
                f"{family} compressed on {_percent(own['compressed_area_share'])}, by up to "
                f"{_percent(-own['min_strain'])}"
            )
    return found


def _mm(length: float, form: str = ".1f") -> str:
    return f"{round(1e3 * length, 3) + 0.0:{form}} mm"


def _percent(share: float) -> str:
    return f"{100 * share:.2g} %"
