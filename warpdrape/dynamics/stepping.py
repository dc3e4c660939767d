"""The steps of a run, in blocks of a search and the steps up to the next one."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
import warp as wp

from warpdrape.dynamics import integration
from warpdrape.dynamics.cores import SpareCores
from warpdrape.dynamics.crew import Barrier, Crew
from warpdrape.dynamics.model import Model
from warpdrape.dynamics.pace import Pace
from warpdrape.dynamics.partition import Part, split
from warpdrape.dynamics.prescribed import prescribe
from warpdrape.dynamics.selective_mass import SelectiveMass
from warpdrape.interaction import Launch, Swept
from warpdrape.state import State
from warpdrape.timing import ask_every, frame_times

FEW_STEPS = range(6, 13)
"""Steps that one graph may hold: a replay costs some 10 µs, less than a hundredth of six steps."""
Section = Callable[[Part, Sequence[Part]], None]
"""Launches that a part can make, given all parts, while the others are in the same section."""


def search_contacts(model: Model, state: State, *, asking: bool = True) -> None:
    """Find what each vertex may touch until the next search.

    Args:
        model: the model.
        state: its state.
        asking: whether every vertex asks for the facet nearest to it; else it walks there.
    """
    (whole,) = split(model, state, 1)
    _launch(whole, whole.launches.prepare)
    if asking:
        _launch(whole, whole.launches.copy)
        refit(whole)
    for section in search_sections(asking=asking):
        section(whole, [whole])


def refit(part: Part) -> None:
    """Refit the query meshes that a part has in its care."""
    for mesh in part.launches.refit:
        mesh.refit()


def step(whole: Part) -> None:
    """Advance everything by one step, for a part that is the whole."""
    for section in step_sections(1, whole.model.selective):
        section(whole, [whole])


def search_sections(*, asking: bool) -> list[Section]:
    """What of a search comes after the refit; a part goes on when all others have come as far.

    Args:
        asking: whether every vertex asks for the facet nearest to it; else it walks there.
    """
    return [_measure, _ask if asking else _walk]


def step_sections(count: int, scaling: SelectiveMass | None) -> list[Section]:
    """So many steps, likewise, each with the powers of selective mass scaling.

    Part 0 moves the tools while the others scatter: nothing there depends on tools.
    """
    ends = [_end_step_and_scatter] * (count - 1) + [_end_steps]
    moves: list[Section] = [_move]
    if scaling is not None:
        moves += [partial(_raise_power, scaling, at) for at in range(len(scaling.powers))]
    return [_scatter, *(section for end in ends for section in (*moves, end))]


def _launch(part: Part, launches: Sequence[Launch | Swept]) -> None:
    for launch in launches:
        launch(part.model.device)


def _measure(part: Part, _: Sequence[Part]) -> None:
    _launch(part, part.launches.measure)


def _ask(part: Part, _: Sequence[Part]) -> None:
    _launch(part, part.launches.ask)


def _walk(part: Part, _: Sequence[Part]) -> None:
    _launch(part, part.launches.walk)


def _scatter(part: Part, _: Sequence[Part]) -> None:
    _launch(part, part.launches.scatter)


def _move(part: Part, parts: Sequence[Part]) -> None:
    integration.gather_forces(part, parts)
    _launch(part, part.launches.push)
    integration.advance_plies(part)


def _raise_power(scaling: SelectiveMass, number: int, part: Part, _: Sequence[Part]) -> None:
    integration.raise_power_of(part, scaling, number)


def _end_step_and_scatter(part: Part, parts: Sequence[Part]) -> None:
    _end_step(part, parts)
    _scatter(part, parts)


def _end_step(part: Part, parts: Sequence[Part]) -> None:
    if part.number == 0:
        integration.gather_totals(parts)
        integration.end_step(part.model, part.state)


def _end_steps(part: Part, parts: Sequence[Part]) -> None:
    _end_step(part, parts)
    if part.number == 0:
        integration.gather_extremes(parts)


def steps_per_graph(steps: int) -> int:
    """Steps of a block that one graph holds: few are captured fast, and most of them replayed."""
    return min(FEW_STEPS, key=lambda few: (steps % few, -few)) if steps > FEW_STEPS[-1] else steps


class _Job:
    """What one thread does in a block: the launches of some parts, and refits between them.

    The refit stays outside the graphs: Warp 1.19 does not record `Mesh.refit` on the CPU, so that a
    replay would query a stale hierarchy. Tools are rigid and need no refit.
    """

    def __init__(self, own: Sequence[Part], parts: Sequence[Part], barrier: Barrier | None) -> None:
        """Keep the parts; nothing is launched yet.

        Args:
            own: the parts of this job, one if others do the rest at the same time.
            parts: all of them.
            barrier: where to wait for the others; None if there are none.
        """
        self._own, self._parts, self._barrier = own, parts, barrier
        every = own[0].model.timing.search_every
        few = steps_per_graph(every)
        self._times, rest = divmod(every, few)
        self._copy: Callable[[], None] = self._launch_copies
        self._prepare: Callable[[], None] = self._launch_preparation
        self._ask: Callable[[], None] = partial(self._launch, search_sections(asking=True))
        self._walk: Callable[[], None] = partial(self._launch, search_sections(asking=False))
        scaling = own[0].model.selective
        self._few: Callable[[], None] = partial(self._launch, step_sections(few, scaling))
        self._rest: Callable[[], None] | None = None
        if rest:
            self._rest = partial(self._launch, step_sections(rest, scaling))

    def capture(self) -> None:
        """Replay from now on what the launches of now record."""
        device = self._own[0].model.device
        self._copy, self._prepare, self._ask, self._walk, self._few = (
            _captured(run, device)
            for run in (self._copy, self._prepare, self._ask, self._walk, self._few)
        )
        if self._rest is not None:
            self._rest = _captured(self._rest, device)

    def run(self, asking: bool) -> None:
        """Do a block; at its start vertices ask for the facets nearest to them, or walk there."""
        self._prepare()
        if asking:
            self._copy()
            for part in self._own:
                refit(part)
        (self._ask if asking else self._walk)()
        for _ in range(self._times):
            self._few()
        if self._rest is not None:
            self._rest()

    def _launch_copies(self) -> None:
        for part in self._own:
            _launch(part, part.launches.copy)

    def _launch_preparation(self) -> None:
        for part in self._own:
            _launch(part, part.launches.prepare)

    def _launch(self, sections: Sequence[Section]) -> None:
        for section in sections:
            if self._barrier is not None:
                self._barrier.launch(self._own[0].number)
            for part in self._own:
                section(part, self._parts)


def _captured(run: Callable[[], None], device: str) -> Callable[[], None]:
    with wp.ScopedCapture(device=device) as capture:
        run()
    return lambda: wp.capture_launch(capture.graph)


class Stepper:
    """Runs blocks of a search and the steps up to the next one, from captured graphs.

    With several threads each computes a part of the model, and while that does not pay one thread
    computes all parts: for a given number of them the results are the same to the bit.
    """

    def __init__(
        self,
        model: Model,
        state: State,
        threads: int = 1,
        blocks: int = 0,
        pace: Pace | None = None,
    ) -> None:
        """Cut the model into a part for each thread; graphs are captured when first needed.

        Args:
            model: the model.
            state: its state.
            threads: that compute it.
            blocks: done before.
            pace: says when threads do; None for where cores are idle and the clock says so.
        """
        self._model, self._state = model, state
        self._parts = split(model, state, threads)
        self._alone = _Job(self._parts, self._parts, None)
        self._captured = not model.scene.numerics.graph
        several = threads > 1 and model.scene.numerics.graph
        self._pace = (pace or Pace(SpareCores(threads))) if several else None
        self._barrier = Barrier(threads) if several else None
        self._crew: Crew | None = None
        self.blocks, self._asking = blocks, True
        self._ask_every = ask_every(model.scene.numerics)

    def close(self) -> None:
        """End the threads."""
        if self._crew is not None:
            self._crew.close()
            self._crew = None

    @property
    def parts(self) -> tuple[Part, ...]:
        """Of the model, one for each thread."""
        return self._parts

    @property
    def together(self) -> bool:
        """Whether the next block is for threads."""
        return self._pace is not None and self._pace.together

    def begin_frame(self, frame: int) -> None:
        """Prescribe the motions of the steps to a frame, numbered from 1, at full pace."""
        self.begin(frame_times(self._model.timing, frame))

    def begin(self, times: np.ndarray) -> None:
        """Prescribe the coming steps: see `prescribe`."""
        prescribe(self._model, self._state, times)

    def block(self) -> None:
        """Search once and do the steps up to the next search."""
        if not self._captured:
            self._alone.capture()
            self._captured = True
        self._asking = self.blocks % self._ask_every == 0
        self.blocks += 1
        if self._barrier is None or self._pace is None:
            self._alone.run(self._asking)
            return
        if self._crew is None and self._pace.together:
            self._crew = self._muster(self._barrier)
        start = time.perf_counter()
        if self._crew is not None and self._pace.together:
            self._barrier.reset()
            self._crew.run()
        else:
            self._alone.run(self._asking)
        self._pace.took(time.perf_counter() - start)

    def _muster(self, barrier: Barrier) -> Crew:
        """Capture every part's graphs and start its thread."""
        jobs = [_Job([part], self._parts, barrier) for part in self._parts]
        for job in jobs:
            job.capture()
        return Crew([partial(self._run, job) for job in jobs], barrier.release)

    def _run(self, job: _Job) -> None:
        job.run(self._asking)
