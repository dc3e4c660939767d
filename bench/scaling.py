"""What of a step does not get faster with threads: ``python bench threads``.

Three runs of one scene, each cut into as many parts as there are threads or left whole, do their
blocks in turn in one process, so that what else the machine does meets all alike: whole on one
thread, its parts in turn on one thread, and its parts on threads. From the wall times follow

- *doubled*: what the parts take in turn beyond the whole, for more launches and adding up forces;
- *alone*: what one part does while the others wait: it ends the step for the tools;
- *waiting*: what threads take beyond the longest part: barriers, memory that they share, cores
  that others have;
- *serial*: the share f for which Amdahl's law gives the time measured, T_n/T_1 = f + (1 − f)/n
  (Karp and Flatt 1990), and what that law predicts for more threads.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass

import warp as wp

from warpdrape.dynamics import integration
from warpdrape.dynamics.model import Model, build_model, initial_state
from warpdrape.dynamics.partition import Part
from warpdrape.dynamics.stepping import Stepper
from warpdrape.scenes import three_ply_hemisphere
from warpdrape.state import State

FRAMES = 60
"""Into which runs are divided."""
PREDICTED = (2, 4, 8, 16)
"""Threads for which a speed is predicted."""
STEPS = 50
"""Of which what a part does alone is timed together."""
HEAD = f"{'triangles':>10}{'threads':>8}{'time':>7}{'doubled':>9}{'uneven':>8}{'alone':>7}"
HEAD += f"{'waiting':>9}{'serial':>8}   times as fast on {', '.join(map(str, PREDICTED))} threads"


class Always:
    """A pace that has made up its mind: see `warpdrape.dynamics.pace.Pace`."""

    def __init__(self, together: bool) -> None:
        """Threads for every block, or for none."""
        self.together = together

    def took(self, seconds: float) -> None:
        """Whatever it took."""


@dataclass(frozen=True)
class Shares:
    """Shares of the time of the whole on one thread, medians over blocks [-].

    Attributes:
        triangles: in all plies.
        threads: that were timed.
        time: on threads.
        doubled: more work for the parts in turn.
        uneven: by which the largest part has more vertices than the mean.
        alone: what one part does while others wait.
        waiting: what is left.
    """

    triangles: int
    threads: int
    time: float
    doubled: float
    uneven: float
    alone: float
    waiting: float

    @property
    def serial(self) -> float:
        """Share that takes as long on any number of threads."""
        return (self.threads * self.time - 1.0) / (self.threads - 1.0)

    def faster(self, threads: int) -> float:
        """How many times as fast so many threads are predicted to be."""
        return 1.0 / (self.serial + (1.0 - self.serial) / threads)

    def __str__(self) -> str:
        """For the table."""
        shares = (self.doubled, self.uneven, self.alone, self.waiting, self.serial)
        doubled, uneven, alone, waiting, serial = (f"{100 * share:.1f} %" for share in shares)
        text = f"{self.triangles:10,}{self.threads:8}{self.time:7.3f}{doubled:>9}{uneven:>8}"
        text += f"{alone:>7}{waiting:>9}{serial:>8}   "
        return text + ", ".join(f"{self.faster(threads):.2f}" for threads in PREDICTED)


def shares_of(times: Sequence[tuple[float, float, float]], alone: float, **known) -> Shares:
    """Shares from the wall times of blocks [s]: whole, parts in turn, parts on threads.

    Args:
        times: of the blocks.
        alone: what one part does by itself in a block [s].
        known: triangles, threads, uneven.
    """
    threads = known["threads"]
    whole = statistics.median(one for one, _, _ in times)
    doubled = statistics.median(turn / one for one, turn, _ in times) - 1.0
    on_threads = statistics.median(together / one for one, _, together in times)
    share = alone / whole
    evenly = (1.0 + doubled - share) / threads * (1.0 + known["uneven"]) + share
    waiting = on_threads - evenly
    return Shares(time=on_threads, doubled=doubled, alone=share, waiting=waiting, **known)


def measure(cells: int, threads: int, blocks: int) -> Shares:
    """Do the first blocks of a run in three ways.

    Args:
        cells: of a ply along a side.
        threads: of the third way.
        blocks: of each; the first, which records the graphs, does not count.
    """
    model = build_model(three_ply_hemisphere.build(cells=cells), "cpu", FRAMES)
    states = [initial_state(model) for _ in range(3)]
    counts, paces = (1, threads, threads), (None, Always(False), Always(True))
    with ExitStack() as stack:
        steppers = [
            stack.enter_context(closing(Stepper(model, state, count, pace=pace)))
            for state, count, pace in zip(states, counts, paces, strict=True)
        ]
        for stepper in steppers:
            stepper.begin_frame(1)
        times = [_each(steppers) for _ in range(blocks + 1)][1:]
        parts = steppers[1].parts
    per_part = [sum(count for _, count in part.vertices) for part in parts]
    return shares_of(
        times,
        _alone(parts, states[1], model) * model.timing.search_every,
        triangles=model.triangles,
        threads=threads,
        uneven=max(per_part) / statistics.fmean(per_part) - 1.0,
    )


def _each(steppers: Sequence[Stepper]) -> tuple[float, float, float]:
    """Wall time of a block of each [s]."""
    times = []
    for stepper in steppers:
        start = time.perf_counter()
        stepper.block()
        times.append(time.perf_counter() - start)
    return tuple(times)


def _alone(parts: Sequence[Part], state: State, model: Model) -> float:
    """Wall time of what one part does alone in a step [s]."""

    def end() -> None:
        integration.gather_totals(parts)
        integration.end_step(model, state)

    with wp.ScopedCapture(device="cpu") as capture:
        for _ in range(STEPS):
            end()
    spent = []
    for _ in range(5):
        state.step.zero_()
        start = time.perf_counter()
        wp.capture_launch(capture.graph)
        spent.append(time.perf_counter() - start)
    return statistics.median(spent) / STEPS


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure every size."""
    parser = argparse.ArgumentParser(prog="python bench threads", description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("--cells", type=int, nargs="+", default=[46, 80, 158], help="of a side")
    parser.add_argument("--threads", type=int, default=2, help="that are timed")
    parser.add_argument("--blocks", type=int, default=40, help="of steps, of each way")
    chosen = parser.parse_args(arguments)
    print(HEAD)
    for cells in chosen.cells:
        print(measure(cells, chosen.threads, chosen.blocks), flush=True)
    return 0
