"""``warpdrape run``: a scene from its start."""

from __future__ import annotations

import argparse

from warpdrape.command_line.command import Command, ended
from warpdrape.command_line.options import add_how, add_scene, add_settings
from warpdrape.commands.values import OUT


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    add_scene(parser)
    parser.add_argument(
        "--out", metavar="DIR", help=f"folder for the results; {OUT}/SCENE if not given"
    )
    add_settings(parser)
    add_how(parser)
    parser.add_argument(
        "--overwrite", action="store_true", help="replace the results in the folder"
    )


def _act(arguments: argparse.Namespace) -> int:
    from warpdrape.commands.running import run

    return ended(run(arguments))


COMMAND = Command(
    name="run",
    words="run a scene and write its results to a folder",
    act=_act,
    add_arguments=_add_arguments,
    epilog="Exit status: 0 done, 1 the run failed, 2 the input cannot be used. "
    "Ctrl-C stops a run and keeps the frames it has; warpdrape resume goes on.",
    shows_progress=True,
)
