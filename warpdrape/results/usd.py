"""The animation as USD: plies with yarn directions and shear per triangle, tools that move.

Frame k is time code k and 24 frames play in a second, so a slow-motion film of the run; the
simulated time of each frame is kept in ``/World.warpdrape:simulatedTime`` [s]. Frames are saved as
they come, those that come within half a second together, or that are small beside the file's index,
into ``.NAME.partial.usdc`` beside the final file; `UsdWriter.close` renames it. A killed run leaves
the partial file, which opens with the frames saved so far. The library updates the file's index in
place: what a kill or power cut inside the millisecond of a save spoils, a `Mark` takes back.
"""

from __future__ import annotations

import math
import os
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pxr import Gf, Sdf, Tf, Usd

from warpdrape.errors import InputError, RunFailed, said
from warpdrape.results.frame_data import PlyFrame, PlyShape, ToolShape
from warpdrape.results.frame_values import checked, frame_values
from warpdrape.results.frames_file import Mark, Marker, take_back
from warpdrape.results.run_folder import give_final_name, partial_path, to_disk
from warpdrape.results.usd_layer import check_space, open_layer
from warpdrape.results.usd_stage import (
    TIME_PATH,
    MeshPrim,
    define_materials,
    define_ply,
    define_tool,
    refuse_duplicates,
    set_up_stage,
    to_usd,
)

FRAMES_PER_SECOND = 24.0
"""Frames that a viewer plays in a second, by default."""
SAVE_EVERY = 0.5
"""Least time between two saves [s]: each costs as much as several frames, and a run that is killed
loses no more than the frames of that time, or of `INDEX_SHARE`."""
INDEX_SHARE = 0.05
"""Largest index that a save may leave behind, over the frames that it saves [-]. In place, each
save writes the places of all values so far anew: saved one by one, 240 frames would take 13 % more
room, and 1,000 half as much again."""
_PLACE_BYTES, _PAGE_BYTES = 8, 4096  # of one value of an attribute, in the index; of a disk


class UsdWriter:
    """Write the animation frame by frame; a context manager.

    Args:
        path: the final file, ``….usdc``; its folder exists and the file does not.
        plies: the plies, in the order in which `write` gets their frames.
        tools: the tools, in the order of `write`'s translations; may be empty.
        frames_per_second: frames that a viewer plays in a second.
        about: what the file says of where it comes from, such as program and scene.
        mark: go on from it, in the partial file; its last frame is ``last``.
        last: frame.

    Raises: InputError when a name appears twice, a mesh is unusable, a file is in the way, or the
        partial file is not the one of the mark.
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        plies: Sequence[PlyShape],
        tools: Sequence[ToolShape] = (),
        *,
        frames_per_second: float = FRAMES_PER_SECOND,
        about: Mapping[str, str] | None = None,
        mark: Mark | None = None,
        last: int = -1,
    ) -> None:
        self.path = Path(path)
        self.partial_path = partial_path(self.path)
        for taken in (self.path, self.partial_path) if mark is None else ():
            if taken.exists():
                raise InputError(f"path = {taken} exists already: remove it or choose another name")
        self._meshes = [MeshPrim.check("ply", p.name, p.rest_points, p.triangles) for p in plies]
        tool_meshes = [MeshPrim.check("tool", t.name, t.vertices, t.triangles) for t in tools]
        for kind, meshes in (("ply", self._meshes), ("tool", tool_meshes)):
            refuse_duplicates(kind, meshes)
        self._last = self._saved = last
        self._mark, self._marker = mark, Marker(self.partial_path)
        self._saved_at = time.monotonic()
        self._spoilt = False
        self._unsaved_bytes = 0
        if mark is not None:
            self._marker.check(mark)
            take_back(self.partial_path, mark)
        # Frames go into the layer itself: a stage over it would follow each of their values.
        self._layer: Any = open_layer(self.partial_path, new=mark is None)
        stage = Usd.Stage.Open(self._layer) if mark is None else Usd.Stage.CreateInMemory()
        set_up_stage(stage, frames_per_second, about)
        self._plies, self._tools = self._prims(stage, plies, tools, tool_meshes)
        if mark is None:
            self._save()

    def _prims(
        self,
        stage: Usd.Stage,
        plies: Sequence[PlyShape],
        tools: Sequence[ToolShape],
        tool_meshes: Sequence[MeshPrim],
    ) -> tuple[list[dict[str, Sdf.Path]], list[tuple[Sdf.Path, Sdf.Path | None]]]:
        """Define plies and tools; return where the values of each frame go."""
        cloth, metal = define_materials(stage)
        of_plies = [
            define_ply(stage, mesh, cloth, ply.at_vertices, ply.in_triangles)
            for mesh, ply in zip(self._meshes, plies, strict=True)
        ]
        of_tools = [
            define_tool(stage, mesh, metal, tool.axis, tool.point)
            for mesh, tool in zip(tool_meshes, tools, strict=True)
        ]
        return of_plies, of_tools

    def write(
        self,
        frame_index: int,
        time_s: float,
        ply_frames: Sequence[PlyFrame],
        tool_translations: ArrayLike = (),
        tool_angles: Sequence[float | None] | None = None,
    ) -> None:
        """Add one frame, and save it unless it is soon after the last save.

        All of it is added or, when a value is unusable, nothing.

        Args:
            frame_index: the time code; each one above the one before.
            time_s: simulated time [s].
            ply_frames: one per ply.
            tool_translations: displacement of each tool, or of the axis about which it turns,
                since the start [m], shape (tool, 3).
            tool_angles: turned about that axis [rad], None for tools that do not turn.

        Raises: ValueError naming ply and quantity when a value is not finite or a shape is wrong;
            RunFailed when the disk refuses.
        """
        if self._layer is None:
            raise ValueError(f"{self.path} is closed: no frame can be added")
        if frame_index <= self._last:
            raise ValueError(f"frame_index = {frame_index} must be above the last, {self._last}")
        if len(ply_frames) != len(self._plies):
            raise ValueError(f"{len(ply_frames)} ply frames for {len(self._plies)} plies")
        frames = [frame_values(m, f) for m, f in zip(self._meshes, ply_frames, strict=True)]
        moves, turns = self._ways(frame_index, tool_translations, tool_angles)
        if not np.isfinite(time_s):
            raise ValueError(f"time_s = {said(time_s)} of frame {frame_index} must be finite")
        size = sum(v.nbytes for values in frames for v in values.values())
        check_space(self.path.parent, self._unsaved_bytes + size, self._last)
        self._author(int(frame_index), float(time_s), frames, moves, turns)
        self._unsaved_bytes += size
        if time.monotonic() - self._saved_at >= SAVE_EVERY and self._worth_saving():
            self._save()

    def _ways(
        self, frame_index: int, translations: ArrayLike, angles: Sequence[float | None] | None
    ) -> tuple[NDArray[np.float64], list[float | None]]:
        """Where the tools have come to and how far they have turned, checked."""
        moves = np.asarray(translations, np.float64)
        if not self._tools:
            moves = moves.reshape(-1, 3)
        moves = checked("tools", "translation", moves, (len(self._tools), 3))
        turns: list[float | None] = [*([None] * len(self._tools) if angles is None else angles)]
        for (_, angle_path), angle in zip(self._tools, turns, strict=True):
            if angle_path is not None and (angle is None or not np.isfinite(angle)):
                raise ValueError(f"angle = {said(angle)} of frame {frame_index} must be finite")
        return moves, turns

    def _worth_saving(self) -> bool:
        """Whether the frames not saved yet are large beside the index that a save leaves behind."""
        attributes = sum(map(len, self._plies)) + len(self._tools)
        index = _PLACE_BYTES * attributes * (self._last + 1)
        return index <= max(INDEX_SHARE * self._unsaved_bytes, _PAGE_BYTES)

    def _author(
        self,
        frame: int,
        time_s: float,
        ply_values: Sequence[dict[str, NDArray]],
        moves: NDArray[np.float64],
        turns: Sequence[float | None],
    ) -> None:
        with Sdf.ChangeBlock():
            for attributes, values in zip(self._plies, ply_values, strict=True):
                for name, path in attributes.items():
                    self._layer.SetTimeSample(path, frame, to_usd(values[name]))
            for (path, angle_path), move, turn in zip(self._tools, moves, turns, strict=True):
                self._layer.SetTimeSample(path, frame, Gf.Vec3d(*map(float, move)))
                if angle_path is not None and turn is not None:
                    self._layer.SetTimeSample(angle_path, frame, math.degrees(turn))
            self._layer.SetTimeSample(TIME_PATH, frame, time_s)
            if self._last < 0:
                self._layer.startTimeCode = frame
            self._layer.endTimeCode = frame
        self._last = frame

    def save(self) -> None:
        """Save the frames that are not yet on the disk.

        Raises: RunFailed when the disk refuses.
        """
        if self._saved < self._last and not self._spoilt:
            self._save()

    def mark(self) -> Mark:
        """Save, wait for the disk, and return the file as it is, to be taken back to.

        Raises: RunFailed when the disk refuses.
        """
        self.save()
        try:
            to_disk(self.partial_path)
            self._mark = self._marker.mark()
        except OSError as error:
            raise RunFailed(
                f"{self.partial_path} cannot be read back ({error.strerror}): leave the folder in "
                "place while the run goes on"
            ) from error
        return self._mark

    def close(self) -> None:
        """Give the file its final name; without a frame, or after a failed save, leave none.

        Raises: RunFailed when the disk refuses the frames not saved yet.
        """
        if self._layer is None:
            return
        try:
            self.save()
        finally:
            self._let_go()

    def _let_go(self) -> None:
        self._layer = None  # the library lets go of the file, as Windows wants before a rename
        if self._spoilt and self._mark is not None:
            with suppress(OSError):
                take_back(self.partial_path, self._mark)
                self._spoilt = False
        if self._last < 0 or self._spoilt:
            if self._mark is None:
                self.partial_path.unlink(missing_ok=True)
            return
        give_final_name(self.partial_path, self.path)
        stale = Sdf.Layer.Find(str(self.path))
        if stale:  # someone in this process still looks at an older file of this name
            stale.Reload(True)

    def __enter__(self) -> UsdWriter:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _save(self) -> None:
        try:
            self._layer.Save()
            self._saved, self._saved_at, self._unsaved_bytes = self._last, time.monotonic(), 0
        except Tf.ErrorException as error:
            self._spoilt = True
            kept = "goes back to its last checkpoint" if self._mark else "is lost"
            raise RunFailed(
                f"{self.partial_path} could not be saved at frame {self._last} and {kept}: "
                "is the disk full, or the folder gone? Free some space or write elsewhere"
            ) from error
