"""What a net's run has as its result: plies, a row of the history, the summary.

What a net cannot give, such as forces, is left out: None, an empty cell, an empty array; never
zero.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from warpdrape.blanks.ply import Ply
from warpdrape.blanks.triangles import area_percentile, yarn_gradients
from warpdrape.defects.limits import limits_entry
from warpdrape.fishnet.net import Net
from warpdrape.fishnet.stack import Draped
from warpdrape.results.defects import defect_entries
from warpdrape.results.draw_in import draw_in
from warpdrape.results.history import tool_angles, tool_axis, tool_ways
from warpdrape.results.result import FormedPly
from warpdrape.results.snapshot import yarn_state
from warpdrape.results.summary import closing_words
from warpdrape.setup import Setup
from warpdrape.tools.pose import Pose

NOT_GIVEN = ("forces", "tensions", "pressures", "friction", "slip", "energies", "wrinkles")
"""What a net has not: it knows lengths and a surface only."""
ENERGIES = ("kinetic", "internal", "friction", "damping", "contact", "external_work")


def formed_ply(ply: Ply, draped: Draped, flat: bool) -> FormedPly:
    """A ply, flat or draped, with what its shape says of its yarns."""
    whole = draped.flat_points if flat else draped.points
    points = whole if len(whole) == len(ply.mesh.vertices) else whole[_used(draped)]
    triangles = np.asarray(ply.mesh.triangles)
    gradients, _ = yarn_gradients(ply.mesh.vertices, triangles, *ply.yarn_directions)
    warp, weft, shear = yarn_state(points, triangles, gradients, ply.fabric.yarn_angle)
    return FormedPly(
        ply.name,
        ply.rest_points,
        points,
        triangles,
        warp,
        weft,
        shear,
        strain=np.zeros((len(triangles), 2)),  # yarns of a net do not stretch
        line_tension=None,
    )


def _used(draped: Draped) -> np.ndarray:
    kept = draped.triangles[draped.covered[draped.triangles].all(axis=1)]
    return np.unique(kept)


def history_row(
    scene: Setup, at: float, plies: Sequence[FormedPly], poses: Sequence[Pose]
) -> dict[str, float | None]:
    """One row of ``history.csv``; None where a net has no such quantity."""
    row: dict[str, float | None] = {"time_s": at}
    angles = tool_angles(scene, at)
    for tool, way, angle in zip(scene.tools, tool_ways(scene, poses), angles, strict=True):
        row[f"{tool.name}_displacement_m"] = float(way @ tool_axis(tool, scene))
        row[f"{tool.name}_force_n"] = None
        if angle is not None:
            row[f"{tool.name}_angle_deg"] = math.degrees(angle)
            row[f"{tool.name}_torque_nm"] = None
    for ply in plies:
        row[f"{ply.name}_max_shear_deg"] = ply.max_shear_deg
    row["max_shear_deg"] = max(ply.max_shear_deg for ply in plies)
    row.update({f"{name}_j": None for name in ENERGIES})
    return row


def net_summary(
    scene: Setup,
    draped: Sequence[Draped],
    plies: Sequence[FormedPly],
    history: Mapping[str, np.ndarray],
    wall: float,
) -> dict[str, Any]:
    """Everything of ``summary.json``; None where a net has no such quantity."""
    warnings = unseen(scene)
    for ply, each in zip(scene.plies, draped, strict=True):
        left = len(each.triangles) - len(ply.mesh.triangles)
        if left:
            warnings.append(
                f"ply {ply.name!r}: {left} of {len(each.triangles)} triangles are left out, as its "
                f"net ends: {ends_of(each.net)}"
            )
    unknown = ("time_step_s", "triangle_steps_per_s", "energy_error", "kinetic_ratio")
    return {
        "status": "completed",
        "message": closing_words("", warnings),
        "approach": scene.approach,
        "limits": limits_entry(scene.limits),
        "not_given": list(NOT_GIVEN),
        "warnings": warnings,
        "steps": 0,
        **dict.fromkeys(unknown),
        "quasi_static": None,
        "max_penetration_m": None,
        "simulated_s": float(history["time_s"][-1]),
        "wall_s": wall,
        "triangles": sum(len(ply.triangles) for ply in plies),
        "tools": [
            {
                "name": tool.name,
                "displacement_m": float(history[f"{tool.name}_displacement_m"][-1]),
                **dict.fromkeys(("force_n", "max_force_n", "max_penetration_m")),
            }
            for tool in scene.tools
        ],
        "interfaces": [],
        "self_contact": [],
        "edge_contact": [],
        "plies": [
            _ply_entry(scene, number, ply, draped[number].net)
            | _defects(scene, number, ply, history)
            for number, ply in enumerate(plies)
        ],
        "reported": [],
    }


def unseen(scene: Setup) -> list[str]:
    """Warning of what acts on the plies and is nothing to a net."""
    kinds = {
        "clamps": [clamp.name for clamp in scene.clamps],
        "pressures": [pressure.name for pressure in scene.pressures],
        "springs": [spring.name for spring in scene.springs],
    }
    found = [f"{kind} {', '.join(map(repr, names))}" for kind, names in kinds.items() if names]
    return [f"a net does not see {' and '.join(found)}"] if found else []


def _defects(
    scene: Setup, number: int, formed: FormedPly, history: Mapping[str, np.ndarray]
) -> dict[str, Any]:
    """What of a ply's defects its shape and shear tell; a net has none of the ply's wrinkles."""
    entries = defect_entries(scene, number, formed, history)
    entries["defects"]["wrinkles"] = None
    return entries


def _ply_entry(scene: Setup, number: int, formed: FormedPly, net: Net) -> dict[str, Any]:
    ply = scene.plies[number]
    shear, areas = np.abs(formed.shear_angle_deg), np.asarray(ply.mesh.areas)
    return {
        "name": ply.name,
        "fabric": ply.fabric.name,
        "woven": True,
        "triangles": len(formed.triangles),
        "max_shear_deg": float(shear.max()),
        "p95_shear_deg": area_percentile(shear, areas, 0.95),
        "mean_abs_shear_deg": float(np.average(shear, weights=areas)),
        "max_strain_warp": float(np.abs(formed.strain[:, 0]).max()),
        "max_strain_weft": float(np.abs(formed.strain[:, 1]).max()),
        "draw_in_m": draw_in(ply, formed.points),
        "net": {
            "spacing_m": net.spacing,
            "crossovers": net.count,
            "max_shear_deg": net.max_shear_deg,
            "start_m": net.points[net.middle].tolist(),
            "ends": [asdict(end) for end in net.ends],
        },
    }


def ends_of(net: Net) -> str:
    """Where a net ends before its ply does, and why, in words."""
    return "; ".join(end.words for end in net.ends) or "it ended nowhere"
