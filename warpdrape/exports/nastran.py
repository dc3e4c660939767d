"""A bulk data file for Nastran: formed plies as shells, each element with a lay-up of its own.

Every triangle is a ``CTRIA3`` whose THETA is the angle of its warp from side G1-G2, and whose
``PCOMP`` has three layers: warp, weft, warp in ¼, ½, ¼ of its thickness, the weft at the angle that
shear has left between the yarns. Numbers are in fields of 16, eight significant digits and more.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TextIO

import numpy as np

from warpdrape.exports.layup import (
    DENSITY,
    LAYERS,
    MATERIAL,
    angles_deg,
    edge_vertices,
    thickness_of,
)
from warpdrape.results.read_run import RunReader
from warpdrape.results.result import FormedPly

GRAVITY = 9.81
"""Of the example's load [m/s²]."""


def write(reader: RunReader, out: Path, frames: Sequence[int]) -> None:
    """Write one frame.

    Args:
        reader: the run.
        out: the file to write.
        frames: one number.
    """
    result = reader.result(frames[0])
    with out.open("w", encoding="ascii", errors="replace", newline="\n") as file:
        file.write(
            f"$ warpdrape: formed plies at {1e3 * result.time_s:.6g} ms; SI units (m, N, kg, s)\n"
            "$ Every element: layers warp, weft, warp of 1/4, 1/2, 1/4 of its thickness,\n"
            "$ along its yarns. Plies do not hold on to each other: add glue or contact.\n"
            "$ Material, boundary and load are an example: replace them by yours.\n"
            "SOL 101\nCEND\nTITLE = FORMED PLIES\nSUBCASE 1\n  SPC = 1\n  LOAD = 1\n"
            "  DISPLACEMENT = ALL\nBEGIN BULK\n"
        )
        file.write(_large("GRAV", 1, 0, GRAVITY, 0.0, 0.0, -1.0))
        _write_material(file)
        node, element = 1, 1
        for ply, flat in zip(result.plies, reader.ply_thicknesses(), strict=True):
            _write_ply(file, ply, thickness_of(ply, flat), node, element)
            node += len(ply.points)
            element += len(ply.triangles)
        file.write("ENDDATA\n")


def _write_ply(
    file: TextIO, ply: FormedPly, thickness: np.ndarray, node: int, element: int
) -> None:
    file.write(
        f"$ ----- ply {ply.name}: nodes {node} to {node + len(ply.points) - 1}, elements "
        f"{element} to {element + len(ply.triangles) - 1}\n"
    )
    for number, place in enumerate(np.asarray(ply.points).tolist(), node):
        file.write(_large("GRID", number, None, *place))
    turned = angles_deg(ply)
    opened = turned["WEFT"] - turned["WARP"]
    opened -= 360.0 * np.round(opened / 360.0)
    corners = (np.asarray(ply.triangles) + node).tolist()
    for k, (a, b, c) in enumerate(corners):
        number = element + k
        file.write(_large("CTRIA3", number, number, a, b, c, float(turned["WARP"][k])))
        layers: list[int | float | None] = []
        for family, share in LAYERS:
            angle = float(opened[k]) if family == "WEFT" else 0.0
            layers += [1, share * float(thickness[k]), angle, None]
        file.write(_large("PCOMP", number, *[None] * 7, *layers))
    for number in (edge_vertices(ply) + node).tolist():
        file.write(f"SPC1    {1:8d}{123:8d}{number:8d}\n")


def _write_material(file: TextIO) -> None:
    e1, e2, _, nu12, _, _, g12, g13, g23 = MATERIAL
    file.write(_large("MAT8", 1, e1, e2, nu12, g12, g13, g23, DENSITY))


def _large(name: str, *fields: int | float | None) -> str:
    """A card in fields of 16 characters, four a line."""
    texts = [_field(value) for value in fields]
    lines = []
    for start in range(0, len(texts), 4):
        head = f"{name}*" if start == 0 else "*"
        lines.append((f"{head:8}" + "".join(texts[start : start + 4])).rstrip())
    return "\n".join(lines) + "\n"


def _field(value: int | float | None) -> str:
    if value is None:
        return " " * 16
    return f"{value:16d}" if isinstance(value, int) else f"{value:16.8E}"
