"""``warpdrape calibrate``: a fabric's card from raw tests."""

from __future__ import annotations

import argparse

from warpdrape.command_line.command import DONE, Command, teller
from warpdrape.commands.values import whole


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("tests", metavar="TESTS", help="a .toml file that names the raw tables")
    parser.add_argument(
        "--out",
        metavar="FABRIC",
        help="the card's .toml; pictures, residuals and report go to FABRIC_calibration beside it",
    )
    parser.add_argument("--dry", action="store_true", help="say what was understood, and stop")
    parser.add_argument(
        "--no-coupons", action="store_true", help="do not simulate the tests with the new card"
    )
    parser.add_argument(
        "--draws", metavar="N", default="400", help="samples of the bootstrap; 400 if not given"
    )
    parser.add_argument("--overwrite", action="store_true", help="replace the card")


def _act(arguments: argparse.Namespace) -> int:
    from warpdrape.commands.interrupts import interrupt_kept

    draws = whole("--draws", arguments.draws)
    with interrupt_kept():
        from warpdrape.calibration.calibrate import run_calibration
        from warpdrape.warp_start import start_warp

    start_warp()
    print(
        run_calibration(
            arguments.tests,
            arguments.out,
            dry=arguments.dry,
            coupons=not arguments.no_coupons,
            draws=draws,
            overwrite=arguments.overwrite,
            say=teller(arguments.quiet),
        )
    )
    return DONE


COMMAND = Command(
    name="calibrate",
    words="make a fabric's card from raw tests, and lay its coupons over them",
    act=_act,
    add_arguments=_add_arguments,
    epilog="Exit status: 0 done, 2 the input cannot be used.",
)
