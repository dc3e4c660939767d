"""The command ``new``: a commented scene script for a part of one's own."""

from __future__ import annotations

import argparse
import math
import os
import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from warpdrape.cad_file import is_cad
from warpdrape.commands.new_blank import blank_of, checked_against
from warpdrape.commands.new_mould import mould_of, refuse_idle, sizes_of
from warpdrape.commands.scene_draft import Draft
from warpdrape.commands.scene_template import CLOSING, script_text
from warpdrape.errors import InputError

if TYPE_CHECKING:
    from warpdrape.tools.mould import Mould

FABRIC = "carbon_interlock"
SPEED = 0.9
"""Mean speed of the stroke [m/s]: that of the bundled presses."""
CELLS, FINEST = 25.0, 50.0
"""Meshes across the narrower side of a blank, about, and at most."""
ABOUT = 1.05
"""How far a mesh may be above what is wanted of it [-]."""
ROUND = (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)
"""Figures that a mesh size may begin with."""
HOLD = 1.5e3
"""Pressure of the blank holder [Pa]: about that of the bundled presses."""
_FORCE = re.compile(r"\s*([\d.eE+]+)\s*(k?N)?\s*")


def new(arguments: argparse.Namespace) -> None:
    """Write a scene script, having asked on a terminal for what was not given."""
    path = _path(arguments.name)
    if _is_terminal(arguments):
        _ask(arguments)
    from warpdrape.commands.interrupts import interrupt_kept

    with interrupt_kept():
        from warpdrape.warp_start import start_warp
    start_warp()
    refuse_idle(arguments)
    draft, told = _draft(arguments, path)
    _write(path, script_text(draft))
    print("\n".join([f"{path} is written.", *(f"  {line}" for line in told)]))
    print(f"Next: warpdrape check {path}")


def _path(name: str) -> Path:
    """Where the script goes."""
    path = Path(name if name.endswith(".py") else f"{name}.py")
    if not path.stem.isidentifier():
        raise InputError(f"NAME = {name!r} must be a plain name, such as my_part")
    from warpdrape.commands.scene_library import bundled_scenes

    if path.stem in bundled_scenes():
        raise InputError(f"NAME = {name!r} is that of a bundled scene: take another")
    if path.exists():
        raise InputError(f"{path} is there already, and is not replaced: take another name")
    if not path.parent.is_dir():
        raise InputError(f"{path.parent} is no folder: make it first, or write here")
    return path


def _is_terminal(arguments: argparse.Namespace) -> bool:
    return sys.stdin.isatty() and sys.stdout.isatty() and not arguments.quiet


def _ask(arguments: argparse.Namespace) -> None:
    """Ask for what was not given; an empty answer takes what stands in brackets."""
    for option, question in (
        ("mould", "Mould, a STEP, IGES or STL file [a stand-in]"),
        ("units", "Unit of its numbers: mm, cm, m or inch [mm]"),
        ("blank", "Blank, a .dxf or a size such as 300x200mm [as large as the mould]"),
        ("angles", "Angles of the warp from x, from the bottom up [0]"),
        ("fabric", f"Fabric, a name or a .toml file [{FABRIC}]"),
    ):
        if option == "units" and (not arguments.mould or is_cad(arguments.mould)):
            continue
        if getattr(arguments, option) is not None:
            continue
        if option == "units":
            print(f"{arguments.mould} is {sizes_of(arguments.mould)}, and states no unit.")
        answer = input(f"{question}: ").strip()
        if answer or option == "units":
            setattr(arguments, option, answer or "mm")


def _draft(arguments: argparse.Namespace, path: Path) -> tuple[Draft, list[str]]:
    """What the script is written from, and what is to be said of it."""
    from warpdrape.materials.fabric_library import load_fabric

    name = arguments.fabric or FABRIC
    fabric, own = load_fabric(name), Path(name).is_file()
    angles = _angles(arguments.angles or "0")
    tolerance = 0.1 * fabric.thickness
    mould, told = mould_of(arguments, tolerance)
    drawn, sizes, centred, more = blank_of(arguments, mould)
    told += more
    if drawn is not None:
        low, high = np.reshape(drawn.bounds, (2, 2))
        sizes = (float(high[0] - low[0]), float(high[1] - low[1]))
    if arguments.blank:
        told += checked_against(mould, sizes)
    thickness = len(angles) * fabric.thickness
    force, words = _force(arguments.holder, mould, thickness)
    told += words
    travel = float(np.ptp(mould.tool.vertices[:, 2]))
    folder = path.resolve().parent
    draft = Draft(
        name=path.stem,
        mould=_beside(arguments.mould, folder),
        units="" if not arguments.mould or is_cad(arguments.mould) else mould.unit,
        unit=mould.unit,
        up=arguments.up,
        kind=mould.kind,
        has_rim=mould.has_rim,
        blank="" if drawn is None else _beside(arguments.blank, folder),
        blank_unit="" if drawn is None else drawn.unit,
        states_unit=drawn is None or drawn.states_unit,
        layer=arguments.layer or "",
        centred=centred,
        sizes=sizes,
        angles=angles,
        fabric=_beside(name, folder) if own else name,
        own_fabric=own,
        thickness=fabric.thickness,
        edge=_edge(min(sizes), mould),
        duration=max(5e-3 * math.ceil(travel / SPEED / 5e-3), 20e-3),
        force=force,
        wet=fabric.matrix is not None,
    )
    if draft.wet:
        told.append(
            f"Fabric: {fabric.name} has a viscous matrix; the press closes in {CLOSING:g} s "
            "(closing_time)."
        )
    return draft, told


def _beside(file: str | None, folder: Path) -> str:
    """A file as a script in a folder names it."""
    return "" if not file else Path(os.path.relpath(Path(file).resolve(), folder)).as_posix()


def _angles(text: str) -> list[float]:
    try:
        angles = [float(angle) for angle in re.split(r"[,/]", text)]
    except ValueError:
        angles = []
    if not angles or not all(-360.0 <= angle <= 360.0 for angle in angles):
        raise InputError(f"--angles {text} must be degrees with commas, such as 0,45,90")
    return angles


def _force(text: str | None, mould: Mould, thickness: float) -> tuple[float, list[str]]:
    """Force of the holder [N], and what is to be said of it."""
    if text is not None:
        found = _FORCE.fullmatch(text)
        try:
            force = float(found[1] if found else "") * (1e3 if found and found[2] == "kN" else 1.0)
        except ValueError:
            raise InputError(f"--holder {text} must be a force, such as 200N, or 0") from None
        if not mould.has_rim and force > 0.0:
            raise InputError(
                f"--holder {text}: the mould has no flat rim round its shape to hold the plies on: "
                "give 0, or a mould with a rim"
            )
        if force > 0.0:
            mould.holder(thickness=thickness, force=force)
        return force, []
    if not mould.has_rim:
        return 0.0, ["The mould has no flat rim: there is no blank holder."]
    try:
        mould.holder(thickness=thickness, force=1.0)
    except InputError as error:
        return 0.0, [f"No blank holder: {error}"]
    area = mould.face.outer.area - mould.face.outline.area
    return max(10.0 * round(HOLD * area / 10.0), 10.0), []


def _edge(width: float, mould: Mould) -> float:
    """A round mesh size for a blank, within the mould's smallest radius if that can be had [m].

    Args:
        width: of the blank's narrower side [m].
        mould: on which it comes to lie.
    """
    from warpdrape.checks.roundings import smallest_rounding

    low, high = np.reshape(mould.face.outer.bounds, (2, 2))
    radius = smallest_rounding(mould.tool, low, high).radius
    wanted = max(min(width / CELLS, ABOUT * radius), width / FINEST)
    power = 10.0 ** math.floor(math.log10(1e3 * wanted))
    return 1e-3 * max(power * f for f in ROUND if power * f <= 1e3 * wanted * ABOUT)


def _write(path: Path, text: str) -> None:
    """Write the script, and see that it builds: what does not is not left behind."""
    from warpdrape.commands.scene_library import find_script

    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(text)
    except OSError as error:
        raise InputError(f"{path} cannot be written: {error.strerror}") from error
    try:
        find_script(path).make()
    except BaseException:
        path.unlink()
        raise
