"""The one call that writes a run in the format of another program."""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping, Sequence
from importlib import import_module
from pathlib import Path

from warpdrape.errors import InputError, one_of
from warpdrape.exports.formats import FORMATS, Format, format_of
from warpdrape.results.read_run import RunReader
from warpdrape.results.run_folder import EXPORTS, give_final_name, partial_path

ALL = "all"
"""What is given as the frame for all of them."""


def export(
    run: str | os.PathLike[str],
    to: str,
    out: str | os.PathLike[str] | None = None,
    *,
    frame: int | str | None = None,
    overwrite: bool = False,
    **options: str | float | None,
) -> Path:
    """Write a run in the format of another program; return the file.

    Args:
        run: the run folder.
        to: one of `FORMATS`.
        out: the file; in the run folder's ``export`` if None.
        frame: the frame, negative ones from the end, or "all"; if None all frames of formats for
            animations, and the last one of others.
        overwrite: replace the file.
        options: what the format takes beside, as ``trim`` of "dxf"; None is as not given.

    Raises:
        InputError: if the format or an option of it is unknown, its package is missing, the run
            cannot be read, the frame is out of range, or the file is there or cannot be written.
    """
    chosen = format_of(to)
    given = {name: value for name, value in options.items() if value is not None}
    _refuse_options(chosen, to, given)
    reader = RunReader(run)
    frames = _frames(chosen, to, reader, frame)
    if chosen.woven:
        reader = _woven(reader, to)
    path = Path(run, EXPORTS, chosen.file) if out is None else Path(out)
    ending = Path(chosen.file).suffix
    if path.suffix.lower() != ending:
        raise InputError(f"out = {path} must end in {ending} for the format {to!r}")
    if path.exists() and not overwrite:
        raise InputError(f"out = {path} exists: give --overwrite to replace it, or another place")
    writer = import_module(f"warpdrape.exports.{chosen.module}")
    partial = partial_path(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        writer.write(reader, partial, frames, **given)
    except OSError as error:
        _drop(partial)
        raise InputError(
            f"out = {path} cannot be written ({error.strerror or error}): give another place"
        ) from error
    except BaseException:  # nothing half written stays, whatever it was
        _drop(partial)
        raise
    give_final_name(partial, path)
    return path


def _drop(partial: Path) -> None:
    if partial.is_file():
        partial.unlink()


def _woven(reader: RunReader, to: str) -> RunReader:
    """The plies that have yarns, and a warning of those that are left out."""
    kept = reader.woven()
    names = [ply["name"] for ply in reader.summary["plies"]]
    left = [name for name in names if name not in [ply["name"] for ply in kept.summary["plies"]]]
    if left:
        warnings.warn(f"{', '.join(left)} left out of {to!r}: no yarns run in it", stacklevel=3)
    return kept


def _refuse_options(chosen: Format, to: str, given: Mapping[str, object]) -> None:
    own = [option.name for option in chosen.options]
    for name in given:
        if name in own:
            continue
        every = {option.name for each in FORMATS.values() for option in each.options}
        one_of("option", name, every)
        takers = [
            known for known, each in FORMATS.items() if name in [o.name for o in each.options]
        ]
        raise InputError(
            f"{name} does not go with the format {to!r}: it goes with {', '.join(takers)}"
        )


def _frames(chosen: Format, to: str, reader: RunReader, frame: int | str | None) -> Sequence[int]:
    """Frames to write, counted from 0."""
    everything = range(reader.frames)
    if frame is None:
        return everything if chosen.animated else [reader.frames - 1]
    if frame == ALL:
        if chosen.single:
            raise InputError(f"frame = {ALL!r}: the format {to!r} holds one frame: give its number")
        return everything
    if isinstance(frame, bool) or not isinstance(frame, int):
        raise InputError(f"frame = {frame!r} must be a whole number, or {ALL!r}")
    if not -reader.frames <= frame < reader.frames:
        raise InputError(
            f"frame = {frame} is out of range: the run has frames 0 to {reader.frames - 1}"
        )
    return [frame % reader.frames]
