"""Where the time of a run goes: the phases of a step, each timed alone on a copy of the state."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial

import warp as wp

from warpdrape.dynamics import integration
from warpdrape.dynamics.model import Model
from warpdrape.dynamics.partition import launches_of, shares, split
from warpdrape.interaction import Launch, Launches, Swept
from warpdrape.state import State, all_arrays, copied
from warpdrape.timing import ask_every

LAUNCHES = 20
"""Steps of one phase that are timed together."""
REPEAT = 3
"""Timings of which the median counts."""
SAMPLES = 8
"""Frames of a run at which its phases are timed."""


def time_phases(
    model: Model, state: State, clock: Callable[[], float] = time.perf_counter
) -> dict[str, float]:
    """Time of each phase for one step [s], a search's shared out over the steps up to the next.

    Nothing of the state changes. For searches that cost what they cost in the run, call it at the
    end of a block of steps.

    Args:
        model: the model.
        state: its state.
        clock: a clock [s].
    """
    scratch = copied(state)
    pairs = [
        (to, array)
        for (_, to, _), (_, array, _) in zip(all_arrays(scratch), all_arrays(state), strict=True)
    ]

    def restore() -> None:
        for to, array in pairs:
            wp.copy(to, array)
        scratch.step.zero_()  # the tables of prescribed motion begin there

    def timed(run: Callable[[], None]) -> float:
        seconds = []
        for _ in range(REPEAT + 1):  # the first one warms up
            restore()
            wp.synchronize_device(model.device)
            start = clock()
            run()
            wp.synchronize_device(model.device)
            seconds.append(clock() - start)
        return statistics.median(seconds[1:])

    (whole,) = split(model, scratch, 1)
    (share,) = shares(model, 1)

    count, every = min(LAUNCHES, model.timing.steps_ahead), model.timing.search_every
    cycle = ask_every(model.scene.numerics)
    costs: dict[str, float] = {}
    searches: dict[str, float] = {}
    of_each = launches_of(model, share, scratch)
    meshes = [mesh for launches in of_each for mesh in launches.refit]
    points = [wp.clone(mesh.points) for mesh in meshes]
    for thing, launches in zip(model.interactions, of_each, strict=True):
        forces = launches.scatter + launches.push
        if forces:
            run = partial(_launch, forces, model.device)
            costs[thing.name] = timed(_captured(run, model.device, count)) / count
        if thing.searches:
            asking, walking = _searches(launches, model.device)
            spent = timed(asking) + (cycle - 1) * timed(walking)
            searches[thing.searches] = spent / (cycle * every)
    for mesh, before in zip(meshes, points, strict=True):  # the run's searches go on asking them
        wp.copy(mesh.points, before)
        mesh.refit()
    advance = partial(integration.advance, whole)
    costs["integration"] = timed(_captured(advance, model.device, count)) / count
    return costs | searches


def _launch(launches: Sequence[Launch | Swept], device: str) -> None:
    for launch in launches:
        launch(device)


def _captured(phase: Callable[[], None], device: str, count: int = 1) -> Callable[[], None]:
    """Replay of so many of a phase."""
    with wp.ScopedCapture(device=device) as capture:
        for _ in range(count):
            phase()
    return lambda: wp.capture_launch(capture.graph)


def _searches(launches: Launches, device: str) -> tuple[Callable[[], None], Callable[[], None]]:
    """A search in which every vertex asks, and one in which it goes on from what it remembers."""
    before, ask, walk = (
        _captured(partial(_launch, stage, device), device)
        for stage in (
            launches.prepare + launches.copy,
            launches.measure + launches.ask,
            launches.prepare + launches.measure + launches.walk,
        )
    )

    def asking() -> None:
        before()
        for mesh in launches.refit:
            mesh.refit()
        ask()

    return asking, walk


class Profile:
    """Adds up the wall time of a run by phase."""

    def __init__(self, model: Model, *, sampling: bool) -> None:
        """Start at zero.

        Args:
            model: the model.
            sampling: whether to time the phases of the steps now and then.
        """
        self._model, self._sampling = model, sampling
        self._seconds = {"stepping": 0.0, "results": 0.0, "output": 0.0, "profiling": 0.0}
        things = [*model.forces, *model.contacts]
        names = [thing.name for thing in things]
        names += ["integration", *(thing.searches for thing in things if thing.searches)]
        self._phases = dict.fromkeys(names, 0.0)
        self._sampled = self._steps = 0

    @contextmanager
    def timed(self, name: str) -> Iterator[None]:
        """Count what happens inside as "stepping", "results", "output" or "profiling"."""
        start = time.perf_counter()
        try:
            yield
        finally:
            self._seconds[name] += time.perf_counter() - start

    def sample(self, state: State, frame: int, steps: int) -> None:
        """Time the phases at a frame, should it be time to; they count since the sample before.

        Args:
            state: the state now.
            frame: its number.
            steps: done so far.
        """
        timing = self._model.timing
        if not self._sampling or frame * SAMPLES // timing.frames == (
            self._sampled * SAMPLES // timing.frames
        ):
            return
        with self.timed("profiling"):
            for name, cost in time_phases(self._model, state).items():
                self._phases[name] += (steps - self._steps) * cost
            self._sampled, self._steps = frame, steps

    def seconds(self) -> dict[str, float]:
        """Wall time by phase [s]; "Python" is what the phases leave of the stepping.

        Where they take longer alone, on one thread, than the stepping did on several, they are
        shown in proportion.
        """
        others = dict(self._seconds)
        stepping, alone = others.pop("stepping"), sum(self._phases.values())
        part = min(1.0, stepping / alone) if alone > 0.0 else 1.0
        phases = {name: part * spent for name, spent in self._phases.items()}
        return {**phases, "Python": stepping - part * alone, **others}


def phase_table(seconds: dict[str, float]) -> str:
    """Lines for a terminal: phase, wall time, share.

    Args:
        seconds: wall time by phase [s].
    """
    whole = sum(seconds.values())
    lines = ["where the time went        s   share"]
    for name, spent in seconds.items():
        if spent > 0.0:
            lines.append(f"  {name:16} {spent:9.3f} {100 * spent / whole:6.1f} %")
    return "\n".join(lines)
