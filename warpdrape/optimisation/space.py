"""Where settings may lie: a coordinate for each parameter, and its value there."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.stats import qmc

from warpdrape.errors import InputError
from warpdrape.studies.design import Row
from warpdrape.studies.parameters import Varied

Place = tuple[float, ...]
"""A coordinate for each parameter: see `Axis`."""
SHARE, WHOLE, CHOICE = "share", "whole", "choice"
"""Kinds of axes: of a range 0 to 1 of its (or its logarithm's) length; of a whole number that, or
the place of one in a list of numbers; of words the place in their list, which has no order."""


@dataclass(frozen=True)
class Axis:
    """One parameter as the search sees it.

    Attributes:
        varied: the parameter.
        kind: "share", "whole" or "choice".
        low: lowest coordinate.
        high: highest coordinate.
    """

    varied: Varied
    kind: str
    low: float
    high: float

    @property
    def log(self) -> bool:
        """Whether a whole number's steps are those of its logarithm."""
        spread = self.varied.spread
        return spread is not None and self.kind == WHOLE and spread.kind == "log_range"

    def value(self, at: float) -> Any:
        """The parameter's value at a coordinate."""
        spread = self.varied.spread
        assert spread is not None
        if spread.values:
            return spread.values[int(at)]
        return int(at) if self.kind == WHOLE else spread.at(at)

    def at(self, share: float) -> float:
        """The coordinate below which a share of the axis lies, in 0 to 1 [-]."""
        if self.kind == SHARE:
            return float(share)
        if self.log:
            high = self.low * (self.high / self.low) ** share
            return float(min(max(round(high), self.low), self.high))
        return float(min(self.low + int(share * (self.high - self.low + 1)), self.high))

    def place(self, value: Any) -> float | None:
        """The coordinate of a value; None if it lies outside."""
        spread = self.varied.spread
        assert spread is not None
        if spread.values:
            return float(spread.values.index(value)) if value in spread.values else None
        if isinstance(value, bool) or not isinstance(value, int | float):
            return None
        low, high = spread.numbers["low"], spread.numbers["high"]
        if not low <= value <= high:
            return None
        if self.kind == WHOLE:
            return float(value)
        if spread.kind == "log_range":
            return math.log(value / low) / math.log(high / low)
        return (value - low) / (high - low)


def axes_of(parameters: Sequence[Varied]) -> tuple[Axis, ...]:
    """The axes of a study's parameters.

    Raises:
        InputError: for a parameter that has a distribution, which says how likely a value is and
            not where the best may be looked for.
    """
    return tuple(map(_axis, parameters))


def _axis(varied: Varied) -> Axis:
    spread = varied.spread
    if spread is None or spread.kind not in ("values", "range", "log_range"):
        raise InputError(
            f"parameter {varied.name!r}: an optimisation looks within values, range or log_range: "
            "give one of these"
        )
    if spread.values:
        numbers = all(isinstance(v, int | float) and not isinstance(v, bool) for v in spread.values)
        ordered = numbers and list(spread.values) == sorted(spread.values)
        return Axis(varied, WHOLE if ordered else CHOICE, 0.0, len(spread.values) - 1.0)
    if varied.own is not None and varied.own.kind is int:
        return Axis(varied, WHOLE, round(spread.numbers["low"]), round(spread.numbers["high"]))
    return Axis(varied, SHARE, 0.0, 1.0)


def row_at(axes: Sequence[Axis], place: Place) -> Row:
    """Values of the parameters at a place."""
    return {axis.varied.name: axis.value(at) for axis, at in zip(axes, place, strict=True)}


def place_of(axes: Sequence[Axis], row: Row) -> Place | None:
    """The place of values; None if one of them lies outside."""
    found = [axis.place(row[axis.varied.name]) for axis in axes]
    return None if None in found else tuple(at for at in found if at is not None)


def features(axes: Sequence[Axis], places: np.ndarray) -> np.ndarray:
    """Places as a model sees them: each axis from 0 to 1, words each with an axis of its own.

    Args:
        axes: the space.
        places: shape [n, axis].

    Returns:
        Shape [n, feature].
    """
    columns = []
    for axis, at in zip(axes, np.asarray(places, dtype=float).T, strict=True):
        if axis.kind == CHOICE:
            count = int(axis.high) + 1
            columns.append(np.eye(count)[at.astype(int)] / math.sqrt(2.0))  # 1 from word to word
        elif axis.log:
            columns.append((np.log(at / axis.low) / math.log(axis.high / axis.low))[:, None])
        else:
            columns.append(((at - axis.low) / max(axis.high - axis.low, 1e-300))[:, None])
    return np.hstack(columns)


def spread_places(axes: Sequence[Axis], count: int, seed: int) -> list[Place]:
    """The first places of a scrambled Sobol sequence, which fills the space evenly."""
    whole = 1 << max(count - 1, 1).bit_length()
    shares = qmc.Sobol(len(axes), seed=np.random.default_rng(seed)).random(whole)[:count]
    return [_at_shares(axes, row) for row in shares]


def random_places(axes: Sequence[Axis], count: int, seed: int) -> list[Place]:
    """Places at random, all alike; the first of more are the same."""
    shares = np.random.default_rng(seed).random((count, len(axes)))
    return [_at_shares(axes, row) for row in shares]


def _at_shares(axes: Sequence[Axis], shares: np.ndarray) -> Place:
    return tuple(axis.at(float(u)) for axis, u in zip(axes, shares, strict=True))
