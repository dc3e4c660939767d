"""``warpdrape resume``: a run from its last checkpoint on."""

from __future__ import annotations

import argparse

from warpdrape.command_line.command import DONE, Command, ended
from warpdrape.command_line.options import add_how


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("run", metavar="RUN", help="the folder of a run")
    parser.add_argument(
        "--extend",
        metavar="BY",
        help="go on beyond its end: strokes by a way (10mm), all by a time (8ms) or 12frames",
    )
    parser.add_argument(
        "--scene",
        metavar="SCENE",
        help="the scene that was run, where its script has been moved or changed",
    )
    add_how(parser)


def _act(arguments: argparse.Namespace) -> int:
    from warpdrape.commands.running import resume

    result = resume(arguments)
    if result is None:
        print(f"{arguments.run} is complete: extend it with --extend, or look at its summary.json")
        return DONE
    return ended(result)


COMMAND = Command(
    name="resume",
    words="go on with a run from its last checkpoint",
    act=_act,
    add_arguments=_add_arguments,
    epilog="The result is that of a run that was never cut off. Exit status as of run.",
    shows_progress=True,
)
