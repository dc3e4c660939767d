"""The formats that a run can be exported to."""

from __future__ import annotations

import re
from dataclasses import dataclass


@dataclass(frozen=True)
class Option:
    """What more a user may say of a format.

    Attributes:
        name: of it.
        kind: float or str.
        unit: of a number, empty for none.
    """

    name: str
    kind: type = str
    unit: str = ""


@dataclass(frozen=True)
class Format:
    """A format.

    Attributes:
        module: that writes it, with a function ``write(reader, out, frames)``.
        file: name of the file where none is given.
        words: what it is for, in a line.
        animated: whether all frames are written unless one is asked for; else the last one.
        single: whether it holds one frame only.
        woven: whether it is of plies that have yarns only: others are left out.
        options: what more a user may say, passed on to ``write``.
    """

    module: str
    file: str
    words: str
    animated: bool = False
    single: bool = False
    woven: bool = False
    options: tuple[Option, ...] = ()


TRIM = (Option("trim"), Option("along"))
"""Where the part ends, of flat patterns, and the axis along which a curve cuts."""
ONTO = (Option("onto"), Option("unit", float, "m"), Option("farthest", float, "m"))
"""The user's mesh, and how far from it plies lie."""
FIBRES = (
    Option("fibre_diameter", float, "m"),
    Option("packing"),
    Option("kozeny_along", float),
    Option("kozeny_across", float),
    Option("warp_share", float),
)
"""What permeability wants to know of fibres."""
FORMATS = {
    "vtk": Format("vtk", "scene.pvd", "ParaView, a .vtp for each ply and frame", animated=True),
    "vtkhdf": Format("vtkhdf", "scene.vtkhdf", "ParaView, one small file", animated=True),
    "csv": Format("table", "triangles.csv", "a row a triangle: centre, yarns, shear, strains …"),
    "parquet": Format("table", "triangles.parquet", "the same as Parquet"),
    "npz": Format("table", "triangles.npz", "the same as numpy arrays"),
    "inp": Format(
        "inp", "formed.inp", "CalculiX and Abaqus: shells with their yarns", single=True, woven=True
    ),
    "dyna": Format(
        "dyna", "formed.k", "LS-DYNA: shells with layers of their own", single=True, woven=True
    ),
    "nastran": Format(
        "nastran", "formed.bdf", "Nastran: the same as CTRIA3 and PCOMP", single=True, woven=True
    ),
    "mapped": Format(
        "mapped",
        "mapped.csv",
        "fields of the plies on your mesh, --onto MESH: a row a shell and ply",
        single=True,
        options=ONTO,
    ),
    "mapped-vtk": Format(
        "mapped", "mapped.vtu", "the same, the mesh with its fields", single=True, options=ONTO
    ),
    "permeability": Format(
        "permeability_file",
        "permeability.csv",
        "filling codes: principal values and directions of plies and stack",
        single=True,
        woven=True,
        options=FIBRES,
    ),
    "permeability-vtk": Format(
        "permeability_file",
        "permeability.vtp",
        "the same for ParaView",
        single=True,
        woven=True,
        options=FIBRES,
    ),
    "dxf": Format(
        "pattern",
        "pattern.dxf",
        "a cutter: the flat blanks, or with --trim what is kept, with yarn axes and notches",
        single=True,
        woven=True,
        options=TRIM,
    ),
    "svg": Format(
        "pattern", "pattern.svg", "the same as a drawing", single=True, woven=True, options=TRIM
    ),
}
"""By the name that a user gives."""


def format_of(name: str) -> Format:
    """Return the format of a name.

    Raises:
        InputError: if there is none; a program or a file's ending gets the formats that are for it.
    """
    from warpdrape.errors import InputError, one_of  # numpy, which `--help` does without

    asked = name.strip(". ").casefold() if isinstance(name, str) else ""
    meant = [
        known
        for known, each in FORMATS.items()
        if asked in re.findall(r"[\w-]+", f"{each.words} {each.file}".casefold())
    ]
    if meant and name not in FORMATS:
        raise InputError(f"unknown format {name!r}: for it take {' or '.join(meant)}")
    return FORMATS[one_of("format", name, FORMATS)]
