"""Measures: the numbers that a study takes from each run's summary and history."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from warpdrape.defects.limits import Limits, limits_of
from warpdrape.errors import InputError, nearest, said
from warpdrape.results.judgement import judge
from warpdrape.results.run_tables import read_history, read_summary

FIT = "fit"
"""Measure that is 1 where a run keeps its limits, else 0."""
HISTORY = "history"
HOW = ("last", "max", "min", "mean")
"""What may be taken of a column of the history."""
ALL = "*"
"""In place of a name: the largest number of all plies, or tools."""
STANDARD = {
    "max_shear_deg": "plies.*.max_shear_deg",
    "p95_shear_deg": "plies.*.p95_shear_deg",
    "wrinkle_amplitude_m": "plies.*.defects.wrinkles.max_amplitude_m",
    "wrinkled_area": "plies.*.defects.wrinkles.area_share",
    "bridge_gap_m": "plies.*.defects.bridging.max_gap_m",
    "max_draw_in_m": "plies.*.defects.draw_in.max_m",
    "max_tool_force_n": "tools.*.max_force_n",
}
"""Where a study names none; those that a scene does not have are left out."""
_NAME = re.compile(r"[A-Za-z]\w*")
TAKEN = ("run", "status", "message", "fit", "wall_s", "cpu_s", "host", "warnings")
"""Columns of the table that no measure or parameter may have."""


@dataclass(frozen=True)
class Measure:
    """A number of a run.

    Attributes:
        name: column of the table.
        path: dotted, into ``summary.json``; or ``history.COLUMN.HOW``.
        asked: whether the study names it; else it may be missing.
    """

    name: str
    path: str
    asked: bool = True

    def of(self, summary: Mapping[str, Any], history: Mapping[str, np.ndarray]) -> float | None:
        """Its value; None where the run has none there, or no finite number.

        Raises:
            InputError: where there is no such entry, with the nearest name.
        """
        parts = self.path.split(".")
        if parts[0] == HISTORY:
            return self._of_history(parts, history)
        values = [v for v in self._look(summary, parts, "") if v is not None]
        return max(values) if values else None

    def _of_history(self, parts: list[str], history: Mapping[str, np.ndarray]) -> float | None:
        column = parts[1]
        if column not in history:
            raise InputError(
                f"measure {self.name}: the history has no column {column!r}"
                + nearest(column, history)
            )
        values, how = history[column], parts[2]
        return _number(values[-1] if how == "last" else getattr(np, how)(values))

    def _look(self, at: Any, parts: list[str], where: str) -> list[float | None]:
        if not parts:
            if isinstance(at, Mapping | list) or isinstance(at, str):
                raise InputError(f"measure {self.name}: {where} is no number; {_inside(at)}")
            return [_number(at)]
        name, rest = parts[0], parts[1:]
        if isinstance(at, list):
            named = {
                str(e.get("name", k)) if isinstance(e, Mapping) else str(k): e
                for k, e in enumerate(at)
            }
            if name == ALL:
                return [v for e in named.values() for v in self._look(e, rest, f"{where}.{ALL}")]
            at = named
        if at is None:
            return [None]
        if not isinstance(at, Mapping) or name not in at:
            known = at if isinstance(at, Mapping) else ()
            raise InputError(
                f"measure {self.name}: {where.lstrip('.') or 'the summary'} has no {name!r}"
                + (nearest(name, known) if known else "")
            )
        return self._look(at[name], rest, f"{where}.{name}")


def _inside(at: Any) -> str:
    if isinstance(at, Mapping):
        return f"go on with one of {', '.join(at)}"
    return "go on with a name, a number or * for the largest" if isinstance(at, list) else "a text"


def _number(value: Any) -> float | None:
    if value is None:
        return None
    number = float(value)
    return number if math.isfinite(number) else None


def read_measures(given: Any) -> tuple[Measure, ...]:
    """Read the table of measures, name to path; the standard ones where there is none.

    Raises:
        InputError: a name or path that cannot be one.
    """
    if given is None:
        return tuple(Measure(name, path, asked=False) for name, path in STANDARD.items())
    if not isinstance(given, Mapping) or not given:
        raise InputError(
            f"measures = {said(given)} must be a table: NAME = 'plies.*.max_shear_deg'"
        )
    for name, path in given.items():
        if not _NAME.fullmatch(name) or name in TAKEN:
            raise InputError(f"measure {name!r}: give another name, letters, digits and _")
        if not isinstance(path, str) or not all(path.split(".")):
            raise InputError(
                f"measure {name} = {said(path)} must be a dotted path into summary.json, such as "
                "'plies.*.max_shear_deg'"
            )
        parts = path.split(".")
        if parts[0] == HISTORY and (len(parts) != 3 or parts[2] not in HOW):
            raise InputError(
                f"measure {name} = {path!r} must be history.COLUMN.HOW, HOW one of {', '.join(HOW)}"
            )
    return tuple(Measure(name, path) for name, path in given.items())


def fit_of(
    summary: Mapping[str, Any], history: Mapping[str, np.ndarray], limits: Limits | None
) -> int:
    """1 for a part within its limits and 0 for another: the verdict of ``warpdrape judge``.

    Args:
        summary: of the run.
        history: columns over the frames.
        limits: what the part may have; None for what its scene has set, or else by default.

    Raises:
        InputError: as `judge` does.
    """
    return int(not judge(summary, history, limits_of(summary) if limits is None else limits))


def measure_run(
    folder: Path, measures: tuple[Measure, ...]
) -> tuple[dict[str, float | None], list[str], Mapping[str, Any], Mapping[str, np.ndarray]]:
    """Measures of a run folder, complaints about those that it does not have, and what it holds.

    Raises:
        InputError: if the folder is damaged.
    """
    summary, history = read_summary(folder), read_history(folder)
    values: dict[str, float | None] = {}
    complaints = []
    for measure in measures:
        try:
            values[measure.name] = measure.of(summary, history)
        except InputError as error:
            values[measure.name] = None
            if measure.asked:
                complaints.append(str(error))
    return values, complaints, summary, history
