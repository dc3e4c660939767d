"""Starting Warp: no noise on a machine without a GPU, a word on compiling, devices by name."""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import warp as wp

from warpdrape import kernels  # sets Warp's log level
from warpdrape.errors import InputError

NO_GPU = b"Could not find or load the NVIDIA CUDA driver"
"""What Warp's native library says on standard error where there is no NVIDIA driver."""


def start_warp() -> None:
    """Start Warp; a machine without a GPU is nothing to warn about."""
    with _without_line(NO_GPU):
        wp.init()


def kernels_are_compiled() -> bool:
    """Whether the kernel cache holds kernels of ours, so that a run starts at once."""
    folder = wp.config.kernel_cache_dir
    return bool(folder) and any(Path(folder).glob(f"wp_{kernels.__name__}.*"))


def check_device(device: str) -> str:
    """Start Warp, if nobody has, and return a device that exists.

    Raises:
        InputError: if it does not, naming those that do.
    """
    start_warp()
    known = [d.alias for d in wp.get_devices()]
    if device not in known:
        raise InputError(f"no device {device!r} here; there is: {', '.join(known)}")
    return device


@contextmanager
def _without_line(unwanted: bytes) -> Iterator[None]:
    """Drop lines that hold ``unwanted`` from what native code writes to standard error."""
    try:
        sys.stderr.flush()
        kept = os.dup(2)
    except (AttributeError, OSError):  # no standard error, as under pythonw
        yield
        return
    with tempfile.TemporaryFile() as said:
        os.dup2(said.fileno(), 2)
        try:
            yield
        finally:
            os.dup2(kept, 2)
            os.close(kept)
            said.seek(0)
            for line in said:
                if unwanted not in line:
                    os.write(2, line)
