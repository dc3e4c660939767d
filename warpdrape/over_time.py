"""Values over time, given as one number or as pairs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from warpdrape.errors import InputError, numbers, positive


def table_over_time(name: str, pairs: Any, unit: str) -> tuple[tuple[float, float], ...]:
    """Pairs of a rising time [s] and a value; or `InputError`.

    Args:
        name: what errors call it.
        pairs: two or more.
        unit: of the values.
    """
    table = numbers(name, pairs)
    if table.ndim != 2 or table.shape[1] != 2 or len(table) < 2 or not np.isfinite(table).all():
        raise InputError(
            f"{name} must be one number [{unit}], or two or more pairs of finite numbers "
            f"(time [s], value [{unit}])"
        )
    if (np.diff(table[:, 0]) <= 0.0).any():
        raise InputError(f"{name}: its times must rise")
    return tuple((float(time), float(value)) for time, value in table)


def never_negative(name: str, given: Any, unit: str) -> float | tuple[tuple[float, float], ...]:
    """One number, or pairs as of `table_over_time`, none below zero; or `InputError`."""
    if not isinstance(given, list | tuple | np.ndarray):
        return positive(name, given, unit=unit, zero=True)
    table = table_over_time(name, given, unit)
    for time, value in table:
        if value < 0.0:
            raise InputError(
                f"{name} = {value:g} {unit} at {time:g} s is below zero: give zero or more"
            )
    return table


def over_time(given: float | Sequence[tuple[float, float]], time: np.ndarray) -> np.ndarray:
    """One number, or a table's values, at times [s]."""
    if isinstance(given, int | float):
        return np.full(np.shape(time), float(given))
    return through(given, time)


def through(table: Sequence[tuple[float, float]], time: np.ndarray) -> np.ndarray:
    """A value at times [s], smooth and monotone between a table's points, the ends holding."""
    from scipy.interpolate import PchipInterpolator  # when needed: help starts sooner

    times, values = np.array(table).T
    inside = np.clip(np.asarray(time, dtype=float), times[0], times[-1])
    return PchipInterpolator(times, values)(inside)
