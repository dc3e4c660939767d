"""``warpdrape new``: a commented scene script for a part of one's own."""

from __future__ import annotations

import argparse

from warpdrape.command_line.command import DONE, Command


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("name", metavar="NAME", help="of the scene; NAME.py is written")
    parser.add_argument(
        "--mould", metavar="FILE", help="STEP or IGES, or STL, OBJ, PLY, OFF, GLB with --units"
    )
    parser.add_argument(
        "--units", metavar="UNIT", help="of files that state none: mm, cm, m or inch"
    )
    parser.add_argument(
        "--up", metavar="AXIS", default="z", help="the file's direction that is up: z, -z, x, …"
    )
    parser.add_argument(
        "--kind", metavar="KIND", help="female or male; if not given, what the mould looks like"
    )
    parser.add_argument(
        "--blank",
        metavar="BLANK",
        help="a .dxf, or a size such as 300x200mm; if not given, as large as the mould",
    )
    parser.add_argument(
        "--layer", metavar="LAYER", help="of the .dxf that holds the blank, if it has several"
    )
    parser.add_argument(
        "--angles", metavar="A,B,…", help="of the warp of each ply, from the bottom up [deg]"
    )
    parser.add_argument("--fabric", metavar="NAME", help="a name, or a .toml file")
    parser.add_argument(
        "--holder", metavar="FORCE", help="of the blank holder, such as 200N; 0 for no holder"
    )


def _act(arguments: argparse.Namespace) -> int:
    from warpdrape.commands.writing import new

    new(arguments)
    return DONE


COMMAND = Command(
    name="new",
    words="write a commented scene script for your own part",
    act=_act,
    add_arguments=_add_arguments,
    epilog="What is not given is asked for on a terminal, and elsewhere taken by default. "
    "Then: warpdrape check NAME.py, warpdrape run NAME.py.",
)
