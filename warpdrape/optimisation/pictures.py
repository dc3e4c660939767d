"""Pictures of an optimisation: how the best came down, the front of two objectives, the field."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from warpdrape.optimisation.answer import corner_of, history_of
from warpdrape.optimisation.book import BASELINE, COARSE, SEARCH, START, Trial
from warpdrape.optimisation.cost import cost_after
from warpdrape.optimisation.front import front_of
from warpdrape.optimisation.runner import Runner
from warpdrape.results.figures import Figure
from warpdrape.studies.effects import is_number
from warpdrape.studies.map_files import INK
from warpdrape.studies.pictures import plain

COLOURS = {SEARCH: "#b3261e", BASELINE: "#35608d", START: INK, COARSE: "#c9a227"}
NAMES = {SEARCH: "search", BASELINE: "random", START: "start", COARSE: "coarse"}


def draw_convergence(runner: Runner) -> Figure:
    """The best so far over what it has cost, of search and baseline; a dot a feasible run."""
    figure = Figure(figsize=(7.6, 4.4), dpi=110)
    axes = figure.subplots()
    objectives = runner.book.task.aims.objectives
    one = len(objectives) == 1
    sign = objectives[0].sign if one else 1.0
    for kind in (BASELINE, SEARCH):
        history = [(c, sign * v) for c, v in history_of(runner, kind) if not math.isnan(v)]
        if history:
            cost, best = zip(*history, strict=True)
            axes.step(cost, best, where="post", color=COLOURS[kind], lw=1.8, label=NAMES[kind])
        if one:
            _dots(axes, runner, kind, sign)
    if one:
        start = runner.book.of_kind(START)
        score = runner.score(start[0]) if start and start[0].number in runner.outcomes else None
        if score is not None and score.counts:
            axes.axhline(sign * score.objectives[0], color=INK, lw=0.8, ls=":", label="start")
    axes.set_xlabel("cost, in runs at full fineness", size=9, color=INK)
    label = objectives[0].measure if one else "area under the front"
    axes.set_ylabel(label, size=9, color=INK)
    if axes.get_legend_handles_labels()[0]:
        axes.legend(fontsize=8, frameon=False)
    plain(axes)
    figure.tight_layout()
    return figure


def _dots(axes: Any, runner: Runner, kind: str, sign: float) -> None:
    points = [
        (cost, sign * runner.score(trial).objectives[0])
        for trial, cost in cost_after(runner, kind)
        if trial.kind == kind and _feasible(runner, trial)
    ]
    if points:
        axes.plot(*zip(*points, strict=True), ".", color=COLOURS[kind], ms=5, alpha=0.55)


def draw_front(runner: Runner) -> Figure:
    """Both objectives of every feasible run, and the fronts of search and baseline."""
    figure = Figure(figsize=(6.4, 5.4), dpi=110)
    axes = figure.subplots()
    first, second = runner.book.task.aims.objectives
    for kind in (BASELINE, SEARCH, START):
        trials = [t for t in runner.book.of_kind(kind) if _feasible(runner, t)]
        points = [runner.score(t).objectives for t in trials]
        if not points:
            continue
        shown = np.array([(first.sign * a, second.sign * b) for a, b in points])
        mark = "*" if kind == START else "."
        axes.plot(*shown.T, mark, color=COLOURS[kind], ms=10 if kind == START else 6)
        front = sorted(front_of(points), key=lambda k: points[k])
        if kind != START:
            _draw_steps(axes, shown[front], COLOURS[kind], NAMES[kind])
        else:
            axes.plot([], [], mark, color=COLOURS[kind], ms=10, label=NAMES[kind])
    axes.set_xlabel(f"{first.measure} ({_better(first.sign)} is better)", size=9, color=INK)
    axes.set_ylabel(f"{second.measure} ({_better(second.sign)} is better)", size=9, color=INK)
    axes.legend(fontsize=8, frameon=False)
    plain(axes)
    figure.tight_layout()
    return figure


def _draw_steps(axes: Any, front: np.ndarray, colour: str, name: str) -> None:
    axes.step(front[:, 0], front[:, 1], where="post", color=colour, lw=1.4, label=name)


def _better(sign: float) -> str:
    return "less" if sign > 0.0 else "more"


def draw_field(runner: Runner) -> Figure:
    """Each objective over each parameter: a dot a run that counts, hollow outside its limits."""
    task = runner.book.task
    columns, rows = len(task.axes), len(task.aims.objectives)
    figure = Figure(figsize=(1.4 + 2.6 * columns, 0.9 + 2.4 * rows), dpi=110)
    panels = figure.subplots(rows, columns, squeeze=False, sharey="row", sharex="col")
    for column, axis in enumerate(task.axes):
        name = axis.varied.name
        spread = axis.varied.spread
        words = [] if spread is None else list(spread.values)
        words = [] if is_number(words) else words
        for row, objective in enumerate(task.aims.objectives):
            panel = panels[row, column]
            for kind in (COARSE, BASELINE, SEARCH, START):
                trials = [t for t in runner.book.of_kind(kind) if _counts(runner, t)]
                _draw_runs(panel, runner, trials, (name, words, row, objective.sign), kind)
            if words:
                panel.set_xticks(range(len(words)), list(map(str, words)))
                panel.set_xlim(-0.5, len(words) - 0.5)
            elif spread is not None and spread.kind == "log_range":
                panel.set_xscale("log")
            if column == 0:
                panel.set_ylabel(objective.measure, size=8, color=INK)
            if row == rows - 1:
                panel.set_xlabel(name, size=8, color=INK)
            plain(panel)
    if panels[0, -1].get_legend_handles_labels()[0]:
        panels[0, -1].legend(fontsize=7, frameon=False)
    figure.tight_layout()
    return figure


def _draw_runs(
    panel: Any, runner: Runner, trials: Sequence[Trial], what: tuple[Any, ...], kind: str
) -> None:
    name, words, row, sign = what
    for feasible in (True, False):
        own = [t for t in trials if runner.score(t).feasible is feasible]
        if words:
            own = [t for t in own if t.row[name] in words]
        if not own:
            continue
        x = [words.index(t.row[name]) if words else t.row[name] for t in own]
        y = [sign * runner.score(t).objectives[row] for t in own]
        style = {"color": COLOURS[kind], "ms": 8 if kind == START else 4}
        style |= {} if feasible else {"mfc": "none"}
        label = NAMES[kind] if feasible else None
        panel.plot(x, y, "*" if kind == START else "o", label=label, **style)


def _counts(runner: Runner, trial: Trial) -> bool:
    return trial.number in runner.outcomes and runner.score(trial).counts


def _feasible(runner: Runner, trial: Trial) -> bool:
    return _counts(runner, trial) and runner.score(trial).feasible


def has_front(runner: Runner) -> bool:
    """Whether there is a front of two objectives to be drawn."""
    return len(runner.book.task.aims.objectives) > 1 and corner_of(runner) is not None
