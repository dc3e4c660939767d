"""The answer: which run is best, what its repeats say of it, and what was gained."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import t as student

from warpdrape.optimisation.aims import Score
from warpdrape.optimisation.book import (
    BASELINE,
    COARSE,
    COARSE_START,
    REPEAT,
    SEARCH,
    START,
    Trial,
)
from warpdrape.optimisation.cost import cost_after
from warpdrape.optimisation.front import area_dominated, front_of, ranked
from warpdrape.optimisation.runner import Runner

CERTAIN = 0.95
"""Chance with which noise alone leaves a smaller difference, for one to be more than noise."""


@dataclass(frozen=True)
class Noise:
    """How much an objective scatters from run to run.

    Attributes:
        deviation: standard deviation of a single run; NaN where repeats do not show it.
        freedom: degrees of freedom that it is known by.
    """

    deviation: float = math.nan
    freedom: int = 0

    @property
    def known(self) -> bool:
        """Whether repeats show it."""
        return self.freedom > 0


@dataclass(frozen=True, eq=False)
class Candidate:
    """A run and its repeats.

    Attributes:
        trial: the run.
        score: what it is worth.
        repeats: what its repeats are worth, those that have ended.
    """

    trial: Trial
    score: Score
    repeats: tuple[Score, ...]

    @property
    def holds(self) -> bool:
        """Whether constraints hold in the run and in every repeat."""
        return all(score.feasible for score in (self.score, *self.repeats))

    def mean(self, objective: int) -> float:
        """Mean of an objective over the repeats: the run itself was chosen for being low."""
        values = self._values(objective)
        return float(np.mean(values)) if values else self.score.objectives[objective]

    def _values(self, objective: int) -> list[float]:
        return [score.objectives[objective] for score in self.repeats if score.counts]


def candidates_of(runner: Runner, kind: str) -> list[Candidate]:
    """Finalists of a kind with their repeats, best first.

    Those come first whose constraints hold in every repeat, and of them, for one objective, the one
    with the best mean over its repeats; of two objectives their front, along the first.
    """
    by_run: dict[int, list[Score]] = {}
    for trial in runner.book.of_kind(REPEAT):
        if trial.number in runner.outcomes and trial.of is not None:
            by_run.setdefault(trial.of, []).append(runner.score(trial))
    found = [
        Candidate(trial, runner.score(trial), tuple(by_run.get(trial.number, ())))
        for trial in finalists_of(runner, kind)
    ]
    two = len(runner.book.task.aims.objectives) > 1
    first = (lambda c: c.score.objectives[0]) if two else (lambda c: c.mean(0))
    return sorted(found, key=lambda c: (not two and not c.holds, first(c)))


def finalists_of(runner: Runner, kind: str) -> list[Trial]:
    """Runs of a kind that are repeated: the start if it counts, else the best feasible ones."""
    trials = [t for t in runner.book.of_kind(kind) if t.number in runner.outcomes]
    if kind == START:
        return [t for t in trials if runner.score(t).counts]
    feasible = [t for t in trials if runner.score(t).feasible]
    order = ranked([runner.score(t) for t in feasible])
    if len(runner.book.task.aims.objectives) > 1:
        front = {feasible[k].number for k in front_of(objectives_of(runner, feasible))}
        order = [k for k in order if feasible[k].number in front]
    return [feasible[k] for k in order[: runner.book.task.finalists]]


def objectives_of(runner: Runner, trials: Sequence[Trial]) -> list[tuple[float, ...]]:
    """Objectives of runs, each to be made small."""
    return [runner.score(trial).objectives for trial in trials]


def nearest_of(runner: Runner, kind: str) -> Trial | None:
    """The best run of a kind; the one that violates least where none is feasible."""
    trials = [t for t in runner.book.of_kind(kind) if t.number in runner.outcomes]
    order = ranked([runner.score(trial) for trial in trials])
    return trials[order[0]] if order and runner.score(trials[order[0]]).counts else None


def noise_of(groups: Sequence[Candidate], objective: int) -> Noise:
    """How much an objective scatters from run to run.

    What differs between repeats is taken apart: what they do to all runs alike, as a finer mesh
    does, is no noise where runs are compared; the rest is (two-way layout without replication).

    Args:
        groups: runs with their repeats; those with a repeat that does not count are left out.
        objective: its place.
    """
    rows = [c._values(objective) for c in groups]
    most = max(map(len, rows), default=0)
    table = np.array([row for row in rows if len(row) == most and most > 1])
    freedom = (table.shape[0] - 1) * (table.shape[1] - 1) if len(table) else 0
    if freedom < 1:
        return Noise()
    rest = table - table.mean(axis=1, keepdims=True) - table.mean(axis=0) + table.mean()
    return Noise(math.sqrt(float((rest**2).sum()) / freedom), freedom)


@dataclass(frozen=True)
class Gain:
    """How much better one run is than another in an objective.

    Attributes:
        single: over the value of the other, of the runs themselves [-].
        repeated: likewise of the means over repeats; NaN without any.
        error: standard error of the latter by the pooled noise; NaN where not known.
        freedom: degrees of freedom that the noise is known by.
    """

    single: float
    repeated: float
    error: float
    freedom: int = 0

    @property
    def certain(self) -> bool | None:
        """Whether it is beyond noise, by Student's t; None where noise is not known."""
        if math.isnan(self.error):
            return None
        errors = float(student.ppf(0.5 + 0.5 * CERTAIN, self.freedom))
        return abs(self.repeated) > errors * self.error


def gain_of(best: Candidate, other: Candidate, objective: int, noise: Noise) -> Gain:
    """What the best run gains on another one; NaN where that is zero.

    Args:
        best: the run.
        other: the one that it is compared with.
        objective: its place.
        noise: of one run.
    """
    before, after = other.score.objectives[objective], best.score.objectives[objective]
    single = (before - after) / abs(before) if before else math.nan
    pairs = [(b.objectives[objective], o.objectives[objective]) for b, o in _both(best, other)]
    first = float(np.mean([o for _, o in pairs])) if pairs else 0.0
    if not first:
        return Gain(single, math.nan, math.nan)
    last = float(np.mean([b for b, _ in pairs]))
    error = noise.deviation * math.sqrt(2.0 / len(pairs)) / abs(first)
    return Gain(single, (first - last) / abs(first), error, noise.freedom)


def _both(best: Candidate, other: Candidate) -> list[tuple[Score, Score]]:
    """Repeats that both have, of one kind each, and that count."""
    pairs = zip(best.repeats, other.repeats, strict=False)
    return [(b, o) for b, o in pairs if b.counts and o.counts]


def history_of(runner: Runner, kind: str) -> list[tuple[float, float]]:
    """Cost in fine runs, and the best so far, after each fine run of a kind that has ended.

    Of one objective the least of feasible runs; of two the area that their front dominates, up to
    the worst that search and baseline have seen. The start comes first; NaN before anything is
    feasible.
    """
    two = len(runner.book.task.aims.objectives) > 1
    corner = corner_of(runner) if two else None
    found, best = [], []
    for trial, cost in cost_after(runner, kind):
        if trial.kind in (COARSE, COARSE_START) or trial.number not in runner.outcomes:
            continue
        score = runner.score(trial)
        if score.feasible:
            best.append(score.objectives)
        if corner is not None:
            found.append((cost, area_dominated(best, corner)))
        else:
            found.append((cost, min((b[0] for b in best), default=math.nan)))
    return found


def corner_of(runner: Runner) -> tuple[float, float] | None:
    """Worst of both objectives that a feasible run of search, baseline or start has."""
    trials = [
        t for t in runner.book.of_kind(START, SEARCH, BASELINE) if t.number in runner.outcomes
    ]
    points = [runner.score(t).objectives for t in trials if runner.score(t).feasible]
    if not points:
        return None
    return max(p[0] for p in points), max(p[1] for p in points)
