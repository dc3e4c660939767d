"""A run that goes on beyond its end: how long it becomes, and motions that begin where it is."""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING

import numpy as np

from warpdrape.dynamics.model import Model
from warpdrape.errors import InputError
from warpdrape.setup import Setup
from warpdrape.timing import Timing, peak_speed
from warpdrape.tools.floating import Float
from warpdrape.tools.pose import rotation
from warpdrape.tools.pressure import along_normals
from warpdrape.tools.tool import Tool
from warpdrape.tools.turn import Turn

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
        InputError: if it is no longer than the run, or that was cut off between frames.
    """
    if earlier.clock.left:
        raise InputError(
            f"{earlier.folder} was cut off between frames {earlier.frame} and {earlier.frame + 1}: "
            "let it come to its end first, without extend"
        )
    each = earlier.duration / earlier.timing.frames
    needed = math.ceil(scene.duration / each - 1e-6)
    total = max(needed, frames or 0)
    if total <= earlier.frame:
        raise InputError(
            f"{earlier.folder} has come to frame {earlier.frame}, {earlier.frame * each:.4g} s: "
            "to extend it, give a longer duration or more frames"
        )
    timing = dataclasses.replace(earlier.timing, frames=total)
    longer, pace = total * each, earlier.parts.get("process_duration over duration")
    process = scene.process_duration
    if pace is not None and process is not None:
        # Given for the run as it was, or for the longer one: the press goes on at its pace.
        if any(
            math.isclose(process, pace * t, rel_tol=1e-6)
            for t in (earlier.duration, scene.duration)
        ):
            process = pace * longer
    return dataclasses.replace(scene, duration=longer, process_duration=process), timing


def check_motions(model: Model, earlier: Restart) -> None:
    """Refuse motions that jump from where the run has left tools and clamps.

    Args:
        model: the model.
        earlier: the run.

    Raises:
        InputError: naming the tool or clamp.
    """
    scene, now, step = model.scene, earlier.clock.time, model.timing.time_step
    times, peak = np.array([now, now + step]), peak_speed(scene)
    for number, tool in enumerate(scene.tools):
        if tool.turn is not None:
            _check_turn(tool, tool.turn, earlier, number, times, peak)
        if isinstance(tool.motion, Float):
            was = earlier.at_end("tools.force", len(scene.tools))[number]
            forces = tool.motion.force_at(times)
            _refuse_step(f"force of tool {tool.name!r}", was, float(forces[0]), "N")
            continue
        shift, velocity = (
            earlier.floats(name, 3)[number] for name in ("tools.shift", "tools.velocity")
        )
        here, there = tool.motion.displacement(times)
        jump = float(np.linalg.norm(tool.pose(now).shift - shift))
        jerk = float(np.linalg.norm((there - here) / step - velocity))
        _refuse_jump(f"tool {tool.name!r}", jump, jerk, step, peak)
    pressures = along_normals(scene.pressures, np.array([now]))[:, 0]
    for number, pressure in enumerate(scene.pressures):
        was = earlier.at_end("loads.pressure", len(scene.pressures))[number]
        _refuse_step(f"pressure {pressure.name!r}", was, float(pressures[number]), "Pa")
    done = int(earlier.arrays["step"].view(np.int32)[0])
    for number, clamp in enumerate(scene.clamps):
        row = number * (model.timing.steps_ahead + 1) + done
        was = earlier.floats("clamps.shift", 3)[row]
        turned = earlier.floats("clamps.matrix", 9)[row].reshape(3, 3)
        here, _ = clamp.motion.displacement(times)
        matrix = clamp.matrix(times)[0] if clamp.matrix else np.eye(3)
        jump = float(np.linalg.norm(here - was) + np.abs(matrix - turned).max())
        _refuse_jump(f"clamp {clamp.name!r}", jump, 0.0, step, peak)


def _check_turn(
    tool: Tool, turn: Turn, earlier: Restart, number: int, times: np.ndarray, peak: float
) -> None:
    """Raise `InputError` where a tool's turn jumps from where the run has left it."""
    step, reach = times[1] - times[0], turn.reach(tool.vertices)
    turned = earlier.floats("tools.turned", 9)[number].reshape(3, 3)
    spin = earlier.floats("tools.spin", 3)[number] @ turn.axis
    here, there = turn.at(times)
    jump = reach * float(np.abs(rotation(turn.axis, float(here)) - turned).max())
    jerk = reach * abs((there - here) / step - float(spin))
    _refuse_jump(f"turn of tool {tool.name!r}", jump, jerk, step, peak)


def _refuse_step(name: str, was: float, now: float, unit: str) -> None:
    if abs(now - was) > JERK * max(abs(now), abs(was)):
        raise InputError(
            f"{name} would go from {was:.4g} to {now:.4g} {unit} at once: let it go on from there"
        )


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
