"""Where to look next: Optuna's samplers, told all that is known, asked for a batch of places.

Each batch has a sampler and a study of its own, made anew from what is known, so that the same
knowledge and seed give the same places, in this process or in one that goes on later.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from warpdrape.errors import InputError
from warpdrape.optimisation.aims import Score
from warpdrape.optimisation.space import CHOICE, SHARE, Axis, Place
from warpdrape.results.pyvista_mesh import needed

EXTRA = "optimise"
"""The extra that brings Optuna."""
TPE, GP = "tpe", "gp"
METHODS = (TPE, GP)
"""Tree-structured Parzen estimator; Gaussian processes that fit the noise, which need PyTorch."""


@dataclass(frozen=True)
class Known:
    """A place of which something is known.

    Attributes:
        place: its coordinates.
        score: what a run there is worth.
    """

    place: Place
    score: Score


def check_method(method: str) -> None:
    """Raise `InputError` where what a method needs is not installed."""
    needed("optuna", EXTRA)
    if method == GP:
        try:
            import torch  # noqa: F401
        except ImportError as error:
            raise InputError(
                "method = 'gp' needs PyTorch, which is not installed: pip install torch, or give "
                "method = 'tpe'"
            ) from error


def propose(
    axes: Sequence[Axis], known: Sequence[Known], count: int, *, method: str, seed: int
) -> list[Place]:
    """Ask for places at which a run promises most.

    Args:
        axes: the space.
        known: what is known, with at least one score that counts.
        count: how many places; those asked for are taken to be under way, so that they differ.
        method: one of `METHODS`.
        seed: of what is random.
    """
    optuna = needed("optuna", EXTRA)
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    distributions = {str(k): _distribution(optuna, axis) for k, axis in enumerate(axes)}
    values, excess = as_numbers([each.score for each in known])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of what Optuna calls experimental
        study = optuna.create_study(
            directions=["minimize"] * values.shape[1], sampler=_sampler(optuna, method, seed)
        )
        for each, objectives, beyond in zip(known, values, excess, strict=True):
            study.add_trial(
                optuna.trial.create_trial(
                    params=_params(axes, each.place),
                    distributions=distributions,
                    values=objectives.tolist(),
                    constraints={str(k): float(e) for k, e in enumerate(beyond)},
                )
            )
        asked = [study.ask(distributions) for _ in range(count)]
    return [tuple(float(trial.params[str(k)]) for k in range(len(axes))) for trial in asked]


def as_numbers(scores: Sequence[Score]) -> tuple[np.ndarray, np.ndarray]:
    """Scores as a sampler takes them: what it minimises, and constraints that hold at zero or less.

    A run that does not count has the worst of all that was seen, and violates a constraint of its
    own, so that the search keeps away from where runs fail. Each constraint is measured by its mean
    violation, so that none outweighs the others by its unit.

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
    all_values = np.empty((len(scores), values.shape[1]))
    all_excess = np.empty((len(scores), excess.shape[1] + 1))
    counts = np.array([score.counts for score in scores], dtype=bool)
    all_values[counts], all_values[~counts] = values, values.max(axis=0)
    all_excess[counts, :-1], all_excess[~counts, :-1] = excess, excess.max(axis=0)
    all_excess[:, -1] = np.where(counts, -1.0, 1.0)
    return all_values, all_excess


def _sampler(optuna: Any, method: str, seed: int) -> Any:
    if method == GP:
        return optuna.samplers.GPSampler(
            seed=seed, n_startup_trials=1, deterministic_objective=False
        )
    return optuna.samplers.TPESampler(
        seed=seed, n_startup_trials=1, multivariate=True, constant_liar=True
    )


def _distribution(optuna: Any, axis: Axis) -> Any:
    if axis.kind == SHARE:
        return optuna.distributions.FloatDistribution(0.0, 1.0)
    if axis.kind == CHOICE:
        return optuna.distributions.CategoricalDistribution(range(int(axis.high) + 1))
    spread = axis.varied.spread
    log = spread is not None and spread.kind == "log_range"
    return optuna.distributions.IntDistribution(int(axis.low), int(axis.high), log=log)


def _params(axes: Sequence[Axis], place: Place) -> dict[str, float | int]:
    return {
        str(k): at if axis.kind == SHARE else int(at)
        for k, (axis, at) in enumerate(zip(axes, place, strict=True))
    }
