"""The result for machines, ``summary.json``: verdicts, warnings, and numbers per ply and tool."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from warpdrape.blanks.triangles import area_percentile, flat_gradients
from warpdrape.defects.limits import limits_entry
from warpdrape.dynamics.interactions import doubts
from warpdrape.dynamics.loading import Loading
from warpdrape.dynamics.model import Model
from warpdrape.interaction import Measured, met_in_contact
from warpdrape.materials.laws import Unwoven
from warpdrape.results.beyond_data import Beyond, beyond_data
from warpdrape.results.complaints import (
    closing_words,
    come_away,
    of_energies,
    of_loads,
    untouched,
)
from warpdrape.results.defects import defect_entries
from warpdrape.results.draw_in import draw_in
from warpdrape.results.numerical_error import numerical_error
from warpdrape.results.penetration import passed_through
from warpdrape.results.process_clock import process_entries
from warpdrape.results.quasi_static import mean_while_loaded
from warpdrape.results.result import FormedPly
from warpdrape.results.soundness import Soundness, soundness_of

_BETWEEN_PLIES = ("interfaces", "self_contact", "edge_contact")
"""Entries of what plies met of each other, and of themselves."""


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
    sound = soundness_of(model, history, failure, grown)
    contacts, deepest = _contacts(measured, depths)
    of_forces, of_force_words = _of_forces(model, measured, history)
    beyond = [beyond_data(ply, own) for ply, own in zip(model.scene.plies, plies, strict=True)]
    warnings = of_energies(sound)
    if squeezed and not sound.failure:
        warnings.append(squeezed)
    warnings += [warning for each in measured for warning in each.warnings]
    if not sound.failure:  # else a tool may have been on its way
        warnings += untouched(model, history, loose)
    warnings += come_away(model, measured, plies, loose)
    warnings += of_loads(sound, history, loose)
    warnings += passed_through(model, contacts)
    warnings += of_force_words
    warnings += loading.warnings()
    warnings += doubts(model.scene, model.spans, model.timing, model.masses.mass)
    for ply, found in zip(model.scene.plies, beyond, strict=True):
        warnings += [each.words(ply.name) for each in found]
    entries: dict[str, Any] = {
        **_run_entries(model, sound, history, warnings, steps, wall),
        "max_penetration_m": deepest,
        **_mass_entries(model, history),
        **of_forces,
        **loading.entries(),
        **process_entries(model, history),
        "tools": [
            _tool_entry(tool.name, history) | of_tool
            for tool, of_tool in zip(model.scene.tools, contacts.get("tools", ()), strict=True)
        ],
        **{name: contacts.get(name, []) for name in _BETWEEN_PLIES},
        "plies": [
            _ply_entry(model, number, measured, ply, beyond[number])
            | defect_entries(model.scene, number, ply, history)
            for number, ply in enumerate(plies)
        ],
    }
    return entries | {"numerical_error": numerical_error(entries, model.scene.plies)}


def _contacts(
    measured: Sequence[Measured], depths: Sequence[tuple[float, float]]
) -> tuple[dict[str, list[dict[str, Any]]], float]:
    """Entries of what was met, by name, and the deepest of all at vertices [m]."""
    contacts = met_in_contact(measured)
    for entry, (at_vertices, between) in zip(contacts.get("tools", ()), depths, strict=False):
        entry["max_penetration_m"] = max(entry["max_penetration_m"], at_vertices)
        entry["max_face_penetration_m"] = between
    deepest = max([e["max_penetration_m"] for found in contacts.values() for e in found], default=0)
    return contacts, float(deepest)


def _of_forces(
    model: Model, measured: Sequence[Measured], history: Mapping[str, np.ndarray]
) -> tuple[dict[str, Any], list[str]]:
    """Entries of forces of their own, and what they warn of."""
    entries: dict[str, Any] = {}
    warnings: list[str] = []
    for force, shown in zip(model.forces, measured, strict=False):
        own, complaints = force.entries(history, shown.fields)
        entries.update(own)
        warnings += complaints
    return entries, warnings


def _run_entries(
    model: Model,
    sound: Soundness,
    history: Mapping[str, np.ndarray],
    warnings: list[str],
    steps: int,
    wall: float,
) -> dict[str, Any]:
    """How the run ended, what it took, and what its energies say."""
    return {
        "status": "failed" if sound.failure else "completed",
        "message": closing_words(sound.failure, warnings),
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
        "energy_error": sound.energy_error,
        "kinetic_ratio": sound.kinetic_end,
        "kinetic_ratio_loaded": sound.kinetic_loaded,
        "quasi_static": sound.calm and sound.loaded,
        "loaded": sound.loaded,
    }


def _mass_entries(model: Model, history: Mapping[str, np.ndarray]) -> dict[str, Any]:
    """Mass of the plies, and what mass scaling added to it."""
    return {
        "mass_kg": float(model.masses.mass.sum()),
        "added_mass_kg": float(model.masses.added.sum()),
        "added_mass_kinetic_ratio": mean_while_loaded(history, "added_mass_kinetic_j"),
        "mass_scaling_order": model.masses.scaling.order,
    }


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
    model: Model,
    number: int,
    measured: Sequence[Measured],
    formed: FormedPly,
    beyond: Sequence[Beyond],
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
        "beyond_data": [asdict(each) for each in beyond],
        "draw_in_m": draw_in(ply, formed.points),
    }
