"""Where to look next by Optuna's tree-structured Parzen estimator (Bergstra et al. 2011).

Each batch has a sampler and a study of its own, made anew from what is known, so that the same
knowledge and seed give the same places, in this process or in one that goes on later.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import Any

from warpdrape.optimisation.known import Known, as_numbers
from warpdrape.optimisation.space import CHOICE, SHARE, Axis, Place
from warpdrape.optional import needed


def propose(axes: Sequence[Axis], known: Sequence[Known], count: int, seed: int) -> list[Place]:
    """Ask for places at which a run promises most.

    Args:
        axes: the space.
        known: what is known, with at least one score that counts.
        count: how many places; those asked for are taken to be under way, so that they differ.
        seed: of what is random.
    """
    optuna = needed("optuna", "optimise")
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    distributions = {str(k): _distribution(optuna, axis) for k, axis in enumerate(axes)}
    values, excess = as_numbers([each.score for each in known])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of what Optuna calls experimental
        sampler = optuna.samplers.TPESampler(
            seed=seed, n_startup_trials=1, multivariate=True, constant_liar=True
        )
        study = optuna.create_study(directions=["minimize"] * values.shape[1], sampler=sampler)
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


def _distribution(optuna: Any, axis: Axis) -> Any:
    if axis.kind == SHARE:
        return optuna.distributions.FloatDistribution(0.0, 1.0)
    if axis.kind == CHOICE:
        return optuna.distributions.CategoricalDistribution(range(int(axis.high) + 1))
    return optuna.distributions.IntDistribution(int(axis.low), int(axis.high), log=axis.log)


def _params(axes: Sequence[Axis], place: Place) -> dict[str, float | int]:
    return {
        str(k): at if axis.kind == SHARE else int(at)
        for k, (axis, at) in enumerate(zip(axes, place, strict=True))
    }
