"""``warpdrape scenes``: the bundled scenes and their parameters."""

from __future__ import annotations

import argparse

from warpdrape.command_line.command import DONE, Command, print_list


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("scene", metavar="SCENE", nargs="?", help="a bundled name, or a script")


def _act(arguments: argparse.Namespace) -> int:
    from warpdrape.commands.scene_library import bundled_scenes, describe_scene, find_typed

    if arguments.scene is None:
        print_list(bundled_scenes())
    else:
        print(describe_scene(find_typed(arguments.scene)))
    return DONE


COMMAND = Command(
    name="scenes",
    words="list the bundled scenes, or one scene's parameters",
    act=_act,
    add_arguments=_add_arguments,
)
