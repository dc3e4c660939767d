"""A run from start to end: checks, steps, frames, checkpoints, and what happens when it fails."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import closing, contextmanager, nullcontext
from dataclasses import dataclass, field, replace

from warpdrape.announcement import announcement
from warpdrape.cadence import Cadence, read_cadence
from warpdrape.contact.closing import closing_tools
from warpdrape.contact.tools_at_start import check_tools
from warpdrape.dynamics.crew import choose_threads
from warpdrape.dynamics.energy import kinetic_energy, taken_energy
from warpdrape.dynamics.loading import Loading
from warpdrape.dynamics.model import Model, build_model, initial_state
from warpdrape.dynamics.start_check import (
    check_clamps,
    check_contacts,
    check_loading,
    check_sheets,
    check_steps,
)
from warpdrape.dynamics.stepping import Stepper
from warpdrape.errors import InputError, RunFailed, said
from warpdrape.extension import check_motions, longer
from warpdrape.recorder import Recorder
from warpdrape.restart import Keeper, Restart, read_restart
from warpdrape.results.progress import Progress
from warpdrape.results.result import Result
from warpdrape.results.run_folder import RunFolder
from warpdrape.setup import Setup
from warpdrape.state import State
from warpdrape.stops import Stops
from warpdrape.warp_start import cache_damage, check_device

FRAMES = 60
"""Frames of a run after the first, where nothing else is asked."""


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
    """Compute a scene; see `Scene.run`."""
    if frames is not None and (
        isinstance(frames, bool) or not isinstance(frames, int) or frames < 1
    ):
        raise InputError(f"frames = {said(frames)} must be a whole number above zero")
    cadence = read_cadence(checkpoint)
    check_device(device)
    folder = _folder(out, resume, overwrite)
    earlier = None
    place = nullcontext() if folder is None else closing(folder)
    with Stops() as stops, place, _cache_watched():
        if folder is not None and resume is not None:
            folder.take()
            earlier = read_restart(folder.path)
        if extend and earlier is None:
            raise InputError("extend needs a run with a checkpoint: give resume, its folder")
        if earlier is not None and threads is None:
            threads = earlier.threads
        triangles = sum(len(ply.mesh.triangles) for ply in scene.plies)
        threads = choose_threads(threads, device, triangles)
        model, state = _prepare(scene, device, frames, threads, earlier, extend)
        stops.check()
        loading = Loading(model.scene, model.timing, None if earlier is None else earlier.clock)
        run = _Run(model, state, threads, folder, loading, cadence, stops, earlier, extend)
        return run.compute(quiet=quiet, profile=profile)


@contextmanager
def _cache_watched() -> Iterator[None]:
    """Say what to do where a compiled kernel cannot be loaded."""
    try:
        yield
    except Exception as error:
        words = cache_damage(error)
        if not words:
            raise
        raise RunFailed(words) from error


def _folder(
    out: str | os.PathLike | None, resume: str | os.PathLike | None, overwrite: bool
) -> RunFolder | None:
    if resume is None:
        return None if out is None else RunFolder(out, overwrite)
    if out is not None:
        raise InputError(f"out = {out} and resume = {resume}: a run goes on in its own folder")
    return RunFolder.of_run(resume)


def prepare(scene: Setup, device: str, frames: int) -> tuple[Model, State]:
    """Check everything that must hold before the first step; return the model and its state.

    Args:
        scene: what is computed.
        device: "cpu" or "cuda:0".
        frames: after the first.

    Raises:
        InputError: naming what cannot be run.
    """
    check_sheets(scene)
    check_tools(scene)
    check_clamps(scene)
    check_loading(scene)
    model = build_model(scene, device, frames)
    check_steps(model)
    state = initial_state(model)
    check_contacts(model, state)
    return model, state


def _prepare(
    scene: Setup,
    device: str,
    frames: int | None,
    threads: int,
    earlier: Restart | None,
    extend: bool,
) -> tuple[Model, State]:
    """Check everything, and build the model and its state at the start."""
    if earlier is None:
        return prepare(scene, device, frames or FRAMES)
    if extend:
        scene, timing = longer(scene, frames, earlier)
    else:
        timing = replace(earlier.timing, frames=frames or earlier.timing.frames)
    model = build_model(scene, device, timing.frames, timing)
    check_steps(model)
    earlier.check(model, threads, extending=extend)
    earlier.check_files()
    if extend:
        check_motions(model, earlier)
    return model, initial_state(model)


@dataclass(eq=False)
class _Run:
    """A run that is ready to go."""

    model: Model
    state: State
    threads: int
    folder: RunFolder | None
    loading: Loading
    cadence: Cadence | None
    stops: Stops
    earlier: Restart | None
    extend: bool
    recorder: Recorder = field(init=False)
    progress: Progress = field(init=False)

    def compute(self, *, quiet: bool, profile: bool) -> Result:
        """Step through all frames, and close the files whatever happens."""
        model, loading = self.model, self.loading
        self.recorder = Recorder(
            model,
            self.folder,
            loading,
            threads=self.threads,
            profile=profile,
            earlier=self.earlier,
        )
        try:
            begun = (loading.here, self.recorder.steps)
            with Progress(model.scene.duration, quiet=quiet, begun=begun) as self.progress:
                self._announce(quiet)
                failure = self._march()
        except Exception as error:  # a fault of ours: keep the frames, then let it be seen
            self.recorder.finish(f"stopped by an unexpected {type(error).__name__}: {error}")
            raise
        return self.recorder.finish(failure)

    def _announce(self, quiet: bool) -> None:
        if quiet:
            return
        for words in closing_tools(self.model.scene) if self.earlier is None else ():
            self.progress.say(f"warning: {words}")
        first = 0 if self.earlier is None else self.earlier.frame
        written = self.folder is not None
        self.progress.say(announcement(self.model, self.state, first, written=written))

    def _march(self) -> str:
        """Step through all frames; return why it stopped early, or an empty text."""
        blocks = 0 if self.earlier is None else self.earlier.blocks
        try:
            with closing(Stepper(self.model, self.state, self.threads, blocks)) as stepper:
                keeper = self._keeper(stepper)
                first = self._begin(stepper, keeper)
                words = ""
                for frame in range(first + 1, self.model.timing.frames + 1):
                    with self.recorder.profile.timed("stepping"):
                        self._step_frame(stepper, keeper, frame, words)
                    self.recorder.profile.sample(self.state, frame, self.recorder.steps)
                    row = self.recorder.record(self.state, frame)
                    if keeper is not None:
                        keeper.at_frame(frame)
                    words = f"max shear {row['max_shear_deg']:.1f}°"
                    self.progress.update(self.loading.time, words, steps=self.recorder.steps)
        except RunFailed as reason:
            return str(reason)
        except KeyboardInterrupt:
            return "interrupted by the user"
        return ""

    def _keeper(self, stepper: Stepper) -> Keeper | None:
        if self.folder is None or self.cadence is None:
            return None
        return Keeper(
            self.folder,
            self.cadence,
            self.model,
            self.loading,
            self.recorder,
            stepper,
            self.threads,
        )

    def _begin(self, stepper: Stepper, keeper: Keeper | None) -> int:
        """Record the first frame, or put back what a checkpoint holds; return its frame."""
        if self.earlier is None:
            self.recorder.record(self.state, 0)
            if keeper is not None:
                keeper.at_frame(0)
            return 0
        self.earlier.put_back(stepper)
        self.recorder.look_again(self.state)
        if self.extend and keeper is not None:
            keeper.take(self.earlier.frame)
        return self.earlier.frame

    def _step_frame(self, stepper: Stepper, keeper: Keeper | None, frame: int, words: str) -> None:
        """Do the steps that lead to a frame, or those of them that are left.

        Args:
            stepper: does them.
            keeper: keeps checkpoints between blocks of them, None for none.
            frame: its number.
            words: go with the progress, which is shown between frames too.

        Raises:
            RunFailed: if a vertex runs away, or a signal asks the run to end.
        """
        loading = self.loading
        while loading.left or not loading.come_to(frame):
            if not loading.left:
                stepper.begin(loading.stretch(frame))
            while loading.left:
                self._do_block(stepper, words)
                if not loading.left and loading.limited:
                    kinetic = kinetic_energy(self.model, self.state)[0]
                    loading.adapt(kinetic, taken_energy(self.model, self.state))
                if keeper is not None:
                    keeper.between(frame - 1, stopping=self.stops.asked)
                self.stops.check()

    def _do_block(self, stepper: Stepper, words: str) -> None:
        """Do a block of the steps that have begun; raise `RunFailed` if a vertex runs away."""
        timing, recorder = self.model.timing, self.recorder
        stepper.block()
        recorder.tally.steps += timing.search_every
        self.loading.did(timing.search_every)
        self.progress.update(self.loading.here, words, steps=recorder.steps)
        vertex = int(self.state.plies.runaway.numpy()[0])
        if vertex >= 0:
            when = recorder.steps * timing.time_step
            raise RunFailed(recorder.watch.where_it_blew_up(vertex, when))
