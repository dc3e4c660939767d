"""``warpdrape report``: runs as one HTML file."""

from __future__ import annotations

import argparse

from warpdrape.command_line.command import DONE, Command
from warpdrape.commands.values import whole


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("runs", metavar="RUN", nargs="+", help="the folder of a run")
    parser.add_argument(
        "--out",
        metavar="FILE",
        help="the .html; if not given RUN/report.html, and for several runs comparison.html in the "
        "current folder",
    )
    parser.add_argument(
        "--frames",
        metavar="N",
        help="frames of each run in the 3-D view at most; if not given, as many as keep the file "
        "small",
    )


def _act(arguments: argparse.Namespace) -> int:
    from warpdrape.report.report import write_report

    frames = arguments.frames
    if frames is not None:
        frames = whole("--frames", frames, least=1)
    print(write_report(arguments.runs, arguments.out, frames=frames))
    return DONE


COMMAND = Command(
    name="report",
    words="write a run, or several beside each other, as one HTML file",
    act=_act,
    add_arguments=_add_arguments,
    epilog="The file needs no network: 3-D view over time, curves, the result in words, and how "
    "the run was made. Of several runs it shows differences from the first.",
)
