"""``warpdrape export``: a run in the format of another program."""

from __future__ import annotations

import argparse

from warpdrape.command_line.command import DONE, Command
from warpdrape.command_line.options import add_set
from warpdrape.commands.values import whole
from warpdrape.exports.formats import FORMATS


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("run", metavar="RUN", help="the folder of a run")
    parser.add_argument("--to", metavar="FORMAT", required=True, help=", ".join(FORMATS))
    parser.add_argument("--out", metavar="PATH", help="the file; in RUN/export if not given")
    parser.add_argument(
        "--frame",
        metavar="N",
        help="which frame, negative ones from the end, or all; if not given all for vtk and "
        "vtkhdf, and the last one for others",
    )
    parser.add_argument(
        "--trim",
        metavar="WHERE",
        help="dxf and svg: where the part ends: a side, z<-20mm or x+0.5*z>10mm; tool:NAME for "
        "that tool's border; or a .dxf, .csv or .json with closed curves",
    )
    parser.add_argument(
        "--onto", metavar="MESH", help="mapped and mapped-vtk: the mesh, in the run's coordinates"
    )
    add_set(
        parser,
        "what a format wants to know, may be repeated; permeability: fibre_diameter=7um, "
        "packing=hexagonal or quadratic, or kozeny_along and kozeny_across, warp_share=0.5; "
        "mapped: unit=1mm, farthest=10mm; --trim with a curve: along=z",
    )
    parser.add_argument("--overwrite", action="store_true", help="replace the file")


def _act(arguments: argparse.Namespace) -> int:
    from warpdrape.commands.exporting import read_options
    from warpdrape.exports.export import ALL, export

    frame = arguments.frame
    if frame is not None and frame != ALL:
        frame = whole("--frame", frame)
    options = {"frame": frame, "overwrite": arguments.overwrite}
    options |= read_options(arguments.settings, trim=arguments.trim, onto=arguments.onto)
    print(export(arguments.run, arguments.to, arguments.out, **options))
    return DONE


COMMAND = Command(
    name="export",
    words="write a run in the format of another program",
    act=_act,
    add_arguments=_add_arguments,
    epilog="; ".join(f"{name}: {each.words}" for name, each in FORMATS.items()),
)
