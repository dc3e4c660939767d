"""``warpdrape check``: what a scene will do, without running it."""

from __future__ import annotations

import argparse

from warpdrape.command_line.command import DONE, Command
from warpdrape.command_line.options import SCENE_VALUE, add_device, add_scene, add_set


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    add_scene(parser)
    add_set(parser, SCENE_VALUE)
    parser.add_argument("--out", metavar="FILE", help="the picture; SCENE_check.png if not given")
    add_device(parser)
    parser.add_argument("--frames", metavar="N", default="60", help="as for run; 60 if not given")


def _act(arguments: argparse.Namespace) -> int:
    from warpdrape.commands.checking import check

    check(arguments)
    return DONE


COMMAND = Command(
    name="check",
    words="say what a scene will do, and draw it, without running it",
    act=_act,
    add_arguments=_add_arguments,
    epilog="Makes the checks of a run's start. Exit status: 0 it would run, 2 the input cannot be "
    "used.",
)
