"""The mould of a new scene: read from what was typed, and what is to be said of it."""

from __future__ import annotations

import argparse
import warnings
from typing import TYPE_CHECKING

import numpy as np

from warpdrape.cad_file import is_cad
from warpdrape.errors import InputError, one_of

if TYPE_CHECKING:
    from warpdrape.tools.mould import Mould

FLAT, UNUSUAL = 1e-3, 0.01
"""Height over width below which a mould has no shape, and share of its face that is worth a word
if it is undercut or lies under something [-]."""
LEVEL, SHARP, TURN = 1.0, 35.0, 3.0
"""Turns from one facet to the next from which on they are on a rounding, or on an edge, and beyond
which facets are coarse: over a radius r they lie up to r (1 - cos ½ turn) off it [deg]."""
LIKELY = (30e-3, 5.0)
"""Widths between which a mould's unit is not doubted [m]."""


def mould_of(arguments: argparse.Namespace, tolerance: float) -> tuple[Mould, list[str]]:
    """The mould, and what is to be said of it.

    Args:
        arguments: of the command.
        tolerance: chord error of a CAD file's facets [m].

    Raises:
        InputError: it cannot be read, has no unit, or nothing of it has a shape.
    """
    from warpdrape.tools.mould import Mould
    from warpdrape.tools.shaped import double_dome_cavity
    from warpdrape.tools.tool import Tool
    from warpdrape.wording import size

    if not arguments.mould:
        cavity = double_dome_cavity(
            0.05, 0.12, 0.04, depth=0.06, edge_radius=0.01, outer_radius=0.2, facet=4e-3
        )
        words = "No mould was given: a double dome stands in for it; --mould FILE takes yours."
        return Mould.of(Tool(name="mould", surface=cavity)), [words]
    file, cad = arguments.mould, is_cad(arguments.mould)
    if not cad and arguments.units is None:
        raise InputError(
            f"{file} is {sizes_of(file)}, and states no unit: give --units, as in --units mm"
        )
    drawing = (arguments.blank or "").lower().endswith(".dxf")
    mould = Mould.from_file(
        file,
        units=None if cad and drawing else arguments.units,  # which are the drawing's then
        tolerance=tolerance if cad else None,
        kind=arguments.kind,
        up=arguments.up,
    )
    states = f"states its unit, {mould.unit}" if cad else f"counts in {mould.unit}"
    rim = f"a flat rim at z {1e3 * mould.face.level:.4g} mm" if mould.has_rim else "no flat rim"
    told = [
        f"Mould: {file} {states}: a {mould.kind} mould with {rim}, "
        f"{size(mould.tool.vertices)}, {len(mould.tool.triangles):,} facets"
    ]
    return mould, told + _doubts(mould, arguments.kind)


def refuse_idle(arguments: argparse.Namespace) -> None:
    """Raise `InputError` for an option of a file that is not given: it would do nothing."""
    from warpdrape.tools.mould import KINDS, UPWARD

    drawing = (arguments.blank or "").lower().endswith(".dxf")
    if arguments.kind is not None:
        one_of("kind of mould", arguments.kind, KINDS)
    one_of("up", arguments.up, UPWARD)
    mould, file = bool(arguments.mould), "--mould FILE"
    for option, idle, of, instead in (
        ("kind", arguments.kind is not None and not mould, "a mould", file),
        ("up", arguments.up != "z" and not mould, "a mould", file),
        ("units", arguments.units and not (mould or drawing), "a mould or a drawing", file),
        ("layer", arguments.layer and not drawing, "a .dxf", "--blank FILE.dxf"),
    ):
        if idle:
            raise InputError(f"--{option} is of {of}: give {instead} too, or leave it away")


def _doubts(mould: Mould, kind: str | None) -> list[str]:
    """What of a mould may not be what its owner meant.

    Raises:
        InputError: if what faces up has no shape.
    """
    face, sizes = mould.face, np.ptp(mould.tool.vertices, axis=0)
    width, height = float(sizes[:2].max()), float(sizes[2])
    if height < FLAT * width:
        raise InputError(
            f"what faces up of the mould is flat, {1e3 * height:.2g} mm high: it may lie upside "
            "down; give another --up, such as --up=-z"
        )
    told = []
    if not LIKELY[0] <= width <= LIKELY[1]:
        told.append(f"It is {1e3 * width:.4g} mm across: look whether {mould.unit} is its unit.")
    if face.hidden > UNUSUAL:
        told.append(
            f"{100 * face.hidden:.0f} % of what faces up lies under something else, and is left "
            "out: is it the right way --up?"
        )
    if face.undercut > UNUSUAL:
        told.append(
            f"{100 * face.undercut:.0f} % of it is undercut, looks down, and is left out: no tool "
            "that comes from above reaches it, and no part comes off."
        )
    if not face.surface.exact:
        angles = np.degrees(face.surface.mesh.face_adjacency_angles)
        rounded = angles[(angles > LEVEL) & (angles < SHARP)]
        if len(rounded) and (turn := float(np.median(rounded))) > TURN:
            told.append(
                f"Its facets turn by {turn:.2g}° from one to the next on roundings, and plies feel "
                f"each as flat, and its edges: export it with {TURN:g}° or less, or as STEP."
            )
    looks = "female" if face.hollow else "male"
    if kind is not None and kind != looks:
        told.append(f"It looks like a {looks} mould; {kind} was asked for.")
    return told


def sizes_of(file: str) -> str:
    """Sizes of a mesh file in its own unit, in words."""
    from warpdrape.tools.tool_mesh import read_facets

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        points = np.asarray(read_facets("mould", file, 1.0).vertices)
    return " × ".join(f"{length:.4g}" for length in np.ptp(points, axis=0))
