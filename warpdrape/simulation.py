"""A run from start to end: checks, frames, results, and what happens when it goes wrong."""

from __future__ import annotations

import os
import time
from bisect import bisect_right
from collections.abc import Mapping, Sequence
from contextlib import closing
from typing import Any

import numpy as np

from warpdrape.blanks.ply import Ply
from warpdrape.contact.closing import closing_tools
from warpdrape.contact.passages import Passages
from warpdrape.contact.squeeze import worst_squeeze
from warpdrape.dynamics.crew import choose_threads
from warpdrape.dynamics.energy import (
    Energies,
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
from warpdrape.results.history import history_row
from warpdrape.results.progress import Progress
from warpdrape.results.result import FormedPly, Result, read_plies, shown_at_vertices
from warpdrape.results.run_folder import RUN, SUMMARY, HistoryWriter, RunFolder, as_json
from warpdrape.results.run_record import run_record
from warpdrape.results.summary import ENERGY_FAILURE, summarise
from warpdrape.results.usd import PlyShape, ToolShape, UsdWriter
from warpdrape.setup import Setup
from warpdrape.state import State
from warpdrape.warp_start import check_device


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


def where_it_blew_up(model: Model, vertex: int, when: float) -> str:
    """Say when and in which ply and triangle a vertex ran away."""
    return (
        f"blew up at {1e3 * when:.4g} ms in {place(model, vertex)}: faster than "
        f"{model.medium.speed_limit:.4g} m/s; lower safety or contact_share, slow the tools down, "
        "or refine the mesh there"
    )


def ply_of(model: Model, vertex: int) -> Ply:
    """The ply of a vertex."""
    firsts = [span.first_vertex for span in model.spans]
    return model.scene.plies[bisect_right(firsts, vertex) - 1]


def place(model: Model, vertex: int) -> str:
    """Name the ply, and a triangle in it, of a vertex."""
    ply = ply_of(model, vertex)
    local = vertex - model.spans[model.scene.plies.index(ply)].first_vertex
    triangle = int(np.argmax((np.asarray(ply.mesh.triangles) == local).any(axis=1)))
    return f"ply {ply.name!r}, triangle {triangle} (vertex {local})"


def loose_plies(model: Model, state: State, measured: Sequence[Measured]) -> tuple[str, ...]:
    """Names of the plies that nothing has held or touched so far: contact always loses energy."""
    lost = state.plies.lost.numpy()[:, :2].any(axis=1)
    held = {clamp.ply for clamp in model.scene.clamps}
    touched = frozenset().union(*(each.touched for each in measured))
    return tuple(
        ply.name
        for number, (ply, span) in enumerate(zip(model.scene.plies, model.spans, strict=True))
        if ply.name not in held and number not in touched and not lost[span.vertices].any()
    )


SQUEEZED = 0.05
"""Share of its thickness by which a ply is squeezed between tools before that is said [-]."""


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
        self._passages = Passages(model.scene, model.spans, model.device)
        self._rows: list[dict[str, float]] = []
        self._plies: tuple[FormedPly, ...] = ()
        self._measured: tuple[Measured, ...] = ()
        self._grown, self._loose = 0.0, ()
        self._squeeze, self._squeezed_words = None, ""
        laws = [ply.fabric.compaction for ply in model.scene.plies]
        counts = [span.vertex_count for span in model.spans]
        self._rooms = np.repeat([law.room if law else 0.0 for law in laws], counts)
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
                    PlyShape(p.name, p.rest_points, p.mesh.triangles, shown_at_vertices(scene, p))
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
        self._refuse_nonsense(plies, now)
        self._note_squeeze(state, now)
        self._refuse_passage(state, now)
        self._refuse_growth(state, energies, now)
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

    def _refuse_nonsense(self, plies: tuple[FormedPly, ...], now: float) -> None:
        """Raise `RunFailed` with ply and triangle where a value is not finite."""
        for ply in plies:
            values = (ply.warp, ply.weft, ply.shear_angle, ply.strain, ply.line_tension)
            if all(np.isfinite(array).all() for array in (ply.points, *values)):
                continue
            bad = ~np.isfinite(ply.points).all(axis=1)[ply.triangles].all(axis=1)
            for array in values:
                bad |= ~np.isfinite(array.reshape(len(bad), -1)).all(axis=1)
            if bad.any():
                raise RunFailed(
                    f"blew up at {1e3 * now:.4g} ms in ply {ply.name!r}, triangle "
                    f"{int(np.argmax(bad))}: its values are not finite; lower safety"
                )

    def _refuse_growth(self, state: State, energies: Energies, now: float) -> None:
        """Raise `RunFailed` where energy came from nowhere, with the place that moves fastest."""
        model = self._model
        speed = model.medium.speed_limit / 100.0
        scale = max(energies.largest, 0.5 * float(model.masses.mass.sum()) * speed**2)
        if not energies.unbalanced <= ENERGY_FAILURE * scale:
            self._grown = energies.unbalanced / scale
            fastest = int(np.argmax((state.plies.v.numpy() ** 2).sum(axis=1)))
            if self._squeeze is not None:
                raise RunFailed(self._squeezed_words)
            raise RunFailed(
                f"energy grew without work at {1e3 * now:.4g} ms, fastest in "
                f"{place(model, fastest)}: {energies.unbalanced:.4g} J of {scale:.4g} J came from "
                "nowhere; lower safety or contact_share, or refine the tools"
            )

    def _note_squeeze(self, state: State, now: float) -> None:
        """Keep the deepest squeeze of the run, in words."""
        model = self._model
        found = worst_squeeze(model.interactions, state, self._rooms)
        least = SQUEEZED if self._squeeze is None else self._squeeze.share
        if found is None or not least < found.share:
            return
        law = ply_of(model, found.vertex).fabric.compaction
        one, other = (model.scene.tools[tool].name for tool in found.tools)
        x, y, _ = 1e3 * state.plies.x.numpy()[found.vertex]
        self._squeeze = found
        least = f"its thickness of {1e3 * found.thickness:.3g} mm"
        why = (
            "that of the contact's numerical stiffness; leave the ply its thickness between them, "
            "or give its fabric a compaction law"
        )
        if law is not None:
            least = f"{1e3 * law.thinnest:.3g} mm, the least thickness of its compaction law,"
            why = "extrapolated; measure to higher pressures, or leave the ply more room"
        self._squeezed_words = (
            f"tools {one!r} and {other!r} squeeze {place(model, found.vertex)} "
            f"{1e3 * found.depth:.3g} mm below {least} at {1e3 * now:.4g} ms, "
            f"({x:.4g}, {y:.4g}) mm: their force there is {why}"
        )

    def _refuse_passage(self, state: State, now: float) -> None:
        """Raise `RunFailed` where a tool has passed through a ply between its vertices."""
        found = self._passages.deepest(state)
        if found is None:
            return
        scene, before = self._model.scene, ""
        if self._squeeze is not None and found.tool in self._squeeze.tools:
            before = f"; before that, {self._squeezed_words}"
        ply, tool = scene.plies[found.ply], scene.tools[found.tool]
        x, y = 1e3 * ply.rest_points[ply.mesh.triangles[found.triangle]].mean(axis=0)[:2]
        raise RunFailed(
            f"tool {tool.name!r} passed through ply {ply.name!r} by {1e3 * now:.4g} ms: it reaches "
            f"{1e3 * found.depth:.3g} mm or more beyond triangle {found.triangle}, at ({x:.4g}, "
            f"{y:.4g}) mm of the flat ply, whose sides are {1e3 * found.side:.3g} mm long: refine "
            f"the ply there, or slow the tool down{before}"
        )

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
            grown=self._grown,
            loose=self._loose,
            squeezed=self._squeezed_words,
            steps=self.steps,
            wall=wall,
        )
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
