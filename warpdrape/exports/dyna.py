"""A keyword file for LS-DYNA: formed plies as shells, each element with layers of its own.

``*ELEMENT_SHELL_COMPOSITE`` gives every triangle its three layers, warp, weft, warp in ¼, ½, ¼ of
its thickness, with the angles in which the yarns lie, from the side of nodes 1 and 2 about the
normal: so a material with AOPT = 0 takes them. A triangle repeats its third node.
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

ROW = 8
"""Numbers in a row of a set."""


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
            "*KEYWORD\n*TITLE\n"
            f"warpdrape: formed plies at {1e3 * result.time_s:.6g} ms\n"
            "$ SI units (m, N, kg, s, Pa). Plies from the bottom up, a part each. Every element\n"
            "$ has layers warp, weft, warp of 1/4, 1/2, 1/4 of its thickness, along its yarns.\n"
            "$ The material is an example: replace it by yours, with AOPT = 0. Node sets are the\n"
            "$ plies' edges. Plies do not hold on to each other: add contact. There is no load.\n"
        )
        _write_material(file)
        first_node, first_element = 1, 1
        for number, (ply, flat) in enumerate(
            zip(result.plies, reader.ply_thicknesses(), strict=True), 1
        ):
            _write_ply(file, ply, thickness_of(ply, flat), number, first_node, first_element)
            first_node += len(ply.points)
            first_element += len(ply.triangles)
        file.write("*END\n")


def _write_ply(
    file: TextIO, ply: FormedPly, thickness: np.ndarray, part: int, node: int, element: int
) -> None:
    mean = float(thickness.mean())
    file.write(f"$ ----- ply {ply.name}\n*PART\n{ply.name}\n{part:10d}{part:10d}{1:10d}\n")
    file.write(f"*SECTION_SHELL\n{part:10d}{2:10d}{1.0:10.4f}{len(LAYERS):10d}\n")
    file.write(_short(mean) * 4 + "\n*NODE\n")
    for number, (x, y, z) in enumerate(np.asarray(ply.points).tolist(), node):
        file.write(f"{number:8d}{x:16.8e}{y:16.8e}{z:16.8e}\n")
    file.write("*ELEMENT_SHELL_COMPOSITE\n")
    turned = angles_deg(ply)
    corners = (np.asarray(ply.triangles) + node).tolist()
    for k, (a, b, c) in enumerate(corners):
        file.write("".join(f"{number:8d}" for number in (element + k, part, a, b, c, c)) + "\n")
        layers = [
            f"{1:10d}{_short(share * float(thickness[k]))}{turned[family][k]:10.4f}{'':10}"
            for family, share in LAYERS
        ]
        for start in range(0, len(layers), 2):
            file.write("".join(layers[start : start + 2]).rstrip() + "\n")
    file.write(f"*SET_NODE_LIST_TITLE\nedge of {ply.name}\n{part:10d}\n")
    edge = (edge_vertices(ply) + node).tolist()
    for start in range(0, len(edge), ROW):
        file.write("".join(f"{number:10d}" for number in edge[start : start + ROW]) + "\n")


def _short(value: float) -> str:
    """A number in ten characters, the first of them a space, five digits."""
    digits, _, power = f"{value:.4e}".partition("e")
    return f"{digits}e{int(power)}".rjust(10)


def _write_material(file: TextIO) -> None:
    """``*MAT_ORTHOTROPIC_ELASTIC``; PRBA is the smaller Poisson's ratio, ν12 E2 / E1."""
    e1, e2, e3, nu12, nu13, nu23, g12, g13, g23 = MATERIAL
    ratios = (nu12 * e2 / e1, nu13 * e3 / e1, nu23 * e3 / e2)
    file.write("$ ----- example material: yarns in resin, a along them\n*MAT_ORTHOTROPIC_ELASTIC\n")
    file.write(f"{1:10d}" + "".join(map(_short, (DENSITY, e1, e2, e3, *ratios))) + "\n")
    file.write("".join(map(_short, (g12, g23, g13, 0.0))) + "\n")
    file.write(f"{0.0:10.1f}" * 6 + "\n" + f"{0.0:10.1f}" * 7 + "\n")
