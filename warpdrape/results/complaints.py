"""What a run says of itself that is to be looked at, in plain words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from warpdrape.dynamics.model import Model
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
