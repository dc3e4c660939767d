"""Confidence bands: the bootstrap over specimens, with Student's correction for few of them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import t as student

LEVEL = 0.90
"""Share of bands that hold the true value [-]."""
DRAWS = 400
"""Samples of specimens drawn with replacement."""
SEED = 20080601
"""Of the draws: the same tests give the same bands."""


@dataclass(frozen=True, eq=False)
class Band:
    """A value, or several, with their confidence bands.

    Attributes:
        value: the estimate, shape [n].
        low: lower end, shape [n]; NaN-free, equal to ``value`` where there is no band.
        high: upper end, shape [n].
        specimens: smallest number of specimens of a kind of test.
        told: whether there is a band at all: two specimens or more.
    """

    value: np.ndarray
    low: np.ndarray
    high: np.ndarray
    specimens: int
    told: bool

    def part(self, index: slice | list[int]) -> Band:
        """Some of its values."""
        told = self.specimens, self.told
        return Band(self.value[index], self.low[index], self.high[index], *told)

    def words(self, unit: str = "", factor: float = 1.0) -> str:
        """A single value with its band."""
        value, low, high = (
            factor * float(np.ravel(v)[0]) for v in (self.value, self.low, self.high)
        )
        ending = f" {unit}".rstrip() if unit != "°" else "°"
        if not self.told:
            return f"{value:.4g}{ending} (one specimen: no band)"
        return f"{value:.4g}{ending} ({LEVEL:.0%} band {low:.4g} to {high:.4g})"


def bootstrap(
    groups: Sequence[int],
    estimate: Callable[[np.ndarray], np.ndarray],
    *,
    weights: np.ndarray | None = None,
    draws: int = DRAWS,
    positive: bool = True,
    pool: bool = True,
) -> Band:
    """Band of an estimate over specimens: ± t √(n/(n − 1)) times the bootstrap's standard error.

    Specimens are drawn within each test. Percentiles of few specimens are too narrow: the factor
    √(n/(n − 1)) makes up for the error of a sample about its own mean, and Student's t of n − 1
    for how little n specimens say of their scatter (Hesterberg 2015).

    Args:
        groups: number of specimens of each test.
        estimate: weights of all specimens, shape [specimen], to values, shape [n].
        weights: of the specimens in a fit; all alike if None.
        draws: how many.
        positive: cut the band off at zero.
        pool: draw the specimens of tests that have only one together, with those of another test
            where it is a single one; if not, such tests have no band.
    """
    total = sum(groups)
    weights = np.ones(total) if weights is None else np.asarray(weights, dtype=float)
    value = np.atleast_1d(np.asarray(estimate(weights), dtype=float))
    strata = _strata(groups) if pool else _apart(groups)
    fewest = min(map(len, strata))
    if fewest < 2:
        return Band(value, value, value, 1, False)
    rng = np.random.default_rng(SEED)
    found = []
    for _ in range(draws):
        counts = np.zeros(total)
        for own in strata:
            counts[own] = rng.multinomial(len(own), np.full(len(own), 1.0 / len(own)))
        found.append(np.atleast_1d(estimate(weights * counts)))
    error = np.std(np.array(found), axis=0, ddof=1)
    wide = float(student.ppf(0.5 + 0.5 * LEVEL, fewest - 1)) * math.sqrt(fewest / (fewest - 1))
    low, high = value - wide * error, value + wide * error
    if positive:
        low = np.maximum(low, np.minimum(value, 0.0))
    return Band(value, low, high, fewest, True)


def _apart(groups: Sequence[int]) -> list[np.ndarray]:
    """Indices of each test's specimens."""
    return np.split(np.arange(sum(groups)), np.cumsum(groups)[:-1])


def _strata(groups: Sequence[int]) -> list[np.ndarray]:
    """The same, single ones together; a lone one joins the smallest other test."""
    parts = _apart(groups)
    many = sorted((p for p in parts if len(p) > 1), key=len)
    single = [p for p in parts if len(p) == 1]
    if len(single) == 1 and many:
        many[0] = np.concatenate([many[0], single[0]])
    elif single:
        many.append(np.concatenate(single))
    return many
