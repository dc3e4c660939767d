"""``warpdrape picture``: a formed ply as a picture or a video."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from warpdrape.command_line.command import DONE, Command, teller
from warpdrape.commands.values import whole


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("run", metavar="RUN", help="the folder of a run")
    parser.add_argument("--ply", metavar="NAME", help="which ply; the middle one if not given")
    parser.add_argument(
        "--field",
        metavar="FIELD",
        default="shear",
        help="shear if not given; warp- or weft-strain, -tension, -curvature; slip, "
        "contact-pressure, tool-pressure, thickness, fibre-volume, wrinkle, tool-distance",
    )
    parser.add_argument("--stack", action="store_true", help="draw all plies side by side")
    parser.add_argument("--frame", metavar="K", help="which frame; -1, the last one, if not given")
    parser.add_argument("--tools", action="store_true", help="draw the tools too, translucent")
    parser.add_argument(
        "--arrows", action="store_true", help="arrows along warp and weft in place of lines"
    )
    parser.add_argument(
        "--video", action="store_true", help="draw all frames, as a .mp4 or, with --out, a .gif"
    )
    parser.add_argument(
        "--out", metavar="FILE", help="the .png or .pdf, .mp4 or .gif; in RUN if not given"
    )


def _act(arguments: argparse.Namespace) -> int:
    from warpdrape.errors import InputError
    from warpdrape.results.picture import draw_ply, draw_stack

    options = {"out": arguments.out, "tools": arguments.tools, "arrows": arguments.arrows}
    options |= {"field": arguments.field}
    if arguments.stack and arguments.ply is not None:
        raise InputError("give --ply NAME for one ply or --stack for all, not both")
    if arguments.video:
        print(_film(arguments, options))
        return DONE
    options["frame"] = whole("--frame", "-1" if arguments.frame is None else arguments.frame)
    if arguments.stack:
        print(draw_stack(arguments.run, **options))
    else:
        print(draw_ply(arguments.run, arguments.ply, **options))
    return DONE


def _film(arguments: argparse.Namespace, options: dict[str, Any]) -> Path:
    from warpdrape.errors import InputError
    from warpdrape.results.video import draw_video

    if arguments.frame is not None:
        raise InputError("give --frame K for one moment or --video for all, not both")
    say = teller(arguments.quiet)
    say("Drawing every frame: that takes a second or more for each.")
    return draw_video(arguments.run, arguments.ply, stack=arguments.stack, **options)


COMMAND = Command(
    name="picture",
    words="draw a formed ply, coloured by shear or another field",
    act=_act,
    add_arguments=_add_arguments,
)
