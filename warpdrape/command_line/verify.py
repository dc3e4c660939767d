"""``warpdrape verify``: results against closed forms."""

from __future__ import annotations

import argparse

from warpdrape.command_line.command import Command
from warpdrape.commands.values import OUT

VERIFICATION = f"{OUT}/verification"
"""Folder that takes table and figures where ``--out`` is not given."""


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--quick", action="store_true", help="coarse meshes: less than a minute")
    parser.add_argument(
        "--out",
        metavar="DIR",
        default=VERIFICATION,
        help=f"folder for table and figures; {VERIFICATION} if not given",
    )


def _act(arguments: argparse.Namespace) -> int:
    from warpdrape.commands.interrupts import interrupt_kept

    with interrupt_kept():
        from warpdrape.verification.verify import main as verify_main
        from warpdrape.warp_start import start_warp

    start_warp()
    return verify_main(arguments.quick, arguments.out)


COMMAND = Command(
    name="verify",
    words="check results against closed forms, and print a table",
    act=_act,
    add_arguments=_add_arguments,
)
