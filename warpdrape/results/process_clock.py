"""By how much a run is faster and heavier than the press, apart from the material's clock."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from warpdrape.dynamics.model import Model


def process_entries(model: Model, history: Mapping[str, np.ndarray]) -> dict[str, Any]:
    """Entry of ``summary.json``, none for a scene without a process's duration.

    The inertia of a press that is simulated so many times as fast, with so much mass, is as many
    times that of the press: speed_up² · mass_scaling. What depends on rates has the press's.

    Args:
        model: the model.
        history: columns over the frames: of a run that was cut off the clock of its last one.
    """
    scene = model.scene
    if scene.process_duration is None:
        return {}
    passed, simulated = (float(history[name][-1]) for name in ("loading_time_s", "time_s"))
    passed /= scene.pace
    speed_up = passed / simulated if simulated > 0.0 else 1.0 / scene.pace
    mass, added = float(model.masses.mass.sum()), float(model.masses.added.sum())
    scaling = mass / (mass - added)
    clock = {
        "process_s": passed,
        "speed_up": speed_up,
        "mass_scaling": scaling,
        "inertia": speed_up**2 * scaling,
    }
    return {"process_clock": clock}


def process_words(summary: Mapping[str, Any]) -> list[str]:
    """The same in words, none for a run without."""
    clock = summary.get("process_clock")
    if clock is None:
        return []
    return [
        f"{clock['process_s']:.4g} s of the process in {1e3 * summary['simulated_s']:.4g} ms: "
        f"rates are the process's, inertia is {clock['inertia']:.2g} times as large"
    ]
