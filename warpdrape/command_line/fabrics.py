"""``warpdrape fabrics``: the fabrics and their cards."""

from __future__ import annotations

import argparse

from warpdrape.command_line.command import DONE, Command, print_list


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("fabric", metavar="NAME", nargs="?", help="a name, or a .toml file")
    parser.add_argument("--plot", metavar="FILE", help="draw its curves to a .png, .pdf or .svg")


def _act(arguments: argparse.Namespace) -> int:
    from warpdrape.errors import InputError
    from warpdrape.materials.fabric_library import fabric_names, load_fabric

    if arguments.fabric is None:
        if arguments.plot is not None:
            raise InputError("--plot needs a fabric: warpdrape fabrics NAME --plot FILE")
        print_list({name: load_fabric(name).description for name in fabric_names()})
        return DONE
    from warpdrape.materials.fabric_card import card, plot_card
    from warpdrape.warp_start import start_warp

    fabric = load_fabric(arguments.fabric)
    start_warp()
    print(card(fabric))
    if arguments.plot is None:
        name = arguments.fabric
        print(f"\nCurves of tension and shear: warpdrape fabrics {name} --plot FILE.png")
    else:
        try:
            plot_card(fabric, arguments.plot)
        except (OSError, ValueError) as error:
            raise InputError(
                f"--plot {arguments.plot} cannot be written ({error}): give a place in a folder "
                "that exists, ending in .png"
            ) from error
        print(f"\nCurves in {arguments.plot}")
    return DONE


COMMAND = Command(
    name="fabrics",
    words="list the fabrics, or show one with its sources",
    act=_act,
    add_arguments=_add_arguments,
)
