"""Read a scene's plies and tools at one frame, from nothing but the run folder's USD file."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from pxr import Usd, UsdGeom

from warpdrape.errors import InputError, one_of
from warpdrape.results.fields import FIELDS, Field
from warpdrape.results.quantities import QUANTITIES, Quantity
from warpdrape.results.run_folder import SCENE, partial_path
from warpdrape.results.tool_distance import TOOL_DISTANCE, ToolDistances
from warpdrape.results.usd_stage import TIME_ATTRIBUTE
from warpdrape.results.usd_values import (
    damage_named,
    numbers,
    open_alone,
    placed_tool,
    triangles_of,
)


@dataclass(frozen=True)
class PlyView:
    """One ply at one frame, over n vertices and m triangles.

    Args:
        name: its name in the file.
        points: vertex positions [m], shape (n, 3).
        rest: the flat blank [m], shape (n, 3).
        triangles: vertex numbers, shape (m, 3).
        warp: unit warp directions, shape (m, 3).
        weft: unit weft directions, shape (m, 3).
        values: of the quantity to show, in its unit, shape (m,) or at vertices (n,).
    """

    name: str
    points: NDArray[np.float64]
    rest: NDArray[np.float64]
    triangles: NDArray[np.int64]
    warp: NDArray[np.float64]
    weft: NDArray[np.float64]
    values: NDArray[np.float64]


Surface = tuple[NDArray[np.float64], NDArray[np.int64]]
"""Vertices [m] and triangles of a tool."""


@dataclass(frozen=True)
class SceneView:
    """What is there at one frame; ``time_s`` is the simulated time [s], NaN if not recorded."""

    time_s: float
    plies: list[PlyView]
    tools: list[Surface]


def find_scene(run_folder: str | os.PathLike[str]) -> Path:
    """Return the USD file of a run folder, or the USD file itself; raise `InputError` if none."""
    path = Path(run_folder)
    if path.is_file() and path.suffix in (".usdc", ".usda", ".usd"):
        return path
    if not path.is_dir():
        raise InputError(f"run folder {path} does not exist: give the folder of a finished run")
    scene = path / SCENE
    if not scene.is_file():
        partial = partial_path(scene)
        remedy = (
            f"the run still goes on or was cut off; if it was, draw {partial}"
            if partial.is_file()
            else "give the folder of a finished run"
        )
        raise InputError(f"run folder {path} holds no {SCENE}: {remedy}")
    return scene


def read_scene(
    path: Path, names: Sequence[str] | None, frame: int, quantity: Quantity = QUANTITIES["shear"]
) -> SceneView:
    """Return the named plies (all when None) and all tools at one frame.

    Args:
        path: the USD file.
        names: names of plies.
        frame: which frame; negative ones count from the end.
        quantity: of the plies.

    Raises: InputError for an unreadable file, an unknown ply, a frame out of range, or a quantity
        that the run does not have.
    """
    (view,) = read_moments(path, names, [frame], quantity)
    return view


def read_moments(
    path: Path, names: Sequence[str] | None, frames: Sequence[int] | None, quantity: Quantity
) -> list[SceneView]:
    """Return what `read_scene` does, at several frames; at all of them when None."""
    with damage_named(path):
        return _Reader(open_alone(path), path, quantity).read(names, frames)


class _Reader:
    """Reads frames of an open stage."""

    def __init__(self, stage: Usd.Stage, path: Path, quantity: Quantity) -> None:
        self._stage, self._path, self._quantity = stage, path, quantity
        root = stage.GetPrimAtPath("/World/plies")
        self._plies = {p.GetName(): p for p in root.GetChildren()} if root else {}
        tools = stage.GetPrimAtPath("/World/tools")
        self._tools = tools.GetChildren() if tools else []
        self._distances: ToolDistances | None = None

    def read(self, names: Sequence[str] | None, frames: Sequence[int] | None) -> list[SceneView]:
        """Read the named plies at frames; all plies, or frames, for None."""
        if not self._plies:
            raise InputError(
                f"{self._path} holds no plies under /World/plies: give a run of warpdrape"
            )
        for name in names or ():
            one_of("ply", name, self._plies)
        first = next(iter(self._plies.values()))
        times = UsdGeom.Mesh(first).GetPointsAttr().GetTimeSamples()
        if not times:
            raise InputError(f"{self._path} has no frames: the run stopped before the first")
        wanted = range(len(times)) if frames is None else frames
        for frame in wanted:
            if not -len(times) <= frame < len(times):
                last = len(times) - 1
                raise InputError(
                    f"frame = {frame} is out of range: {self._path} has frames 0 to {last}"
                )
        chosen = [self._plies[name] for name in names or self._plies]
        return [self._moment(chosen, Usd.TimeCode(times[frame])) for frame in wanted]

    def _moment(self, plies: Sequence[Usd.Prim], time: Usd.TimeCode) -> SceneView:
        recorded = self._stage.GetPrimAtPath("/World").GetAttribute(TIME_ATTRIBUTE)
        tools = [
            placed_tool(self._path, UsdGeom.Mesh(prim), prim.GetName(), time)
            for prim in self._tools
        ]
        return SceneView(
            time_s=float(recorded.Get(time)) if recorded else float("nan"),
            plies=[self._ply(prim, time, tools) for prim in plies],
            tools=tools,
        )

    def _ply(self, prim: Usd.Prim, time: Usd.TimeCode, tools: list[Surface]) -> PlyView:
        mesh, primvars = UsdGeom.Mesh(prim), UsdGeom.PrimvarsAPI(prim)
        self._check_quantity(prim, primvars, time)

        name = prim.GetName()
        rest = numbers(
            self._path, primvars.GetPrimvar("restPoints").Get(), f"{name}: restPoints", None
        )
        triangles = triangles_of(self._path, mesh, name, len(rest))

        def values(field: Field) -> NDArray[np.float64]:
            found = primvars.GetPrimvar(field.primvar).Get(time)
            shape = field.shape(len(rest), len(triangles))
            return numbers(self._path, found, f"{name}: {field.primvar}", shape)

        found = mesh.GetPointsAttr().Get(time)
        points = numbers(self._path, found, f"{name}: points", rest.shape)
        if self._quantity.primvar == TOOL_DISTANCE:
            shown = self._distance(points, tools)
        else:
            shown = values(_FIELD[self._quantity.primvar])
        return PlyView(
            name=name,
            points=points,
            rest=rest,
            triangles=triangles,
            warp=values(_FIELD["warp"]),
            weft=values(_FIELD["weft"]),
            values=self._quantity.of(shown),
        )

    def _check_quantity(
        self, prim: Usd.Prim, primvars: UsdGeom.PrimvarsAPI, time: Usd.TimeCode
    ) -> None:
        there = [
            name
            for name, q in QUANTITIES.items()
            if _given(primvars, q.primvar, time) or (q.primvar == TOOL_DISTANCE and self._tools)
        ]
        if self._quantity not in (QUANTITIES[name] for name in there):
            raise InputError(
                f"ply {prim.GetName()!r} has no {self._quantity.title} in this run; it has: "
                + ", ".join(there)
            )

    def _distance(self, points: NDArray[np.float64], tools: list[Surface]) -> NDArray[np.float64]:
        if self._distances is None:
            self._distances = ToolDistances(tools)
        return self._distances.of(points, [vertices for vertices, _ in tools])


def _given(primvars: UsdGeom.PrimvarsAPI, name: str, time: Usd.TimeCode) -> bool:
    """Whether a ply has values of a primvar; it is empty where an approach gives none."""
    return primvars.HasPrimvar(name) and len(primvars.GetPrimvar(name).Get(time) or ()) > 0


_FIELD = {field.primvar: field for field in FIELDS}
