"""Friction laws as small TOML files, as ``warpdrape calibrate`` writes them."""

from __future__ import annotations

import os
import tomllib
from dataclasses import fields
from pathlib import Path

from warpdrape.errors import InputError, nearest
from warpdrape.materials.friction import Friction


def load_friction(path: str | os.PathLike[str]) -> Friction:
    """Read a friction law; its keys are those of `Friction`.

    Args:
        path: the TOML file.

    Raises:
        InputError: it cannot be read, or a key or value is none of a friction law.
    """
    file = Path(path)
    try:
        given = tomllib.loads(file.read_text(encoding="utf-8-sig"))
    except OSError as error:
        raise InputError(f"friction file {file} cannot be read: {error.strerror}") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"friction file {file}: not valid TOML: {error}") from error
    known = [each.name for each in fields(Friction)]
    for key in given:
        if key not in known:
            raise InputError(f"friction file {file}: key {key!r} is unknown{nearest(key, known)}")
    if "coefficient" not in given:
        raise InputError(f"friction file {file}: 'coefficient' is missing")
    if not isinstance(given.get("source", ""), str):
        raise InputError(f"friction file {file}: source = {given['source']!r} must be a text")
    try:
        return Friction(**given)
    except InputError as error:
        raise InputError(f"friction file {file}: {error}") from None
