"""A scene computed as a net on its closed tools: a frame of the flat plies, and one of the draped.

What a net cannot give, such as forces, is left out of the result: None, an empty cell, an empty
array; never zero.
"""

from __future__ import annotations

import math
import os
import time
from collections.abc import Mapping, Sequence
from contextlib import ExitStack, closing, nullcontext
from dataclasses import asdict, replace
from typing import Any

import numpy as np

from warpdrape.blanks.flat_mesh import FlatMesh
from warpdrape.blanks.ply import Ply
from warpdrape.blanks.triangles import area_percentile, yarn_gradients
from warpdrape.defects.limits import limits_entry
from warpdrape.errors import InputError, RunFailed
from warpdrape.fishnet.net import Net
from warpdrape.fishnet.stack import Draped, drape_stack
from warpdrape.results.defects import DefectWatch, defect_entries
from warpdrape.results.draw_in import draw_in
from warpdrape.results.frame_data import PlyShape
from warpdrape.results.history import tool_angles, tool_axis, tool_ways
from warpdrape.results.result import FormedPly, Result
from warpdrape.results.run_folder import HISTORY, RUN, SUMMARY, RunFolder, as_json
from warpdrape.results.run_record import run_record
from warpdrape.results.snapshot import place_tools, shown_of_defects, tool_shape, yarn_state
from warpdrape.results.summary import add_warning, closing_words
from warpdrape.results.tables import HistoryWriter
from warpdrape.results.usd import UsdWriter
from warpdrape.setup import Setup
from warpdrape.tools.pose import Pose, shifted

NOT_GIVEN = ("forces", "tensions", "pressures", "friction", "slip", "energies", "wrinkles")
"""What a net has not: it knows lengths and a surface only."""
ENERGIES = ("kinetic", "internal", "friction", "damping", "contact", "external_work")


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


def unseen(scene: Setup) -> list[str]:
    """Warning of what acts on the plies and is nothing to a net."""
    kinds = {"clamps": scene.clamps, "pressures": scene.pressures, "springs": scene.springs}
    found = [
        f"{kind} {', '.join(repr(each.name) for each in some)}"
        for kind, some in kinds.items()
        if some
    ]
    return [f"a net does not see {' and '.join(found)}"] if found else []


def _trimmed(ply: Ply, draped: Draped) -> Ply:
    """The part of a ply that the net covers; raise `RunFailed` where there is none."""
    triangles = np.asarray(ply.mesh.triangles)
    kept = triangles[draped.covered[triangles].all(axis=1)]
    if not len(kept):
        raise RunFailed(f"ply {ply.name!r}: its net covers none of it: {_ends(draped.net)}")
    if len(kept) == len(triangles):
        return ply
    used, corners = np.unique(kept, return_inverse=True)
    mesh = FlatMesh(np.asarray(ply.mesh.vertices)[used], corners.reshape(-1, 3))
    return replace(ply, mesh=mesh)


def _ends(net: Net) -> str:
    return "; ".join(end.words for end in net.ends) or "it ended nowhere"


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
        plies = [_formed(p, d, flat) for p, d in zip(scene.plies, draped, strict=True)]
        looked = watch.look(plies, moved)
        moments.append(([replace(ply, wrinkle=None) for ply in looked], moved))
    times = (0.0, scene.duration)
    rows = [_row(scene, at, *moment) for at, moment in zip(times, moments, strict=True)]
    plies = tuple(moments[-1][0])
    given = [name for name in rows[0] if rows[0][name] is not None]
    history = {name: np.array([row[name] for row in rows]) for name in given}
    summary = _summary(scene, draped, plies, history, time.perf_counter() - begun)
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


def _formed(ply: Ply, draped: Draped, flat: bool) -> FormedPly:
    """A ply, flat or draped, with what its shape says of its yarns."""
    whole = draped.flat_points if flat else draped.points
    points = whole if len(whole) == len(ply.mesh.vertices) else whole[_used(draped)]
    triangles = np.asarray(ply.mesh.triangles)
    gradients, _ = yarn_gradients(ply.mesh.vertices, triangles, *ply.yarn_directions)
    warp, weft, shear = yarn_state(points, triangles, gradients, ply.fabric.yarn_angle)
    return FormedPly(
        ply.name,
        ply.rest_points,
        points,
        triangles,
        warp,
        weft,
        shear,
        strain=np.zeros((len(triangles), 2)),  # yarns of a net do not stretch
        line_tension=None,
    )


def _used(draped: Draped) -> np.ndarray:
    kept = draped.triangles[draped.covered[draped.triangles].all(axis=1)]
    return np.unique(kept)


def _row(
    scene: Setup, at: float, plies: Sequence[FormedPly], poses: Sequence[Pose]
) -> dict[str, float | None]:
    """One row of ``history.csv``; None where a net has no such quantity."""
    row: dict[str, float | None] = {"time_s": at}
    angles = tool_angles(scene, at)
    for tool, way, angle in zip(scene.tools, tool_ways(scene, poses), angles, strict=True):
        row[f"{tool.name}_displacement_m"] = float(way @ tool_axis(tool, scene))
        row[f"{tool.name}_force_n"] = None
        if angle is not None:
            row[f"{tool.name}_angle_deg"] = math.degrees(angle)
            row[f"{tool.name}_torque_nm"] = None
    for ply in plies:
        row[f"{ply.name}_max_shear_deg"] = ply.max_shear_deg
    row["max_shear_deg"] = max(ply.max_shear_deg for ply in plies)
    row.update({f"{name}_j": None for name in ENERGIES})
    return row


def _summary(
    scene: Setup,
    draped: Sequence[Draped],
    plies: Sequence[FormedPly],
    history: Mapping[str, np.ndarray],
    wall: float,
) -> dict[str, Any]:
    """Everything of ``summary.json``; None where a net has no such quantity."""
    warnings = unseen(scene)
    for ply, each in zip(scene.plies, draped, strict=True):
        left = len(each.triangles) - len(ply.mesh.triangles)
        if left:
            warnings.append(
                f"ply {ply.name!r}: {left} of {len(each.triangles)} triangles are left out, as its "
                f"net ends: {_ends(each.net)}"
            )
    unknown = ("time_step_s", "triangle_steps_per_s", "energy_error", "kinetic_ratio")
    return {
        "status": "completed",
        "message": closing_words("", warnings),
        "approach": scene.approach,
        "limits": limits_entry(scene.limits),
        "not_given": list(NOT_GIVEN),
        "warnings": warnings,
        "steps": 0,
        **dict.fromkeys(unknown),
        "quasi_static": None,
        "max_penetration_m": None,
        "simulated_s": float(history["time_s"][-1]),
        "wall_s": wall,
        "triangles": sum(len(ply.triangles) for ply in plies),
        "tools": [
            {
                "name": tool.name,
                "displacement_m": float(history[f"{tool.name}_displacement_m"][-1]),
                **dict.fromkeys(("force_n", "max_force_n", "max_penetration_m")),
            }
            for tool in scene.tools
        ],
        "interfaces": [],
        "self_contact": [],
        "edge_contact": [],
        "plies": [
            _ply_entry(scene, number, ply, draped[number].net)
            | _defects(scene, number, ply, history)
            for number, ply in enumerate(plies)
        ],
        "reported": [],
    }


def _defects(
    scene: Setup, number: int, formed: FormedPly, history: Mapping[str, np.ndarray]
) -> dict[str, Any]:
    """What of a ply's defects its shape and shear tell; a net has none of the ply's wrinkles."""
    entries = defect_entries(scene, number, formed, history)
    entries["defects"]["wrinkles"] = None
    return entries


def _ply_entry(scene: Setup, number: int, formed: FormedPly, net: Net) -> dict[str, Any]:
    ply = scene.plies[number]
    shear, areas = np.abs(formed.shear_angle_deg), np.asarray(ply.mesh.areas)
    return {
        "name": ply.name,
        "fabric": ply.fabric.name,
        "woven": True,
        "triangles": len(formed.triangles),
        "max_shear_deg": float(shear.max()),
        "p95_shear_deg": area_percentile(shear, areas, 0.95),
        "mean_abs_shear_deg": float(np.average(shear, weights=areas)),
        "max_strain_warp": float(np.abs(formed.strain[:, 0]).max()),
        "max_strain_weft": float(np.abs(formed.strain[:, 1]).max()),
        "draw_in_m": draw_in(ply, formed.points),
        "net": {
            "spacing_m": net.spacing,
            "crossovers": net.count,
            "max_shear_deg": net.max_shear_deg,
            "start_m": net.points[net.middle].tolist(),
            "ends": [asdict(end) for end in net.ends],
        },
    }


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
            at, frames = row["time_s"], [ply.frame() for ply in plies]
            usd.write(number, at, frames, tool_ways(scene, moved), tool_angles(scene, at))
    if scene.write is not None:
        try:
            scene.write(result, folder)
        except Exception as error:
            add_warning(summary, "the scene's own files could not be written", error)
            folder.write_json(SUMMARY, summary)
