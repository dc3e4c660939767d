"""The command ``compare``: a scene by several approaches, each as ``run`` does it, side by side."""

from __future__ import annotations

import argparse
import sys
import warnings
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from warpdrape.approaches import APPROACHES, SLIDING_YARNS
from warpdrape.commands.interrupts import interrupt_kept
from warpdrape.commands.running import announce_compiling, start_for_runs
from warpdrape.commands.values import OUT, whole
from warpdrape.errors import InputError, RunFailed, one_of
from warpdrape.stops import asked_to_end

if TYPE_CHECKING:
    from warpdrape.commands.scene_library import SceneScript
    from warpdrape.results.comparison import Compared
    from warpdrape.scene import Scene

PAGE = "comparison.html"
"""File of the report, in the folder that holds the runs."""


def compare(arguments: argparse.Namespace) -> list[Compared]:
    """Run a scene by each approach, write and print the comparison; return what each came to."""
    from warpdrape.commands.scene_library import find_typed

    approaches = read_approaches(arguments.approaches)
    options: dict[str, Any] = {"device": arguments.device, "threads": None}
    options["frames"] = whole("--frames", arguments.frames, least=1)
    if arguments.threads is not None:
        options["threads"] = whole("--threads", arguments.threads, least=1)
    with interrupt_kept():
        script = find_typed(arguments.scene)
        _check_settings(script, arguments.settings)
    folder = Path(OUT, f"{script.name}_approaches") if arguments.out is None else arguments.out
    folder = Path(folder)
    start_for_runs(arguments.device)
    built = {name: _build(script, name, arguments.settings) for name in approaches}
    scenes = [scene for scene in built.values() if not isinstance(scene, InputError)]
    if not scenes:
        raise next(error for error in built.values() if isinstance(error, InputError))
    plies = [ply.name for ply in scenes[0].plies]
    ply = plies[0] if arguments.ply is None else one_of("ply", arguments.ply, plies)
    finished = _finished(folder, built, options, arguments.overwrite)
    _remove_comparison(folder)
    runs = _run_all(folder, built, finished, arguments, options)
    if any(run.completed for run in runs):
        _conclude(runs, plies, ply, folder, arguments.report)
    return runs


def read_approaches(text: str | None) -> list[str]:
    """Names of approaches with commas between them.

    Where none is given all but the one that most cards have no values for.

    Raises:
        InputError: if one is unknown, or given twice.
    """
    if text is None:
        return [name for name in APPROACHES if name != SLIDING_YARNS]
    names = [one_of("approach", name.strip(), APPROACHES) for name in text.split(",")]
    twice = [name for name in names if names.count(name) > 1]
    if twice:
        raise InputError(f"--approaches {text}: {twice[0]} is given twice: give it once")
    return names


def _check_settings(script: SceneScript, settings: Sequence[str]) -> None:
    """Raise `InputError` for settings that the scene does not take, or that choose an approach."""
    if any(setting.partition("=")[0].strip() == "approach" for setting in settings):
        raise InputError("--set approach: name the approaches to compare with --approaches A,B")
    script.read_settings(settings)


def _build(script: SceneScript, approach: str, settings: Sequence[str]) -> Scene | InputError:
    """The scene by one approach; the error where it has none by that."""
    try:
        own = [f"approach={approach}"] if "approach" in script.parameters else []
        scene = script.make([*settings, *own])
        return scene if scene.approach == approach else replace(scene, approach=approach)
    except InputError as error:
        return error


def _finished(
    folder: Path,
    built: dict[str, Scene | InputError],
    options: dict[str, Any],
    overwrite: bool,
) -> set[str]:
    """Approaches whose run is there already.

    Raises:
        InputError: if another run, or an unfinished one, is there and may not be replaced.
    """
    from warpdrape.commands.finished import holds_results, what_differs
    from warpdrape.results.run_folder import RunFolder

    found = set()
    for name, scene in built.items():
        place = folder / name
        if isinstance(scene, InputError):
            continue
        if not holds_results(place):
            RunFolder(place)  # whether one may write there
            continue
        how = {"frames": options["frames"], "device": options["device"]}
        differs = what_differs(place, scene, **how)
        if not differs:
            found.add(name)
        elif not overwrite:
            raise InputError(
                f"{place} holds {differs}: give --overwrite to replace it, or another --out"
            )
    return found


def _remove_comparison(folder: Path) -> None:
    """Remove what was written of other runs, or of fewer: not all of it is written each time."""
    from warpdrape.results.comparison import COMPARISON_TABLE
    from warpdrape.results.comparison_picture import COMPARISON_PICTURE

    for name in (COMPARISON_TABLE, COMPARISON_PICTURE, PAGE):
        try:
            (folder / name).unlink(missing_ok=True)
        except OSError as error:
            raise InputError(
                f"{folder / name} cannot be replaced ({error.strerror}): close what uses it, or "
                "give another --out"
            ) from error


def _run_all(
    folder: Path,
    built: dict[str, Scene | InputError],
    finished: set[str],
    arguments: argparse.Namespace,
    options: dict[str, Any],
) -> list[Compared]:
    """Run what is not there yet, one after the other; a failure or Ctrl-C loses nothing."""
    from warpdrape.results.comparison import Compared, read_compared

    def say(words: str) -> None:
        if not arguments.quiet:
            print(words, file=sys.stderr, flush=True)

    announce_compiling(arguments.quiet)
    runs: list[Compared] = []
    stopped = ""
    for number, (name, scene) in enumerate(built.items(), 1):
        place, heading = folder / name, f"{name} ({number} of {len(built)})"
        if name in finished:
            say(f"{heading}: {place} is finished, and taken as it is")
            failure = ""
        elif stopped:
            failure = f"not run, as {stopped}"
        elif isinstance(scene, InputError):
            failure = str(scene)
        else:
            say(heading)
            failure = run_one(scene, place, arguments, options)
            stopped = f"{name} was {failure}" if asked_to_end(failure) else ""
        if failure and not stopped:
            say(f"{name} has no result: {failure}")
        runs.append(Compared(name, place, failure) if failure else read_compared(name, place))
    return runs


def run_one(
    scene: Scene, place: Path, arguments: argparse.Namespace, options: dict[str, Any]
) -> str:
    """Run a scene as ``run`` does; return why it failed, empty where it did not."""
    try:
        result = scene.run(place, quiet=arguments.quiet, overwrite=arguments.overwrite, **options)
    except (InputError, RunFailed) as error:
        return str(error)
    except KeyboardInterrupt:  # where no run takes note of it
        return "interrupted by the user"
    except MemoryError:
        return "out of memory: take fewer cells or larger facets"
    except Exception as error:  # the other approaches shall have their turn
        return f"unexpected {type(error).__name__}: {error}; please report it"
    return "" if result.completed else result.summary["message"]


def _conclude(
    runs: Sequence[Compared], plies: Sequence[str], ply: str, folder: Path, report: bool
) -> None:
    """Write table, picture and report, and print the figures of a ply."""
    from warpdrape.report.report import write_report
    from warpdrape.results.comparison import COMPARISON_TABLE, write_figures
    from warpdrape.results.comparison_picture import COMPARISON_PICTURE, draw_comparison
    from warpdrape.results.comparison_text import comparison_text

    table = write_figures(runs, plies, folder / COMPARISON_TABLE)
    print(comparison_text(runs, ply))
    print(f"\nSide by side in {folder}")
    print(f"  {table.name:15} these figures and more, in SI units")
    picture = draw_comparison(runs, ply, folder / COMPARISON_PICTURE)
    print(f"  {picture.name:15} {ply} by each approach, on one scale")
    if report:
        try:
            page = write_report([r.folder for r in runs if r.completed], folder / PAGE)
            print(f"  {page.name:15} all of it as one page, for a browser")
        except InputError as error:
            warnings.warn(f"no report: {error}", stacklevel=2)
