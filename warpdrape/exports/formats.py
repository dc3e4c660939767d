"""The formats that a run can be exported to."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Format:
    """A format.

    Attributes:
        module: that writes it, with a function ``write(reader, out, frames)``.
        file: name of the file where none is given.
        words: what it is for, in a line.
        animated: whether all frames are written unless one is asked for; else the last one.
        single: whether it holds one frame only.
        options: names of what more a user may say, passed on to ``write``.
    """

    module: str
    file: str
    words: str
    animated: bool = False
    single: bool = False
    options: tuple[str, ...] = ()


FORMATS = {
    "vtk": Format("vtk", "scene.pvd", "ParaView, a .vtp for each ply and frame", animated=True),
    "vtkhdf": Format("vtkhdf", "scene.vtkhdf", "ParaView, one small file", animated=True),
    "csv": Format("table", "triangles.csv", "a row a triangle: centre, yarns, shear, strains …"),
    "parquet": Format("table", "triangles.parquet", "the same as Parquet"),
    "npz": Format("table", "triangles.npz", "the same as numpy arrays"),
    "inp": Format("inp", "formed.inp", "CalculiX and Abaqus: shells with their yarns", single=True),
    "dxf": Format(
        "pattern",
        "pattern.dxf",
        "a cutter: the flat blanks, or with --trim what is kept, with yarn axes and notches",
        single=True,
        options=("trim",),
    ),
    "svg": Format(
        "pattern", "pattern.svg", "the same as a drawing", single=True, options=("trim",)
    ),
}
"""By the name that a user gives."""
