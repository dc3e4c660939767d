"""A run as the report's page holds it: meshes, frames, fields, lines along yarns, tools."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warpdrape.report.packing import Blocks, step
from warpdrape.results.fields import FIELDS, fields_of
from warpdrape.results.quantities import QUANTITIES
from warpdrape.results.read_run import RunReader
from warpdrape.results.result import FormedPly, PlacedTool, Result
from warpdrape.results.tool_distance import TOOL_DISTANCE, ToolDistances
from warpdrape.results.yarn_lines import on_blank, round_spacing, yarn_lines
from warpdrape.tools.pose import Pose, pose_between

MOST_VALUES = 6_000_000
"""Values of a page that frames are left out for: about 9 MB of it."""
LEAST_FRAMES = 7
"""Frames that are kept all the same, so that a motion can be seen."""
_AT_VERTICES = {field.primvar for field in FIELDS if field.at_vertices} | {TOOL_DISTANCE}


@dataclass(frozen=True, eq=False)
class PlyFrames:
    """A ply over the frames shown.

    Attributes:
        name: its name.
        rest: the flat blank [m], shape [n, 3].
        triangles: shape [m, 3].
        points: [m], shape [frame, n, 3].
        values: field → its values with their sign, in the unit shown, shape [frame, m or n].
        along: direction of warp and of weft on the blank, unit, each shape [2].
    """

    name: str
    rest: NDArray[np.float64]
    triangles: NDArray[np.int64]
    points: NDArray[np.float64]
    values: dict[str, NDArray[np.float64]]
    along: tuple[NDArray[np.float64], NDArray[np.float64]]


@dataclass(frozen=True, eq=False)
class ToolFrames:
    """A tool over the frames shown.

    Attributes:
        name: its name.
        vertices: at the first frame [m], shape [n, 3].
        triangles: shape [m, 3].
        poses: where it is from there, at each frame.
    """

    name: str
    vertices: NDArray[np.float64]
    triangles: NDArray[np.int64]
    poses: list[Pose]


@dataclass(frozen=True, eq=False)
class RunFrames:
    """A run over the frames shown.

    Attributes:
        frames: their numbers, shape [frame].
        of: how many the run has.
        plies: in stacking order.
        tools: as in the run.
    """

    frames: NDArray[np.int64]
    of: int
    plies: Sequence[PlyFrames]
    tools: Sequence[ToolFrames]

    @cached_property
    def box(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Lowest and highest corner of where the plies ever are [m]."""
        low = np.min([ply.points.min(axis=(0, 1)) for ply in self.plies], axis=0)
        high = np.max([ply.points.max(axis=(0, 1)) for ply in self.plies], axis=0)
        return low, np.maximum(high, low + 1e-9)

    @property
    def resolution(self) -> float:
        """Distance of neighbouring places that the page can hold [m]."""
        low, high = self.box
        return max(step(a, b) for a, b in zip(low, high, strict=True))


def read_frames(reader: RunReader, most: int | None, share: float = 1.0) -> RunFrames:
    """Read the frames of a run that a page shows.

    Args:
        reader: the run.
        most: how many at most; if None, as many as keep the page small.
        share: part of the page that is this run's [-].
    """
    last = reader.result()
    if most is None:
        most = max(int(share * MOST_VALUES / _values_a_frame(last)), LEAST_FRAMES)
    count = max(min(most, reader.frames), 1)
    chosen = np.unique(np.rint(np.linspace(reader.frames - 1, 0, count)).astype(np.int64))
    results = [reader.result(int(frame)) for frame in chosen]
    distances = None
    if last.tools:
        distances = ToolDistances([(tool.vertices, tool.triangles) for tool in results[0].tools])
    plies = [
        _ply_frames([result.plies[k] for result in results], results, distances)
        for k in range(len(last.plies))
    ]
    tools = [_tool_frames([result.tools[k] for result in results]) for k in range(len(last.tools))]
    return RunFrames(chosen, reader.frames, plies, tools)


def _values_a_frame(result: Result) -> int:
    """How many values a frame of a run has."""
    total = 0
    for ply in result.plies:
        scalars = sum(len(v) for f, v in fields_of(ply).items() if f.name not in ("warp", "weft"))
        total += 3 * len(ply.points) + scalars + (len(ply.points) if result.tools else 0)
    return total


def _ply_frames(
    moments: Sequence[FormedPly], results: Sequence[Result], distances: ToolDistances | None
) -> PlyFrames:
    first, last = moments[0], moments[-1]
    triangles = np.asarray(first.triangles, np.int64)
    fields = [{field.primvar: values for field, values in fields_of(p).items()} for p in moments]
    values = {
        name: np.stack([quantity.with_sign(each[quantity.primvar]) for each in fields])
        for name, quantity in QUANTITIES.items()
        if all(quantity.primvar in each for each in fields)
    }
    if distances is not None:
        (name,) = (name for name, q in QUANTITIES.items() if q.primvar == TOOL_DISTANCE)
        ways = [
            distances.of(ply.points, [tool.vertices for tool in result.tools])
            for ply, result in zip(moments, results, strict=True)
        ]
        values[name] = QUANTITIES[name].with_sign(np.stack(ways).ravel()).reshape(len(ways), -1)
    warp, weft = (
        on_blank(last.rest_points, last.points, triangles, way) for way in (last.warp, last.weft)
    )
    points = np.stack([ply.points for ply in moments])
    return PlyFrames(first.name, first.rest_points, triangles, points, values, (warp, weft))


def _tool_frames(moments: Sequence[PlacedTool]) -> ToolFrames:
    first = moments[0]
    poses = [pose_between(first.vertices, tool.vertices) for tool in moments]
    return ToolFrames(first.name, first.vertices, np.asarray(first.triangles, np.int64), poses)


def pack_run(run: RunFrames, blocks: Blocks) -> dict[str, Any]:
    """Return what the page is told of a run's shapes; the numbers go into ``blocks``."""
    low, high = run.box
    spacing = round_spacing(run.plies[0].rest)
    bounds = {
        name: _bounds([ply.values[name] for ply in run.plies if name in ply.values])
        for name in QUANTITIES
        if any(name in ply.values for ply in run.plies)
    }
    return {
        "frames": run.frames.tolist(),
        "of": run.of,
        "low": low.tolist(),
        "high": high.tolist(),
        "spacing": spacing,
        "plies": [_pack_ply(ply, run, bounds, spacing, blocks) for ply in run.plies],
        "tools": [_pack_tool(tool, blocks) for tool in run.tools],
    }


def _pack_ply(
    ply: PlyFrames,
    run: RunFrames,
    bounds: dict[str, tuple[float, float]],
    spacing: float,
    blocks: Blocks,
) -> dict[str, Any]:
    rest_low, rest_high = ply.rest.min(axis=0), ply.rest.max(axis=0)
    yarns = []
    for direction in ply.along:
        lines = yarn_lines(ply.rest, ply.triangles, direction, spacing)
        count = len(lines.triangles)
        ends = blocks.values(lines.weights.reshape(1, -1), 0.0, 1.0) if count else None
        triangles = blocks.whole_numbers(lines.triangles) if count else None
        yarns.append({"triangles": triangles, "weights": ends, "count": count})
    return {
        "name": ply.name,
        "vertices": len(ply.rest),
        "triangles": len(ply.triangles),
        "corners": blocks.whole_numbers(ply.triangles),
        "rest": blocks.values(ply.rest[None], rest_low, rest_high),
        "restLow": rest_low.tolist(),
        "restHigh": rest_high.tolist(),
        "points": blocks.values(ply.points, *run.box),
        "yarns": yarns,
        "fields": {
            name: {
                "block": blocks.values(values, *bounds[name]),
                "low": bounds[name][0],
                "high": bounds[name][1],
                "atVertices": QUANTITIES[name].primvar in _AT_VERTICES,
            }
            for name, values in ply.values.items()
        },
    }


def _pack_tool(tool: ToolFrames, blocks: Blocks) -> dict[str, Any]:
    low, high = tool.vertices.min(axis=0), tool.vertices.max(axis=0)
    return {
        "name": tool.name,
        "vertices": len(tool.vertices),
        "triangles": len(tool.triangles),
        "corners": blocks.whole_numbers(tool.triangles),
        "points": blocks.values(tool.vertices[None], low, high),
        "low": low.tolist(),
        "high": high.tolist(),
        "places": [_columns(pose) for pose in tool.poses],
    }


def _columns(pose: Pose) -> list[float]:
    """The matrix that places a tool, column by column, as WebGL has them."""
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = pose.turned, pose.shift
    return matrix.ravel(order="F").tolist()


def _bounds(values: Sequence[NDArray[np.float64]]) -> tuple[float, float]:
    return min(float(v.min()) for v in values), max(float(v.max()) for v in values)
