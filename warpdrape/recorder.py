"""What a run takes down as it goes: rows, frames, the last good one, and the summary at its end."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from warpdrape.dynamics.energy import balance, measure
from warpdrape.dynamics.loading import Loading
from warpdrape.dynamics.model import Model
from warpdrape.dynamics.phases import Profile
from warpdrape.errors import RunFailed
from warpdrape.interaction import Measured
from warpdrape.results.defects import DefectWatch
from warpdrape.results.frame_data import PlyShape
from warpdrape.results.frames_file import Mark
from warpdrape.results.history import history_row, tool_angles, tool_ways
from warpdrape.results.result import FormedPly, Result
from warpdrape.results.run_folder import HISTORY, RUN, SUMMARY, RunFolder, as_json
from warpdrape.results.run_record import run_record
from warpdrape.results.snapshot import (
    place_tools,
    read_plies,
    shown_at_vertices,
    shown_of_defects,
    tool_shape,
)
from warpdrape.results.summary import add_warning, summarise
from warpdrape.results.tables import HistoryWriter
from warpdrape.results.usd import UsdWriter
from warpdrape.state import State
from warpdrape.tools.pose import Pose
from warpdrape.watch import Watch, loose_plies

if TYPE_CHECKING:
    from warpdrape.restart import Restart


@dataclass
class Tally:
    """What a `Recorder` counts.

    Attributes:
        steps: done so far.
        steps_before: done by the last row.
        wall: time taken up to the last checkpoint [s].
    """

    steps: int = 0
    steps_before: int = 0
    wall: float = 0.0


@dataclass(frozen=True)
class _Files:
    """A run's folder and the files that grow in it."""

    folder: RunFolder
    history: HistoryWriter
    usd: UsdWriter


class Recorder:
    """Keeps history and last good frame, and writes the run folder as the run goes.

    Attributes:
        tally: what it counts.
        watch: what looks for what is wrong.
        profile: where the time goes.
    """

    def __init__(
        self,
        model: Model,
        folder: RunFolder | None,
        loading: Loading,
        *,
        threads: int = 1,
        profile: bool = False,
        earlier: Restart | None = None,
    ) -> None:
        """Open the run folder, if there is one.

        Args:
            model: the model.
            folder: to write, None for none.
            loading: the clock of the motions.
            threads: of the run.
            profile: whether to time the phases of the steps.
            earlier: the run that goes on, as it was at its checkpoint.
        """
        self.tally = Tally() if earlier is None else earlier.tally
        self.profile = Profile(model, sampling=profile)
        self._profiled, self._loading = profile, loading
        self._model = model
        self.watch = Watch(model, None if earlier is None else earlier.seen)
        self._defects = DefectWatch(model.scene)
        self._rows: list[dict[str, float]] = []
        self._plies: tuple[FormedPly, ...] = ()
        self._measured: tuple[Measured, ...] = ()
        self._loose: tuple[str, ...] = ()
        self._poses: list[Pose] = []
        self._started = time.perf_counter() - self.tally.wall
        self._files: _Files | None = None
        if folder is not None:
            self._files = self._open(folder, threads, earlier)

    def _open(self, folder: RunFolder, threads: int, earlier: Restart | None) -> _Files:
        """Begin the files of the run, or go on in them."""
        scene, path = self._model.scene, folder.path / HISTORY
        folder.take()
        if earlier is None:
            folder.begin()
        else:
            folder.go_on()
        record = run_record(scene, self._model, self._model.timing.frames, threads)
        folder.write_json(RUN, record)
        history = HistoryWriter(path, None if earlier is None else earlier.history)
        self._rows = history.rows
        usd = UsdWriter(
            folder.scene_path,
            [
                PlyShape(
                    p.name,
                    p.rest_points,
                    p.mesh.triangles,
                    shown_at_vertices(scene, p),
                    shown_of_defects(p),
                )
                for p in scene.plies
            ],
            [tool_shape(tool) for tool in scene.tools],
            about={
                "program": "warpdrape",
                "version": record["versions"]["warpdrape"],
                "scene": scene.name,
            },
            mark=None if earlier is None else earlier.frames,
            last=-1 if earlier is None else earlier.frame,
        )
        return _Files(folder, history, usd)

    @property
    def steps(self) -> int:
        """Done so far."""
        return self.tally.steps

    def saved(self) -> tuple[Mark, dict[str, Any]]:
        """Bring frames and rows of a run with a folder to the disk, and mark where they end.

        Raises:
            RunFailed: when the disk refuses.
        """
        self.tally.wall = time.perf_counter() - self._started
        if self._files is None:
            raise ValueError("the run writes no folder: it has nothing to go on in")
        with self.profile.timed("output"):
            return self._files.usd.mark(), self._files.history.mark()

    def look_again(self, state: State) -> None:
        """Take the last good frame from a state that was put back.

        Between frames that is the state itself: what a run has that fails before its next frame.
        """
        self._keep(state, measure(self._model, state))

    def _keep(self, state: State, measured: tuple[Measured, ...]) -> None:
        plies = read_plies(self._model, state, measured)
        self._poses = state.tools.poses()
        self._plies = self._defects.look(plies, self._poses)
        self._measured = measured
        self._loose = loose_plies(self._model, state, measured)

    def record(self, state: State, frame: int) -> dict[str, float]:
        """Take down a frame.

        Args:
            state: the state now.
            frame: its number.

        Returns:
            The row of the history.

        Raises:
            RunFailed: if a number is not finite, or energy came from nowhere; nothing is kept then.
        """
        with self.profile.timed("results"):
            row = self._take_down(state)
        if self._files is not None:
            with self.profile.timed("output"):
                self._files.history.append(row)
                frames = [ply.frame() for ply in self._plies]
                ways = tool_ways(self._model.scene, self._poses)
                angles = tool_angles(self._model.scene, self._loading.time)
                self._files.usd.write(frame, row["time_s"], frames, ways, angles)
        return row

    def _take_down(self, state: State) -> dict[str, float]:
        model, loading = self._model, self._loading
        measured = measure(model, state)
        energies = balance(model, state, measured)
        now, steps = loading.simulated, self.steps - self.tally.steps_before
        plies = read_plies(model, state, measured)
        self.watch.look(state, plies, energies, measured, now)
        poses = state.tools.poses()
        plies = self._defects.look(plies, poses)
        before = self._rows[-1] if self._rows else None
        row = history_row(model, state, now, loading.time, steps, energies, plies, measured, before)
        for name, value in row.items():
            if not np.isfinite(value):
                raise RunFailed(f"blew up at {1e3 * now:.4g} ms: {name} is {value}; lower safety")
        state.tools.impulse.zero_()
        state.tools.twist.zero_()
        state.clamps.force.zero_()
        self._rows.append(row)
        self.tally.steps_before = self.steps
        self._plies, self._measured, self._poses = plies, measured, poses
        self._loose = loose_plies(model, state, measured)
        return row

    def finish(self, failure: str) -> Result:
        """Close the files and say how it went; ``failure`` is empty where it went well.

        Raises:
            RunFailed: if not even the first frame is there.
        """
        wall = time.perf_counter() - self._started
        if not self._rows:
            self._close(None, {"status": "failed", "message": failure})
            raise RunFailed(failure)
        history = {name: np.array([row[name] for row in self._rows]) for name in self._rows[0]}
        model, seen = self._model, self.watch.seen
        failure = failure or self._save_frames()
        summary = summarise(
            model,
            self._measured,
            history,
            self._plies,
            self._loading,
            failure=failure,
            grown=seen.grown,
            loose=self._loose,
            squeezed=seen.squeezed,
            depths=seen.depths,
            steps=self.steps,
            wall=wall,
        )
        self._defects.add_at_end(summary, self._plies)
        if self._profiled:
            summary["phases_s"] = self.profile.seconds()
        result = Result(self._plies, summary, history, place_tools(model.scene, self._poses))
        summary["reported"] = []
        if model.scene.report is not None and not failure:
            self._add_report(model.scene.report, result, summary)
        self._close(result, summary)
        return result

    def _save_frames(self) -> str:
        """Save the frames that are not yet on the disk; return why that failed, or nothing."""
        if self._files is not None:
            with self.profile.timed("output"):
                try:
                    self._files.usd.save()
                except RunFailed as reason:
                    return str(reason)
        return ""

    @staticmethod
    def _add_report(
        report: Callable[[Result], Mapping[str, Any]], result: Result, summary: dict[str, Any]
    ) -> None:
        """Add what the scene itself reports; a fault in that must not cost the result."""
        try:
            entries = as_json(report(result), "report")
        except Exception as error:
            add_warning(summary, "the scene's report failed", error)
            return
        summary.update(entries)
        summary["reported"] = list(entries)

    def _close(self, result: Result | None, summary: dict[str, Any]) -> None:
        """Give the files their final names, the summary last."""
        if self._files is None:
            return
        folder = self._files.folder
        with ExitStack() as last:  # each is done even where another fails, the summary last
            last.callback(folder.write_json, SUMMARY, summary)
            if result is not None and summary["status"] == "completed":
                last.callback(self._add_files, folder, result, summary)
            last.callback(self._files.history.close)
            last.callback(self._files.usd.close)

    def _add_files(self, folder: RunFolder, result: Result, summary: dict[str, Any]) -> None:
        """Let the scene write its own files; a fault in that must not cost the result."""
        write = self._model.scene.write
        if write is None:
            return
        try:
            write(result, folder)
        except Exception as error:
            add_warning(summary, "the scene's own files could not be written", error)
