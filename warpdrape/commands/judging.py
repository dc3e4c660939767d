"""The command ``judge``: defects of a run against limits, measured again where a file says so."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from warpdrape.errors import InputError

if TYPE_CHECKING:
    from warpdrape.defects.thresholds import DefectThresholds
    from warpdrape.results.judgement import Fault
    from warpdrape.results.result import Result


def judged(folder: Path, arguments: argparse.Namespace) -> tuple[str, list[Fault]]:
    """Judge a run, and draw where its faults are.

    Args:
        folder: of the run, which has completed.
        arguments: of the command.

    Returns:
        What to say, and the faults.

    Raises:
        InputError: of the folder, of the limits, or of the scene if defects are to be measured.
    """
    from warpdrape.defects.limits import limits_of, read_limits
    from warpdrape.results.defect_text import defect_lines
    from warpdrape.results.judgement import judge, not_judged, verdict
    from warpdrape.results.judgement_picture import draw_judgement
    from warpdrape.results.run_folder import JUDGEMENT
    from warpdrape.results.run_tables import read_history, read_summary

    limits = None if arguments.limits is None else read_limits(arguments.limits)
    summary: Mapping[str, Any] = read_summary(folder)
    history, lines = read_history(folder), []
    again = None if limits is None else _measured_again(folder, arguments)
    if again is not None:
        summary, history = again.summary, again.history
        lines = [
            "Measured again, with the thresholds of the file:",
            *defect_lines(summary["plies"]),
        ]
        lines.append("")
    elif arguments.scene is not None:
        raise InputError(
            f"--scene {arguments.scene}: a scene is needed for other thresholds only: give a file "
            "of limits with a table [thresholds]"
        )
    limits = limits_of(summary) if limits is None else limits
    faults = judge(summary, history, limits)
    lines.append(verdict(faults, not_judged(summary, limits)))
    out = folder / JUDGEMENT if arguments.out is None else Path(arguments.out)
    lines.append(f"Marked in {draw_judgement(folder, summary, faults, out)}")
    return "\n".join(lines), faults


def _measured_again(folder: Path, arguments: argparse.Namespace) -> Result | None:
    """The run with the defects that count by the file's thresholds; None where it has none."""
    from warpdrape.commands.extending import extended
    from warpdrape.commands.resuming import begun, scene_of
    from warpdrape.commands.running import start_for_runs
    from warpdrape.defects.limits import read_thresholds
    from warpdrape.results.remeasure import remeasure

    thresholds = read_thresholds(arguments.limits, _own_thresholds(folder))
    if thresholds is None:
        return None
    run = begun(folder)
    command = f"judge {{run}} {arguments.limits} --scene SCRIPT"
    if arguments.scene is None and not run.scene:
        raise InputError(
            f"run folder {folder} is of a scene from Python: measure it there, with "
            f"warpdrape.remeasure({str(folder)!r}, scene, thresholds)"
        )
    script = scene_of(folder, run, arguments.scene, command)
    start_for_runs("cpu")
    return remeasure(folder, extended(script.make(run.settings), run, None), thresholds)


def _own_thresholds(folder: Path) -> DefectThresholds:
    """The thresholds of a run, from its record."""
    from warpdrape.defects.thresholds import DefectThresholds
    from warpdrape.results.run_folder import RUN
    from warpdrape.results.run_tables import AGAIN, read_record

    record = read_record(folder, needed=("defect_thresholds",))
    try:
        return DefectThresholds(**record["defect_thresholds"])
    except (TypeError, InputError) as error:
        raise InputError(
            f"{folder / RUN} has no thresholds of defects that are known here ({error}): {AGAIN}"
        ) from error
