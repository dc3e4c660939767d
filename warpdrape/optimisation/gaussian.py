"""Where to look next by Gaussian processes, scikit-learn's: noise is fitted, limits are modelled.

Objective and constraints have a process each. The next place has the largest expected improvement
on the best mean so far (not the luckiest run) times the chance that all constraints hold (Schonlau,
Welch & Jones 1998). Further places of a batch take those before them for known at their mean
(kriging believer), and every other one is where doubt is largest of all that may be best yet
(Contal et al. 2013), lest a batch sit in one spot. Two objectives are weighed, by other weights for
each place (ParEGO, Knowles 2006).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from scipy.special import erfcx, log_ndtr

from warpdrape.optimisation.known import Known, as_numbers
from warpdrape.optimisation.process import Process
from warpdrape.optimisation.space import CHOICE, SHARE, Axis, Place, features
from warpdrape.optional import needed

FIELD, NEAR, BEST = 1500, 40, 8
"""Places tried all over; near each of the best ones; how many of those."""
STEPS = (0.2, 0.06, 0.02, 0.006)
"""Standard deviations of the places tried near the best [-], one round each."""
APART = 0.1
"""Least distance to places that are known, over the mean one between as many [-]: a run beside one
that is known tells next to nothing, and its noise is much the same."""
ROOT = np.sqrt(2.0 * np.pi)
FARTHEST = 1e5
"""Standard deviations beyond which the improvement's difference is lost to rounding."""
WIDE = 2.0
"""Standard deviations within which a mean is taken to lie."""
OUTSIDE = 100.0
"""Taken from the logarithm of the doubt for each deviation by which a place cannot be best."""
BESIDE = 1e6
"""Taken from the logarithm of what a run promises, where it lies beside one that is known."""
EVEN = 0.05
"""Weight of the sum beside the larger one, where two objectives are weighed."""


def propose(axes: Sequence[Axis], known: Sequence[Known], count: int, seed: int) -> list[Place]:
    """Ask for places at which a run promises most.

    Args:
        axes: the space.
        known: what is known, with at least one score that counts.
        count: how many places.
        seed: of what is random.
    """
    with needed("threadpoolctl", "optimise").threadpool_limits(1):  # more only wait for each other
        return _propose(axes, known, count, seed)


def _propose(axes: Sequence[Axis], known: Sequence[Known], count: int, seed: int) -> list[Place]:
    rng = np.random.default_rng(seed)
    places = np.array([each.place for each in known])
    values, excess = as_numbers([each.score for each in known])
    feasible = (excess <= 0.0).all(axis=1)
    limits = [Process(axes, places, column, seed) for column in excess.T if (column > 0.0).any()]
    aim: Process | None = None
    found: list[Place] = []
    first = rng.random()
    for k in range(count):
        if aim is None or values.shape[1] > 1:
            weight = (first + k / count) % 1.0  # evenly over a batch
            aim = Process(axes, places, _weighed(values, weight), seed)
            for chosen in found:
                aim.believe(np.array([chosen]))
        doubt = k % 2 == 1 and values.shape[1] == 1 and feasible.any()
        worth = (_doubt if doubt else _worth)(aim, limits, places[feasible])
        worth = _apart(axes, worth, np.vstack([places, *found]))
        best = places[np.lexsort((aim.at(places)[0], ~feasible))[:BEST]]
        place = _climb(axes, worth, best, rng)
        found.append(tuple(float(at) for at in place))
        for process in (aim, *limits):
            process.believe(place[None])
    return found


def _weighed(values: np.ndarray, weight: float) -> np.ndarray:
    """One objective as it is; of two the larger of both by their weights, shape [run]."""
    if values.shape[1] == 1:
        return values[:, 0]
    width = np.ptp(values, axis=0)
    share = (values - values.min(axis=0)) / np.where(width > 0.0, width, 1.0)
    weighed = share * np.array([weight, 1.0 - weight])
    return weighed.max(axis=1) + EVEN * weighed.sum(axis=1)


def _worth(
    aim: Process, limits: Sequence[Process], feasible: np.ndarray
) -> Callable[[np.ndarray], np.ndarray]:
    """Logarithm of what a run at places, shape [n, axis], promises, shape [n]."""
    best = float(aim.at(feasible)[0].min()) if len(feasible) else None

    def worth(places: np.ndarray) -> np.ndarray:
        total = np.zeros(len(places))
        if best is not None:
            mean, deviation = aim.at(places)
            total += np.log(deviation) + log_improvement((best - mean) / deviation)
        for limit in limits:
            mean, deviation = limit.at(places)
            total += log_ndtr(-mean / deviation)
        return total

    return worth


def _doubt(
    aim: Process, limits: Sequence[Process], feasible: np.ndarray
) -> Callable[[np.ndarray], np.ndarray]:
    """Logarithm of the doubt about places that may be best yet, times the chance of all limits.

    Those may be best whose mean less `WIDE` deviations is below the least mean plus as many.
    """
    mean, deviation = aim.at(feasible)
    bound = float((mean + WIDE * deviation).min())

    def worth(places: np.ndarray) -> np.ndarray:
        mean, deviation = aim.at(places)
        beyond = np.maximum(mean - WIDE * deviation - bound, 0.0) / deviation
        total = np.log(deviation) - OUTSIDE * beyond
        for limit in limits:
            mean, deviation = limit.at(places)
            total += log_ndtr(-mean / deviation)
        return total

    return worth


def _apart(
    axes: Sequence[Axis], worth: Callable[[np.ndarray], np.ndarray], known: np.ndarray
) -> Callable[[np.ndarray], np.ndarray]:
    """The same, but next to nothing right beside places that are known, shape [n, axis]."""
    seen = features(axes, known)
    least = APART * len(known) ** (-1.0 / len(axes))

    def apart(places: np.ndarray) -> np.ndarray:
        there = features(axes, places)
        gaps = np.linalg.norm(there[:, None] - seen[None], axis=2).min(axis=1)
        return worth(places) - np.where(gaps < least, BESIDE, 0.0)

    return apart


def log_improvement(z: np.ndarray) -> np.ndarray:
    """Logarithm of φ(z) + z Φ(z), the expected improvement over the standard deviation.

    Args:
        z: how far the mean lies below the best, in standard deviations, shape [n].
    """
    z = np.asarray(z, dtype=float)
    high, low = np.maximum(z, 0.0), np.clip(-z, 0.0, FARTHEST)
    above = np.exp(-0.5 * high**2) / ROOT + high * np.exp(log_ndtr(high))
    below = 1.0 / ROOT - 0.5 * low * erfcx(low / np.sqrt(2.0))  # over exp(-z²/2): it vanishes
    return np.where(z > 0.0, np.log(above), np.log(below) - 0.5 * z**2)


def _climb(
    axes: Sequence[Axis],
    worth: Callable[[np.ndarray], np.ndarray],
    best: np.ndarray,
    rng: np.random.Generator,
) -> np.ndarray:
    """The place that promises most, of many all over and of those near the best, shape [axis]."""
    shares = rng.random((FIELD, len(axes)))
    field = np.array([[axis.at(float(u)) for axis, u in zip(axes, s, strict=True)] for s in shares])
    tried = np.vstack([field, best])
    for step in STEPS:
        order = np.argsort(-worth(tried), kind="stable")
        best = tried[order[:BEST]]
        near = np.repeat(best, NEAR, axis=0)
        for k, axis in enumerate(axes):
            near[:, k] = _moved(axis, near[:, k], step, rng)
        tried = np.vstack([best, near])
    return tried[int(np.argmax(worth(tried)))]


def _moved(axis: Axis, at: np.ndarray, step: float, rng: np.random.Generator) -> np.ndarray:
    """Coordinates near others, within the axis; of words any now and then."""
    if axis.kind == CHOICE:
        other = rng.integers(int(axis.high) + 1, size=at.shape).astype(float)
        return np.where(rng.random(at.shape) < step, other, at)
    width = axis.high - axis.low
    moved = at + step * width * rng.standard_normal(at.shape)
    if axis.kind != SHARE:
        moved = np.round(moved)
    return np.clip(moved, axis.low, axis.high)
