"""``warpdrape unit_cell``: a fabric's card from its weave."""

from __future__ import annotations

import argparse

from warpdrape.command_line.command import DONE, Command, teller
from warpdrape.command_line.options import add_set


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "weave",
        metavar="WEAVE",
        help="plain, twill or satin, or a .toml file with the cell's values",
    )
    parser.add_argument(
        "--out",
        metavar="FABRIC",
        help="the card's .toml; pictures, curves and record go to FABRIC_unit_cell beside it",
    )
    add_set(parser, 'a value of the cell with its unit, as width="4.2 mm"; may be repeated')
    parser.add_argument("--dry", action="store_true", help="say what was understood, and stop")
    parser.add_argument("--overwrite", action="store_true", help="replace the card")


def _act(arguments: argparse.Namespace) -> int:
    from warpdrape.commands.interrupts import interrupt_kept

    with interrupt_kept():
        from warpdrape.unit_cell.command import run_unit_cell
    print(
        run_unit_cell(
            arguments.weave,
            arguments.out,
            arguments.settings,
            dry=arguments.dry,
            overwrite=arguments.overwrite,
            say=teller(arguments.quiet),
        )
    )
    return DONE


COMMAND = Command(
    name="unit_cell",
    words="make a fabric's card from its weave: a unit cell of yarns in contact, pulled and "
    "sheared",
    act=_act,
    add_arguments=_add_arguments,
    epilog="Exit status: 0 done, 1 the cell finds no rest, 2 the input cannot be used.",
)
