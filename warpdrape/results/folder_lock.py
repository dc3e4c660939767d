"""One run at a time in a folder: a lock that the system takes away with the process holding it."""

from __future__ import annotations

import os
import sys
from contextlib import suppress
from pathlib import Path

from warpdrape.errors import InputError

LOCK = ".lock"
"""Name of the file in the run folder, there while a run is."""


class FolderBusy(InputError):
    """Another run is at it now: one may wait for its end."""


class FolderLock:
    """Holds a folder for one run, from `take` to `release`.

    A file system that knows no locks gives none, and is used all the same.
    """

    def __init__(self, folder: Path) -> None:
        """Nothing taken yet."""
        self._path = folder / LOCK
        self._file: int | None = None

    def take(self) -> None:
        """Take the lock, once; raise `InputError` if another run holds it."""
        while self._file is None:
            try:
                file = os.open(self._path, os.O_RDWR | os.O_CREAT, 0o666)
            except OSError as error:
                raise InputError(
                    f"out = {self._path.parent} is not writable ({error.strerror}): give a folder "
                    "in which you may write"
                ) from error
            try:
                _lock(file)
            except BlockingIOError as error:
                os.close(file)
                raise FolderBusy(
                    f"out = {self._path.parent} is being written by another run: wait for its end, "
                    "or give another folder"
                ) from error
            except OSError:  # no locks here
                pass
            if self._is_still(file):
                self._file = file
            else:  # the run before has just removed it
                os.close(file)

    def release(self) -> None:
        """Let go of the folder, and leave no trace."""
        if self._file is None:
            return
        with suppress(OSError):
            if os.name != "nt":  # where an open file cannot be removed
                self._path.unlink()
        os.close(self._file)
        self._file = None
        with suppress(OSError):
            if os.name == "nt":
                self._path.unlink()

    def _is_still(self, file: int) -> bool:
        try:
            return os.path.samestat(os.fstat(file), os.stat(self._path))
        except OSError:
            return False


def _lock(file: int) -> None:
    """Lock an open file; `BlockingIOError` where another has it."""
    if sys.platform == "win32":
        import msvcrt

        try:
            msvcrt.locking(file, msvcrt.LK_NBLCK, 1)
        except PermissionError as error:
            raise BlockingIOError from error
        return
    import fcntl

    fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
