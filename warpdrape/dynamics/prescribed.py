"""What is prescribed of the coming steps, in tables that the device reads by the step's number."""

from __future__ import annotations

import numpy as np

from warpdrape.dynamics.model import Model
from warpdrape.over_time import over_time
from warpdrape.setup import Setup
from warpdrape.state import ClampState, State, ToolState
from warpdrape.tools.floating import Float
from warpdrape.tools.pressure import along_normals


def prescribe(model: Model, state: State, times: np.ndarray) -> None:
    """Put motions, forces of tools, damping and pressures of the coming steps on the device.

    Args:
        model: the model.
        state: its state; the step counter begins anew.
        times: of the motions, before the first step and after each [s]; at most as many steps as
            `Timing.steps_ahead`.
    """
    scene = model.scene
    time = np.pad(times, (0, model.timing.steps_ahead + 1 - len(times)), mode="edge")
    if scene.tools:
        _move_tools(scene, state.tools, time)
    if scene.clamps:
        _move_clamps(scene, state.clamps, time)
    state.loads.damping.assign(over_time(scene.numerics.damping, time))
    state.loads.process.assign(scene.process_time(time))
    if scene.pressures:
        state.loads.pressure.assign(along_normals(scene.pressures, time))
    state.step.zero_()


def _move_tools(scene: Setup, tools: ToolState, time: np.ndarray) -> None:
    shape = (len(scene.tools), len(time))
    path, force, angle = np.zeros((*shape, 3)), np.zeros(shape), np.zeros(shape)
    for k, tool in enumerate(scene.tools):
        if isinstance(tool.motion, Float):
            force[k] = tool.motion.force_at(time)
        else:
            path[k] = tool.motion.displacement(time)
        if tool.turn is not None:
            angle[k] = tool.turn.at(time)
    tools.path.assign(path)
    tools.force.assign(force)
    tools.angle.assign(angle)


def _move_clamps(scene: Setup, clamps: ClampState, time: np.ndarray) -> None:
    shift = np.stack([clamp.motion.displacement(time) for clamp in scene.clamps])
    eye = np.broadcast_to(np.eye(3), (len(time), 3, 3))
    matrix = [clamp.matrix(time) if clamp.matrix else eye for clamp in scene.clamps]
    clamps.shift.assign(shift.reshape(-1, 3))
    clamps.matrix.assign(np.concatenate(matrix))
