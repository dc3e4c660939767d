"""VTKHDF for ParaView: one compressed file, all plies as one surface that moves.

``ply`` tells the plies apart, counted from the bottom up; tools are left out. Triangles are stored
once, points and fields in single precision, as in the USD file. The layout is VTKHDF 2.2's temporal
``PolyData``; a collection of plies would be nearer, but VTK 9.7 does not follow the time of those.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from warpdrape.results.fields import FIELDS, fields_of
from warpdrape.results.pyvista_mesh import needed
from warpdrape.results.read_run import RunReader

if TYPE_CHECKING:
    from h5py import Group

    from warpdrape.results.result import FormedPly

VERSION = (2, 2)
_KINDS = ("Vertices", "Lines", "Polygons", "Strips")  # in the order of the format's offsets


def write(reader: RunReader, out: Path, frames: Sequence[int]) -> None:
    """Write frames.

    Args:
        reader: the run.
        out: the file to write.
        frames: their numbers.
    """
    h5py = needed("h5py", "vtk")
    with h5py.File(out, "w") as file:
        root = file.create_group("VTKHDF")
        root.attrs["Version"] = np.array(VERSION, np.int64)
        root.attrs.create("Type", np.bytes_("PolyData"))
        times: list[float] = []
        for frame in frames:
            result = reader.result(frame)
            if not times:
                _write_triangles(root, result.plies)
            times.append(result.time_s)
            for name, values in _arrays(result.plies).items():
                _append(root, name, values)
        _write_steps(root, times)


def _arrays(plies: Sequence[FormedPly]) -> dict[str, np.ndarray]:
    """Points and fields of all plies, one below the other; NaN where a ply has no such field."""
    arrays = {"Points": np.concatenate([ply.points for ply in plies])}
    found = [fields_of(ply) for ply in plies]
    for field in FIELDS:
        if not any(field in own for own in found):
            continue
        shapes = [field.shape(len(ply.points), len(ply.triangles)) for ply in plies]
        parts = [
            own.get(field, np.full(shape, np.nan)) for own, shape in zip(found, shapes, strict=True)
        ]
        data = "PointData" if field.at_vertices else "CellData"
        arrays[f"{data}/{field.column}"] = np.concatenate(parts)
    return arrays


def _write_triangles(root: Group, plies: Sequence[FormedPly]) -> None:
    """Write what stays: the triangles, whose they are, and the flat blanks."""
    counts = [len(ply.points) for ply in plies]
    first = np.concatenate([[0], np.cumsum(counts)[:-1]])
    triangles = np.concatenate([p.triangles + k for p, k in zip(plies, first, strict=True)])
    root["NumberOfPoints"] = np.array([sum(counts)], np.int64)
    for kind in _KINDS:
        corners = triangles if kind == "Polygons" else np.empty((0, 3))
        cells = root.create_group(kind)
        cells["NumberOfCells"] = np.array([len(corners)], np.int64)
        cells["NumberOfConnectivityIds"] = np.array([corners.size], np.int64)
        cells["Offsets"] = np.arange(0, corners.size + 1, 3, dtype=np.int64)
        cells["Connectivity"] = corners.ravel().astype(np.int64)
    numbers = np.arange(len(plies), dtype=np.int32)
    root["CellData/ply"] = np.repeat(numbers, [len(ply.triangles) for ply in plies])
    rest = np.concatenate([ply.rest_points for ply in plies])
    root["PointData/rest_points_m"] = rest.astype(np.float32)


def _append(root: Group, name: str, values: np.ndarray) -> None:
    """Add the values of a step below those of the step before."""
    values = np.asarray(values, np.float32)
    if name not in root:
        options = {"chunks": values.shape, "compression": "gzip", "shuffle": True}
        root.create_dataset(name, data=values, maxshape=(None, *values.shape[1:]), **options)
        return
    dataset = root[name]
    before = len(dataset)
    dataset.resize(before + len(values), axis=0)
    dataset[before:] = values


def _write_steps(root: Group, times: Sequence[float]) -> None:
    """Write the times [s] of the steps, and where the values of each begin."""
    count = len(times)
    points = int(root["NumberOfPoints"][0])
    triangles = int(root["Polygons/NumberOfCells"][0])
    steps = root.create_group("Steps")
    steps.attrs["NSteps"] = np.int64(count)
    steps["Values"] = np.array(times)
    steps["PartOffsets"] = np.zeros(count, np.int64)
    steps["NumberOfParts"] = np.ones(count, np.int64)
    steps["PointOffsets"] = points * np.arange(count)
    for name in ("CellOffsets", "ConnectivityIdOffsets"):
        steps[name] = np.zeros((count, len(_KINDS)), np.int64)
    for data, length in (("PointData", points), ("CellData", triangles)):
        offsets = steps.create_group(f"{data}Offsets")
        for name, array in root[data].items():
            moves = len(array) == length * count
            offsets[name] = length * np.arange(count) if moves else np.zeros(count, np.int64)
