"""Main effects: how the mean of a measure goes with each parameter, all others as they come."""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np
from scipy.stats import spearmanr

from warpdrape.studies.table import Table

BINS = 6
"""Parts with as many runs each into which a parameter of many values is cut, at most."""
LEAST = 5
"""Runs to a part, on average, at least."""


@dataclass(frozen=True, eq=False)
class Effect:
    """How a measure goes with a parameter.

    Attributes:
        parameter: its name.
        measure: its name.
        levels: of the parameter: its values, or the mean of each part.
        words: the same for a text.
        means: of the measure there, shape [level].
        errors: standard error of each mean; NaN of a single run.
        counts: runs at each.
        rank: Spearman's correlation of ranks [-]; NaN for words, or where nothing varies.
    """

    parameter: str
    measure: str
    levels: np.ndarray
    words: tuple[str, ...]
    means: np.ndarray
    errors: np.ndarray
    counts: np.ndarray
    rank: float

    @property
    def span(self) -> float:
        """Highest mean minus lowest."""
        return float(self.means.max() - self.means.min()) if len(self.means) else 0.0


def effects(table: Table) -> list[Effect]:
    """The effect of each parameter on each measure, over the runs that completed."""
    return [
        found
        for measure in table.measures
        for parameter in table.parameters
        if (found := _effect(table, parameter, measure)) is not None
    ]


def _effect(table: Table, parameter: str, measure: str) -> Effect | None:
    values = table.numbers(measure)
    there = np.isfinite(values)
    if not there.any():
        return None
    values = values[there]
    given = [v for v, t in zip(table.columns[parameter], there, strict=True) if t]
    if is_number(given):
        levels, places = _parts(np.array(given, dtype=float))
        words: tuple[str, ...] = ()
        rank = _rank(np.array(given, dtype=float), values)
    else:
        words = tuple(sorted({str(v) for v in given}))
        levels = np.arange(len(words), dtype=float)
        places = np.array([words.index(str(v)) for v in given])
        rank = np.nan
    sets = [values[places == k] for k in range(len(levels))]
    errors = [s.std(ddof=1) / np.sqrt(len(s)) if len(s) > 1 else np.nan for s in sets]
    return Effect(
        parameter,
        measure,
        levels,
        words,
        np.array([s.mean() for s in sets]),
        np.array(errors),
        np.array([len(s) for s in sets]),
        rank,
    )


def is_number(values: list) -> bool:
    """Whether a parameter's values are numbers: neither words nor yes and no."""
    return all(isinstance(v, int | float) and not isinstance(v, bool) for v in values)


def _parts(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Levels of a parameter, and at which one each run is.

    A parameter of few values, each of several runs, has those; others are cut into parts with as
    many runs each.
    """
    distinct, places = np.unique(values, return_inverse=True)
    if len(distinct) <= min(BINS, max(len(values) // 2, 2)):
        return distinct, places
    count = max(2, min(BINS, len(values) // LEAST))
    ranks = np.argsort(np.argsort(values, kind="stable"), kind="stable")
    places = ranks * count // len(values)
    return np.array([values[places == k].mean() for k in range(count)]), places


def _rank(one: np.ndarray, other: np.ndarray) -> float:
    if len(one) < 3 or np.ptp(one) == 0.0 or np.ptp(other) == 0.0:
        return np.nan
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return float(spearmanr(one, other).statistic)
