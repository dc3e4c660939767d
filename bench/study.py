"""What a study costs beyond its runs, and what a second worker gains: ``python bench/study.py``.

The same study (coarse runs of the hemisphere, all alike) is run with one worker and with two, in
turns, as often as asked, each time by a process and in a folder of its own. Of each: the wall clock
from the first worker's order to the last worker's end, processor time in runs, to start, for order
(all that the study's process, its workers and their keepers took beside) and for the report, and
the share of the workers' time that lies within runs. What Dask does in a worker while a run is on
is order. Not counted: Python's own start and the imports of the command, as of any command.
Processor times hold on a machine with other work on it, but for the watch that Dask keeps by the
clock; the clock itself, and so what two workers gain by it, only on one without.
"""

from __future__ import annotations

import argparse
import statistics
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from warpdrape.studies.folder import StudyFolder
from warpdrape.studies.running import Cost, run_study
from warpdrape.studies.study_file import read_study

MOST_BEYOND = 0.02
"""Share of the runs that a study may cost beyond them."""
TEXT = """
scene = "hemisphere"
[set]
cells = {cells}
accuracy = "standard"
[run]
frames = 5
[parameters.holder_force]
range = ["90 N", "110 N"]
[design]
kind = "grid"
steps = {runs}
"""


@dataclass(frozen=True)
class Timed:
    """A study that was timed.

    Attributes:
        workers: processes that did its runs.
        wall_s: wall clock of all [s].
        within: share of the workers' time within runs, by the clock [-].
        cost: processor time.
        report_s: that of table and report, with what they import [s].
    """

    workers: int
    wall_s: float
    within: float
    cost: Cost
    report_s: float

    def line(self) -> str:
        """As a row of the table."""
        c = self.cost
        parts = (c.start_s, c.order_s, self.report_s)
        shares = "".join(f"{s:9.2f}{100.0 * s / c.runs_s:7.1f} %" for s in parts)
        return (
            f"{self.workers:7}{self.wall_s:9.1f}{c.runs_s:9.1f}{shares}{100 * self.within:9.1f} %"
        )


HEAD = f"{'workers':>7}{'wall s':>9}{'runs s':>9}"
HEAD += (
    "".join(f"{name:>9}{'':9}" for name in ("start s", "order s", "report s")) + f"{'within':>11}"
)


def timed(workers: int, runs: int, cells: int) -> Timed:
    """Run the study once."""
    with tempfile.TemporaryDirectory() as place:
        path = Path(place, "timed.toml")
        path.write_text(TEXT.format(runs=runs, cells=cells), encoding="utf-8")
        study, folder = read_study(path), StudyFolder(Path(place, "out"))
        folder.take()
        try:
            rows = folder.plan(study)
            before = time.perf_counter()
            _, outcomes, cost = run_study(study, folder, rows=rows, workers=workers, quiet=True)
            wall = time.perf_counter() - before
            report = report_time(study, folder, rows, outcomes)
        finally:
            folder.release()
    failed = [o["message"] for o in outcomes.values() if o["status"] != "completed"]
    if failed:
        raise SystemExit(f"{len(failed)} runs failed: {failed[0]}")
    within = sum(o["wall_s"] for o in outcomes.values()) / (workers * wall)
    return Timed(workers, wall, within, cost, report)


def report_time(*made: Any) -> float:
    """Processor time of a study's table and report [s]."""
    before = time.process_time()
    from warpdrape.studies.report import write_report

    write_report(*made)
    return time.process_time() - before


def alone(act: Callable[..., Timed], *arguments: int) -> Timed:
    """What a function returns in a process of its own, as ``warpdrape study`` is one."""
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        return pool.submit(act, *arguments).result()


def verdict(found: list[Timed], runs: int) -> str:
    """What follows: gain of two workers, cost beyond runs, and from which length it is small."""
    one, two = ([t for t in found if t.workers == n] for n in (1, 2))
    gains = [a.wall_s / b.wall_s for a, b in zip(one, two, strict=True)]
    spread = ", ".join(f"{gain:.2f}" for gain in gains)
    lines = [f"two workers by the clock: {statistics.median(gains):.2f} times one ({spread})"]
    for group in (one, two):
        start, order, done = (
            statistics.median(getattr(t.cost, name) for t in group)
            for name in ("start_s", "order_s", "runs_s")
        )
        words = f"{group[0].workers} of {runs} runs of {done / runs:.2f} s: beyond them "
        words += f"{100.0 * (start + order) / done:.1f} %, of it order {100.0 * order / done:.1f} %"
        least = (start + order) / (MOST_BEYOND * runs)
        words += f"; below 2 % from runs of {least:.1f} s on"
        report = statistics.median(t.report_s for t in group)
        lines.append(
            f"workers {words}; the report, once, {report:.1f} s ({100 * report / done:.1f} %)"
        )
    return "\n".join(lines)


def main() -> int:
    """Time the study in turns."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=64, help="of the study")
    parser.add_argument("--cells", type=int, default=12, help="of each run's mesh")
    parser.add_argument("--repeat", type=int, default=3, help="times with one worker and with two")
    chosen = parser.parse_args()
    alone(timed, 1, 2, chosen.cells)  # kernels are compiled and read once before
    print(HEAD)
    found = []
    for _ in range(chosen.repeat):
        for workers in (1, 2):
            found.append(alone(timed, workers, chosen.runs, chosen.cells))
            print(found[-1].line(), flush=True)
    print(verdict(found, chosen.runs))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
