"""What goes wrong, in words that say what to do."""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable
from typing import Any

import numpy as np

SIZES = (1e-9, 1e6)
"""Sizes of plies and tools [m] beyond which one is a slip of the pen, and its square no number."""
LONGEST = 600
"""Characters of a message beyond which its middle is left out: a value may be of any length."""


class InputError(ValueError):
    """Unusable input: the text names the argument, its value, the limit and the remedy.

    Whatever the value is, it takes one line.
    """

    def __init__(self, text: object) -> None:
        super().__init__(_one_line(str(text)))


class RunFailed(RuntimeError):
    """A run that had to stop: the text says when, where, and what to try."""


def _one_line(text: str) -> str:
    text = " ".join(text.split())
    if len(text) <= LONGEST:
        return text
    return f"{text[: LONGEST // 2]} … {text[-LONGEST // 2 :]}"


def said(value: Any) -> str:
    """How a message says a value, be it what it may."""
    try:
        return repr(value)
    except Exception:  # a whole number of more than some thousand digits, for instance
        return f"a {type(value).__name__} that cannot be printed"


def positive(name: str, value: Any, *, unit: str = "", zero: bool = False) -> float:
    """Return ``value`` as a float; raise `InputError` unless it is finite and above 0 (or 0)."""
    number = finite(name, value, unit=unit)
    if number < 0.0 or (number == 0.0 and not zero):
        raise InputError(
            f"{name} = {said(value)} {unit}".rstrip()
            + f" must be {'zero or more' if zero else 'above zero'}"
        )
    return number


def finite(name: str, value: Any, *, unit: str = "") -> float:
    """Return ``value`` as a float; raise `InputError` unless it is one finite number."""
    real = int | float | np.integer | np.floating
    if isinstance(value, bool | np.timedelta64) or not isinstance(value, real):
        raise InputError(
            f"{name} = {said(value)} must be a number {f'[{unit}]' if unit else ''}".strip()
        )
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise InputError(f"{name} = {said(value)} must be finite")
    return number


def length(name: str, value: Any) -> float:
    """Return a size of a ply or tool as a float; raise `InputError` unless it can be one [m]."""
    size = positive(name, value, unit="m")
    if not SIZES[0] <= size <= SIZES[1]:
        raise InputError(
            f"{name} = {size:.4g} m must lie in {SIZES[0]:g} … {SIZES[1]:g} m: give metres, as in "
            "75 * mm"
        )
    return size


def numbers(name: str, values: Any) -> np.ndarray:
    """Return ``values`` as an array of floats; raise `InputError` unless they are real numbers."""
    try:
        array = np.asarray(values)
        if array.dtype.kind == "O":
            array = np.array([[finite(name, v) for v in np.ravel(array)]]).reshape(array.shape)
        if array.dtype.kind not in "iuf":
            raise TypeError
        return array.astype(float)
    except (TypeError, ValueError, OverflowError, RecursionError):
        raise InputError(f"{name} = {said(values)} must be finite numbers") from None


def one_of(kind: str, name: object, known: Iterable[str]) -> str:
    """Return ``name`` if it is known; raise `InputError` with the nearest known one if not."""
    names = sorted(known)
    if isinstance(name, str) and name in names:
        return name
    words = name if isinstance(name, str) else said(name)
    raise InputError(f"unknown {kind} {words!r}{nearest(words, names)}")


def true_or_false(name: str, value: Any) -> bool:
    """Return ``value``; raise `InputError` unless it is True or False."""
    if not isinstance(value, bool | np.bool_):
        raise InputError(f"{name} = {said(value)} must be True or False")
    return bool(value)


def nearest(name: Any, names: Iterable[str]) -> str:
    """Say which known name is meant, or list them all."""
    names = sorted(names)
    close = difflib.get_close_matches(str(name)[:100], names, n=1, cutoff=0.5)
    hint = f"; did you mean {close[0]!r}?" if close else ";"
    return f"{hint} known: {', '.join(names)}"
