"""Packages that are installed on demand: imported where they are needed, with the remedy."""

from __future__ import annotations

from importlib import import_module
from types import ModuleType

from warpdrape.errors import InputError


def needed(package: str, extra: str) -> ModuleType:
    """Import an optional package.

    Args:
        package: its name, dotted for a module in it.
        extra: that of ours which brings it.

    Raises:
        InputError: if it is not installed, with the command that installs it.
    """
    try:
        return import_module(package)
    except ImportError as error:
        name = package.partition(".")[0]
        raise InputError(
            f"this needs {name}, which is not installed ({error}): pip install 'warpdrape[{extra}]'"
        ) from error
