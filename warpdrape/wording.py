"""How things show themselves in a notebook: a name, counts, sizes with units, in a line or two."""

from __future__ import annotations

import dataclasses
import inspect
import math
import re
from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np

FEW = 4
"""Numbers of a list that are shown; of more, how many there are and from where to where."""
_ATTRIBUTE = re.compile(r"^ {4}(\w+): (.*?)(?=^ {4}\w+: |^\s*$|\Z)", re.MULTILINE | re.DOTALL)
_UNIT = re.compile(r"(?<!shape )\[([^\],]+)[^\]]*\]")
_SMALLER = {"m": ("mm", 1e3), "s": ("ms", 1e3), "N·m": ("N·mm", 1e3), "rad": ("°", 180.0 / math.pi)}
"""Unit → the one in which people read what is small, and its factor; angles always."""


def brief(record: Any) -> str:
    """What a record of numbers, laws and names is, in a line; units are those of its docstring.

    Entries at their defaults are left out.

    Args:
        record: a dataclass.
    """
    known = units(record.__class__)
    parts = [
        f"{field.name} {value(getattr(record, field.name), known.get(field.name, ''))}"
        for field in dataclasses.fields(record)
        if field.name != "name" and not _is_default(record, field)
    ]
    return f"{heading(record)}{': ' if parts else ''}{', '.join(parts)}"


def heading(record: Any) -> str:
    """The class of a record, and its name if it has one."""
    name = getattr(record, "name", None)
    return type(record).__name__ + (f" {name!r}" if name else "")


def value(of: Any, unit: str = "") -> str:
    """A value in few words.

    Args:
        of: number, list of numbers, record, function or text.
        unit: of numbers, in SI.
    """
    if dataclasses.is_dataclass(of) or (callable(of) and hasattr(of, "__name__")):
        return type(of).__name__ if dataclasses.is_dataclass(of) else "a function"
    if isinstance(of, Mapping):
        return f"of {len(of)}"
    if isinstance(of, list | tuple | np.ndarray) and len(of) and not isinstance(of[0], str):
        return _values(np.asarray(of), unit)
    if isinstance(of, int | float | np.number) and not isinstance(of, bool):
        return _values(np.asarray(of), unit)
    return repr(of)


def size(points: np.ndarray) -> str:
    """How large points [m] are along the axes, such as 300 × 300 × 62 mm.

    Args:
        points: shape [n, 2 or 3].
    """
    return " × ".join(f"{1e3 * length:.3g}" for length in np.ptp(points, axis=0)) + " mm"


def surface(points: np.ndarray, triangles: np.ndarray, called: str = "triangles") -> str:
    """Size and counts of a surface.

    Args:
        points: vertices [m], shape [n, 2 or 3].
        triangles: their vertices, shape [m, 3].
        called: its triangles.
    """
    vertices = f"{len(points):,} vertices, " if called == "triangles" else ""
    across = f"{size(points)}, " if len(points) else ""
    return f"{across}{vertices}{len(triangles):,} {called}"


def _values(numbers: np.ndarray, unit: str) -> str:
    if numbers.dtype.kind not in "iuf":
        return f"of {numbers.size}"
    largest = float(np.abs(numbers).max()) if numbers.size else 0.0
    if unit in _SMALLER and (largest < 1.0 or unit == "rad"):
        unit, factor = _SMALLER[unit]
        numbers = factor * numbers
    ending = "" if unit in ("", "-") else unit if unit == "°" else f" {unit}"
    if numbers.ndim == 0:
        return f"{numbers:.4g}{ending}"
    if numbers.ndim == 1 and numbers.size <= FEW:
        return "(" + ", ".join(f"{number:.4g}" for number in numbers) + f"){ending}"
    count = " × ".join(map(str, numbers.shape))
    return f"{count} from {numbers.min():.4g} to {numbers.max():.4g}{ending}"


def _is_default(record: Any, field: dataclasses.Field) -> bool:
    held, default = getattr(record, field.name), field.default
    if field.default_factory is not dataclasses.MISSING:
        default = field.default_factory()
    try:
        return bool(held is default or held == default)
    except ValueError:  # arrays
        return False


@cache
def units(kind: type) -> dict[str, str]:
    """Units of a dataclass's entries, as its docstring has them in square brackets."""
    found = {}
    _, _, entries = inspect.cleandoc(kind.__doc__ or "").partition("Attributes:\n")
    for name, text in _ATTRIBUTE.findall(entries):
        unit = _UNIT.search(text)
        if unit:
            found[name] = unit[1]
    return found
