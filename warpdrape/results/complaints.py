"""What a run says of itself that is to be looked at, in plain words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from warpdrape.dynamics.model import Model
from warpdrape.interaction import Measured
from warpdrape.results.result import FormedPly
from warpdrape.results.soundness import ENERGY_FAILURE, ENERGY_WARNING, Soundness


def closing_words(failure: str, warnings: Sequence[str]) -> str:
    """What ``message`` says: why a run failed, or else what to look at, or that all went well."""
    return failure or "; ".join(warnings) or "completed"


def add_warning(summary: dict[str, Any], what: str, error: Exception) -> None:
    """Add what went wrong after a run was computed to its warnings and its message."""
    words = " ".join(str(error).split())
    summary["warnings"].append(f"{what}: {type(error).__name__}: {words}")
    if summary["status"] == "completed":
        summary["message"] = closing_words("", summary["warnings"])


def of_energies(sound: Soundness) -> list[str]:
    """Warning of energy that is not balanced, though less than what fails a run."""
    if ENERGY_WARNING < sound.energy_error <= ENERGY_FAILURE:
        error = f"{100 * sound.energy_error:.1f} %"
        return [f"{error} of the energy is unbalanced: look at the contacts"]
    return []


def of_loads(
    sound: Soundness, history: Mapping[str, np.ndarray], loose: Sequence[str]
) -> list[str]:
    """Warning of a run that was too fast, or loaded nothing; none of one that explains itself.

    Args:
        sound: what its energies say.
        history: columns over the frames.
        loose: names of the plies that nothing has held or touched.
    """
    if sound.failure or loose:
        return []
    if not sound.loaded:
        return [nothing_loaded(history, sound.least)]
    if not sound.calm:
        return ["not quasi-static: inertia carries part of the load; lengthen the duration"]
    return []


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


def come_away(
    model: Model, measured: Sequence[Measured], plies: Sequence[FormedPly], loose: Sequence[str]
) -> list[str]:
    """Warnings of plies that have left their stack: nothing holds them, or presses on them now.

    A patch under the others, over the hole of a die, falls as soon as these slow down. A ply has
    left where all its vertices are farther from every other ply's than any side of a triangle.

    Args:
        model: the model.
        measured: what forces and contacts show at the end.
        plies: at the end.
        loose: names of those that nothing ever touched, which are told of already.
    """
    if len(plies) == 1:
        return []
    held = {c.ply for c in model.scene.clamps} | {s.ply for s in model.scene.springs} | set(loose)
    pressed = sum(rows.sum(axis=0) for each in measured for rows in each.pressing.values())
    pressed = np.broadcast_to(pressed, model.spans[-1].vertices.stop)
    longest = max(_longest_side(ply) for ply in plies)
    found = []
    for number, (ply, span) in enumerate(zip(plies, model.spans, strict=True)):
        if ply.name in held or pressed[span.vertices].any():
            continue
        others = np.concatenate([other.points for k, other in enumerate(plies) if k != number])
        away = cKDTree(others).query(ply.points)[0].min()
        if away > longest:
            found.append(
                f"ply {ply.name!r} has left the stack: at the end nothing touches it, and it lies "
                f"{1e3 * away:.3g} mm from the nearest other: lay it between others, or clamp it"
            )
    return found


def _longest_side(ply: FormedPly) -> float:
    """Of a ply's triangles [m]."""
    sides = ply.points[ply.triangles] - ply.points[np.roll(ply.triangles, 1, axis=1)]
    return float(np.linalg.norm(sides, axis=2).max())
