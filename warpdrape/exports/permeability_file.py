"""Permeability of every triangle and of the stack, as CSV for filling codes or VTK to look at.

Rows of each ply, then of ``laminate``: the stack in the triangles of its lowest ply, with all plies
on their normals.
"""

from __future__ import annotations

import csv
import warnings
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from warpdrape.errors import InputError
from warpdrape.exports.laminate import REACH, averaged, met
from warpdrape.exports.permeability import FibreModel, Permeability, of_ply
from warpdrape.exports.table import DIGITS
from warpdrape.results.pyvista_mesh import needed
from warpdrape.results.read_run import RunReader
from warpdrape.results.result import FormedPly

LAMINATE = "laminate"
"""What the stack is called beside the plies."""


def write(
    reader: RunReader,
    out: Path,
    frames: Sequence[int],
    *,
    fibre_diameter: float | None = None,
    packing: str = "hexagonal",
    kozeny_along: float | None = None,
    kozeny_across: float | None = None,
    warp_share: float = 0.5,
) -> None:
    """Write one frame; the options are those of `FibreModel`.

    Args:
        reader: the run.
        out: the file to write; its ending says the format.
        frames: one number.
        fibre_diameter: [m].
        packing: of the fibres.
        kozeny_along: k of Kozeny-Carman, in place of Gebart's model.
        kozeny_across: likewise.
        warp_share: share of the fibres that are in the warp.
    """
    if fibre_diameter is None:
        raise InputError("permeability needs the diameter of a fibre: --set fibre_diameter=7um")
    model = FibreModel(fibre_diameter, packing, kozeny_along, kozeny_across, warp_share)
    plies = reader.result(frames[0]).plies
    parts = parts_of(plies, reader.ply_thicknesses(), model)
    {".csv": _write_csv, ".vtp": _write_vtp}[out.suffix.lower()](out, plies, parts)


def parts_of(
    plies: Sequence[FormedPly], flat_thicknesses: Sequence[float], model: FibreModel
) -> dict[str, dict[str, np.ndarray]]:
    """Columns of each ply and of the stack.

    Args:
        plies: from the bottom up.
        flat_thicknesses: of their fabrics [m].
        model: of the fibres.
    """
    thick = [
        np.full(len(ply.triangles), flat) if ply.thickness is None else np.asarray(ply.thickness)
        for ply, flat in zip(plies, flat_thicknesses, strict=True)
    ]
    every = [of_ply(ply, model) for ply in plies]
    fractions = [np.minimum(np.asarray(ply.fibre_volume_fraction), model.densest) for ply in plies]
    parts = {
        ply.name: _columns(ply, own, thickness, fraction)
        for ply, own, thickness, fraction in zip(plies, every, thick, fractions, strict=True)
    }
    if LAMINATE in parts:
        raise InputError(f"a ply is named {LAMINATE!r}, as the stack's rows are: rename it")
    base = plies[0]
    triangles = met(plies, base, REACH * float(sum(map(np.max, thick))))
    count = (triangles >= 0).sum(axis=0)
    if (count < len(plies)).any():
        warnings.warn(
            f"the laminate lacks plies in {int((count < len(plies)).sum())} of {len(count)} "
            f"triangles of {base.name}, beyond an edge or a gap: see its column plies",
            stacklevel=2,
        )
    stack, thickness = averaged(every, thick, base, triangles)
    solid = sum(
        np.where(at >= 0, t[at] * fraction[at], 0.0)
        for fraction, t, at in zip(fractions, thick, triangles, strict=True)
    )
    parts[LAMINATE] = _columns(base, stack, thickness, solid / thickness) | {"plies": count}
    return parts


def _columns(
    ply: FormedPly, own: Permeability, thickness: np.ndarray, fraction: np.ndarray
) -> dict[str, np.ndarray]:
    centers = np.asarray(ply.points)[ply.triangles].mean(axis=1)
    columns: dict[str, np.ndarray] = {"triangle": np.arange(len(centers))}
    columns |= {f"centre_{axis}_m": centers[:, k] for k, axis in enumerate("xyz")}
    columns |= {"thickness_m": thickness, "fibre_volume_fraction": fraction}
    columns |= {"porosity": 1.0 - fraction, "plies": np.ones(len(centers), int)}
    columns |= {f"k{k + 1}_m2": own.principal[:, k] for k in range(3)}
    for k in range(2):
        columns |= {f"e{k + 1}_{axis}": own.directions[:, k, i] for i, axis in enumerate("xyz")}
    tensors = own.tensors()
    for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2)):
        columns[f"k_{'xyz'[i]}{'xyz'[j]}_m2"] = tensors[:, i, j]
    return columns


def _write_csv(
    out: Path, plies: Sequence[FormedPly], parts: dict[str, dict[str, np.ndarray]]
) -> None:
    with out.open("w", encoding="utf-8", newline="") as file:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(["ply", *parts[LAMINATE]])
        for name, columns in parts.items():
            texts = [
                [f"{v:.{DIGITS}g}" if isinstance(v, float) else str(v) for v in values.tolist()]
                for values in columns.values()
            ]
            rows.writerows([name, *row] for row in zip(*texts, strict=True))


def _write_vtp(
    out: Path, plies: Sequence[FormedPly], parts: dict[str, dict[str, np.ndarray]]
) -> None:
    """All surfaces as one; ``ply`` counts them from the bottom up, the laminate is the last."""
    pyvista = needed("pyvista", "vtk")
    surfaces = [*plies, plies[0]]
    first = np.cumsum([0, *(len(ply.points) for ply in surfaces)])
    points = np.concatenate([np.asarray(ply.points) for ply in surfaces])
    triangles = np.concatenate(
        [np.asarray(ply.triangles, np.int64) + k for ply, k in zip(surfaces, first, strict=False)]
    )
    mesh = pyvista.PolyData.from_regular_faces(points, triangles)
    counts = [len(ply.triangles) for ply in surfaces]
    mesh.cell_data["ply"] = np.repeat(np.arange(len(surfaces)), counts)
    joined = {
        name: np.concatenate([columns[name] for columns in parts.values()])
        for name in parts[LAMINATE]
    }
    for k in "12":
        vectors = [joined.pop(f"e{k}_{axis}") for axis in "xyz"]
        joined[f"e{k}"] = np.stack(vectors, axis=1)
    for name, values in joined.items():
        if not name.startswith("centre"):
            mesh.cell_data[name] = values
    mesh.cell_data.active_scalars_name = "k1_m2"
    mesh.save(out)
