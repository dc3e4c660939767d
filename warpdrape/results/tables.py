"""Tables of a run folder, which grow row by row."""

from __future__ import annotations

import csv
import hashlib
import io
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from warpdrape.errors import InputError, RunFailed
from warpdrape.results.run_folder import as_json, give_final_name, partial_path, unwritable


class HistoryWriter:
    """A table that grows row by row; a context manager.

    Each row reaches the disk at once, in ``.NAME.partial.csv``; `close` gives the file its name.

    Args:
        path: the final file, ``….csv``.
        mark: go on from it, in the partial file; see `mark`.

    Attributes:
        rows: those of the mark.

    Raises: InputError when the partial file is not the one of the mark, RunFailed when the disk
        refuses it.
    """

    def __init__(self, path: str | os.PathLike[str], mark: Mapping[str, Any] | None = None) -> None:
        self.path = Path(path)
        self.partial_path = partial_path(self.path)
        self.columns: tuple[str, ...] = ()
        self.rows: list[dict[str, float]] = []
        self._closed = False
        self._digest = hashlib.blake2b(digest_size=16)
        self._size = 0
        if mark is None:
            try:
                self._file: io.BufferedIOBase = open(self.partial_path, "wb")
            except OSError as error:
                raise RunFailed(unwritable(self.path, error)) from error
        else:
            self._go_on(mark)

    def _go_on(self, mark: Mapping[str, Any]) -> None:
        content = marked_rows(self.partial_path, mark)
        self._digest.update(content)
        self._size = len(content)
        table = csv.reader(io.StringIO(content.decode("utf-8"), newline=""))
        self.columns = tuple(next(table, ()))
        self.rows = [dict(zip(self.columns, map(float, row), strict=True)) for row in table]
        self._file = open(self.partial_path, "r+b")
        self._file.truncate(self._size)
        self._file.seek(self._size)

    def append(self, row: Mapping[str, Any]) -> None:
        """Add one row; the first one fixes the columns and their order.

        Raises: ValueError when a column is missing or new, or a value not finite; nothing is
            written then. RunFailed when the disk refuses.
        """
        if self._closed:
            raise ValueError(f"{self.path} is closed: no row can be added")
        name = self.path.name
        values = {key: as_json(value, f"{name}: {key}") for key, value in row.items()}
        known = self.columns or tuple(values)
        if set(values) != set(known):
            odd = sorted(set(values) ^ set(known))
            raise ValueError(f"{name}: {', '.join(odd)} not in both first and this row")
        text = io.StringIO()
        rows = csv.writer(text, lineterminator="\n")
        if not self.columns:
            rows.writerow(known)
        rows.writerow([values[key] for key in known])
        self._write(text.getvalue().encode("utf-8"))
        self.columns = known

    def _write(self, content: bytes) -> None:
        """Write all of it or, as far as the system lets it, nothing."""
        try:
            self._file.write(content)
            self._file.flush()
        except OSError as error:
            self._cut_off()
            raise RunFailed(unwritable(self.path, error)) from error
        self._digest.update(content)
        self._size += len(content)

    def _cut_off(self) -> None:
        """Take half a row away."""
        try:
            self._file.close()
        except OSError:  # what is left in the buffer is refused again
            pass
        try:
            os.truncate(self.partial_path, self._size)
        except OSError:  # the folder is gone, or worse
            pass

    def mark(self) -> dict[str, Any]:
        """Wait for the disk, and return size and digest of the file as it is.

        Raises: RunFailed when the disk refuses.
        """
        try:
            os.fsync(self._file.fileno())
        except OSError as error:
            raise RunFailed(unwritable(self.path, error)) from error
        return {"size": self._size, "digest": self._digest.hexdigest()}

    def close(self) -> None:
        """Give the file its final name; without a single row, leave no file at all."""
        if self._closed:
            return
        self._closed = True
        self._file.close()
        if self.columns:
            give_final_name(self.partial_path, self.path)
        else:
            self.partial_path.unlink(missing_ok=True)

    def __enter__(self) -> HistoryWriter:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def marked_rows(path: Path, mark: Mapping[str, Any]) -> bytes:
    """Return what a table held at a mark; raise `InputError` unless it still does."""
    size = int(mark["size"])
    try:
        content = path.read_bytes()[:size]
    except OSError as error:
        raise InputError(f"{path} cannot be read ({error.strerror})") from error
    digest = hashlib.blake2b(content, digest_size=16).hexdigest()
    if len(content) != size or digest != mark["digest"]:
        raise InputError(
            f"{path} does not hold the rows of the checkpoint beside it: put the run's own file "
            "back, or run the scene anew with --overwrite"
        )
    return content
