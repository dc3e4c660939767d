"""A table with a row a triangle, as CSV, Parquet or numpy arrays.

What a run has at vertices is the mean of a triangle's corners here. Where a ply has no such
quantity the cell is empty (CSV), null (Parquet) or NaN (numpy).
"""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from warpdrape.results.fields import FIELDS, Field, fields_of
from warpdrape.results.pyvista_mesh import needed
from warpdrape.results.read_run import RunReader
from warpdrape.results.result import FormedPly

DIGITS = 9
"""Significant digits of a number in CSV: all that single precision has."""


def write(reader: RunReader, out: Path, frames: Sequence[int]) -> None:
    """Write frames below each other.

    Args:
        reader: the run.
        out: the file to write; its ending says the format.
        frames: their numbers.
    """
    kind = out.suffix.lower()
    if kind == ".parquet":
        needed("pyarrow.parquet", "tables")
    parts = []
    for frame in frames:
        result = reader.result(frame)
        for ply in result.plies:
            counts = {"frame": frame, "time_s": result.time_s, "ply": ply.name}
            m = len(ply.triangles)
            parts.append({name: np.full(m, value) for name, value in counts.items()} | _rows(ply))
    columns = _joined(parts)
    {".csv": _write_csv, ".parquet": _write_parquet, ".npz": _write_npz}[kind](out, columns)


def _rows(ply: FormedPly) -> dict[str, np.ndarray]:
    """Columns of one ply, each of shape [triangle]."""
    corners, flat = ply.points[ply.triangles], ply.rest_points[ply.triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    columns = {"triangle": np.arange(len(ply.triangles))}
    for name, place in (("centre", corners.mean(axis=1)), ("rest_centre", flat.mean(axis=1))):
        columns |= {f"{name}_{axis}_m": place[:, k] for k, axis in enumerate("xyz")}
    columns["area_m2"] = 0.5 * np.linalg.norm(normal, axis=1)
    for field, values in fields_of(ply).items():
        if field.at_vertices:
            values = values[ply.triangles].mean(axis=1)
        names = _names(field)
        columns |= dict(zip(names, values.reshape(-1, len(names)).T, strict=True))
    return columns


def _names(field: Field) -> list[str]:
    """Columns of a quantity: one, or one a component."""
    if not field.vector:
        return [field.column]
    ending = field.column.removeprefix(field.name)
    return [f"{field.name}_{axis}{ending}" for axis in "xyz"]


def _joined(parts: Sequence[dict[str, np.ndarray]]) -> dict[str, np.ndarray]:
    """Parts of a table below each other, with NaN for columns that a part lacks."""
    quantities = [name for field in FIELDS for name in _names(field)]
    order = [name for name in parts[0] if name not in quantities] + quantities
    there = [name for name in order if any(name in part for part in parts)]
    return {
        name: np.concatenate(
            [part.get(name, np.full(len(part["triangle"]), np.nan)) for part in parts]
        )
        for name in there
    }


def _write_csv(out: Path, columns: dict[str, np.ndarray]) -> None:
    texts = [list(map(_text, values.tolist())) for values in columns.values()]
    with out.open("w", encoding="utf-8", newline="") as file:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(columns)
        rows.writerows(zip(*texts, strict=True))


def _text(value: float | int | str) -> str:
    if isinstance(value, float):
        return "" if value != value else f"{value:.{DIGITS}g}"
    return str(value)


def _write_parquet(out: Path, columns: dict[str, np.ndarray]) -> None:
    pyarrow = needed("pyarrow", "tables")
    parquet = needed("pyarrow.parquet", "tables")
    arrays = {
        name: pyarrow.array(values, from_pandas=True)  # NaN becomes null
        if values.dtype.kind == "f"
        else pyarrow.array(values.tolist())
        for name, values in columns.items()
    }
    parquet.write_table(pyarrow.table(arrays), out)


def _write_npz(out: Path, columns: dict[str, np.ndarray]) -> None:
    with out.open("wb") as file:
        arrays: Any = columns
        np.savez_compressed(file, **arrays)
