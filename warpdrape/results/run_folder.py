"""The run folder: its file names, and files that appear under them only when they are whole."""

from __future__ import annotations

import csv
import io
import json
import math
import os
import tempfile
import warnings
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from warpdrape.errors import InputError, RunFailed, said
from warpdrape.results.folder_lock import FolderLock
from warpdrape.results.leftovers import others_in, pictures_in, put_aside

SCENE = "scene.usdc"
HISTORY = "history.csv"
SUMMARY = "summary.json"
RUN = "run.json"
COUPON = "coupon.csv"
COUPON_PLOT = "coupon.png"
CHECKPOINT = "checkpoint.npz"
JUDGEMENT = "judgement.png"
REPORT = "report.html"
EXPORTS = "export"
"""Folder in it that takes what is exported from the run where no other place is given."""
RESULTS = (SCENE, HISTORY, SUMMARY, RUN, COUPON, COUPON_PLOT, CHECKPOINT, JUDGEMENT, REPORT)
"""Every result that a run leaves. Beside them ``--overwrite`` may remove pictures and films under
names of their own, and nothing else."""


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


def write_whole(final: Path, write: Callable[[Path], object]) -> None:
    """Let ``write`` fill a file under its partial name, and give it its own once it is on the disk.

    Raises:
        RunFailed: when the disk refuses; what was there under the final name is kept then.
    """
    partial = partial_path(final)
    try:
        write(partial)
        to_disk(partial)
    except OSError as error:
        with suppress(OSError):
            partial.unlink(missing_ok=True)
        raise RunFailed(unwritable(final, error)) from error
    give_final_name(partial, final)


def to_disk(path: Path) -> None:
    """Wait until what was written to a file is on the disk, power cut or not."""
    file = os.open(path, os.O_RDWR)
    try:
        os.fsync(file)
    finally:
        os.close(file)


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
        self._overwrite = overwrite
        self._lock = FolderLock(self.path)
        _check_writable(self.path)
        self._refuse_old()

    @classmethod
    def of_run(cls, path: str | os.PathLike[str]) -> RunFolder:
        """The folder of a run that is to go on; raise `InputError` if it is none."""
        folder = Path(path)
        if not folder.is_dir():
            raise InputError(f"run folder {folder} does not exist: give the folder of a run")
        found = cls(folder, overwrite=True)
        old = found._old_files()
        if not old:
            raise InputError(f"run folder {folder} holds no run: give the folder of one")
        for file in old:
            if file.is_symlink():  # what is written there would be written elsewhere
                raise InputError(f"{file} is a link: put the file itself there")
        return found

    def _refuse_old(self) -> None:
        old = self._old_files()
        if old and not self._overwrite:
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

    def take(self) -> None:
        """Make the folder and keep other runs out, until `close`.

        Raises: InputError when one writes there now, or has left results since.
        """
        try:
            self.path.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise _unprepared(self.path, error) from error
        self._lock.take()
        self._refuse_old()

    def close(self) -> None:
        """Let other runs in."""
        self._lock.release()

    def begin(self) -> None:
        """Make the folder and remove the results of the run before; done once, and by any write."""
        if self._begun:
            return
        others = ""
        try:
            self.path.mkdir(parents=True, exist_ok=True)
            old = self._old_files()
            if old:
                self._remove_leftovers()
            for file in old:
                file.unlink()
            if old:
                others = others_in(self.path, EXPORTS)
        except OSError as error:
            raise _unprepared(self.path, error) from error
        self._begun = True
        if others:
            warnings.warn(
                f"{self.path} also holds {others}: left as it is, and perhaps of the run before",
                stacklevel=2,
            )

    def _remove_leftovers(self) -> None:
        """Leave nothing made of the run as it was that could be taken for the run to come.

        First of all, as the record that is removed later names the plies.
        """
        for file in pictures_in(self.path, self.path / RUN):
            file.unlink()
        aside = put_aside(self.path, EXPORTS)
        if aside is not None:
            warnings.warn(f"exports of the run before are in {aside} now", stacklevel=4)

    def write_json(self, name: str, data: Mapping[str, Any]) -> Path:
        """Write ``data`` as the file ``name``, replacing it in one move; return its path.

        numpy numbers and arrays and paths are understood.

        Raises: ValueError naming the entry that is not finite, TypeError one of an unknown type.
        """
        self.begin()
        text = json.dumps(as_json(data, name), indent=2, ensure_ascii=False) + "\n"
        final = self._place(name)
        write_whole(final, lambda p: p.write_text(text, encoding="utf-8", newline="\n"))
        return final

    def write_table(self, name: str, columns: Mapping[str, Any]) -> Path:
        """Write columns of equal length [n] as the file ``name`` (….csv); return its path."""
        self.begin()
        final = self._place(name)
        values = [[as_json(v, f"{name}: {key}") for v in col] for key, col in columns.items()]
        text = io.StringIO()
        rows = csv.writer(text, lineterminator="\n")
        rows.writerows([columns, *zip(*values, strict=True)])
        write_whole(final, lambda p: p.write_text(text.getvalue(), "utf-8", newline="\n"))
        return final

    def go_on(self) -> None:
        """Give the results of a run that ended their partial names, and remove what told its end.

        Done again after a kill in the midst of it, it does the rest.
        """
        try:
            self._remove_leftovers()
            for name in (SUMMARY, COUPON, COUPON_PLOT, REPORT, JUDGEMENT):
                (self.path / name).unlink(missing_ok=True)
            for name in (SUMMARY, COUPON, COUPON_PLOT, RUN, CHECKPOINT, REPORT, JUDGEMENT):
                partial_path(self.path / name).unlink(missing_ok=True)
            for file in self._debris():
                file.unlink()
            for name in (SCENE, HISTORY):
                final = self.path / name
                if final.exists():
                    os.replace(final, partial_path(final))
        except OSError as error:
            raise _unprepared(self.path, error) from error
        self._begun = True

    def write_figure(self, name: str, figure: Any) -> Path:
        """Write a matplotlib figure as the file ``name``, replacing it in one move."""
        self.begin()
        final = self._place(name)
        write_whole(final, figure.savefig)
        return final

    def _old_files(self) -> list[Path]:
        finals = [self.path / name for name in RESULTS]
        found = [f for f in [*finals, *map(partial_path, finals)] if os.path.lexists(f)]
        return found + self._debris()

    def _debris(self) -> list[Path]:
        """What a kill leaves while the library makes a new .usdc, under a name of its own."""
        return sorted(self.path.glob(f"{partial_path(Path(SCENE)).stem}.??????"))

    def _place(self, name: str) -> Path:
        """Path of a file of the folder; a name that would lead out of it is refused."""
        if Path(name).name != name or set(name) & set("\\/:") or name in ("", ".."):
            raise InputError(f"file name {name!r} must be a plain name, such as notes.csv")
        return self.path / name


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


def _unprepared(path: Path, error: OSError) -> InputError:
    return InputError(
        f"out = {path} cannot be prepared ({error.strerror}): close what uses it, or "
        "give another folder"
    )


def unwritable(path: Path, error: OSError) -> str:
    """Say that the disk refused."""
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
    raise TypeError(f"{where} = {said(value)} is a {type(value).__name__}: JSON has no such type")
