"""Slopes at the start by central differences of two steps, and whether they may be trusted.

A measure that is smooth has the same slope by a step and by half of it, but for a term of second
order. One that jumps as triangles take turns in being the worst, or as contact opens and closes,
has not: there a gradient leads nowhere, and the search by models of the measure goes on.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from warpdrape.errors import InputError
from warpdrape.optimisation.book import Asked, Trial
from warpdrape.optimisation.differences import STEP, agree
from warpdrape.optimisation.runner import Runner
from warpdrape.optimisation.space import SHARE, Place, place_of, row_at
from warpdrape.results.run_folder import write_whole

SLOPE = "slope"
"""Kind of runs."""
SLOPES = "slopes.csv"


@dataclass(frozen=True)
class Slope:
    """How a measure goes with a parameter at the start.

    Attributes:
        parameter: its name.
        measure: its name.
        wide: change over the whole axis, by the larger step, in the measure's unit.
        narrow: likewise by half of it.
    """

    parameter: str
    measure: str
    wide: float
    narrow: float

    @property
    def trusted(self) -> bool:
        """Whether both steps give the same; not where a run is missing."""
        return bool(agree(self.wide, self.narrow))


def find_slopes(runner: Runner) -> list[Slope]:
    """Do the runs for the slopes of all measures that are aimed at, and find them.

    A start at the end of an axis is moved inwards by a step, along that axis alone.

    Raises:
        InputError: if the start lies outside of where is looked.
    """
    book, task = runner.book, runner.book.task
    start = place_of(task.axes, task.start)
    if start is None:
        raise InputError(
            "slopes are taken at the start, which lies outside of where is looked: give "
            "[optimise.start] within the parameters' ranges"
        )
    trials: dict[int, list[Trial]] = {}
    for k, axis in enumerate(task.axes):
        if axis.kind != SHARE:
            continue
        places = [_moved(start, k, shift) for shift in _SHIFTS]
        asked = [Asked(row_at(task.axes, place), place) for place in places]
        trials[k] = book.asked(SLOPE, k, partial(list, asked))
    if not trials:
        raise InputError("slopes are of parameters with a range: all have whole numbers or words")
    runner.do([trial for four in trials.values() for trial in four])
    return [
        _slope(runner, four, task.axes[k].varied.name, measure)
        for k, four in trials.items()
        for measure in task.aims.measures
    ]


_SHIFTS = (STEP, -STEP, 0.5 * STEP, -0.5 * STEP)


def _moved(start: Place, axis: int, shift: float) -> Place:
    middle = min(max(start[axis], STEP), 1.0 - STEP)
    return (*start[:axis], middle + shift, *start[axis + 1 :])


def _slope(runner: Runner, four: Sequence[Trial], parameter: str, measure: str) -> Slope:
    scores = [runner.score(trial) for trial in four]
    if not all(score.counts for score in scores):
        return Slope(parameter, measure, np.nan, np.nan)
    up, down, half_up, half_down = (float(score.values[measure] or 0.0) for score in scores)
    return Slope(parameter, measure, (up - down) / (2.0 * STEP), (half_up - half_down) / STEP)


def slopes_text(slopes: Sequence[Slope]) -> str:
    """The slopes as a table for a terminal."""
    rows = [("parameter", "measure", "over its range", "by half the step", "")]
    for slope in slopes:
        words = "to be trusted" if slope.trusted else "not to be trusted"
        words = "does not change" if slope.wide == slope.narrow == 0.0 else words
        rows.append(
            (slope.parameter, slope.measure, f"{slope.wide:.4g}", f"{slope.narrow:.4g}", words)
        )
    widths = [max(len(row[k]) for row in rows) for k in range(4)]
    return "\n".join(
        "  ".join(cell.ljust(width) for cell, width in zip(row, [*widths, 0], strict=True)).rstrip()
        for row in rows
    )


def write_slopes(folder: Path, slopes: Sequence[Slope]) -> Path:
    """Write the slopes as CSV in one move; return the file."""
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(["parameter", "measure", "slope", "slope_half_step", "trusted"])
    for s in slopes:
        table.writerow([s.parameter, s.measure, repr(s.wide), repr(s.narrow), int(s.trusted)])
    out = folder / SLOPES
    write_whole(out, lambda p: p.write_text(text.getvalue(), "utf-8", newline="\n"))
    return out
