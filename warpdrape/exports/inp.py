"""An input deck for CalculiX or Abaqus: formed plies as shells with both yarn families' directions.

Every ply is a surface of six-node triangles (composite sections of CalculiX want them), its middle
nodes on the straight edges. Each element has a section of its own with three layers, warp, weft and
warp in the shares ¼, ½, ¼ of its thickness: symmetric, so that a ply does not warp when it is
pulled, with the directions that both families have there, which are not at right angles after
shear. They are given by an orientation each: CalculiX 2.20 ignores distributions in composites.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TextIO

import numpy as np

from warpdrape.exports.layup import DENSITY, LAYERS, MATERIAL
from warpdrape.results.read_run import RunReader
from warpdrape.results.result import FormedPly, Result

POINTS = 3
"""Section points of a layer, for Abaqus; CalculiX takes its own."""
ROW = 8
"""Numbers in a row of a set."""


@dataclass(frozen=True)
class Shell:
    """A ply with middle nodes; numbers count from 0 within the ply.

    Attributes:
        name: of its sets, in capitals.
        nodes: corners, then middles [m], shape [node, 3].
        elements: three corners, then the middles of 1-2, 2-3 and 3-1, shape [triangle, 6].
        edge: nodes on the border.
        thickness: of each element [m], shape [triangle].
        directions: unit vectors of warp and weft in the element's plane, by name.
    """

    name: str
    nodes: np.ndarray
    elements: np.ndarray
    edge: np.ndarray
    thickness: np.ndarray
    directions: dict[str, np.ndarray]


def write(reader: RunReader, out: Path, frames: Sequence[int]) -> None:
    """Write one frame.

    Args:
        reader: the run.
        out: the file to write.
        frames: one number.
    """
    result = reader.result(frames[0])
    thicknesses = reader.ply_thicknesses()
    shells = [shell_of(p, t) for p, t in zip(result.plies, thicknesses, strict=True)]
    with out.open("w", encoding="ascii", errors="replace", newline="\n") as file:
        _write_heading(file, reader, result, shells)
        write_model(file, shells)
        _write_step(file, shells)


def write_model(file: TextIO, shells: Sequence[Shell]) -> None:
    """Write all but heading, boundary and load.

    Args:
        file: the deck.
        shells: the plies, from the bottom up.
    """
    file.write("*NODE\n")  # in one block: some readers keep the last one only
    nodes = np.concatenate([shell.nodes for shell in shells])
    for number, (x, y, z) in enumerate(nodes.tolist(), 1):
        file.write(f"{number}, {x:.9g}, {y:.9g}, {z:.9g}\n")
    first_node, first_element = 1, 1
    for shell in shells:
        _write_shell(file, shell, first_node, first_element)
        first_node += len(shell.nodes)
        first_element += len(shell.elements)
    _write_material(file)


def shell_of(ply: FormedPly, thickness: float) -> Shell:
    """Make a shell of a formed ply.

    Args:
        ply: the ply.
        thickness: of the flat ply [m], for one of which the run has none.
    """
    triangles = np.asarray(ply.triangles)
    ends = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    edges, of, count = np.unique(ends, axis=0, return_inverse=True, return_counts=True)
    middles = len(ply.points) + of.reshape(-1, 3)
    elements = np.column_stack([triangles, middles])
    nodes = np.concatenate([ply.points, ply.points[edges].mean(axis=1)])
    border = edges[count == 1]
    edge = np.union1d(border, len(ply.points) + np.flatnonzero(count == 1))
    return Shell(
        name=ply.name.upper(),
        nodes=nodes,
        elements=elements,
        edge=edge,
        thickness=np.full(len(triangles), thickness) if ply.thickness is None else ply.thickness,
        directions={"WARP": ply.warp, "WEFT": ply.weft},
    )


def _write_heading(
    file: TextIO, reader: RunReader, result: Result, shells: Sequence[Shell]
) -> None:
    file.write(
        "*HEADING\n"
        f"warpdrape: formed plies at {1e3 * result.time_s:.6g} ms; SI units (m, N, kg, s, Pa)\n"
        "** Stack from the bottom up: " + ", ".join(shell.name for shell in shells) + "\n"
        "** Every element: layers warp, weft, warp of 1/4, 1/2, 1/4 of its thickness, each along\n"
        "** its yarns as they lie. Element type S6 is CalculiX's; Abaqus calls it STRI65.\n"
        "** Plies do not hold on to each other: tie TOP_ of one to BOTTOM_ of the next, without\n"
        "** moving nodes (ADJUST=NO), or add contact. Material, boundary and load are an example.\n"
    )


def _write_shell(file: TextIO, shell: Shell, first_node: int, first_element: int) -> None:
    name = shell.name
    last_node = first_node + len(shell.nodes) - 1
    file.write(
        f"** ----- ply {name}\n*NSET, NSET=N_{name}, GENERATE\n{first_node}, {last_node}, 1\n"
    )
    file.write(f"*ELEMENT, TYPE=S6, ELSET={name}\n")
    for number, corners in enumerate((shell.elements + first_node).tolist(), first_element):
        file.write(f"{number}, {', '.join(map(str, corners))}\n")
    file.write(f"*NSET, NSET=EDGE_{name}\n")
    file.writelines(_rows((shell.edge + first_node).tolist()))
    for side, face in (("TOP", "SPOS"), ("BOTTOM", "SNEG")):
        file.write(f"*SURFACE, NAME={side}_{name}, TYPE=ELEMENT\n{name}, {face}\n")
    for k, thickness in enumerate(shell.thickness.tolist()):
        number = first_element + k
        for family, directions in shell.directions.items():
            other = shell.directions["WEFT" if family == "WARP" else "WARP"]
            along = ", ".join(f"{x:.9g}" for x in (*directions[k], *other[k]))
            file.write(f"*ORIENTATION, NAME={family}_{number}, SYSTEM=RECTANGULAR\n{along}\n")
        file.write(f"*ELSET, ELSET=E_{number}\n{number}\n")
        file.write(f"*SHELL SECTION, ELSET=E_{number}, COMPOSITE\n")
        for family, share in LAYERS:
            file.write(f"{share * thickness:.9g}, {POINTS}, YARNS, {family}_{number}\n")


def _write_material(file: TextIO) -> None:
    file.write("** ----- example material: yarns in resin, 1 along them\n*MATERIAL, NAME=YARNS\n")
    numbers = [f"{value:.6g}" for value in MATERIAL]
    file.write("*ELASTIC, TYPE=ENGINEERING CONSTANTS\n")
    file.write(f"{', '.join(numbers[:8])}\n{numbers[8]}\n")
    file.write(f"*DENSITY\n{DENSITY:g}\n")


def _write_step(file: TextIO, shells: Sequence[Shell]) -> None:
    file.write("** ----- example: held at the plies' edges, under their own weight\n")
    file.write("*BOUNDARY\n")
    file.writelines(f"EDGE_{shell.name}, 1, 3\n" for shell in shells)
    file.write("*STEP\n*STATIC\n*DLOAD\n")
    file.writelines(f"{shell.name}, GRAV, 9.81, 0, 0, -1\n" for shell in shells)
    file.write("*NODE FILE\nU, RF\n*EL FILE\nS, E\n*END STEP\n")


def _rows(numbers: Sequence[int]) -> Iterator[str]:
    for start in range(0, len(numbers), ROW):
        yield ", ".join(map(str, numbers[start : start + ROW])) + "\n"
