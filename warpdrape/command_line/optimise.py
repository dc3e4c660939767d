"""``warpdrape optimise``: the settings of a scene that are best."""

from __future__ import annotations

import argparse

from warpdrape.command_line.command import DONE, FAILED, Command, complain
from warpdrape.command_line.options import add_study_arguments


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    add_study_arguments(parser)
    parser.add_argument(
        "--slopes",
        action="store_true",
        help="show how what is aimed at goes with each parameter at the start, and whether a "
        "gradient may be trusted; search nothing",
    )
    parser.add_argument(
        "--seed", metavar="N", help="of what is random, in place of the file's; give --out too"
    )


def _act(arguments: argparse.Namespace) -> int:
    from warpdrape.commands.interrupts import interrupt_kept

    with interrupt_kept():
        from warpdrape.optimisation.command import optimise

    why = optimise(arguments)
    return complain(why, FAILED) if why else DONE


COMMAND = Command(
    name="optimise",
    words="look for the settings of a scene that are best, beside random ones of equal cost",
    act=_act,
    add_arguments=_add_arguments,
    epilog="Started again, it runs only what is missing. Exit status: 0 all runs have ended, "
    "failed ones among them too; 1 it was interrupted, or none completed; 2 the input cannot be "
    "used.",
)
