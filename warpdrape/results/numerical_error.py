"""What the way of computing a run may have cost: an estimate from what the run itself shows.

Every part is a measure of the run times the most that such a measure has cost where it was
compared with a converged run (docs/performance.md): presses with one ply of a dry fabric, on meshes
as fine as their tools ask for. They add up: their signs are not known.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from warpdrape.blanks.ply import Ply, longest_yarn

SOFTENING_SHEAR = math.degrees(5.7)
"""Change of the 95th percentile of shear by a strain owed to softer yarns [deg]: a square box's;
hemispheres, tetrahedron and double dome of 20 cells have 2.1 rad at most."""
SOFTENING_DRAW_IN = 0.65
"""Change of the draw-in by such a strain, over the length of a yarn [-]: that of half of it."""
INERTIA_SHEAR = 16.5
"""Change of the percentile by kinetic over internal energy while loaded [deg]: a double dome's, in
which it is at most 12.5 now."""
INERTIA_DRAW_IN = 0.14
"""Change of the draw-in by it, over the length of a yarn [-]: a double dome's at full stiffness, in
80 ms against 320."""
CONTACT_SHEAR, CONTACT_DRAW_IN = 2000.0, 1.5
"""Changes by a depth to which tools and plies came into each other [deg/m], [-]: a double dome's
and a box's, at one step with contacts of several stiffnesses (bench/contact_stiffness.py)."""


def numerical_error(summary: Mapping[str, Any], plies: Sequence[Ply]) -> dict[str, Any]:
    """Entry of ``summary.json``: how much the percentile of shear and draw-in may be off.

    Args:
        summary: of the run, without this entry.
        plies: flat.

    Returns:
        ``p95_shear_deg`` and ``draw_in_m``, both also by cause in ``softer_yarns``, ``inertia`` and
        ``soft_contact``; or ``not_known``, why there is no estimate.
    """
    if summary["status"] != "completed":
        return {"not_known": "the run failed"}
    if not summary["tools"]:
        return {"not_known": "nothing is pressed"}
    if not summary["quasi_static"]:
        return {"not_known": "not quasi-static"}
    if any(ply.fabric.matrix is not None for ply in plies):
        return {"not_known": "it was measured on dry plies, and a matrix is in these"}
    length = max(longest_yarn(ply) for ply in plies)
    owed = (summary.get(f"{name}softening_strain", 0.0) for name in ("", "mean_"))
    strain, kinetic = max(owed), summary["kinetic_ratio_loaded"]
    depth = summary["max_penetration_m"]
    parts = {
        "softer_yarns": (SOFTENING_SHEAR * strain, SOFTENING_DRAW_IN * strain * length),
        "inertia": (INERTIA_SHEAR * kinetic, INERTIA_DRAW_IN * kinetic * length),
        "soft_contact": (CONTACT_SHEAR * depth, CONTACT_DRAW_IN * depth),
    }
    whole = tuple(sum(part[k] for part in parts.values()) for k in (0, 1))
    return _entry(whole) | {name: _entry(part) for name, part in parts.items()}


def _entry(error: Sequence[float]) -> dict[str, float]:
    return {"p95_shear_deg": float(error[0]), "draw_in_m": float(error[1])}


def numerical_error_text(summary: Mapping[str, Any]) -> str:
    """Say in words what a summary's estimate says; nothing where it has none."""
    if "numerical_error" not in summary:
        return ""
    entry = summary["numerical_error"]
    if "not_known" in entry:
        return f"what the numerics cost is not known: {entry['not_known']}"
    causes = ", ".join(
        f"{name.replace('_', ' ')} {_said(entry[name])}"
        for name in ("softer_yarns", "inertia", "soft_contact")
        if entry[name]["p95_shear_deg"] >= 0.005 or entry[name]["draw_in_m"] >= 5e-6
    )
    words = "numerics: 95 % of shear and draw-in may be off by "
    words += f"{_said(entry)}{f' ({causes})' if causes else ''}"
    if len(summary["plies"]) > 1:
        words += "; rounding alone moves those of a stack by half a degree and a millimetre or more"
    return words


def _said(error: Mapping[str, float]) -> str:
    return f"{error['p95_shear_deg']:.2f}° and {1e3 * error['draw_in_m']:.2f} mm"
