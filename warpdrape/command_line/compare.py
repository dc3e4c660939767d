"""``warpdrape compare``: a scene by several approaches."""

from __future__ import annotations

import argparse

from warpdrape.command_line.command import DONE, FAILED, Command, complain
from warpdrape.command_line.options import add_scene, add_settings
from warpdrape.commands.values import OUT


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    add_scene(parser)
    parser.add_argument(
        "--approaches",
        metavar="A,B,…",
        help="their names, differences being from the first; all of them if not given",
    )
    parser.add_argument(
        "--out",
        metavar="DIR",
        help=f"folder for the runs and the comparison; {OUT}/SCENE_approaches if not given",
    )
    add_settings(parser)
    parser.add_argument(
        "--ply", metavar="NAME", help="the ply that is drawn and printed; the first if not given"
    )
    parser.add_argument(
        "--report", action="store_true", help="write comparison.html too, as warpdrape report does"
    )
    parser.add_argument(
        "--overwrite",
        action="store_true",
        help="replace runs in the folder that are unfinished or of another scene",
    )


def _act(arguments: argparse.Namespace) -> int:
    from warpdrape.commands.comparing import compare

    failed = [run for run in compare(arguments) if run.failure]
    if not failed:
        return DONE
    return complain("; ".join(f"{run.approach}: {run.failure}" for run in failed), FAILED)


COMMAND = Command(
    name="compare",
    words="run a scene by several approaches and put them side by side",
    act=_act,
    add_arguments=_add_arguments,
    epilog="Writes a run folder for each, comparison.csv and comparison.png, and prints the "
    "figures. Runs that are there already, finished and of the same scene, are taken as they are. "
    "Exit status: 0 done, 1 an approach failed, 2 the input cannot be used.",
    shows_progress=True,
)
