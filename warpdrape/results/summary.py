"""The result for machines, ``summary.json``: verdicts, warnings, and numbers per ply and tool."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from warpdrape.blanks.ply import Ply
from warpdrape.blanks.triangles import area_percentile
from warpdrape.dynamics.loading import Loading
from warpdrape.dynamics.model import Model, State
from warpdrape.forces.membrane import flat_gradients
from warpdrape.materials.softening import softening_entries, softening_warnings
from warpdrape.results.draw_in import draw_in
from warpdrape.results.result import FormedPly

ENERGY_WARNING = 0.02
"""Unbalanced share of the largest energy above which a run warns [-]."""
ENERGY_FAILURE = 0.10
"""… and above which it fails [-]."""
PENETRATION_WARNING = 0.5
"""Penetration over the thinnest ply's thickness above which a run warns [-]."""
QUASI_STATIC_END = 0.05
"""Kinetic over internal energy at the end that still counts as quasi-static [-]."""
QUASI_STATIC_MEAN = 0.10
"""Its mean while the plies are loaded [-]."""
LOADED = 0.1
"""Share of the largest internal energy from which the plies count as loaded [-]."""


@dataclasses.dataclass(frozen=True, eq=False)
class ContactExtremes:
    """What contacts have come to by a good frame; a state that blew up cannot be asked any more.

    Attributes:
        tool_deepest: deepest penetration of each tool [m], shape [tool].
        ply_deepest: that of each directed pair of plies [m], shape [pair].
        ply_jump: largest penetration of each pair that a jump of the gap allowed [m], shape [pair].
        slip: of the searching plies' vertices on the searched ones [m], shape [slot].
    """

    tool_deepest: np.ndarray
    ply_deepest: np.ndarray
    ply_jump: np.ndarray
    slip: np.ndarray

    @classmethod
    def of(cls, state: State) -> ContactExtremes:
        """Copy them from the device."""
        return cls(
            state.tool_deepest.numpy().copy(),
            state.ply_deepest.numpy().copy(),
            state.ply_jump.numpy().copy(),
            state.ply_slip.numpy().copy(),
        )


def energy_error(history: Mapping[str, np.ndarray]) -> float:
    """Largest unbalanced energy over the largest energy of the run [-]."""
    names = ("kinetic_j", "internal_j", "friction_j", "damping_j", "external_work_j")
    largest = max(np.abs(history[name]).max() for name in names)
    return float(np.abs(history["unbalanced_j"]).max() / largest) if largest > 0.0 else 0.0


def mean_while_loaded(history: Mapping[str, np.ndarray], name: str) -> float:
    """An energy over the internal one, on average over the frames in which plies are loaded [-]."""
    internal = history["internal_j"]
    if internal.max() <= 0.0:
        return 0.0
    loaded = internal >= LOADED * internal.max()
    return float(history[name][loaded].sum() / internal[loaded].sum())


def quasi_static(history: Mapping[str, np.ndarray]) -> tuple[float, float, bool]:
    """Kinetic over internal energy at the end, its mean while loaded, and the verdict."""
    kinetic, internal = history["kinetic_j"], history["internal_j"]
    if internal.max() <= 0.0:
        return 0.0, 0.0, False
    mean = mean_while_loaded(history, "kinetic_j")
    end = float(kinetic[-1] / internal[-1]) if internal[-1] > 0.0 else float("inf")
    end = min(end, 1e12)
    return end, mean, bool(end < QUASI_STATIC_END and mean < QUASI_STATIC_MEAN)


def summarise(
    model: Model,
    contacts: ContactExtremes,
    history: Mapping[str, np.ndarray],
    plies: Sequence[FormedPly],
    loading: Loading,
    *,
    failure: str,
    steps: int,
    wall: float,
) -> dict[str, Any]:
    """Everything of ``summary.json``.

    Args:
        model: the model.
        contacts: penetrations and slips by the last good frame.
        history: columns over the frames.
        plies: the last good frame.
        loading: the clock of the motions.
        failure: why the run stopped early, empty if it did not.
        steps: steps done.
        wall: time they took [s].
    """
    triangles = sum(m.triangle_count for m in model.membranes)
    error = energy_error(history)
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
    if not calm and not failure:
        warnings.append("not quasi-static: inertia carries part of the load; lengthen the duration")
    penetration = np.concatenate([contacts.tool_deepest, contacts.ply_deepest, [0.0]])
    if penetration.max() > PENETRATION_WARNING * min(p.fabric.thickness for p in model.scene.plies):
        warnings.append(
            f"things pressed {1e3 * penetration.max():.3g} mm into each other and may have passed: "
            "lower the forces or the speed, refine the plies, or raise contact_share"
        )
    added = float(model.masses.added.sum())
    strain = max(float(ply.strain.max()) for ply in plies)
    speed_up = softening_entries(model.scene.numerics.yarn_softening, history, strain)
    warnings += softening_warnings(speed_up) + loading.warnings()
    return {
        "status": "failed" if failure else "completed",
        "message": failure or "; ".join(warnings) or "completed",
        "warnings": warnings,
        "steps": steps,
        "time_step_s": model.timing.time_step,
        "stable_time_step_s": model.timing.stable_step,
        "simulated_s": float(history["time_s"][-1]),
        "wall_s": wall,
        "triangles": triangles,
        "triangle_steps_per_s": triangles * steps / wall if wall > 0.0 else 0.0,
        "energy_error": error,
        "kinetic_ratio": end,
        "kinetic_ratio_loaded": mean,
        "quasi_static": calm,
        "max_penetration_m": float(penetration.max()),
        "mass_kg": float(model.masses.mass.sum()),
        "added_mass_kg": added,
        "added_mass_kinetic_ratio": mean_while_loaded(history, "added_mass_kinetic_j"),
        "mass_scaling_order": model.masses.scaling.order,
        **speed_up,
        **loading.entries(),
        "tools": _tool_entries(model, contacts, history),
        "interfaces": _interfaces(model, contacts),
        "plies": [_ply_entry(p, f) for p, f in zip(model.scene.plies, plies, strict=True)],
    }


def _tool_entries(
    model: Model, contacts: ContactExtremes, history: Mapping[str, np.ndarray]
) -> list[dict]:
    return [
        {
            "name": tool.name,
            "displacement_m": float(history[f"{tool.name}_displacement_m"][-1]),
            "force_n": float(history[f"{tool.name}_force_n"][-1]),
            "max_force_n": float(np.abs(history[f"{tool.name}_force_n"]).max()),
            "max_penetration_m": float(contacts.tool_deepest[k]),
        }
        for k, tool in enumerate(model.scene.tools)
    ]


def _interfaces(model: Model, contacts: ContactExtremes) -> list[dict]:
    """Slip of each ply's vertices on each other ply."""
    entries = []
    for number, pair in enumerate(model.ply_pairs):
        count = model.membranes[pair.searching].vertex_count
        of_pair = contacts.slip[pair.first_slot : pair.first_slot + count]
        entries.append(
            {
                "vertices_of": model.scene.plies[pair.searching].name,
                "on": model.scene.plies[pair.searched].name,
                "max_slip_m": float(of_pair.max()),
                "mean_slip_m": float(of_pair.mean()),
                "max_penetration_m": float(contacts.ply_deepest[number]),
                "max_gap_jump_m": float(contacts.ply_jump[number]),
            }
        )
    return entries


def _ply_entry(ply: Ply, formed: FormedPly) -> dict[str, Any]:
    shear = np.abs(formed.shear_angle_deg)
    _, areas = flat_gradients(ply)
    return {
        "name": ply.name,
        "fabric": ply.fabric.name,
        "triangles": len(formed.triangles),
        "max_shear_deg": float(shear.max()),
        "p95_shear_deg": area_percentile(shear, areas, 0.95),
        "mean_abs_shear_deg": float(np.average(shear, weights=areas)),
        "max_strain_warp": float(formed.strain[:, 0].max()),
        "max_strain_weft": float(formed.strain[:, 1].max()),
        "draw_in_m": draw_in(ply, formed.points),
    }
