"""The run folder: its file names, and files that appear under them only when they are whole."""

from __future__ import annotations

import csv
import json
import math
import os
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from warpdrape.errors import InputError, RunFailed

SCENE = "scene.usdc"
HISTORY = "history.csv"
SUMMARY = "summary.json"
RUN = "run.json"
COUPON = "coupon.csv"
COUPON_PLOT = "coupon.png"
JUDGEMENT = "judgement.png"
RESULTS = (SCENE, HISTORY, SUMMARY, RUN, COUPON, COUPON_PLOT, JUDGEMENT)
"""Every result that a run leaves; what ``--overwrite`` may remove, and nothing else."""


def partial_path(path: Path) -> Path:
    """Return the name that ``path`` has while it is being written."""
    return path.with_name(f".{path.stem}.partial{path.suffix}")


def give_final_name(partial: Path, final: Path) -> None:
    """Rename a whole file in one move; raise `RunFailed` when the system refuses."""
    try:
        os.replace(partial, final)
    except OSError as error:
        raise RunFailed(
            f"{partial} could not be renamed to {final.name} ({error.strerror}): close what uses "
            "the folder, and rename it by hand"
        ) from error


class RunFolder:
    """A folder that is fit to take one run's results; nothing is touched until `begin`.

    Args:
        path: the folder; made, with its parents, when the run begins.
        overwrite: replace the results of an earlier run.

    Raises: InputError when a file is in the way, the folder holds results and ``overwrite`` is
        false, or nothing can be written there.
    """

    def __init__(self, path: str | os.PathLike[str], overwrite: bool = False) -> None:
        self.path = Path(path)
        self._begun = False
        _check_writable(self.path)
        old = self._old_files()
        if old and not overwrite:
            raise InputError(
                f"out = {self.path} holds {_words(old)} of another run: "
                "give --overwrite to replace it, or another folder"
            )
        for file in old:
            if file.is_dir():
                raise InputError(f"out = {self.path}: {file.name} is a folder; move it away")

    @property
    def scene_path(self) -> Path:
        """The animation's final name, for `UsdWriter`; call `begin` first."""
        return self.path / SCENE

    def begin(self) -> None:
        """Make the folder and remove the results of the run before; done once, and by any write."""
        if self._begun:
            return
        try:
            self.path.mkdir(parents=True, exist_ok=True)
            for file in self._old_files():
                file.unlink()
        except OSError as error:
            raise InputError(
                f"out = {self.path} cannot be prepared ({error.strerror}): close what uses it, or "
                "give another folder"
            ) from error
        self._begun = True

    def write_json(self, name: str, data: Mapping[str, Any]) -> Path:
        """Write ``data`` as the file ``name``, replacing it in one move; return its path.

        numpy numbers and arrays and paths are understood.

        Raises: ValueError naming the entry that is not finite, TypeError one of an unknown type.
        """
        self.begin()
        text = json.dumps(as_json(data, name), indent=2, ensure_ascii=False) + "\n"
        final = self.path / name
        partial = partial_path(final)
        try:
            partial.write_text(text, encoding="utf-8", newline="\n")
        except OSError as error:
            raise RunFailed(_unwritable(final, error)) from error
        give_final_name(partial, final)
        return final

    def history(self) -> HistoryWriter:
        """Return the writer of ``history.csv``."""
        self.begin()
        return HistoryWriter(self.path / HISTORY)

    def write_table(self, name: str, columns: Mapping[str, Any]) -> Path:
        """Write columns of equal length [n] as the file ``name`` (….csv); return its path."""
        self.begin()
        with HistoryWriter(self.path / name) as rows:
            for row in zip(*columns.values(), strict=True):
                rows.append(dict(zip(columns, row, strict=True)))
        return self.path / name

    def write_figure(self, name: str, figure: Any) -> Path:
        """Write a matplotlib figure as the file ``name``, replacing it in one move."""
        self.begin()
        final = self.path / name
        partial = partial_path(final)
        try:
            figure.savefig(partial)
        except OSError as error:
            raise RunFailed(_unwritable(final, error)) from error
        give_final_name(partial, final)
        return final

    def _old_files(self) -> list[Path]:
        finals = [self.path / name for name in RESULTS]
        return [f for f in [*finals, *map(partial_path, finals)] if f.exists()]


class HistoryWriter:
    """A table that grows row by row; a context manager.

    Each row reaches the disk at once, in ``.NAME.partial.csv``; `close` gives the file its name.

    Args:
        path: the final file, ``….csv``.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)
        self.partial_path = partial_path(self.path)
        self.columns: tuple[str, ...] = ()
        self._file = open(self.partial_path, "w", encoding="utf-8", newline="")
        self._rows = csv.writer(self._file, lineterminator="\n")

    def append(self, row: Mapping[str, Any]) -> None:
        """Add one row; the first one fixes the columns and their order.

        Raises: ValueError when a column is missing or new, or a value not finite; nothing is
            written then. RunFailed when the disk refuses.
        """
        if self._file.closed:
            raise ValueError(f"{self.path} is closed: no row can be added")
        name = self.path.name
        values = {key: as_json(value, f"{name}: {key}") for key, value in row.items()}
        known = self.columns or tuple(values)
        if set(values) != set(known):
            odd = sorted(set(values) ^ set(known))
            raise ValueError(f"{name}: {', '.join(odd)} not in both first and this row")
        try:
            if not self.columns:
                self._rows.writerow(known)
                self.columns = known
            self._rows.writerow([values[key] for key in known])
            self._file.flush()
        except OSError as error:
            raise RunFailed(_unwritable(self.path, error)) from error

    def close(self) -> None:
        """Give the file its final name; without a single row, leave no file at all."""
        if self._file.closed:
            return
        self._file.close()
        if self.columns:
            give_final_name(self.partial_path, self.path)
        else:
            self.partial_path.unlink(missing_ok=True)

    def __enter__(self) -> HistoryWriter:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def read_summary(folder: Path) -> dict[str, Any]:
    """Return what a run folder's summary holds; raise `InputError` where there is none."""
    return json.loads(_text(folder, SUMMARY))


def read_history(folder: Path) -> dict[str, np.ndarray]:
    """Return the columns of a run folder's history; raise `InputError` where there is none."""
    rows = list(csv.DictReader(_text(folder, HISTORY).splitlines()))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


def _text(folder: Path, name: str) -> str:
    """Text of a file of a run folder."""
    if not folder.is_dir():
        raise InputError(f"run folder {folder} does not exist: give the folder of a finished run")
    try:
        return (folder / name).read_text(encoding="utf-8")
    except OSError as error:
        raise InputError(
            f"run folder {folder} holds no {name}: give the folder of a finished run"
        ) from error


def _check_writable(path: Path) -> None:
    """Try a nameless file in ``path``, or in the nearest parent that exists."""
    existing = path
    while not existing.exists() and existing != existing.parent:
        existing = existing.parent
    if not existing.is_dir():
        raise InputError(f"out = {path}: {existing} is a file: give another folder")
    try:
        with tempfile.TemporaryFile(dir=existing):
            pass
    except OSError as error:
        raise InputError(
            f"out = {path} is not writable ({error.strerror}): give a folder in which you may write"
        ) from error


def _unwritable(path: Path, error: OSError) -> str:
    return f"{path} could not be written ({error.strerror}): free some space or write elsewhere"


def _words(files: list[Path]) -> str:
    finals = [f.name for f in files if f.name in RESULTS]
    return ", ".join(finals) if finals else f"unfinished results ({files[0].name})"


def as_json(value: Any, where: str) -> Any:
    """Return ``value`` as what JSON knows; ``where`` names it in errors.

    Raises: ValueError for a number that is not finite, TypeError for an unknown type.
    """
    if isinstance(value, Mapping):
        for key in value:
            if not isinstance(key, str):
                raise TypeError(f"{where}: key {key!r} must be a string")
        return {key: as_json(item, f"{where}: {key}") for key, item in value.items()}
    if isinstance(value, np.generic | np.ndarray):
        value = value.tolist()
    if isinstance(value, list | tuple):
        return [as_json(item, f"{where}[{i}]") for i, item in enumerate(value)]
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if isinstance(value, float) and not math.isfinite(value):
        raise ValueError(f"{where} = {value} must be finite: leave it out or say None")
    if value is None or isinstance(value, str | bool | int | float):
        return value
    raise TypeError(f"{where} = {value!r} is a {type(value).__name__}: JSON has no such type")
