"""How a parameter varies: from a share between 0 and 1, as designs give it, to a value."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from statistics import NormalDist
from typing import Any

import numpy as np
from scipy import stats

from warpdrape.errors import InputError, nearest

KINDS = ("values", "range", "log_range", "normal", "lognormal", "triangular", "band")
"""How a parameter may be said to vary; one of them each."""
_TABLES = {
    "normal": (("mean", "sd"), ("low", "high")),
    "lognormal": (("median", "spread"), ()),
    "triangular": (("low", "mode", "high"), ()),
}
"""Kinds that are tables → keys that they need, and may have."""
EDGE = 1e-6
"""Least share, and from 1 the most, at which a distribution without ends is asked."""


@dataclass(frozen=True)
class Spread:
    """How a parameter varies.

    Attributes:
        kind: one of `KINDS`, but for "band", which is a normal one.
        numbers: what describes it, by name, in the parameter's own unit; low and high may lack.
        values: all that there are, for the kind "values" alone.
    """

    kind: str
    numbers: Mapping[str, float]
    values: tuple[Any, ...] = ()

    def at(self, share: float) -> Any:
        """The value below which a share of all values lies.

        Args:
            share: between 0 and 1 [-].
        """
        if self.values:
            return self.values[min(int(share * len(self.values)), len(self.values) - 1)]
        n = self.numbers
        if self.kind == "range":
            return n["low"] + share * (n["high"] - n["low"])
        if self.kind == "log_range":
            return n["low"] * (n["high"] / n["low"]) ** share
        return float(_frozen(self.kind, n).ppf(np.clip(share, EDGE, 1.0 - EDGE)))

    def whole_at(self, share: float) -> int:
        """Likewise for a whole number: of a range every one in it has the same chance."""
        if self.values:
            return self.at(share)
        if self.kind == "range":
            low, high = round(self.numbers["low"]), round(self.numbers["high"])
            return min(low + int(share * (high - low + 1)), high)
        return round(self.at(share))

    def steps(self, count: int) -> list[Any]:
        """So many values from end to end, for a grid; those that are given where they are."""
        if self.values:
            return list(self.values)
        ends = {"range", "log_range", "triangular"}
        shares = np.linspace(0.0, 1.0, count) if self.kind in ends else _midway(count)
        return [self.at(float(share)) for share in shares]


def _midway(count: int) -> np.ndarray:
    """Shares in the midst of so many equal parts, where a distribution has no ends."""
    return (np.arange(count) + 0.5) / count


def _frozen(kind: str, n: Mapping[str, float]) -> Any:
    if kind == "lognormal":
        return stats.lognorm(s=n["spread"], scale=n["median"])
    if kind == "triangular":
        width = n["high"] - n["low"]
        return stats.triang((n["mode"] - n["low"]) / width, n["low"], width)
    ends = [(n.get(end, far) - n["mean"]) / n["sd"] for end, far in _FAR]
    return stats.truncnorm(*ends, loc=n["mean"], scale=n["sd"])


_FAR = (("low", -math.inf), ("high", math.inf))


def read_spread(given: Mapping[str, Any], read: Callable[[Any], Any], *, numeric: bool) -> Spread:
    """Read how a parameter varies.

    Args:
        given: the table of the study file, one key of which is in `KINDS`.
        read: makes a value of what is written, such as "50 N".
        numeric: whether values are numbers, so that they have ranges and distributions.

    Raises:
        InputError: it varies in no way or in two, or the numbers make no sense.
    """
    found = [kind for kind in KINDS if kind in given]
    if len(found) != 1:
        raise InputError(f"give one of {', '.join(KINDS)}; there are {len(found)}")
    kind = found[0]
    if kind == "values":
        return Spread("values", {}, _values(given["values"], read))
    if not numeric:
        raise InputError(f"{kind} needs a parameter that is one number: give values = [...]")
    if kind in ("range", "log_range"):
        numbers = _ends(kind, given[kind], read)
    else:
        numbers = _table(kind, given[kind], read)
    return Spread(kind, numbers)


def _values(given: Any, read: Callable[[Any], Any]) -> tuple[Any, ...]:
    if not isinstance(given, list) or not given:
        raise InputError(f"values = {given!r} must be a list with an entry or more")
    values = tuple(map(read, given))
    if len(set(map(repr, values))) < len(values):
        raise InputError(f"values = {given!r} has an entry twice: give each once")
    return values


def _ends(kind: str, given: Any, read: Callable[[Any], Any]) -> dict[str, float]:
    if not isinstance(given, list) or len(given) != 2:
        raise InputError(f"{kind} = {given!r} must be a list of two, [lowest, highest]")
    low, high = map(read, given)
    if not low < high:
        raise InputError(f"{kind} = {given!r} must rise from its lowest to its highest")
    if kind == "log_range" and low <= 0.0:
        raise InputError(f"log_range = {given!r} must lie above zero: give a range")
    return {"low": low, "high": high}


def _table(kind: str, given: Any, read: Callable[[Any], Any]) -> dict[str, float]:
    need, may = _TABLES[kind]
    if not isinstance(given, Mapping):
        raise InputError(f"{kind} = {given!r} must be a table with {', '.join(need)}")
    for key in given:
        if key not in (*need, *may):
            raise InputError(f"{kind}: {key!r} is unknown{nearest(key, (*need, *may))}")
    missing = [key for key in need if key not in given]
    if missing:
        raise InputError(f"{kind} lacks {', '.join(missing)}")
    n = {key: _bare(key, value) if key == "spread" else read(value) for key, value in given.items()}
    for width in {"sd", "spread", "median"} & set(n):
        if n[width] <= 0.0:
            raise InputError(f"{kind}: {width} = {n[width]:g} must be above zero")
    low, high = n.get("low", -math.inf), n.get("high", math.inf)
    if not low < high or not low <= n.get("mode", low) <= high:
        raise InputError(f"{kind} = {dict(given)!r} must have low below high, and mode between")
    if kind == "normal":
        below = NormalDist(n["mean"], n["sd"]).cdf
        if below(high) - below(low) < EDGE:
            raise InputError(f"{kind} = {dict(given)!r}: low and high leave nothing of it")
    return n


def _bare(key: str, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise InputError(f"{key} = {value!r} must be a number without unit")
    return float(value)
