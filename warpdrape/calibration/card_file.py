"""Cards that tests give: measured values, drafts read as fabrics, and the file put in place."""

from __future__ import annotations

import os
import tempfile
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from warpdrape.errors import InputError
from warpdrape.materials.card_text import card_text
from warpdrape.materials.fabric import Fabric
from warpdrape.materials.fabric_library import load_fabric
from warpdrape.results.run_folder import write_whole

DIGITS = 5
"""Of a number on a card: bands are a thousand times wider."""
PLACEHOLDER = {
    "law": "linear",
    "warp": {"value": 1.0, "unit": "N", "status": "assumed", "source": "to be measured"},
    "weft": {"value": 1.0, "unit": "N", "status": "assumed", "source": "to be measured"},
}
"""Tension of a draft whose tests will tell it."""


def quantity(
    value: Any, unit: str, source: str, doubt: str = "", status: str = "measured"
) -> dict[str, Any]:
    """A value as a card has it, rounded to ``DIGITS`` digits."""
    table = {"value": _rounded(value), "unit": unit, "status": status, "source": source}
    return {**table, "doubt": doubt} if doubt else table


def _rounded(value: Any) -> Any:
    if isinstance(value, list | tuple | np.ndarray):
        return [_rounded(v) for v in value]
    return float(f"{float(value):.{DIGITS}g}")


def draft(tables: Mapping[str, Any], named: str) -> Fabric:
    """The fabric that a card would give, its tension a placeholder where it has none.

    Args:
        tables: of the card.
        named: what messages call the file that they are from.

    Raises:
        InputError: as of the card's file.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # about the placeholder; the card itself is read again
        return fabric_of(card_text({"tension": PLACEHOLDER, **tables}), named)


def fabric_of(text: str, named: str) -> Fabric:
    """Read a card's text back, as `load_fabric` reads its file."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "card.toml"
        path.write_text(text, encoding="utf-8")
        try:
            return load_fabric(path)
        except InputError as error:
            words = str(error).partition(": ")[2] or str(error)
            raise InputError(f"{named}: {words}") from error


def card_place(out: str | os.PathLike[str] | None, overwrite: bool) -> Path:
    """Where a new card goes, before anything is computed.

    Raises:
        InputError: nowhere, or where it cannot or must not be written.
    """
    if out is None:
        raise InputError("give --out FABRIC.toml for the card, or --dry to see what is understood")
    path = Path(out)
    if path.suffix != ".toml":
        raise InputError(f"--out {path} must end in .toml, as fabrics do")
    if path.is_dir() or not path.parent.is_dir():
        raise InputError(f"--out {path}: give a file in a folder that exists")
    if path.exists() and not overwrite:
        raise InputError(f"--out {path} is there already: give --overwrite to replace it")
    return path


def write_card(path: Path, text: str) -> None:
    """Put a card's file in place in one move."""
    write_whole(path, lambda p: p.write_text(text, encoding="utf-8", newline="\n"))
