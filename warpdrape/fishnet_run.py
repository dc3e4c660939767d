"""A scene computed as a net on its closed tools: a frame of flat plies, and one of draped ones."""

from __future__ import annotations

import os
import time
from collections.abc import Mapping, Sequence
from contextlib import ExitStack, closing, nullcontext
from dataclasses import replace
from typing import Any

import numpy as np

from warpdrape.blanks.flat_mesh import FlatMesh
from warpdrape.blanks.ply import Ply
from warpdrape.errors import InputError, RunFailed
from warpdrape.fishnet.stack import Draped, drape_stack
from warpdrape.fishnet_result import ends_of, formed_ply, history_row, net_summary
from warpdrape.results.defects import DefectWatch
from warpdrape.results.frame_data import PlyShape
from warpdrape.results.history import tool_angles, tool_ways
from warpdrape.results.result import FormedPly, Result
from warpdrape.results.run_folder import HISTORY, RUN, SUMMARY, RunFolder, as_json
from warpdrape.results.run_record import run_record
from warpdrape.results.snapshot import place_tools, shown_of_defects, tool_shape
from warpdrape.results.summary import add_warning
from warpdrape.results.tables import HistoryWriter
from warpdrape.results.usd import UsdWriter
from warpdrape.setup import Setup
from warpdrape.tools.pose import Pose, shifted


def run_scene(
    scene: Setup,
    out: str | os.PathLike | None,
    *,
    device: str,
    frames: int | None,
    overwrite: bool,
    quiet: bool,
    profile: bool,
    threads: int | None,
    resume: str | os.PathLike | None,
    extend: bool,
    checkpoint: str | int,
) -> Result:
    """Drape a scene's plies over its closed tools; see `Scene.run`.

    A net takes seconds and runs on the processor: ``device``, ``threads``, ``frames``,
    ``checkpoint`` and ``profile`` do not matter to it.
    """
    if resume is not None or extend:
        raise InputError("a fishnet has no checkpoints: run the scene again, which takes seconds")
    folder = None if out is None else RunFolder(out, overwrite)
    place = nullcontext() if folder is None else closing(folder)
    with place:
        begun = time.perf_counter()
        # A tool that floats under a force is taken to stay: it rests on the plies.
        poses = [tool.pose(scene.duration) for tool in scene.tools]
        try:
            draped = drape_stack(scene.plies, scene.tools, poses)
            plies = [_trimmed(ply, each) for ply, each in zip(scene.plies, draped, strict=True)]
        except RunFailed as reason:
            if folder is not None:
                _begin(scene, folder)
                folder.write_json(SUMMARY, {"status": "failed", "message": str(reason)})
            raise
        scene = replace(scene, plies=plies)
        return _finish(scene, draped, poses, folder, begun)


def _begin(scene: Setup, folder: RunFolder) -> dict[str, Any]:
    """Take the run folder, and return the record that is written first."""
    folder.take()
    folder.begin()
    record = run_record(scene, None, 1, 1)
    folder.write_json(RUN, record)
    return record


def _trimmed(ply: Ply, draped: Draped) -> Ply:
    """The part of a ply that the net covers; raise `RunFailed` where there is none."""
    triangles = np.asarray(ply.mesh.triangles)
    kept = triangles[draped.covered[triangles].all(axis=1)]
    if not len(kept):
        raise RunFailed(f"ply {ply.name!r}: its net covers none of it: {ends_of(draped.net)}")
    if len(kept) == len(triangles):
        return ply
    used, corners = np.unique(kept, return_inverse=True)
    vertices = np.asarray(ply.mesh.vertices)[used]
    mesh = FlatMesh(vertices, corners.reshape(-1, 3).astype(np.int32))
    return replace(ply, mesh=mesh)


def _finish(
    scene: Setup,
    draped: Sequence[Draped],
    poses: Sequence[Pose],
    folder: RunFolder | None,
    begun: float,
) -> Result:
    """Make frames and summary, and write them."""
    watch = DefectWatch(scene)
    moments = []
    for moved, flat in (([shifted() for _ in poses], True), (poses, False)):
        formed = [formed_ply(p, d, flat) for p, d in zip(scene.plies, draped, strict=True)]
        looked = watch.look(formed, moved)
        moments.append(([replace(ply, wrinkle=None) for ply in looked], moved))
    times = (0.0, scene.duration)
    rows = [history_row(scene, at, *moment) for at, moment in zip(times, moments, strict=True)]
    plies = tuple(moments[-1][0])
    given = [name for name in rows[0] if rows[0][name] is not None]
    history = {name: np.array([row[name] for row in rows]) for name in given}
    summary = net_summary(scene, draped, plies, history, time.perf_counter() - begun)
    watch.add_at_end(summary, plies)
    result = Result(plies, summary, history, place_tools(scene, poses))
    if scene.report is not None:
        try:
            entries = as_json(scene.report(result), "report")
            summary.update(entries)
            summary["reported"] = list(entries)
        except Exception as error:  # what a scene reports may be of forces; the result stands
            add_warning(summary, "the scene's report failed", error)
    if folder is not None:
        _write(scene, folder, moments, rows, result, summary)
    return result


def _shown(names: Sequence[str]) -> tuple[str, ...]:
    return tuple(name for name in names if name != "wrinkle")


def _write(
    scene: Setup,
    folder: RunFolder,
    moments: Sequence[tuple[Sequence[FormedPly], Sequence[Pose]]],
    rows: Sequence[Mapping[str, float | None]],
    result: Result,
    summary: dict[str, Any],
) -> None:
    """Write the run folder, the summary last."""
    record = _begin(scene, folder)
    about = {"program": "warpdrape", "version": record["versions"]["warpdrape"]}
    about["scene"] = scene.name
    shapes = [
        PlyShape(p.name, p.rest_points, p.mesh.triangles, (), _shown(shown_of_defects(p)))
        for p in scene.plies
    ]
    tools = [tool_shape(tool) for tool in scene.tools]
    with ExitStack() as last:  # each is done even where another fails, the summary last
        last.callback(folder.write_json, SUMMARY, summary)
        history = last.enter_context(HistoryWriter(folder.path / HISTORY))
        usd = last.enter_context(UsdWriter(folder.scene_path, shapes, tools, about=about))
        for number, ((plies, moved), row) in enumerate(zip(moments, rows, strict=True)):
            history.append(row)
            at, frames = row["time_s"] or 0.0, [ply.frame() for ply in plies]
            usd.write(number, at, frames, tool_ways(scene, moved), tool_angles(scene, at))
    if scene.write is not None:
        try:
            scene.write(result, folder)
        except Exception as error:
            add_warning(summary, "the scene's own files could not be written", error)
            folder.write_json(SUMMARY, summary)
