"""Where to look next by slopes: SciPy's sequential least squares (Kraft 1988), on runs.

The slopes are differences of runs, four a parameter at the beginning, by two steps, and two a
parameter from then on. Where the two steps disagree the measure has no slope that could be trusted,
and the method says so and ends. Nothing is remembered between batches: the descent is done again
each time on the runs that there are, the same to the last digit, until it wants some that are not
there. When it has come to its end another one begins at random.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from warpdrape.errors import InputError
from warpdrape.optimisation.aims import Aims, Score
from warpdrape.optimisation.differences import STEP, agree
from warpdrape.optimisation.known import Known
from warpdrape.optimisation.space import SHARE, Axis, Place, random_places

GRADIENT = "gradient"
DIGITS = 9
"""Of coordinates, which tell runs that are there from others."""
FLAT = 0.1
"""A slope counts as this share of a measure's steepest one at least, where steps are compared [-]:
what matters less need not be known as well."""
ENOUGH = 1e-3
"""Gain at which a descent ends, over the objective's steepest change along an axis [-]."""
MARGIN = 2e-3
"""By which limits are kept, likewise [-]: a run that is outside by a rounding is outside."""


class _Wanted(Exception):
    """Runs that are not there."""

    def __init__(self, places: Sequence[Place]) -> None:
        super().__init__("runs are wanted")
        self.places = list(places)


class _Broken(Exception):
    """A run beside does not count: the descent ends there."""


class NoSlope(Exception):
    """Slopes by two steps that disagree: the descent ends there.

    Args:
        measure: 0 for the objective, from 1 on constraints in their order.
        axis: along which.
        wide: change of what is kept small over the whole axis, by the larger step.
        narrow: likewise by half of it.
    """

    def __init__(self, measure: int, axis: int, wide: float, narrow: float) -> None:
        super().__init__("no slope to be trusted")
        self.measure, self.axis, self.wide, self.narrow = measure, axis, wide, narrow

    def words(self, axes: Sequence[Axis], aims: Aims) -> str:
        """What to do about it, with measure and parameter as their file names them."""
        aim = aims.every[self.measure]
        name = axes[self.axis].varied.name
        wide, narrow = aim.sign * self.wide, aim.sign * self.narrow
        return (
            f"optimise: method = 'gradient': the measure of '{aim.words}' changes with {name} by "
            f"{wide:.3g} over its range by one step and by {narrow:.3g} by half of it: that is no "
            "slope to be trusted; take method = 'gp', which is the default, or leave "
            f"{name} as it is"
        )


def refuse_gradient(axes: Sequence[Axis], aims: Aims, *, coarse: bool) -> None:
    """Raise `InputError` for what has no slopes, or of which no descent can be made."""
    words = [axis.varied.name for axis in axes if axis.kind != SHARE]
    other = "take method = 'gp', which is the default"
    if words:
        raise InputError(
            f"optimise: method = 'gradient' wants ranges of numbers, and {', '.join(words)} has "
            f"whole numbers or words: {other}"
        )
    if len(aims.objectives) > 1:
        raise InputError(
            f"optimise: method = 'gradient' makes one measure least: give one, or {other}"
        )
    if coarse:
        raise InputError(
            "optimise: method = 'gradient' has no use for coarse runs, whose slopes are others: "
            f"leave [optimise.coarse] away, or {other}"
        )


def propose(axes: Sequence[Axis], known: Sequence[Known], count: int, seed: int) -> list[Place]:
    """Ask for places that the descent wants next.

    Args:
        axes: the space, of ranges.
        known: what is known, with at least one score that counts, in the order of the runs.
        count: how many places at most.
        seed: of where the next descent begins.

    Raises:
        NoSlope: where the slopes at the first beginning are not to be trusted.
        InputError: where a run for them does not count.
    """
    runs = {_key(each.place): each.score for each in known}
    used: set[Place] = set()
    first = True
    for each in known:
        place = _key(each.place)
        if place in used or not each.score.counts:
            continue
        try:
            _descend(_Runs(runs, used), place)
        except _Wanted as wanted:
            return wanted.places[:count]
        except NoSlope:
            if first:
                raise
        except _Broken as why:
            if first:
                raise InputError(
                    f"optimise: method = 'gradient': {why}: begin elsewhere by [optimise.start], "
                    "or take method = 'gp', which is the default"
                ) from why
        first = False
    return random_places(axes, 1, seed)


def _key(place: Sequence[float] | np.ndarray) -> Place:
    return tuple(round(float(at), DIGITS) for at in place)


@dataclass(frozen=True, eq=False)
class _Runs:
    """Runs that are there by their place, and those of them that a descent has used."""

    there: dict[Place, Score]
    used: set[Place]

    def score(self, place: Sequence[float] | np.ndarray) -> Score:
        """Of the run at a place."""
        return self.scores([place])[0]

    def scores(self, places: Sequence[Sequence[float] | np.ndarray]) -> list[Score]:
        """Of runs at places; all that are missing are wanted at once."""
        keys = [_key(place) for place in places]
        self.used.update(keys)
        missing = [key for key in dict.fromkeys(keys) if key not in self.there]
        if missing:
            raise _Wanted(missing)
        return [self.there[key] for key in keys]

    def slopes(self, place: Place, step: float) -> np.ndarray:
        """Of the objective and of every excess along each axis, shape [1 + excess, axis].

        Second order everywhere: of two runs to both sides, or where that would leave the axis of
        two to one.
        """
        sides = [_sides(at, step) for at in place]
        beside = [
            (*place[:k], place[k] + shift, *place[k + 1 :])
            for k, pair in enumerate(sides)
            for shift in pair
        ]
        here, *there = (_column(score) for score in self.scores([place, *beside]))
        columns = []
        for k, (a, b) in enumerate(sides):
            one, two = there[2 * k], there[2 * k + 1]
            central = (one - two) / (a - b)
            aside = (4.0 * one - two - 3.0 * here) / b
            columns.append(central if a == -b else aside)
        return np.ascontiguousarray(np.array(columns).T)  # SciPy's SLSQP knows no strides


def _sides(at: float, step: float) -> tuple[float, float]:
    if step <= at <= 1.0 - step:
        return step, -step
    return (step, 2.0 * step) if at < step else (-step, -2.0 * step)


def _column(score: Score) -> np.ndarray:
    if not score.counts:
        raise _Broken(f"a run for the slopes does not count ({score.why})")
    return np.array([*score.objectives, *score.excess])


def _descend(runs: _Runs, begin: Place) -> None:
    """Do a descent to its end, on runs that are there."""
    scale = _scale_of(runs, begin)
    begun = _column(runs.score(begin)) / scale

    def at(place: np.ndarray) -> np.ndarray:
        score = runs.score(place)
        if score.counts:
            return _column(score) / scale
        return np.maximum(begun, 0.0) + 1.0  # worse than where it began: the step is made shorter

    def slopes(place: np.ndarray) -> np.ndarray:
        return runs.slopes(_key(place), 0.5 * STEP) / scale[:, None]

    limits = []
    if len(scale) > 1:
        limits = [
            {
                "type": "ineq",
                "fun": lambda place: -at(place)[1:] - MARGIN,
                "jac": lambda place: -slopes(place)[1:],
            }
        ]
    minimize(
        lambda place: at(place)[0],
        np.array(begin),
        jac=lambda place: slopes(place)[0],
        bounds=[(0.0, 1.0)] * len(begin),
        constraints=limits,
        method="SLSQP",
        options={"ftol": ENOUGH},
    )


def _scale_of(runs: _Runs, begin: Place) -> np.ndarray:
    """The steepest slope of each measure, shape [1 + excess]; raise where one is none."""
    narrow = runs.slopes(begin, 0.5 * STEP)
    wide = runs.slopes(begin, STEP)
    steepest = np.maximum(np.abs(narrow), np.abs(wide)).max(axis=1)
    bad = ~agree(wide, narrow, FLAT * steepest[:, None])
    if bad.any():
        row, column = map(int, np.argwhere(bad)[0])
        raise NoSlope(row, column, float(wide[row, column]), float(narrow[row, column]))
    return np.where(steepest > 0.0, steepest, 1.0)
