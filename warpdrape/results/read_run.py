"""A run folder read back: the `Result` that the run returned, at any of its frames.

Plies and tools come from ``scene.usdc``, which holds single precision: seven digits, so that a
point of a ply a metre wide is off by 0.06 µm at most. History and summary are exact. Nothing in the
folder is executed, and no file outside it is opened.
"""

from __future__ import annotations

import os
from copy import copy
from dataclasses import MISSING, fields
from itertools import compress
from pathlib import Path
from typing import Any

import numpy as np
from pxr import Usd, UsdGeom

from warpdrape.errors import InputError
from warpdrape.results.fields import FIELDS
from warpdrape.results.result import FormedPly, PlacedTool, Result
from warpdrape.results.run_folder import HISTORY, RUN, SCENE, SUMMARY
from warpdrape.results.run_tables import (
    AGAIN,
    check_whole,
    read_history,
    read_record,
    read_summary,
)
from warpdrape.results.usd import PlyFrame
from warpdrape.results.usd_stage import MAY_BE_EMPTY
from warpdrape.results.usd_values import (
    damage_named,
    damaged,
    numbers,
    open_alone,
    placed_tool,
    triangles_of,
)


def read_run(folder: str | os.PathLike[str], *, frame: int = -1) -> Result:
    """Read a run folder.

    Args:
        folder: the run folder.
        frame: frame of plies and tools; negative ones count from the end. Summary and history are
            those of the whole run.

    Returns:
        What the run returned, in the single precision of the USD file.

    Raises:
        InputError: if the folder is none, unfinished or damaged, or has no such frame.
    """
    return RunReader(folder).result(frame)


class RunReader:
    """A run folder that is opened once and read at several frames.

    Attributes:
        folder: the run folder.
        summary: as in ``summary.json``.
        history: column name → values over the frames.
        frames: how many there are.
    """

    def __init__(self, folder: str | os.PathLike[str]) -> None:
        """Open a folder; raise `InputError` if it is none, unfinished or damaged."""
        self.folder = Path(folder)
        check_whole(self.folder)
        self.summary = read_summary(self.folder)
        self._stage = open_alone(self._scene)
        self.history = read_history(self.folder)
        with damage_named(self._scene):
            self._plies, self._tools = self._meshes("plies"), self._meshes("tools")
            self._check_plies()
            self._times = self._plies[0].GetPointsAttr().GetTimeSamples()
        self.frames = len(self.history["time_s"])
        if len(self._times) != self.frames:
            raise InputError(
                f"run folder {self.folder}: {SCENE} has {len(self._times)} frames and {HISTORY} "
                f"{self.frames}: the files are of different runs, or damaged; {AGAIN}"
            )

    def ply_thicknesses(self) -> list[float]:
        """Thickness of every ply's fabric [m], from the record of the run.

        Raises:
            InputError: if ``run.json`` is missing or damaged.
        """
        record = read_record(self.folder, needed=("plies", "fabrics"))
        fabric_of = {ply["name"]: record["fabrics"][ply["fabric"]] for ply in record["plies"]}
        names = self._names()
        if not fabric_of.keys() >= set(names):
            raise InputError(f"{self.folder / RUN} has other plies than {SUMMARY}: {AGAIN}")
        return [float(fabric_of[name]["thickness"]) for name in names]

    def woven(self) -> RunReader:
        """The run with the plies only that have yarns: no sheets of rubber, no films.

        Raises:
            InputError: if it has none.
        """
        kept = [ply.get("woven", True) is not False for ply in self.summary["plies"]]
        if all(kept):
            return self
        if not any(kept):
            raise InputError(f"run folder {self.folder} has no plies of woven fabrics")
        part = copy(self)
        part._plies = list(compress(self._plies, kept))
        part.summary = {**self.summary, "plies": list(compress(self.summary["plies"], kept))}
        return part

    def _names(self) -> list[str]:
        return [ply["name"] for ply in self.summary["plies"]]

    def result(self, frame: int = -1) -> Result:
        """Return the run at a frame; negative ones count from the end."""
        if isinstance(frame, bool) or not isinstance(frame, int | np.integer):
            raise InputError(f"frame = {frame!r} must be a whole number")
        if not -self.frames <= frame < self.frames:
            raise InputError(
                f"frame = {frame} is out of range: {self.folder} has frames 0 to {self.frames - 1}"
            )
        time = Usd.TimeCode(self._times[frame])
        names = self._names()
        with damage_named(self._scene):
            plies = [self._ply(m, n, time) for m, n in zip(self._plies, names, strict=True)]
            tools = [
                PlacedTool(name, *placed_tool(self._scene, mesh, name, time))
                for mesh, name in zip(self._tools, self._tool_names(), strict=True)
            ]
        at = int(frame) % self.frames
        return Result(tuple(plies), self.summary, self.history, tuple(tools), at)

    @property
    def _scene(self) -> Path:
        return self.folder / SCENE

    def _meshes(self, folder: str) -> list[UsdGeom.Mesh]:
        root = self._stage.GetPrimAtPath(f"/World/{folder}")
        return [UsdGeom.Mesh(prim) for prim in root.GetChildren()] if root else []

    def _tool_names(self) -> list[str]:
        names = [tool["name"] for tool in self.summary["tools"]]
        if len(names) != len(self._tools):
            names = [mesh.GetPrim().GetName() for mesh in self._tools]
        return names

    def _check_plies(self) -> None:
        """Raise `InputError` where the plies of the animation are not those of the summary."""
        said = [ply["triangles"] for ply in self.summary["plies"]]
        counts = [mesh.GetFaceVertexCountsAttr().Get() for mesh in self._plies]
        found = [len(count) if count else 0 for count in counts]
        if not found or said != found:
            raise InputError(
                f"run folder {self.folder}: {SCENE} has plies of {found} triangles and {SUMMARY} "
                f"of {said}: the files are of different runs, or damaged; {AGAIN}"
            )

    def _ply(self, mesh: UsdGeom.Mesh, name: str, time: Usd.TimeCode) -> FormedPly:
        primvars = UsdGeom.PrimvarsAPI(mesh)
        rest = numbers(
            self._scene, primvars.GetPrimvar("restPoints").Get(), f"{name}: restPoints", None
        )
        n = len(rest)
        triangles = triangles_of(self._scene, mesh, name, n)
        values: dict[str, np.ndarray | None] = {}
        for field in FIELDS:
            if not primvars.HasPrimvar(field.primvar):
                continue
            found = primvars.GetPrimvar(field.primvar).Get(time)
            if field.name in MAY_BE_EMPTY and found is not None and len(found) == 0:
                values[field.name] = None
                continue
            shape = field.shape(n, len(triangles))
            values[field.name] = numbers(self._scene, found, f"{name}: {field.primvar}", shape)
        missing = _ALWAYS - set(values)
        if missing:
            raise damaged(self._scene, f"ply {name!r} lacks {', '.join(sorted(missing))}")
        points = numbers(self._scene, mesh.GetPointsAttr().Get(time), f"{name}: points", (n, 3))
        moment: dict[str, Any] = {"points": points, **values}
        return FormedPly.from_frame(name, rest, triangles, PlyFrame(**moment))


_ALWAYS = {field.name for field in fields(PlyFrame) if field.default is MISSING} - {"points"}
"""Quantities that every ply has."""
