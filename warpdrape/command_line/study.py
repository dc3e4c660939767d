"""``warpdrape study``: a scene many times, with parameters that vary."""

from __future__ import annotations

import argparse

from warpdrape.command_line.command import DONE, FAILED, Command, complain
from warpdrape.command_line.options import add_study_arguments


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    add_study_arguments(parser)


def _act(arguments: argparse.Namespace) -> int:
    from warpdrape.commands.interrupts import interrupt_kept

    with interrupt_kept():
        from warpdrape.studies.command import study

    why = study(arguments)
    return complain(why, FAILED) if why else DONE


COMMAND = Command(
    name="study",
    words="run a scene many times, with parameters that vary, and report what they do",
    act=_act,
    add_arguments=_add_arguments,
    epilog="Started again, it runs only what is missing. Exit status: 0 all runs have ended, "
    "failed ones among them too; 1 it was interrupted, or none completed; 2 the input cannot be "
    "used.",
)
