"""The rows of ``history.csv``: way and force of tools and clamps, largest shear, energies."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence

import numpy as np

from warpdrape.dynamics.energy import Energies
from warpdrape.dynamics.model import Model
from warpdrape.interaction import Measured
from warpdrape.results.defects import defect_columns
from warpdrape.results.result import FormedPly
from warpdrape.setup import Setup
from warpdrape.state import State
from warpdrape.tools.floating import Float
from warpdrape.tools.pose import Pose
from warpdrape.tools.tool import Tool


def tool_axis(tool: Tool, scene: Setup) -> np.ndarray:
    """Direction along which a tool's displacement and force are reported, shape [3].

    That of its force or of its way; for one that stands still, vertical towards the plies. So a
    force above zero always presses.
    """
    if isinstance(tool.motion, Float):
        return np.asarray(tool.motion.axis)
    heading = np.asarray(tool.motion.heading, dtype=float)
    if np.linalg.norm(heading) > 0.0:
        return heading / np.linalg.norm(heading)
    heights = [ply.z for ply in scene.plies]
    above = tool.vertices[:, 2].min() + tool.vertices[:, 2].max() > min(heights) + max(heights)
    return np.array([0.0, 0.0, -1.0 if above else 1.0])


def tool_ways(scene: Setup, poses: Sequence[Pose]) -> np.ndarray:
    """How far tools, or the axes about which they turn, have gone [m], shape [tool, 3]."""
    ways = [pose.shift for pose in poses]
    for k, (tool, pose) in enumerate(zip(scene.tools, poses, strict=True)):
        if tool.turn is not None:
            ways[k] = pose.shift - (tool.turn.point - pose.turned @ tool.turn.point)
    return np.reshape(ways, (-1, 3))


def tool_angles(scene: Setup, loading_time: float) -> list[float | None]:
    """How far tools have turned at a time of the motions [rad], None for those that do not."""
    time = np.array(loading_time)
    return [None if tool.turn is None else float(tool.turn.at(time)) for tool in scene.tools]


def history_row(
    model: Model,
    state: State,
    time: float,
    loading_time: float,
    steps: int,
    energies: Energies,
    plies: Sequence[FormedPly],
    measured: Sequence[Measured],
    before: Mapping[str, float] | None = None,
) -> dict[str, float]:
    """One row of ``history.csv``; forces are means over the frame.

    Args:
        model: the model.
        state: its state, its impulses and twists summed over ``steps``.
        time: simulated time [s].
        loading_time: time of the tools' and clamps' motions [s], as in `loading`.
        steps: steps since the row before.
        energies: the balance now.
        plies: the plies now.
        measured: from `energy.measure`.
        before: the row before, None for the first.
    """
    row = {"time_s": time, "loading_time_s": loading_time}
    ways, impulse = tool_ways(model.scene, state.tools.poses()), state.tools.impulse.numpy()
    angles, twist = tool_angles(model.scene, loading_time), state.tools.twist.numpy()
    for k, tool in enumerate(model.scene.tools):
        axis = tool_axis(tool, model.scene)
        row[f"{tool.name}_displacement_m"] = float(ways[k] @ axis)
        row[f"{tool.name}_force_n"] = float(-impulse[k] @ axis / max(steps, 1))
        angle = angles[k]
        if angle is not None:
            row[f"{tool.name}_angle_deg"] = math.degrees(angle)
            row[f"{tool.name}_torque_nm"] = float(-twist[k] / max(steps, 1))
    row.update(_clamp_entries(model, state, loading_time, steps, before))
    for each in measured:
        row.update(each.readings)
    for ply in plies:
        row[f"{ply.name}_max_shear_deg"] = ply.max_shear_deg
    for ply in plies:
        row.update(defect_columns(ply))
    row["max_shear_deg"] = max(ply.max_shear_deg for ply in plies)
    for name in ("kinetic", "internal", "friction", "damping", "contact", "external_work"):
        row[f"{name}_j"] = getattr(energies, name)
    row.update({f"{name}_j": energy for name, energy in energies.stored.items()})
    row.update({f"{name}_j": loss for name, loss in energies.lost.items()})
    for field in dataclasses.fields(energies):
        if field.name not in ("stored", "lost"):
            row.setdefault(f"{field.name}_j", getattr(energies, field.name))
    row["unbalanced_j"] = energies.unbalanced
    return row


def _clamp_entries(
    model: Model, state: State, time: float, steps: int, before: Mapping[str, float] | None
) -> dict[str, float]:
    """Displacement, force (along ``follow``, or by work; and its components) and work of clamps."""
    entries: dict[str, float] = {}
    if not model.scene.clamps:
        return entries
    held, work = model.clamp.numpy(), state.clamps.work.numpy()
    mean_force = state.clamps.force.numpy() / max(steps, 1)
    for k, clamp in enumerate(model.scene.clamps):
        name, done = clamp.name, float(work[held == k].sum())
        follow = np.asarray(clamp.follow, dtype=float) / np.linalg.norm(clamp.follow)
        moved = float(clamp.motion.displacement(np.array(time)) @ follow)
        force = float(mean_force[k] @ follow)
        if clamp.travel is not None:
            moved = float(clamp.travel(np.array(time)))
            force = 0.0
            if before and moved != before[f"{name}_displacement_m"]:
                step = moved - before[f"{name}_displacement_m"]
                force = (done - before[f"{name}_work_j"]) / step
        entries[f"{name}_displacement_m"] = moved
        entries[f"{name}_force_n"] = force
        for axis, component in zip("xyz", mean_force[k], strict=True):
            entries[f"{name}_force_{axis}_n"] = float(component)
        entries[f"{name}_work_j"] = done
    return entries
