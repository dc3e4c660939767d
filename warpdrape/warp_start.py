"""Starting Warp: no noise on a machine without a GPU, a word on compiling, devices by name."""

from __future__ import annotations

import atexit
import os
import shutil
import sys
import tempfile
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import warp as wp

import warpdrape.kernels as kernels  # sets Warp's log level
from warpdrape.errors import InputError

NO_GPU = b"Could not find or load the NVIDIA CUDA driver"
"""What Warp's native library says on standard error where there is no NVIDIA driver."""
NOT_LOADED = (
    "Failed to load CPU module",
    "Failed to load CUDA module",
    "Failed to find forward kernel",
)
"""How what Warp raises begins where a compiled kernel is unusable."""


def start_warp() -> None:
    """Start Warp; a machine without a GPU is nothing to warn about.

    Where there is no place for its kernel cache, as without a home folder, one is made for this
    process alone: whoever may write into a cache has their code run, so that it is a private one.
    """
    with _without_line(NO_GPU):
        try:
            wp.init()
        except OSError as error:
            folder = tempfile.mkdtemp(prefix="warpdrape-kernels-")
            atexit.register(shutil.rmtree, folder, ignore_errors=True)
            wp.config.kernel_cache_dir = folder
            wp.init()
            warnings.warn(
                f"no place for the kernel cache ({error}): kernels are compiled for this run "
                "alone; set WARP_CACHE_PATH to a folder in which you may write",
                stacklevel=2,
            )


def cache_damage(error: Exception) -> str:
    """Say what to do where Warp could not load a kernel from its cache; empty for all else."""
    words = str(error)
    if not any(words.startswith(said) for said in NOT_LOADED):
        return ""
    return (
        f"the kernel cache {wp.config.kernel_cache_dir} is damaged ({words}): remove that folder; "
        "kernels are compiled anew"
    )


def kernels_are_compiled() -> bool:
    """Whether the kernel cache holds kernels of ours, so that a run starts at once."""
    folder = wp.config.kernel_cache_dir
    return bool(folder) and any(Path(str(folder)).glob(f"wp_{kernels.__name__}.*"))


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
