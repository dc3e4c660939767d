"""Time the default threads against one, beside other programs: ``python bench/threads.py``.

Two runs of three plies, one with as many threads as there are cores and one with a single thread,
do their blocks of steps in turn in one process, from the start, so that what happens on the machine
meets both alike; a program beside them is a loop that takes a core. Figures are ratios of wall
time, default over one thread: below 1 threads are faster.
"""

from __future__ import annotations

import argparse
import json
import statistics
import subprocess
import sys
import time
from contextlib import ExitStack, closing
from dataclasses import asdict, dataclass
from pathlib import Path

from warpdrape.dynamics.cores import allowed_cores, look_at
from warpdrape.dynamics.crew import choose_threads
from warpdrape.dynamics.model import build_model, initial_state
from warpdrape.dynamics.stepping import Stepper
from warpdrape.scenes import three_ply_hemisphere

FRAMES = 60
"""Into which runs are divided."""
HEAD = f"{'beside':>16}{'others':>8}{'first s':>14}{'all':>8}{'half':>8}{'median':>8}"
HEAD += f"{'threads':>9}{'taken up':>22}"


@dataclass(frozen=True)
class Situation:
    """What else runs: so many programs, all ended halfway if ``freed``."""

    programs: int
    freed: bool = False

    def __str__(self) -> str:
        """For the table."""
        return f"{self.programs}{', then none' if self.freed else ''}"


SITUATIONS = (Situation(0), Situation(1), Situation(2), Situation(1, freed=True))


@dataclass(frozen=True)
class Row:
    """What one situation gave.

    Attributes:
        triangles: in all plies.
        beside: the situation.
        others: cores that other programs took, on average, ours beside us among them.
        first: wall time of the first block of both ways, which records the graphs [s].
        all: ratio of the wall times of all further blocks.
        half: of those of the second half.
        median: of block to block.
        threads: share of the blocks of the default that were computed on threads.
        taken_up: blocks alone, and their time [s], after the others ended; None if they did not.
    """

    triangles: int
    beside: str
    others: float
    first: tuple[float, float]
    all: float
    half: float
    median: float
    threads: float
    taken_up: tuple[int, float] | None

    def __str__(self) -> str:
        """For the table."""
        first = f"{self.first[0]:.2f}, {self.first[1]:.2f}"
        text = f"{self.beside:>16}{self.others:8.2f}{first:>14}{self.all:8.3f}{self.half:8.3f}"
        text += f"{self.median:8.3f}{100 * self.threads:7.0f} %"
        if self.taken_up is not None:
            text += f"{self.taken_up[0]:>6} blocks, {self.taken_up[1]:.2f} s"
        return text


def measure(cells: int, situation: Situation, blocks: int) -> Row:
    """Do the first blocks of a run in a situation.

    Args:
        cells: of a ply along a side.
        situation: what else runs.
        blocks: of each way.
    """
    models = [build_model(three_ply_hemisphere.build(cells=cells), "cpu", FRAMES) for _ in range(2)]
    triangles = len(models[0].facets.corners)
    threads = (choose_threads(None, "cpu", triangles), 1)
    if threads[0] == 1:
        raise SystemExit(f"{triangles} triangles have one thread by default here: nothing to time")
    with ExitStack() as stack:
        busy = [Hog() for _ in range(situation.programs)]
        for hog in busy:
            stack.callback(hog.end)
        time.sleep(1.0)  # until they run
        steppers = [
            stack.enter_context(closing(Stepper(model, initial_state(model), count)))
            for model, count in zip(models, threads, strict=True)
        ]
        for stepper in steppers:
            stepper.begin_frame(1)
        start = look_at(allowed_cores())
        times, together = ([], []), []
        for block in range(blocks):
            if situation.freed and block == blocks // 2:
                for hog in busy:
                    hog.end()
            together.append(steppers[0].together)
            for way in (0, 1) if block % 2 else (1, 0):
                begun = time.perf_counter()
                steppers[way].block()
                times[way].append(time.perf_counter() - begun)
        others = taken_by_others(start, look_at(allowed_cores()))
    return row_of(triangles, situation, others, times, together)


def row_of(
    triangles: int,
    situation: Situation,
    others: float,
    times: tuple[list[float], list[float]],
    together: list[bool],
) -> Row:
    """Sum up the times [s] of the blocks of the default and of one thread."""
    (first, *default), (first_one, *one) = times
    half = len(together) // 2
    alone = together[half:].index(True) if True in together[half:] else len(together) - half
    return Row(
        triangles=triangles,
        beside=str(situation),
        others=others,
        first=(first, first_one),
        all=sum(default) / sum(one),
        half=sum(times[0][half:]) / sum(times[1][half:]),
        median=statistics.median(a / b for a, b in zip(default, one, strict=True)),
        threads=sum(together) / len(together),
        taken_up=(alone, sum(times[0][half : half + alone])) if situation.freed else None,
    )


class Hog:
    """Another program that takes a core."""

    def __init__(self) -> None:
        """Start it."""
        self._process = subprocess.Popen([sys.executable, "-c", "while True: pass"])

    def end(self) -> None:
        """End it; again does nothing."""
        self._process.kill()
        self._process.wait()


def taken_by_others(start, end) -> float:
    """Cores that other programs took between two looks, on average; NaN where not known."""
    if start is None or end is None:
        return float("nan")
    passed = end.now - start.now
    return len(allowed_cores()) - (end.idle - start.idle + end.own - start.own) / passed


def main() -> int:
    """Time every situation at every size."""
    parser = argparse.ArgumentParser(prog="threads.py", description=__doc__.splitlines()[0])
    parser.add_argument("--cells", type=int, nargs="+", default=[46, 80], help="of a ply's side")
    parser.add_argument("--blocks", type=int, default=60, help="of steps, of each way")
    parser.add_argument("--repeat", type=int, default=3, help="rows of each situation")
    parser.add_argument("--out", type=Path, default=Path("threads.json"), help="for the figures")
    chosen = parser.parse_args()
    rows = []
    for cells in chosen.cells:
        print(f"three plies of {4 * cells**2:,} triangles, {chosen.blocks} blocks\n{HEAD}")
        for _ in range(chosen.repeat):
            for situation in SITUATIONS:
                rows.append(measure(cells, situation, chosen.blocks))
                print(rows[-1], flush=True)
    text = json.dumps([asdict(row) for row in rows], indent=2)
    chosen.out.write_text(text + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
