"""A checkpoint on the disk: one file of arrays and one JSON text, whole or not there.

A zip of plain .npy members without pickle: reading it executes nothing, and every byte of content
has a checksum.
"""

from __future__ import annotations

import io
import json
import zipfile
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from warpdrape.errors import InputError
from warpdrape.results.run_folder import CHECKPOINT, write_whole

FORM = 1
"""Number of the form of the file; another one is refused."""
_RECORD = "record.json"
_DAMAGE = (
    OSError, EOFError, ValueError, KeyError, TypeError, NotImplementedError, MemoryError,
    RuntimeError, RecursionError, zipfile.BadZipFile, zlib.error,
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class Checkpoint:
    """What a restart needs.

    Attributes:
        record: what JSON takes, by name.
        arrays: bytes by name, each of shape [byte].
    """

    record: Mapping[str, Any]
    arrays: Mapping[str, np.ndarray]


def write_checkpoint(folder: Path, checkpoint: Checkpoint, *, small: bool = False) -> None:
    """Write a checkpoint in place of the one before.

    Args:
        folder: the run's.
        checkpoint: what to keep.
        small: compress it: a fifth of the size for eight times the time.

    Raises:
        RunFailed: when the disk refuses; the one before is kept then.
    """
    text = json.dumps({"form": FORM, **checkpoint.record}, allow_nan=False, ensure_ascii=False)
    how = zipfile.ZIP_DEFLATED if small else zipfile.ZIP_STORED
    whole = io.BytesIO()
    with zipfile.ZipFile(whole, "w", how, compresslevel=1) as members:
        members.writestr(_RECORD, text)
        for number, (name, array) in enumerate(checkpoint.arrays.items()):
            info = zipfile.ZipInfo(f"{number:04d}.npy")
            info.comment = name.encode()
            info.compress_type = how
            with members.open(info, "w", force_zip64=array.nbytes > 2**31) as member:
                np.lib.format.write_array(member, array, allow_pickle=False)
    write_whole(folder / CHECKPOINT, lambda partial: partial.write_bytes(whole.getbuffer()))


def read_checkpoint(folder: Path) -> Checkpoint | None:
    """Return the checkpoint of a run folder, None if it has none.

    Raises:
        InputError: if it is damaged or of another form.
    """
    path = folder / CHECKPOINT
    if not path.is_file():
        return None
    try:
        with zipfile.ZipFile(path) as members:
            record = json.loads(members.read(_RECORD))
            arrays = {
                info.comment.decode(): _array(members.read(info))
                for info in members.infolist()
                if info.filename != _RECORD
            }
        form = record.pop("form")
    except _DAMAGE as error:
        raise damaged(folder, f"{type(error).__name__}: {error}") from error
    except AttributeError as error:  # no mapping
        raise damaged(folder, "its record is none") from error
    if form != FORM:
        raise InputError(
            f"{path} has form {form!r}, this version reads {FORM}: go on with the version of "
            "warpdrape that wrote it"
        )
    return Checkpoint(record, arrays)


def damaged(folder: Path, why: str) -> InputError:
    """The error of a checkpoint that cannot be used."""
    return InputError(
        f"{folder / CHECKPOINT} is damaged, or of another version ({why}): run the scene anew with "
        "--overwrite"
    )


def _array(content: bytes) -> np.ndarray:
    array = np.lib.format.read_array(io.BytesIO(content), allow_pickle=False)
    if array.dtype != np.uint8 or array.ndim != 1:
        raise ValueError("an array of bytes was expected")
    return array
