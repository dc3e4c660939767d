"""The result for machines, ``summary.json``: verdicts, warnings, and numbers per ply and tool."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from warpdrape.blanks.triangles import area_percentile, flat_gradients
from warpdrape.defects.limits import limits_entry
from warpdrape.dynamics.interactions import doubts
from warpdrape.dynamics.loading import Loading, reference_energy
from warpdrape.dynamics.model import Model
from warpdrape.interaction import Measured, met_in_contact
from warpdrape.materials.laws import Unwoven
from warpdrape.results.beyond_data import beyond_data
from warpdrape.results.defects import defect_entries
from warpdrape.results.draw_in import draw_in
from warpdrape.results.numerical_error import numerical_error
from warpdrape.results.penetration import passed_through
from warpdrape.results.process_clock import process_entries
from warpdrape.results.quasi_static import (
    LEAST_LOADED,
    mean_while_loaded,
    quasi_static,
    was_loaded,
)
from warpdrape.results.result import FormedPly

ENERGY_WARNING = 0.02
"""Unbalanced share of the largest energy above which a run warns [-]."""
ENERGY_FAILURE = 0.10
"""… and above which it fails [-]."""


def energy_error(history: Mapping[str, np.ndarray], least: float = 0.0) -> float:
    """Largest unbalanced energy over the largest energy of the run [-].

    Args:
        history: columns over the frames.
        least: energy [J] below which the largest is nothing but rounding.
    """
    names = ("kinetic_j", "internal_j", "friction_j", "damping_j", "external_work_j")
    largest = max(least, *(np.abs(history[name]).max() for name in names))
    return float(np.abs(history["unbalanced_j"]).max() / largest) if largest > 0.0 else 0.0


def summarise(
    model: Model,
    measured: Sequence[Measured],
    history: Mapping[str, np.ndarray],
    plies: Sequence[FormedPly],
    loading: Loading,
    *,
    failure: str,
    grown: float = 0.0,
    loose: Sequence[str] = (),
    squeezed: str = "",
    depths: Sequence[tuple[float, float]] = (),
    steps: int,
    wall: float,
) -> dict[str, Any]:
    """Everything of ``summary.json``.

    Args:
        model: the model.
        measured: by the last good frame, from `energy.measure`: a state that blew up cannot be
            asked any more.
        history: columns over the frames.
        plies: the last good frame.
        loading: the clock of the motions.
        failure: why the run stopped early, empty if it did not.
        grown: share of energy that came from nowhere after the last good frame [-], if it did.
        loose: names of the plies that nothing has held or touched.
        squeezed: where two tools are closest to each other in a ply, in words, if they are.
        depths: deepest place of the plies at vertices, and between them, for each tool [m].
        steps: steps done.
        wall: time they took [s].
    """
    reference = reference_energy(tuple(model.scene.plies))
    error = energy_error(history, LEAST_LOADED * reference)
    error = max(error, grown if np.isfinite(grown) else 0.0)
    end, mean, calm = quasi_static(history)
    if not failure and error > ENERGY_FAILURE:
        failure = (
            f"{100 * error:.1f} % of the energy is unbalanced "
            f"(limit {100 * ENERGY_FAILURE:.0f} %): refine the tool meshes or the plies, "
            "or lower contact_share"
        )
    warnings = []
    if ENERGY_WARNING < error <= ENERGY_FAILURE:
        warnings.append(f"{100 * error:.1f} % of the energy is unbalanced: look at the contacts")
    if squeezed and not failure:
        warnings.append(squeezed)
    warnings += [warning for each in measured for warning in each.warnings]
    warnings += untouched(model, history, loose)
    loaded = was_loaded(history, reference)
    if not failure and not loaded and not loose:
        warnings.append(nothing_loaded(history, LEAST_LOADED * reference))
    if not failure and loaded and not calm and not loose:
        warnings.append("not quasi-static: inertia carries part of the load; lengthen the duration")
    contacts = met_in_contact(measured)
    for entry, (at_vertices, between) in zip(contacts.get("tools", ()), depths, strict=False):
        entry["max_penetration_m"] = max(entry["max_penetration_m"], at_vertices)
        entry["max_face_penetration_m"] = between
    deepest = max([e["max_penetration_m"] for found in contacts.values() for e in found], default=0)
    warnings += passed_through(model, contacts)
    added = float(model.masses.added.sum())
    of_forces: dict[str, Any] = {}
    for force, shown in zip(model.forces, measured, strict=False):
        own, complaints = force.entries(history, shown.fields)
        of_forces.update(own)
        warnings += complaints
    warnings += loading.warnings()
    warnings += doubts(model.scene, model.spans, model.timing, model.masses.mass)
    for ply, formed in zip(model.scene.plies, plies, strict=True):
        warnings += [beyond.words(ply.name) for beyond in beyond_data(ply, formed)]
    entries: dict[str, Any] = {
        "status": "failed" if failure else "completed",
        "message": closing_words(failure, warnings),
        "warnings": warnings,
        "approach": model.scene.approach,
        "limits": limits_entry(model.scene.limits),
        "steps": steps,
        "time_step_s": model.timing.time_step,
        "stable_time_step_s": model.timing.stable_step,
        "simulated_s": float(history["time_s"][-1]),
        "wall_s": wall,
        "triangles": model.triangles,
        "triangle_steps_per_s": model.triangles * steps / wall if wall > 0.0 else 0.0,
        "energy_error": error,
        "kinetic_ratio": end,
        "kinetic_ratio_loaded": mean,
        "quasi_static": calm and loaded,
        "loaded": loaded,
        "max_penetration_m": float(deepest),
        "mass_kg": float(model.masses.mass.sum()),
        "added_mass_kg": added,
        "added_mass_kinetic_ratio": mean_while_loaded(history, "added_mass_kinetic_j"),
        "mass_scaling_order": model.masses.scaling.order,
        **of_forces,
        **loading.entries(),
        **process_entries(model, history),
        "tools": [
            _tool_entry(tool.name, history) | of_tool
            for tool, of_tool in zip(model.scene.tools, contacts.get("tools", ()), strict=True)
        ],
        "interfaces": contacts.get("interfaces", []),
        "self_contact": contacts.get("self_contact", []),
        "edge_contact": contacts.get("edge_contact", []),
        "plies": [
            _ply_entry(model, number, measured, ply)
            | defect_entries(model.scene, number, ply, history)
            for number, ply in enumerate(plies)
        ],
    }
    return entries | {"numerical_error": numerical_error(entries, model.scene.plies)}


def closing_words(failure: str, warnings: Sequence[str]) -> str:
    """What ``message`` says: why a run failed, or else what to look at, or that all went well."""
    return failure or "; ".join(warnings) or "completed"


def add_warning(summary: dict[str, Any], what: str, error: Exception) -> None:
    """Add what went wrong after a run was computed to its warnings and its message."""
    words = " ".join(str(error).split())
    summary["warnings"].append(f"{what}: {type(error).__name__}: {words}")
    if summary["status"] == "completed":
        summary["message"] = closing_words("", summary["warnings"])


def nothing_loaded(history: Mapping[str, np.ndarray], least: float) -> str:
    """Warning of a run in which no ply was deformed in its plane or bent, which no duration mends.

    Args:
        history: columns over the frames.
        least: energy [J] that counts as none.
    """
    stored = f"the plies stored at most {history['internal_j'].max():.2g} J"
    unknown = "so it cannot be said whether the run was quasi-static"
    if np.abs(history["contact_j"]).max() > least:
        return f"plies were pressed but not stretched, sheared or bent: {stored}, {unknown}"
    return f"nothing was loaded: {stored}, {unknown}; let tools, clamps or gravity act on them"


def untouched(model: Model, history: Mapping[str, np.ndarray], loose: Sequence[str]) -> list[str]:
    """Warnings of tools and plies that met nothing: most likely they stand in the wrong place."""
    found = [
        f"tool {tool.name!r} never touched a ply: look at where it stands and how far it moves"
        for tool in model.scene.tools
        if not history[f"{tool.name}_force_n"].any()
        and not np.any(history.get(f"{tool.name}_torque_nm", 0.0))
    ]
    if model.scene.tools:
        found += [
            f"ply {name!r} was neither held nor touched by anything: look at where it lies"
            for name in loose
        ]
    return found


def _tool_entry(name: str, history: Mapping[str, np.ndarray]) -> dict[str, Any]:
    entry = {
        "name": name,
        "displacement_m": float(history[f"{name}_displacement_m"][-1]),
        "force_n": float(history[f"{name}_force_n"][-1]),
        "max_force_n": float(np.abs(history[f"{name}_force_n"]).max()),
    }
    if f"{name}_angle_deg" in history:
        torque = history[f"{name}_torque_nm"]
        entry["angle_deg"] = float(history[f"{name}_angle_deg"][-1])
        entry["torque_nm"] = float(torque[-1])
        entry["max_torque_nm"] = float(np.abs(torque).max())
    return entry


def _ply_entry(
    model: Model, number: int, measured: Sequence[Measured], formed: FormedPly
) -> dict[str, Any]:
    ply = model.scene.plies[number]
    shear = np.abs(formed.shear_angle_deg)
    _, areas = flat_gradients(ply)
    of_forces: dict[str, float] = {}
    for force, shown in zip(model.forces, measured, strict=False):
        of_forces |= force.ply_entries(shown.fields[number])
    return {
        "name": ply.name,
        "fabric": ply.fabric.name,
        "woven": not isinstance(ply.fabric.tension, Unwoven),
        "triangles": len(formed.triangles),
        "max_shear_deg": float(shear.max()),
        "p95_shear_deg": area_percentile(shear, areas, 0.95),
        "mean_abs_shear_deg": float(np.average(shear, weights=areas)),
        **of_forces,
        "beyond_data": [asdict(beyond) for beyond in beyond_data(ply, formed)],
        "draw_in_m": draw_in(ply, formed.points),
    }
