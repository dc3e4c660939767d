"""``warpdrape judge``: a run's defects against limits."""

from __future__ import annotations

import argparse
from pathlib import Path

from warpdrape.command_line.command import DONE, FAILED, UNFIT, Command, complain


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("run", metavar="RUN", help="the folder of a run")
    parser.add_argument(
        "limits",
        metavar="LIMITS",
        nargs="?",
        help="a .toml file with limits; if not given those of the scene, and where it has none: no "
        "wrinkle, no bridge, nothing past locking or failure",
    )
    parser.add_argument("--out", metavar="FILE", help="the .png or .pdf; in RUN if not given")


def _act(arguments: argparse.Namespace) -> int:
    from warpdrape.defects.limits import limits_of, read_limits
    from warpdrape.results.judgement import judge, not_judged, verdict
    from warpdrape.results.judgement_picture import draw_judgement
    from warpdrape.results.run_folder import JUDGEMENT
    from warpdrape.results.run_tables import read_history, read_summary

    given = None if arguments.limits is None else read_limits(arguments.limits)
    folder = Path(arguments.run)
    summary = read_summary(folder)
    limits = limits_of(summary) if given is None else given
    if summary["status"] != "completed":
        return complain(f"the run failed, nothing to judge: {summary['message']}", FAILED)
    faults = judge(summary, read_history(folder), limits)
    print(verdict(faults, not_judged(summary, limits)))
    out = folder / JUDGEMENT if arguments.out is None else Path(arguments.out)
    print(f"Marked in {draw_judgement(folder, summary, faults, out)}")
    return UNFIT if faults else DONE


COMMAND = Command(
    name="judge",
    words="say whether a run's defects are within limits, and mark where not",
    act=_act,
    add_arguments=_add_arguments,
    epilog="Exit status: 0 fit, 3 unfit, 1 the run failed, 2 the input cannot be used.",
)
