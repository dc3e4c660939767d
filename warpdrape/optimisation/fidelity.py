"""Coarse runs beside fine ones: what they promise, which are done again, what the budget allows."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import spearmanr

from warpdrape.optimisation.aims import Aims, Score
from warpdrape.optimisation.front import ranked

LEAST_PAIRS = 3
"""Pairs of a coarse and a fine run from which a correlation of ranks is said."""
ROUNDING = 1e-9
"""Of a sum of costs, in fine runs."""


@dataclass(frozen=True)
class Shares:
    """How many runs a batch has.

    Attributes:
        fine: at full fineness.
        coarse: before them.
    """

    fine: int
    coarse: int = 0


def shares_of(left: float, batch: int, share: float, coarse_cost: float) -> Shares:
    """How many coarse and fine runs the next batch has.

    Args:
        left: budget that is left, in fine runs.
        batch: fine runs at a time, at most.
        share: of the cost that coarse runs take; 0 without any.
        coarse_cost: of a coarse run, in fine runs.
    """
    left += ROUNDING
    if share == 0.0 or left < 1.0:
        return Shares(min(batch, math.floor(left)))
    fine = min(batch, max(1, math.floor(left * (1.0 - share))))
    wanted = fine * share / (1.0 - share)
    return Shares(fine, math.floor(min(wanted, left - fine) / coarse_cost))


def corrected(score: Score, aims: Aims, pairs: Sequence[tuple[Score, Score]]) -> Score:
    """What a fine run in place of a coarse one would be worth, by those that have both.

    The mean difference is added to each measure. It moves all coarse runs alike, so that their
    order is their own; a fine run replaces its coarse one.

    Args:
        score: of the coarse run.
        aims: what is wanted.
        pairs: scores of coarse and fine runs with the same settings.
    """
    both = [(a, b) for a, b in pairs if a.counts and b.counts]
    if not score.counts or not both:
        return score
    values = dict(score.values)
    for name in aims.measures:
        change = float(np.mean([b.value(name) - a.value(name) for a, b in both]))
        values[name] = score.value(name) + change
    return aims.of_values(values)


def promoted(scores: Sequence[Score], count: int) -> list[int]:
    """Which coarse runs are done again at full fineness: the best that count, best first.

    Args:
        scores: of those that were not, corrected.
        count: how many at most.
    """
    return [k for k in ranked(scores) if scores[k].counts][:count]


def agreement(pairs: Sequence[tuple[Score, Score]]) -> list[float]:
    """Rank correlation of coarse and fine values, one for each objective [-]; none if too few."""
    both = [(a, b) for a, b in pairs if a.counts and b.counts]
    if len(both) < LEAST_PAIRS:
        return []
    found = []
    for k in range(len(both[0][0].objectives)):
        coarse, fine = ([s.objectives[k] for s in side] for side in zip(*both, strict=True))
        alike = np.ptp(coarse) == 0.0 or np.ptp(fine) == 0.0
        found.append(math.nan if alike else float(spearmanr(coarse, fine).statistic))
    return found
