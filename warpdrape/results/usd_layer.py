"""The layer that frames of the animation go into, and the room that the disk has for them."""

from __future__ import annotations

import shutil
from pathlib import Path

from pxr import Sdf, Tf

from warpdrape.errors import InputError, RunFailed

_SPARE_BYTES = 1_000_000  # for the file's index, and the small files beside it


def open_layer(path: Path, *, new: bool) -> Sdf.Layer:
    """Make a layer, or open the one that is there.

    Raises: InputError when that cannot be.
    """
    try:
        layer = Sdf.Layer.CreateNew(str(path)) if new else Sdf.Layer.FindOrOpen(str(path))
        if layer is None:
            raise Tf.ErrorException("it is not there")
        if not new:
            layer.Reload(True)  # someone in this process may have looked at it before
        return layer
    except Tf.ErrorException as error:
        raise InputError(
            f"path = {path} cannot be created: give a folder in which you may write, and a name "
            "that ends in .usdc"
        ) from error


def check_space(folder: Path, size: int, last: int) -> None:
    """Stop before a save that would not fit, because it would spoil the frames before it.

    Args:
        folder: where the file is.
        size: of what is to be saved, once [bytes].
        last: number of the last frame that is kept.

    Raises: RunFailed when there is too little room, or no folder.
    """
    try:
        free = shutil.disk_usage(folder).free
    except OSError as error:
        raise RunFailed(
            f"{folder} cannot take the next frame: the folder is gone; run again "
            "and leave it in place"
        ) from error
    if free < 2 * size + _SPARE_BYTES:
        raise RunFailed(
            f"{folder} has {free / 1e6:.0f} MB left, too little for the next frame: "
            f"free some space or write elsewhere; the frames up to {last} are kept"
        )
