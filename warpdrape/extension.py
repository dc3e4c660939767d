"""A run that goes on beyond its end: how long it becomes, and motions that begin where it is."""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING

import numpy as np

from warpdrape.dynamics.model import Model
from warpdrape.errors import InputError
from warpdrape.setup import Setup
from warpdrape.state import State
from warpdrape.timing import Timing, peak_speed
from warpdrape.tools.motion import Float

if TYPE_CHECKING:
    from warpdrape.restart import Restart

JERK = 0.05
"""Jump of a speed, over the largest of the run, with which a motion may go on [-]."""


def longer(scene: Setup, frames: int | None, earlier: Restart) -> tuple[Setup, Timing]:
    """A scene with its duration, and its steps, in whole frames as long as the run's.

    Args:
        scene: with the longer duration.
        frames: in all, None for as many as the duration needs.
        earlier: the run.

    Raises:
        InputError: if it is no longer than the run.
    """
    each = earlier.duration / earlier.timing.frames
    needed = math.ceil(scene.duration / each - 1e-6)
    total = max(needed, frames or 0)
    if total <= earlier.frame:
        raise InputError(
            f"{earlier.folder} has come to frame {earlier.frame}, {earlier.frame * each:.4g} s: "
            "to extend it, give a longer duration or more frames"
        )
    timing = dataclasses.replace(earlier.timing, frames=total)
    return dataclasses.replace(scene, duration=total * each), timing


def check_motions(model: Model, state: State, now: float) -> None:
    """Refuse motions that jump from where tools and clamps are.

    Args:
        model: the model.
        state: put back.
        now: time of the motions [s].

    Raises:
        InputError: naming the tool or clamp.
    """
    step, peak = model.timing.time_step, peak_speed(model.scene)
    times = np.array([now - step, now, now + step])
    shift, velocity = state.tools.shift.numpy(), state.tools.velocity.numpy()
    for number, tool in enumerate(model.scene.tools):
        if isinstance(tool.motion, Float):
            continue
        _, here, there = tool.motion.displacement(times)
        jump = float(np.linalg.norm(here - shift[number]))
        jerk = float(np.linalg.norm((there - here) / step - velocity[number]))
        _refuse_jump(f"tool {tool.name!r}", jump, jerk, step, peak)
    count = len(model.scene.clamps)
    tables = [a.numpy() for a in (state.clamps.shift, state.clamps.matrix)] if count else []
    done = int(state.step.numpy()[0])
    for number, clamp in enumerate(model.scene.clamps):
        was, turned = (table.reshape(count, -1, *table.shape[1:])[number, done] for table in tables)
        _, here, _ = clamp.motion.displacement(times)
        matrix = clamp.matrix(times)[1] if clamp.matrix else np.eye(3)
        jump = float(np.linalg.norm(here - was) + np.abs(matrix - turned).max())
        _refuse_jump(f"clamp {clamp.name!r}", jump, 0.0, step, peak)


def _refuse_jump(name: str, jump: float, jerk: float, step: float, peak: float) -> None:
    if jump > step * peak:
        raise InputError(
            f"{name} would jump {1e3 * jump:.4g} mm from where it is: let its motion begin there"
        )
    if jerk > JERK * peak:
        raise InputError(
            f"{name} would change its speed by {jerk:.4g} m/s at once: let its motion go on at "
            "the speed that it has"
        )
