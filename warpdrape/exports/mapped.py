"""Fields of the formed plies on a structural mesh of the user's own.

From the middle of each shell a line goes out along its normal, both ways; what a ply has in the
triangle that it meets nearest is the shell's value of that ply. Yarn directions are turned into
the shell's plane and given too as angles from its first side.
"""

from __future__ import annotations

import csv
import warnings
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from warpdrape.errors import InputError, positive
from warpdrape.exports.table import DIGITS
from warpdrape.exports.through_stack import PlyLines
from warpdrape.exports.user_mesh import UserMesh, read_mesh
from warpdrape.results.fields import fields_of
from warpdrape.results.read_run import RunReader
from warpdrape.results.result import FormedPly

FARTHEST = 0.01
"""How far from a shell a ply is looked for [m], where nothing else is said."""


def write(
    reader: RunReader,
    out: Path,
    frames: Sequence[int],
    *,
    onto: str | None = None,
    unit: float = 1.0,
    farthest: float = FARTHEST,
) -> None:
    """Write one frame.

    Args:
        reader: the run.
        out: the file to write; its ending says the format.
        frames: one number.
        onto: the mesh's file.
        unit: of its lengths [m].
        farthest: distance along the normal up to which plies are looked for [m].
    """
    if onto is None:
        raise InputError("this format needs your mesh: --onto MESH, a .vtu, .stl, .inp, .bdf …")
    mesh = read_mesh(onto, positive("unit", unit, unit="m"))
    positive("farthest", farthest, unit="m")
    plies = reader.result(frames[0]).plies
    parts = {ply.name: on_mesh(ply, mesh, farthest) for ply in plies}
    _say_missing(parts, mesh, farthest)
    {".csv": _write_csv, ".vtu": _write_vtu}[out.suffix.lower()](out, mesh, parts)


def on_mesh(ply: FormedPly, mesh: UserMesh, farthest: float) -> dict[str, np.ndarray]:
    """What a ply has on each shell of a mesh: columns, NaN where it is not met.

    Args:
        ply: the formed ply.
        mesh: the mesh.
        farthest: distance along the normal up to which it is looked for [m].

    Returns:
        Its triangle (−1 for none), the way to it along the normal [m], and every field, those at
        vertices as the mean of the triangle's corners; each of shape [shell] or [shell, 3].
    """
    triangle, way = PlyLines(ply).nearest(mesh.centers, mesh.normals, farthest)
    none = triangle < 0
    columns = {"triangle": triangle, "way_m": np.where(none, np.nan, way)}
    across = np.cross(mesh.normals, mesh.sides)
    for field, values in fields_of(ply).items():
        values = values[ply.triangles].mean(axis=1) if field.at_vertices else values
        values = np.asarray(values, float)[triangle]
        if field.name in ("warp", "weft"):
            values = _into_plane(values, mesh.normals)
            angle = np.arctan2((values * across).sum(axis=1), (values * mesh.sides).sum(axis=1))
            columns[f"{field.name}_angle_deg"] = np.where(none, np.nan, np.degrees(angle))
        values = values.copy()
        values[none] = np.nan
        columns[field.column] = values
    return columns


def _into_plane(directions: np.ndarray, normals: np.ndarray) -> np.ndarray:
    flat = directions - (directions * normals).sum(axis=1, keepdims=True) * normals
    return flat / np.maximum(np.linalg.norm(flat, axis=1, keepdims=True), 1e-300)


def _say_missing(parts: dict[str, dict[str, np.ndarray]], mesh: UserMesh, farthest: float) -> None:
    count = len(mesh.shells)
    missed = {name: int((columns["triangle"] < 0).sum()) for name, columns in parts.items()}
    if all(number == count for number in missed.values()):
        raise InputError(
            f"onto: no ply is met within {1e3 * farthest:g} mm along the normals of the mesh: give "
            "it where the formed part is, its unit (--set unit=1mm), or --set farthest=20mm"
        )
    for name, number in missed.items():
        if number:
            warnings.warn(
                f"{name} is not met on {number} of {count} shells within {1e3 * farthest:g} mm: "
                "their values are empty",
                stacklevel=2,
            )


def _write_csv(out: Path, mesh: UserMesh, parts: dict[str, dict[str, np.ndarray]]) -> None:
    """A row a shell and ply."""
    names = list(dict.fromkeys(name for columns in parts.values() for name in columns))
    vectors = {n for c in parts.values() for n, values in c.items() if values.ndim == 2}
    heads = [f"{n}_{axis}" if n in vectors else n for n in names for axis in _axes(n in vectors)]
    with out.open("w", encoding="utf-8", newline="") as file:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(["element", "ply", *heads])
        for name, columns in parts.items():
            empty = np.full(len(mesh.shells), np.nan)
            table = []
            for column in names:
                values = columns.get(
                    column, np.stack([empty] * 3, 1) if column in vectors else empty
                )
                table += list(values.T) if values.ndim == 2 else [values]
            texts = [list(map(_text, values.tolist())) for values in table]
            for element, *row in zip(mesh.shells.tolist(), *texts, strict=True):
                rows.writerow([element + 1, name, *row])


def _axes(vector: bool) -> str:
    return "xyz" if vector else "x"


def _text(value: float | int) -> str:
    if isinstance(value, int):
        return str(value)
    return "" if value != value else f"{value:.{DIGITS}g}"


def _write_vtu(out: Path, mesh: UserMesh, parts: dict[str, dict[str, np.ndarray]]) -> None:
    """The whole mesh with an array a ply and field; NaN on cells that are no shells."""
    grid = mesh.grid.copy()
    for name, columns in parts.items():
        for column, values in columns.items():
            whole = np.full((grid.n_cells, *values.shape[1:]), np.nan)
            whole[mesh.shells] = values
            grid.cell_data[f"{name}_{column}"] = whole
    grid.save(out)
