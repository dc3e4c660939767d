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
        "wrinkle, no bridge, nothing past locking or failure. With a table [thresholds] defects "
        "are measured again by these, without running",
    )
    parser.add_argument(
        "--scene",
        metavar="SCRIPT",
        help="the scene for other thresholds, where the run's own script is gone or has changed",
    )
    parser.add_argument("--out", metavar="FILE", help="the .png or .pdf; in RUN if not given")


def _act(arguments: argparse.Namespace) -> int:
    from warpdrape.commands.judging import judged
    from warpdrape.results.run_tables import read_summary

    folder = Path(arguments.run)
    summary = read_summary(folder)
    if summary["status"] != "completed":
        return complain(f"the run failed, nothing to judge: {summary['message']}", FAILED)
    words, faults = judged(folder, arguments)
    print(words)
    return UNFIT if faults else DONE


COMMAND = Command(
    name="judge",
    words="say whether a run's defects are within limits, and mark where not",
    act=_act,
    add_arguments=_add_arguments,
    epilog="Exit status: 0 fit, 3 unfit, 1 the run failed, 2 the input cannot be used.",
)
