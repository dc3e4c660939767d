"""A run from start to end: checks, frames, results, and what happens when it goes wrong."""

from __future__ import annotations

import os
import time
from collections.abc import Mapping
from contextlib import closing
from typing import Any

import numpy as np

from warpdrape.contact.closing import closing_tools
from warpdrape.dynamics.crew import choose_threads
from warpdrape.dynamics.energy import (
    balance,
    internal_energy,
    kinetic_energy,
    measure,
)
from warpdrape.dynamics.loading import Loading
from warpdrape.dynamics.model import Model, build_model, initial_state
from warpdrape.dynamics.phases import Profile
from warpdrape.dynamics.start_check import (
    check_clamps,
    check_contacts,
    check_loading,
    check_sheets,
    check_steps,
    check_tools,
)
from warpdrape.dynamics.stepping import Stepper
from warpdrape.errors import InputError, RunFailed
from warpdrape.interaction import Measured
from warpdrape.results.defects import DefectWatch
from warpdrape.results.history import history_row
from warpdrape.results.progress import Progress
from warpdrape.results.result import (
    FormedPly,
    Result,
    read_plies,
    shown_at_vertices,
    shown_of_defects,
)
from warpdrape.results.run_folder import RUN, SUMMARY, HistoryWriter, RunFolder, as_json
from warpdrape.results.run_record import run_record
from warpdrape.results.summary import summarise
from warpdrape.results.usd import PlyShape, ToolShape, UsdWriter
from warpdrape.setup import Setup
from warpdrape.state import State
from warpdrape.warp_start import check_device
from warpdrape.watch import Watch, loose_plies, where_it_blew_up


def run_scene(
    scene: Setup,
    out: str | os.PathLike | None,
    *,
    device: str,
    frames: int,
    overwrite: bool,
    quiet: bool,
    profile: bool,
    threads: int | None,
) -> Result:
    """Compute a scene; see `Setup.run`."""
    if isinstance(frames, bool) or not isinstance(frames, int) or frames < 1:
        raise InputError(f"frames = {frames!r} must be a whole number above zero")
    check_device(device)
    triangles = sum(len(ply.mesh.triangles) for ply in scene.plies)
    threads = choose_threads(threads, device, triangles)
    folder = None if out is None else RunFolder(out, overwrite)
    check_sheets(scene)
    check_tools(scene)
    check_clamps(scene)
    check_loading(scene)
    model = build_model(scene, device, frames)
    check_steps(model)
    state = initial_state(model)
    check_contacts(model, state)
    loading = Loading(scene, model.timing)
    recorder = Recorder(model, folder, loading, threads=threads, profile=profile)
    try:
        with Progress(scene.duration, quiet=quiet) as progress:
            if not quiet:
                for closing in closing_tools(scene):
                    progress.say(f"warning: {closing}")
            progress.say(f"{model.timing.steps:,} steps of {1e6 * model.timing.time_step:.3g} µs")
            failure = _march(model, state, threads, loading, recorder, progress)
    except Exception as error:  # a fault of ours: keep the frames, then let it be seen
        recorder.finish(f"stopped by an unexpected {type(error).__name__}: {error}")
        raise
    return recorder.finish(failure)


def _march(
    model: Model,
    state: State,
    threads: int,
    loading: Loading,
    recorder: Recorder,
    progress: Progress,
) -> str:
    """Step through all frames; return why it stopped early, or an empty text."""
    try:
        with closing(Stepper(model, state, threads)) as stepper:
            recorder.record(state, 0)
            words = ""
            for frame in range(1, model.timing.frames + 1):
                with recorder.profile.timed("stepping"):
                    _step_frame(model, state, stepper, loading, frame, recorder, progress, words)
                recorder.profile.sample(state, frame, recorder.steps)
                row = recorder.record(state, frame)
                words = f"max shear {row['max_shear_deg']:.1f}°"
                progress.update(loading.time, words, steps=recorder.steps)
    except RunFailed as reason:
        return str(reason)
    except KeyboardInterrupt:
        return "interrupted by the user"
    return ""


def _step_frame(
    model: Model,
    state: State,
    stepper: Stepper,
    loading: Loading,
    frame: int,
    recorder: Recorder,
    progress: Progress,
    words: str,
) -> None:
    """Do the steps that lead to a frame; raise `RunFailed` if a vertex runs away.

    ``words`` go with the progress, which is shown between frames too.
    """
    timing = model.timing
    while not loading.come_to(frame):
        times = loading.stretch(frame)
        stepper.begin(times)
        done = 0
        for _ in range((len(times) - 1) // timing.search_every):
            stepper.block()
            recorder.steps += timing.search_every
            done += timing.search_every
            progress.update(float(times[done]), words, steps=recorder.steps)
            vertex = int(state.plies.runaway.numpy()[0])
            if vertex >= 0:
                when = recorder.steps * timing.time_step
                raise RunFailed(where_it_blew_up(model, vertex, when))
        if loading.limited:
            loading.adapt(kinetic_energy(model, state)[0], internal_energy(model, state))


class Recorder:
    """Keeps history and last good frame, and writes the run folder as the run goes."""

    def __init__(
        self,
        model: Model,
        folder: RunFolder | None,
        loading: Loading,
        *,
        threads: int = 1,
        profile: bool = False,
    ) -> None:
        """Open the run folder, if there is one; with ``profile``, time the phases of the steps."""
        self.steps, self._steps_before, self._loading = 0, 0, loading
        self.profile = Profile(model, sampling=profile)
        self._profiled = profile
        self._model, self._folder = model, folder
        self._watch, self._defects = Watch(model), DefectWatch(model.scene)
        self._rows: list[dict[str, float]] = []
        self._plies: tuple[FormedPly, ...] = ()
        self._measured: tuple[Measured, ...] = ()
        self._loose: tuple[str, ...] = ()
        self._started = time.perf_counter()
        self._usd: UsdWriter | None = None
        self._history: HistoryWriter | None = None
        if folder is not None:
            scene = model.scene
            folder.begin()
            folder.write_json(RUN, run_record(scene, model, model.timing.frames, threads))
            self._history = folder.history()
            self._usd = UsdWriter(
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
                [ToolShape(t.name, t.vertices, t.triangles) for t in scene.tools],
            )

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
        if self._history is not None:
            with self.profile.timed("output"):
                self._history.append(row)
                frames = [ply.frame() for ply in self._plies]
                self._usd.write(frame, row["time_s"], frames, state.tools.shift.numpy())
        return row

    def _take_down(self, state: State) -> dict[str, float]:
        model, loading = self._model, self._loading
        measured = measure(model, state)
        energies = balance(model, state, measured)
        now, steps = loading.simulated, self.steps - self._steps_before
        plies = read_plies(model, state, measured)
        self._watch.look(state, plies, energies, now)
        plies = self._defects.look(plies, state.tools.shift.numpy())
        before = self._rows[-1] if self._rows else None
        row = history_row(model, state, now, loading.time, steps, energies, plies, before)
        for name, value in row.items():
            if not np.isfinite(value):
                raise RunFailed(f"blew up at {1e3 * now:.4g} ms: {name} is {value}; lower safety")
        state.tools.impulse.zero_()
        state.clamps.force.zero_()
        self._rows.append(row)
        self._steps_before = self.steps
        self._plies, self._measured = plies, measured
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
        model = self._model
        failure = failure or self._save_frames()
        summary = summarise(
            model,
            self._measured,
            history,
            self._plies,
            self._loading,
            failure=failure,
            grown=self._watch.grown,
            loose=self._loose,
            squeezed=self._watch.squeezed,
            steps=self.steps,
            wall=wall,
        )
        self._defects.add_at_end(summary, self._plies)
        if self._profiled:
            summary["phases_s"] = self.profile.seconds()
        result = Result(self._plies, summary, history)
        summary["reported"] = []
        if model.scene.report is not None and not failure:
            self._add_report(result, summary)
        self._close(result, summary)
        return result

    def _save_frames(self) -> str:
        """Save the frames that are not yet on the disk; return why that failed, or nothing."""
        if self._usd is not None:
            with self.profile.timed("output"):
                try:
                    self._usd.save()
                except RunFailed as reason:
                    return str(reason)
        return ""

    def _add_report(self, result: Result, summary: dict[str, Any]) -> None:
        """Add what the scene itself reports; a fault in that must not cost the result."""
        try:
            entries = as_json(self._model.scene.report(result), "report")
        except Exception as error:
            fault = f"{type(error).__name__}: {error}"
            summary["warnings"].append(f"the scene's report failed: {fault}")
            return
        summary.update(entries)
        summary["reported"] = list(entries)

    def _close(self, result: Result | None, summary: Mapping[str, Any]) -> None:
        """Give the files their final names, the summary last."""
        if self._folder is None:
            return
        self._usd.close()
        self._history.close()
        self._folder.write_json(SUMMARY, summary)
        write = self._model.scene.write
        if write is not None and result is not None and summary["status"] == "completed":
            write(result, self._folder)
