"""The animation's file at a moment to which it can be taken back, however it was written since.

Saving a .usdc in place appends values and writes the index after them, over the one before; only
then its head, which says where the index is, follows. So head and index of a moment, with the
length of the file, take it back: values before the index never change, which a digest confirms.
The layout is that of OpenUSD's crate files: pxr/usd/usd/crateFile.h.
"""

from __future__ import annotations

import hashlib
import os
import struct
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from warpdrape.errors import InputError

_HEAD = 88
"""Bytes before the values: "PXR-USDC", a version, where the index is, room for more."""
_MAGIC, _INDEX_AT = b"PXR-USDC", 16
_SECTION = struct.Struct("<16sqq")
"""Name, start and size of a section, as the index lists them after their number."""
_CHUNK = 1 << 22


@dataclass(frozen=True, eq=False)
class Mark:
    """The file at one moment.

    Attributes:
        size: of the file [byte].
        values_end: where its values end [byte].
        digest: of the values.
        head: bytes before the values.
        tail: bytes after them.
    """

    size: int
    values_end: int
    digest: str
    head: bytes
    tail: bytes

    def record(self) -> dict[str, Any]:
        """What JSON takes of it."""
        return {"size": self.size, "values_end": self.values_end, "digest": self.digest}

    def arrays(self) -> dict[str, np.ndarray]:
        """The rest."""
        parts = {"head": self.head, "tail": self.tail}
        return {f"frames: {name}": np.frombuffer(b, np.uint8) for name, b in parts.items()}

    @staticmethod
    def of(record: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> Mark:
        """The mark that gave a record and arrays."""
        head, tail = (arrays[f"frames: {name}"].tobytes() for name in ("head", "tail"))
        size, end, digest = int(record["size"]), int(record["values_end"]), str(record["digest"])
        if len(head) != _HEAD or end + len(tail) != size:
            raise ValueError("head and index of the frames do not fit")
        return Mark(size, end, digest, head, tail)


class Marker:
    """Takes marks of a file that grows, and reads no value twice."""

    def __init__(self, path: Path) -> None:
        """Nothing read yet."""
        self._path = path
        self._read = _HEAD
        self._digest = hashlib.blake2b(digest_size=16)

    def mark(self) -> Mark:
        """Mark the file as it is, saved; an `OSError` if it cannot be read."""
        with open(self._path, "rb") as file:
            head = file.read(_HEAD)
            end = _values_end(file, head)
            self._read_to(file, end)
            file.seek(end)
            tail = file.read()
        return Mark(end + len(tail), end, self._digest.hexdigest(), head, tail)

    def check(self, mark: Mark) -> None:
        """Raise `InputError` unless the file holds all values that it had at a mark."""
        try:
            with open(self._path, "rb") as file:
                whole = self._read_to(file, mark.values_end)
        except OSError as error:
            raise InputError(f"{self._path} cannot be read ({error.strerror})") from error
        if not whole or self._digest.hexdigest() != mark.digest:
            raise InputError(
                f"{self._path} does not hold the frames of the checkpoint beside it: put the run's "
                "own file back, or run the scene anew with --overwrite"
            )

    def _read_to(self, file: Any, end: int) -> bool:
        file.seek(self._read)
        while self._read < end:
            chunk = file.read(min(_CHUNK, end - self._read))
            if not chunk:
                return False
            self._digest.update(chunk)
            self._read += len(chunk)
        return self._read == end


def take_back(path: Path, mark: Mark) -> None:
    """Give a file the bytes that it had at a mark; cut off on the way, it can be done again."""
    with open(path, "r+b") as file:
        file.seek(mark.values_end)
        file.write(mark.tail)
        file.truncate(mark.size)
        file.seek(0)
        file.write(mark.head)
        file.flush()
        os.fsync(file.fileno())


def _values_end(file: Any, head: bytes) -> int:
    """Where values end: at the first of the sections that the index lists."""
    if len(head) < _HEAD or not head.startswith(_MAGIC):
        raise OSError(0, "it is no .usdc")
    (index,) = struct.unpack_from("<q", head, _INDEX_AT)
    file.seek(index)
    (sections,) = struct.unpack("<Q", file.read(8))
    listed = file.read(sections * _SECTION.size)
    return min(start for _, start, _ in _SECTION.iter_unpack(listed))
