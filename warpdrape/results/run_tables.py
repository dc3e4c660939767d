"""Summary, record and history of a run folder, read back and checked; nothing is executed."""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from warpdrape.errors import InputError
from warpdrape.results import record_form, summary_form
from warpdrape.results.run_folder import HISTORY, RUN, SCENE, SUMMARY, partial_path

AGAIN = "run the scene again"
"""What to do about a damaged folder."""
FEW = 4
"""Odd entries of a file that are named."""


def check_whole(folder: Path) -> None:
    """Raise `InputError` where a folder is none, or lacks a file of a finished run."""
    if not folder.is_dir():
        kind = "is a file" if folder.exists() else "does not exist"
        raise InputError(f"run folder {folder} {kind}: give the folder of a finished run")
    missing = [name for name in (SUMMARY, SCENE, HISTORY) if not (folder / name).is_file()]
    if not missing:
        return
    if SUMMARY not in missing:
        summary = load_json(folder / SUMMARY)
        if isinstance(summary, dict) and summary.get("status") == "failed":
            raise InputError(
                f"run folder {folder} holds no {missing[0]}, as the run failed: "
                f"{summary.get('message')}"
            )
    if any(partial_path(folder / name).exists() for name in missing):
        raise InputError(
            f"run folder {folder} holds no {missing[0]} but an unfinished one: wait for the run, "
            f"or, if it was cut off, {AGAIN}"
        )
    raise InputError(f"run folder {folder} holds no {missing[0]}: give that of a finished run")


def load_json(path: Path) -> Any:
    """What a JSON file holds; raise `InputError` where it cannot be read."""
    try:
        return json.loads(
            path.read_text(encoding="utf-8"),
            parse_constant=_no_number,
            parse_float=_finite,
            parse_int=_whole,
        )
    except (OSError, ValueError, RecursionError) as error:
        words = " ".join(str(error).split())
        raise InputError(f"{path} is not readable JSON ({words}): {AGAIN}") from error


def _no_number(words: str) -> float:
    raise ValueError(f"{words} is no number")


def _finite(words: str) -> float:
    found = float(words)
    return found if math.isfinite(found) else _no_number(words)


def _whole(words: str) -> int:
    _finite(words)
    return int(words)


def read_summary(folder: Path) -> dict[str, Any]:
    """The summary of a run folder; raise `InputError` where there is none, or it is damaged."""
    path = _file(folder, SUMMARY)
    summary = load_json(path)
    if not isinstance(summary, dict):
        raise InputError(f"{path} is no summary of a run: {AGAIN}")
    if summary.get("status") == "failed" and "plies" not in summary:
        raise InputError(
            f"run folder {folder}: the run failed before its first frame: {summary.get('message')}"
        )
    _refuse_odd(path, summary_form.odd_entries(summary))
    return summary


def read_record(folder: Path, needed: Collection[str] = ()) -> dict[str, Any]:
    """The record of a run folder; raise `InputError` where there is none, or it is damaged.

    Args:
        folder: of a run.
        needed: entries that must be there, which records of older versions may lack.
    """
    path = folder / RUN
    if not path.is_file():
        raise InputError(f"run folder {folder} holds no {RUN}: {AGAIN}")
    record = load_json(path)
    if not isinstance(record, dict):
        raise InputError(f"{path} is no record of a run: {AGAIN}")
    _refuse_odd(path, record_form.odd_entries(record, needed))
    return record


def _refuse_odd(path: Path, odd: Sequence[str]) -> None:
    """Raise `InputError` where entries of a file are not as a run writes them."""
    if odd:
        names = ", ".join(odd[:FEW]) + (f" and {len(odd) - FEW} more" if len(odd) > FEW else "")
        raise InputError(
            f"{path} has no usable {names}: it is of another version, damaged, or changed by hand; "
            f"{AGAIN}"
        )


def read_history(folder: Path) -> Mapping[str, np.ndarray]:
    """Columns of a run folder's history; raise `InputError` where there is none usable.

    A column that is empty throughout is one of those that every run has, and that the approach
    does not give: it is left out.
    """
    path = _file(folder, HISTORY)
    try:
        with path.open(encoding="utf-8", newline="") as file:
            names, *rows = csv.reader(file)
        left_out = {k for k in range(len(names)) if rows and all(row[k] == "" for row in rows)}
        kept = [k for k in range(len(names)) if k not in left_out]
        names, rows = [names[k] for k in kept], [[row[k] for k in kept] for row in rows]
        table = np.array(rows, dtype=float).reshape(len(rows), len(names))
    except (OSError, ValueError, IndexError, csv.Error) as error:
        words = " ".join(str(error).split())
        raise InputError(f"{path} is no table of numbers ({words}): {AGAIN}") from error
    if "time_s" not in names or not len(table) or not np.isfinite(table).all():
        raise InputError(f"{path} has no rows, no time_s, or numbers that are not finite: {AGAIN}")
    return dict(zip(names, table.T.copy(), strict=True))


def _file(folder: Path, name: str) -> Path:
    """A file of a run folder; raise `InputError` where it is not there."""
    if not folder.is_dir():
        kind = "is a file" if folder.exists() else "does not exist"
        raise InputError(f"run folder {folder} {kind}: give the folder of a finished run")
    if not (folder / name).is_file():
        raise InputError(f"run folder {folder} holds no {name}: give that of a finished run")
    return folder / name
