"""What is known at places, as numbers that a model of it takes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from warpdrape.optimisation.aims import Score
from warpdrape.optimisation.space import Place


@dataclass(frozen=True)
class Known:
    """A place of which something is known.

    Attributes:
        place: its coordinates.
        score: what a run there is worth.
    """

    place: Place
    score: Score


def as_numbers(scores: Sequence[Score]) -> tuple[np.ndarray, np.ndarray]:
    """Scores as a model takes them: what is minimised, and constraints that hold at zero or less.

    A run that does not count has the worst of all that was seen, and violates a constraint of its
    own, so that the search keeps away from where runs fail. Each constraint is measured by its mean
    violation, so that none outweighs the others by its unit. One that is never kept by a margin, as
    that of no wrinkle at all, does not tell how far off its limit is: where it is kept it is taken
    for kept by a mean violation, else a model would give it an even chance there.

    Args:
        scores: one or more of which count.

    Returns:
        Objectives, shape [run, objective], and excesses, shape [run, constraint + 1].
    """
    good = [score for score in scores if score.counts]
    values = np.array([score.objectives for score in good], dtype=float)
    excess = np.array([score.excess for score in good], dtype=float).reshape(len(good), -1)
    beyond = np.where(excess > 0.0, excess, 0.0)
    hits = np.maximum((excess > 0.0).sum(axis=0), 1)
    scale = beyond.sum(axis=0) / hits
    scale = np.where(scale > 0.0, scale, np.abs(excess).max(axis=0, initial=0.0))
    excess = excess / np.where(scale > 0.0, scale, 1.0)
    bare = (excess >= 0.0).all(axis=0)
    excess = np.where(bare & (excess == 0.0), -1.0, excess)
    all_values = np.empty((len(scores), values.shape[1]))
    all_excess = np.empty((len(scores), excess.shape[1] + 1))
    counts = np.array([score.counts for score in scores], dtype=bool)
    all_values[counts], all_values[~counts] = values, values.max(axis=0)
    all_excess[counts, :-1], all_excess[~counts, :-1] = excess, excess.max(axis=0)
    all_excess[:, -1] = np.where(counts, -1.0, 1.0)
    return all_values, all_excess
