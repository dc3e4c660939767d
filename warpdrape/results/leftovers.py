"""What is made of a run and lies in its folder: out of date as soon as the run is another."""

from __future__ import annotations

import json
import os
from itertools import chain, count
from pathlib import Path

FILMS_AND_PICTURES = (".png", ".mp4")
"""Endings of what `warpdrape picture` writes where no other place is given."""
STACK = "stack"
"""Name of a picture of all plies."""
LISTED = 3
"""Files that a message names at most."""


def picture_name(name: str, field: str, ending: str) -> str:
    """File of a picture in the run folder: shear under the plain name, others with theirs."""
    return f"{name if field == 'shear' else f'{name}_{field}'}{ending}"


def pictures_in(folder: Path, record: Path) -> list[Path]:
    """Pictures and films of a run, under the names that they have where none is given.

    Args:
        folder: of the run.
        record: its ``run.json``; without it the names of the plies are not known.
    """
    from pxr import Tf

    from warpdrape.results.quantities import QUANTITIES

    try:
        plies = json.loads(record.read_text(encoding="utf-8"))["plies"]
        names = [Tf.MakeValidIdentifier(ply["name"]) for ply in plies]
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        names = []
    possible = (
        folder / f"{before}{picture_name(name, field, f'{partial}{ending}')}"
        for name in [STACK, *names]
        for field in QUANTITIES
        for ending in FILMS_AND_PICTURES
        for before, partial in (("", ""), (".", ".partial"))
    )
    return [path for path in possible if os.path.lexists(path) and not path.is_dir()]


def put_aside(folder: Path, name: str) -> Path | None:
    """Give a folder of the run before, which may hold work of the user, a name that says so.

    One that was put aside before keeps its name, and all that is in it: the next has a number.

    Args:
        folder: of the run.
        name: of the folder in it.

    Returns:
        Where it is now; None where there is none.

    Raises:
        OSError: if it cannot be renamed.
    """
    if not (folder / name).is_dir():
        return None
    first = folder / f"{name}_of_the_run_before"
    names = (first.with_name(f"{first.name}_{number}") for number in count(2))
    aside = next(path for path in chain([first], names) if not os.path.lexists(path))
    os.rename(folder / name, aside)
    return aside


def others_in(folder: Path, beginning: str) -> str:
    """Name the files of a folder that are nobody's results, but for those that begin so."""
    names = sorted(
        file.name for file in folder.iterdir() if not file.name.startswith((".", beginning))
    )
    more = f" and {len(names) - LISTED} more" if len(names) > LISTED else ""
    return ", ".join(names[:LISTED]) + more
