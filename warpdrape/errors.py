"""What goes wrong, in words that say what to do."""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable
from typing import Any

import numpy as np


class InputError(ValueError):
    """Unusable input: the text names the argument, its value, the limit and the remedy."""


class RunFailed(RuntimeError):
    """A run that had to stop: the text says when, where, and what to try."""


def positive(name: str, value: Any, *, unit: str = "", zero: bool = False) -> float:
    """Return ``value`` as a float; raise `InputError` unless it is finite and above 0 (or 0)."""
    number = finite(name, value, unit=unit)
    if number < 0.0 or (number == 0.0 and not zero):
        raise InputError(
            f"{name} = {value!r} {unit}".rstrip()
            + f" must be {'zero or more' if zero else 'above zero'}"
        )
    return number


def finite(name: str, value: Any, *, unit: str = "") -> float:
    """Return ``value`` as a float; raise `InputError` unless it is one finite number."""
    if isinstance(value, bool) or not isinstance(value, int | float | np.number):
        raise InputError(
            f"{name} = {value!r} must be a number {f'[{unit}]' if unit else ''}".strip()
        )
    if not math.isfinite(value):
        raise InputError(f"{name} = {value!r} must be finite")
    return float(value)


def one_of(kind: str, name: str, known: Iterable[str]) -> str:
    """Return ``name`` if it is known; raise `InputError` with the nearest known one if not."""
    names = sorted(known)
    if name in names:
        return name
    raise InputError(f"unknown {kind} {name!r}{nearest(name, names)}")


def nearest(name: Any, names: Iterable[str]) -> str:
    """Say which known name is meant, or list them all."""
    names = sorted(names)
    close = difflib.get_close_matches(str(name), names, n=1, cutoff=0.5)
    hint = f"; did you mean {close[0]!r}?" if close else ";"
    return f"{hint} known: {', '.join(names)}"
