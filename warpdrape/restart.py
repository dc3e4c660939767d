"""A run as it was at a checkpoint: gathered, read back, checked against the scene, and put back.

What the steps write comes from `moving_arrays`; what the host keeps beside it is in a few small
records, `Clock`, `Seen` and `Tally`, each all that changes of its owner.
"""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from warpdrape.cadence import Cadence
from warpdrape.contact.squeeze import Squeeze
from warpdrape.dynamics.loading import Clock, Loading
from warpdrape.dynamics.model import Model
from warpdrape.dynamics.moving_arrays import moving_arrays, read_bytes, write_bytes
from warpdrape.dynamics.stepping import Stepper, refit
from warpdrape.errors import InputError, RunFailed
from warpdrape.recorder import Recorder, Tally
from warpdrape.results.checkpoint_file import (
    Checkpoint,
    damaged,
    read_checkpoint,
    write_checkpoint,
)
from warpdrape.results.fingerprint import differences, fingerprint
from warpdrape.results.frames_file import Mark, Marker
from warpdrape.results.run_folder import HISTORY, SCENE, RunFolder, partial_path
from warpdrape.results.tables import marked_rows
from warpdrape.timing import Timing, peak_speed
from warpdrape.watch import Seen

FRAMES = "frames: "
"""How the names of arrays begin that belong to the animation's file."""


@dataclass(frozen=True, eq=False)
class Restart:
    """A run as it was at a checkpoint.

    Attributes:
        folder: the run's.
        frame: the last one before it.
        blocks: of steps done.
        timing: the steps.
        clock: of the motions.
        seen: what the watch had seen.
        tally: what the recorder had counted.
        parts: the fingerprint.
        peak_speed: of tools and clamps, as contact searches allow for it [m/s].
        call: how the command line began it.
        history: mark of the rows.
        frames: mark of the animation.
        arrays: bytes of what the steps write.
    """

    folder: Path
    frame: int
    blocks: int
    timing: Timing
    clock: Clock
    seen: Seen
    tally: Tally
    parts: Mapping[str, Any]
    peak_speed: float
    call: Mapping[str, Any]
    history: Mapping[str, Any]
    frames: Mark
    arrays: Mapping[str, np.ndarray]

    @property
    def threads(self) -> int:
        """Of the run."""
        return int(self.parts["threads"])

    @property
    def duration(self) -> float:
        """Of the run [s]."""
        return float(self.parts["duration"])

    def floats(self, name: str, columns: int) -> np.ndarray:
        """An array of real numbers, shape [entry, columns]."""
        try:
            return self.arrays[name].view(np.float64).reshape(-1, columns)
        except (KeyError, ValueError) as error:
            raise damaged(self.folder, f"{name}: {error}") from error

    def at_end(self, name: str, rows: int) -> np.ndarray:
        """Entries of a table over the coming steps at the step that it has come to, shape [row]."""
        done = int(self.arrays["step"].view(np.int32)[0])
        return self.floats(name, self.floats(name, 1).size // rows)[:, done]

    def check(self, model: Model, threads: int, *, extending: bool) -> None:
        """Raise `InputError` if a model is not that of the run, saying where it differs."""
        ours = fingerprint(model, threads)
        odd = differences(ours, self.parts, extending=extending)
        mine, theirs = model.masses.stable_step, self.timing.stable_step
        if not odd and mine != theirs:
            odd.append(f"stable step = {mine!r} s, the run's {theirs!r}")
        if odd:
            more = f", and {len(odd) - 3} more" if len(odd) > 3 else ""
            raise InputError(
                f"{self.folder} cannot go on: {'; '.join(odd[:3])}{more}: give back what the run "
                "had, or run the scene anew with --overwrite"
            )
        if extending and peak_speed(model.scene) > self.peak_speed * (1.0 + 1e-9):
            raise InputError(
                f"{self.folder} cannot be extended at {peak_speed(model.scene):.4g} m/s: its tools "
                f"came to {self.peak_speed:.4g} m/s, for which contacts are sought; go slower"
            )

    def check_files(self) -> None:
        """Raise `InputError` unless frames and rows are those of the checkpoint."""
        scene, history = (
            final if (final := self.folder / name).exists() else partial_path(final)
            for name in (SCENE, HISTORY)
        )
        Marker(scene).check(self.frames)
        marked_rows(history, self.history)

    def put_back(self, stepper: Stepper) -> None:
        """Give a model's arrays what they held; raise `InputError` where they do not fit."""
        arrays = moving_arrays(stepper.parts)
        try:
            write_bytes(arrays, self.arrays)
        except ValueError as error:
            raise damaged(self.folder, str(error)) from error
        for part in stepper.parts:
            refit(part)


def read_restart(folder: Path) -> Restart | None:
    """Return what the checkpoint of a run folder holds, None without one.

    Raises:
        InputError: if it is damaged.
    """
    checkpoint = read_checkpoint(folder)
    if checkpoint is None:
        return None
    record, arrays = checkpoint.record, dict(checkpoint.arrays)
    try:
        squeeze = record["seen"]["squeeze"]
        if squeeze is not None:
            squeeze = Squeeze(**{**squeeze, "tools": tuple(squeeze["tools"])})
        frames = {name: arrays.pop(name) for name in list(arrays) if name.startswith(FRAMES)}
        return Restart(
            folder=folder,
            frame=int(record["frame"]),
            blocks=int(record["blocks"]),
            timing=Timing(**record["timing"]),
            clock=Clock(**record["clock"]),
            seen=Seen(**{**record["seen"], "squeeze": squeeze}),
            tally=Tally(**record["tally"]),
            parts=dict(record["parts"]),
            peak_speed=float(record["peak_speed"]),
            call=dict(record["call"]),
            history=dict(record["history"]),
            frames=Mark.of(record["frames"], frames),
            arrays=arrays,
        )
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise damaged(folder, f"{type(error).__name__}: {error}") from error


class Keeper:
    """Keeps checkpoints of a run as it goes."""

    def __init__(
        self,
        folder: RunFolder,
        cadence: Cadence,
        model: Model,
        loading: Loading,
        recorder: Recorder,
        stepper: Stepper,
        threads: int,
    ) -> None:
        """Nothing kept yet."""
        self._folder, self._cadence, self._model = folder, cadence, model
        self._loading, self._recorder, self._stepper = loading, recorder, stepper
        self._parts = fingerprint(model, threads)
        self._taken_at, self._cost = -np.inf, 0.0

    def at_frame(self, frame: int) -> None:
        """Keep a checkpoint if one is due, the first and the last frame's in any case.

        Raises:
            RunFailed: when the disk refuses.
        """
        now = time.perf_counter()
        final = frame == self._model.timing.frames
        if final or self._cadence.due(frame, now - self._taken_at, self._cost):
            self.take(frame, small=final)
            self._took(now)

    def between(self, frame: int, *, stopping: bool) -> None:
        """Keep a checkpoint between two blocks of steps if one is due, or the run is about to end.

        Args:
            frame: number of the last one.
            stopping: whether a signal asks the run to end: what was last kept stands then if the
                disk refuses.

        Raises:
            RunFailed: when the disk refuses.
        """
        now = time.perf_counter()
        if stopping:
            with suppress(RunFailed):
                self.take(frame)
        elif self._cadence.due(None, now - self._taken_at, self._cost):
            self.take(frame)
            self._took(now)

    def _took(self, begun: float) -> None:
        self._taken_at = time.perf_counter()
        self._cost = self._taken_at - begun

    def take(self, frame: int, *, small: bool = False) -> None:
        """Keep a checkpoint of the run as it is.

        Args:
            frame: number of the last one recorded.
            small: whether to take time to compress it.

        Raises:
            RunFailed: when the disk refuses.
        """
        frames, history = self._recorder.saved()
        record = {
            "frame": frame,
            "blocks": self._stepper.blocks,
            "timing": dataclasses.asdict(self._model.timing),
            "clock": dataclasses.asdict(self._loading.clock),
            "seen": dataclasses.asdict(self._recorder.watch.seen),
            "tally": dataclasses.asdict(self._recorder.tally),
            "parts": self._parts,
            "peak_speed": peak_speed(self._model.scene),
            "call": dict(self._model.scene.call),
            "history": history,
            "frames": frames.record(),
        }
        arrays = read_bytes(moving_arrays(self._stepper.parts))
        checkpoint = Checkpoint(record, {**arrays, **frames.arrays()})
        write_checkpoint(self._folder.path, checkpoint, small=small)
