"""Where the time of a run goes: the phases of a step, each timed alone on a copy of the state."""

from __future__ import annotations

import dataclasses
import statistics
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import warp as wp

from warpdrape.dynamics import launches
from warpdrape.dynamics.model import ASK_EVERY, Model, State
from warpdrape.dynamics.partition import Part, split

PER_STEP: dict[str, Callable[[Part], None]] = {
    "elements": launches.add_element_forces,
    "tool contact": launches.add_tool_contact,
    "ply contact": launches.add_ply_contact,
    "integration": launches.advance,
}
"""Phases of every step."""
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
    names = [field.name for field in dataclasses.fields(State)]
    scratch = State(**{name: wp.clone(getattr(state, name)) for name in names})

    def restore() -> None:
        for name in names:
            wp.copy(getattr(scratch, name), getattr(state, name))
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

    def captured(phase: Callable[[Part], None], count: int) -> Callable[[], None]:
        with wp.ScopedCapture(device=model.device) as capture:
            for _ in range(count):
                phase(whole)
        return lambda: wp.capture_launch(capture.graph)

    count, every = min(LAUNCHES, model.timing.steps_ahead), model.timing.search_every
    absent = (not model.scene.tools and "tool contact", not model.ply_pairs and "ply contact")
    costs = {
        name: timed(captured(phase, count)) / count
        for name, phase in PER_STEP.items()
        if name not in absent
    }
    if model.scene.tools:
        costs["tool search"] = timed(captured(launches.search_tools, 1)) / every
    if model.ply_pairs:
        ask = timed(lambda: launches.search_plies(whole, asking=True))
        walk = timed(lambda: launches.search_plies(whole, asking=False))
        costs["ply search"] = (ask + (ASK_EVERY - 1) * walk) / (ASK_EVERY * every)
    return costs


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
        self._phases = dict.fromkeys((*PER_STEP, "tool search", "ply search"), 0.0)
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
