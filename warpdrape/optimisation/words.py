"""A plan and an answer in words, for a terminal and for the report."""

from __future__ import annotations

import math
from collections.abc import Iterable

from warpdrape.optimisation.answer import (
    Candidate,
    Gain,
    candidates_of,
    corner_of,
    gain_of,
    history_of,
    nearest_of,
    noise_of,
)
from warpdrape.optimisation.book import BASELINE, SEARCH, START
from warpdrape.optimisation.optimise_file import Task
from warpdrape.optimisation.runner import Runner
from warpdrape.optimisation.space import place_of
from warpdrape.studies.design import Row
from warpdrape.studies.parameters import Varied, exact


def plan_text(task: Task) -> str:
    """What would be looked for, where, and at what cost."""
    study = task.study
    aims = " and ".join(objective.words for objective in task.aims.objectives)
    lines = [f"{study.name}: {aims} of {study.script.name}"]
    lines += [f"  subject to {constraint.words}" for constraint in task.aims.constraints]
    if study.fixed:
        lines.append(f"all with {', '.join(study.fixed)}")
    lines += [f"  {axis.varied.name}: {_range(axis.varied)}" for axis in task.axes]
    lines.append(f"start: {settings_text(task, task.start)}")
    if place_of(task.axes, task.start) is None:
        lines.append("  (outside of where is looked: the search is not told of it)")
    how = f"search, {task.method}, batches of {task.batch}"
    lines.append(f"{task.runs} runs for the {how}, and {task.runs} at random; both with the start")
    if task.coarse is not None:
        share = 100.0 * task.coarse.share
        words = ", ".join(task.coarse.settings)
        lines.append(f"  {share:.0f} % of the search's cost in coarse runs first: {words}")
    if task.repeats:
        most = (2 * task.finalists + 1) * len(task.repeats)
        each = "; ".join(", ".join(settings) for settings in task.repeats)
        lines.append(f"  then the best again, with {each}: {most} runs at most")
    else:
        lines.append("  no repeats: what is noise will not be known")
    return "\n".join(lines)


def _range(varied: Varied) -> str:
    spread = varied.spread
    assert spread is not None
    if spread.values:
        return "one of " + "; ".join(map(exact, spread.values))
    unit = "" if varied.unit in ("", "-") else f" {varied.unit}"
    log = " by its logarithm" if spread.kind == "log_range" else ""
    return f"{spread.numbers['low']:.6g} to {spread.numbers['high']:.6g}{unit}{log}"


def settings_text(task: Task, row: Row) -> str:
    """Settings in words, with units."""
    return ", ".join(f"{p.name} {value_text(p, row[p.name])}" for p in task.study.parameters)


def value_text(parameter: Varied, value: object) -> str:
    """A parameter's value with its unit."""
    shown = f"{value:.4g}" if isinstance(value, float) else exact(value)
    unit = "" if parameter.unit in ("", "-") else f" {parameter.unit}"
    return f"{shown}{unit}"


def answer_text(runner: Runner) -> str:
    """What was found: settings, values, what was gained on the start and on the baseline."""
    task = runner.book.task
    lines = [f"{task.study.name}: {', '.join(_counts(runner))}"]
    if len(task.aims.objectives) > 1:
        lines += front_lines(runner)
    else:
        lines += best_lines(runner)
    return "\n".join(lines)


def _counts(runner: Runner) -> list[str]:
    statuses = [outcome["status"] for outcome in runner.outcomes.values()]
    return [f"{statuses.count(s)} {s}" for s in dict.fromkeys(statuses)]


def best_lines(runner: Runner) -> list[str]:
    """The best settings of one objective, and what they gain."""
    task = runner.book.task
    found = {kind: candidates_of(runner, kind) for kind in (SEARCH, BASELINE, START)}
    if not found[SEARCH]:
        return [_nothing(runner)]
    best = found[SEARCH][0]
    noise = noise_of([c for group in found.values() for c in group], 0)
    lines = [
        f"best settings, run {best.trial.number}: {settings_text(task, best.trial.row)}",
        f"  {candidate_text(runner, best)}",
    ]
    for kind, name in ((START, "the start"), (BASELINE, "the best at random")):
        if not found[kind]:
            lines.append(f"{name}: no run that {'counts' if kind == START else 'is feasible'}")
            continue
        other = found[kind][0]
        lines.append(f"{name}, run {other.trial.number}: {candidate_text(runner, other)}")
        lines.append(f"  {gain_text(gain_of(best, other, 0, noise))}")
    if noise.known:
        words = f"{_measure(task, 0)}, standard deviation of one run"
        lines.append(f"noise: {noise.deviation:.3g} ({words}, {noise.freedom} degrees of freedom)")
    return lines


def front_lines(runner: Runner) -> list[str]:
    """The front of two objectives, and how much of the field it takes beside the baseline's."""
    task = runner.book.task
    found = candidates_of(runner, SEARCH)
    if not found:
        return [_nothing(runner)]
    lines = [f"on the front, by {_measure(task, 0)} and {_measure(task, 1)}:"]
    for each in found:
        lines.append(f"  run {each.trial.number}: {settings_text(task, each.trial.row)}")
        lines.append(f"    {candidate_text(runner, each)}")
    for start in candidates_of(runner, START):
        lines.append(f"the start: {candidate_text(runner, start)}")
    areas = {kind: history_of(runner, kind) for kind in (SEARCH, BASELINE)}
    corner = corner_of(runner)
    if corner is not None and all(areas.values()):
        ours, others = (areas[kind][-1][1] for kind in (SEARCH, BASELINE))
        share = f", {100.0 * (ours / others - 1.0):+.0f} %" if others > 0.0 else ""
        lines.append(f"area under the front: {ours:.4g}, of random settings {others:.4g}{share}")
    return lines


def candidate_text(runner: Runner, candidate: Candidate) -> str:
    """A run's values, those of its repeats, and whether constraints hold."""
    task, words = runner.book.task, []
    for k, objective in enumerate(task.aims.objectives):
        value = candidate.score.values[objective.measure]
        text = f"{objective.measure} {value:.5g}"
        if candidate.repeats:
            again = _listed(
                f"{s.values[objective.measure]:.5g}" if s.counts else "failed"
                for s in candidate.repeats
            )
            text += f" (repeats {again}, mean {objective.sign * candidate.mean(k):.5g})"
        words.append(text)
    seen = {objective.measure for objective in task.aims.objectives}
    for constraint in task.aims.constraints:
        if constraint.measure not in seen:
            seen.add(constraint.measure)
            words.append(f"{constraint.measure} {candidate.score.values[constraint.measure]:.5g}")
    if task.aims.constraints:
        words.append(_limits_text(candidate))
    return ", ".join(words)


def _limits_text(candidate: Candidate) -> str:
    if not candidate.score.feasible:
        return "outside its limits"
    kept = sum(score.feasible for score in candidate.repeats)
    if not candidate.repeats:
        return "within its limits"
    if kept == len(candidate.repeats):
        return "within its limits, in all repeats"
    return f"within its limits, in {kept} of {len(candidate.repeats)} repeats"


def gain_text(gain: Gain) -> str:
    """What is gained, and whether it is more than noise."""
    if math.isnan(gain.single):
        return "gain: nothing to measure it by, the other is zero"
    text = f"gain: {100.0 * gain.single:.3g} %"
    if not math.isnan(gain.repeated):
        text += f", by repeats {100.0 * gain.repeated:.3g}"
        text += "" if math.isnan(gain.error) else f" ± {100.0 * gain.error:.2g}"
        text += " %"
    if gain.certain is None:
        return text
    return text + (": more than noise" if gain.certain else ": within noise")


def _nothing(runner: Runner) -> str:
    nearest = nearest_of(runner, SEARCH)
    if nearest is None:
        return "no run of the search counts: table.csv says why of each"
    task, score = runner.book.task, runner.score(nearest)
    beyond = [
        f"{score.values[c.measure]:.5g} where {c.words} is wanted"
        for c, excess in zip(task.aims.constraints, score.excess, strict=True)
        if excess > 0.0
    ]
    return (
        f"no settings keep all limits; run {nearest.number} comes nearest, with "
        f"{settings_text(task, nearest.row)}: {'; '.join(beyond)}"
    )


def _measure(task: Task, objective: int) -> str:
    return task.aims.objectives[objective].measure


def _listed(words: Iterable[str]) -> str:
    return " and ".join(words)
