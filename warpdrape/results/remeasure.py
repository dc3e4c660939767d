"""Defects of a finished run, measured again with other thresholds; nothing is computed anew."""

from __future__ import annotations

import copy
import os
from collections.abc import Sequence
from dataclasses import asdict, replace

import numpy as np

from warpdrape.defects.thresholds import DefectThresholds
from warpdrape.errors import InputError
from warpdrape.results.defects import DefectWatch, defect_columns, defect_entries
from warpdrape.results.read_run import RunReader
from warpdrape.results.result import FormedPly, Result
from warpdrape.results.run_tables import AGAIN, read_record
from warpdrape.results.same_scene import THRESHOLDS, scene_difference
from warpdrape.setup import Setup
from warpdrape.tools.pose import Pose, pose_between

OF_NO_DEFECT = (THRESHOLDS, "limits", "plies", "tools")
"""Entries of a record that may differ; of plies and tools those of the frames are compared."""
SAME = 1e-6
"""Distance over the size of a mesh below which vertices are the same: single precision [-]."""


def remeasure(folder: str | os.PathLike[str], scene: Setup, thresholds: DefectThresholds) -> Result:
    """Measure the defects of a finished run again, at every frame, with other thresholds.

    The folder is only read. Tools and flat plies are the scene's, in full precision and with their
    true surfaces; where they have come to is the run's.

    Args:
        folder: the run folder.
        scene: that was run, made with the same parameters.
        thresholds: what counts as a defect now.

    Returns:
        The run's last frame, its summary and its history, with the defects measured now.

    Raises:
        InputError: if the folder holds no finished run of this scene, or one of a net.
    """
    reader = RunReader(folder)
    _check(reader, scene)
    now = replace(scene, defects=thresholds)
    watch = DefectWatch(now)
    starts = [tool.vertices for tool in scene.tools]
    rows, frame = [], reader.result()
    plies: tuple[FormedPly, ...] = ()
    for number in range(reader.frames):
        frame = reader.result(number)
        poses = _poses(starts, frame)
        plies = watch.look(frame.plies, poses)
        rows.append({name: v for ply in plies for name, v in defect_columns(ply).items()})
    history = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    history = {**reader.history, **history}
    summary = copy.deepcopy(reader.summary)
    for number, (entry, ply) in enumerate(zip(summary["plies"], plies, strict=True)):
        entry.update(defect_entries(now, number, ply, history))
    watch.add_at_end(summary, plies)
    summary[THRESHOLDS] = asdict(thresholds)
    return replace(frame, plies=plies, summary=summary, history=history)


def _poses(starts: Sequence[np.ndarray], frame: Result) -> list[Pose]:
    """Where the tools are at a frame."""
    return [
        pose_between(start, tool.vertices) for start, tool in zip(starts, frame.tools, strict=True)
    ]


def _check(reader: RunReader, scene: Setup) -> None:
    """Raise `InputError` unless a folder holds a finished run of a scene."""
    folder = reader.folder
    if "not_given" in reader.summary:
        raise InputError(
            f"run folder {folder} is a fishnet's: run the scene again with other thresholds, "
            "which takes seconds"
        )
    if reader.summary["status"] != "completed":
        raise InputError(f"run folder {folder}: the run failed: {reader.summary['message']}")
    other = scene_difference(read_record(folder), scene, without=OF_NO_DEFECT)
    if not other:
        other = _other_meshes(reader.result(0), scene)
    if other:
        raise InputError(
            f"run folder {folder} holds {other}: give the scene as it was run, or {AGAIN}"
        )


def _other_meshes(frame: Result, scene: Setup) -> str:
    """Say which mesh of the folder is not the scene's; empty if all are."""
    pairs = [
        (f"ply {ply.name}", ply.rest_points, formed.rest_points)
        for ply, formed in zip(scene.plies, frame.plies, strict=True)
    ]
    for tool, placed in zip(scene.tools, frame.tools, strict=True):
        mine, there = tool.vertices, placed.vertices
        if mine.shape == there.shape:
            mine = pose_between(mine, there).place(mine)
        pairs.append((f"tool {tool.name}", mine, there))
    for name, mine, there in pairs:
        size = float(np.abs(mine).max())
        if mine.shape != there.shape or np.abs(mine - there).max() > SAME * size:
            return f"a run with another mesh of {name}"
    return ""
