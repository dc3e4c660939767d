"""What a new scene script is written from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Draft:
    """What a script is written from; paths as the script gives them, from its own folder.

    Attributes:
        name: of the scene.
        mould: path of the mould's file; "" for a stand-in.
        units: of the file, where it states none; else "".
        unit: of the file in words.
        up: the file's direction that is up.
        kind: "female" or "male".
        has_rim: whether a holder can be had.
        blank: path of a drawing; "" for a rectangle.
        blank_unit: of the drawing, and whether it states it.
        states_unit: whether the drawing does.
        layer: of the drawing; "" for all.
        centred: whether the drawing is moved onto the mould.
        sizes: of a rectangle, along x and y [m].
        angles: of the warp [deg].
        fabric: name or path.
        own_fabric: whether that is a path.
        thickness: of a ply [m].
        edge: of the mesh [m].
        duration: of the stroke [s].
        force: of the holder [N]; 0 for none.
        wet: whether the fabric has a viscous matrix, which asks for the press's time.
    """

    name: str
    mould: str
    units: str
    unit: str
    up: str
    kind: str
    has_rim: bool
    blank: str
    blank_unit: str
    states_unit: bool
    layer: str
    centred: bool
    sizes: tuple[float, float]
    angles: Sequence[float]
    fabric: str
    own_fabric: bool
    thickness: float
    edge: float
    duration: float
    force: float
    wet: bool
