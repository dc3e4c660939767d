"""Values out of a run's USD file, checked: a damaged file is told in a sentence, whoever reads it.

No file but the one that is named is opened.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from pxr import Sdf, Tf, Usd, UsdGeom

from warpdrape.errors import InputError
from warpdrape.results.run_tables import AGAIN


def open_alone(path: Path) -> Usd.Stage:
    """Open a USD file that stands for itself; raise `InputError` where it is damaged or refers."""
    try:
        layer = Sdf.Layer.FindOrOpen(str(path))
        others = layer.GetCompositionAssetDependencies() if layer else []
        stage = Usd.Stage.Open(layer) if layer and not others else None
    except (Tf.ErrorException, MemoryError) as error:
        raise InputError(f"{path} is not a readable USD file: {AGAIN}") from error
    if others:
        raise InputError(f"{path} refers to another file, {others[0]}, which no run does: {AGAIN}")
    if stage is None:
        raise InputError(f"{path} is not a readable USD file: {AGAIN}")
    return stage


@contextmanager
def damage_named(path: Path) -> Iterator[None]:
    """Turn what the USD library says of a damaged file into one sentence."""
    try:
        yield
    except InputError:
        raise
    except (Tf.ErrorException, TypeError, ValueError, MemoryError) as error:
        raise damaged(path, "its values cannot be read") from error


def damaged(path: Path, what: str) -> InputError:
    """The error of a file that is no run's any more."""
    return InputError(f"{path} is damaged: {what}; {AGAIN}")


def numbers(path: Path, values: Any, what: str, shape: tuple[int, ...] | None) -> np.ndarray:
    """Finite numbers of a shape.

    Args:
        path: of the file.
        values: as the library gives them, None where there are none.
        what: they are, for the error.
        shape: that they must have; None for places in space, of any number.

    Raises:
        InputError: if they are not.
    """
    with np.errstate(invalid="ignore"):  # refused below
        array = np.array([] if values is None else values, np.float64)
    if shape is None:
        shape = (len(array), 3)
    if not array.size:
        raise damaged(path, f"{what} is empty")
    if array.shape != shape or not np.isfinite(array).all():
        raise damaged(path, f"{what} has shape {array.shape}, not finite numbers of {shape}")
    return array


def triangles_of(path: Path, mesh: UsdGeom.Mesh, name: str, vertices: int) -> np.ndarray:
    """Triangles of a mesh, shape [m, 3]; raise `InputError` where it has no such vertices."""
    corners = np.array(mesh.GetFaceVertexIndicesAttr().Get(), np.int32)
    if corners.ndim != 1 or corners.size % 3 or not corners.size:
        raise damaged(path, f"{name!r} has no triangles")
    if corners.min() < 0 or corners.max() >= vertices:
        raise damaged(path, f"{name!r} has triangles of vertices that it lacks")
    return corners.reshape(-1, 3)


def placed_tool(
    path: Path, mesh: UsdGeom.Mesh, name: str, time: Usd.TimeCode
) -> tuple[np.ndarray, np.ndarray]:
    """A tool's vertices at a moment [m], shape [n, 3], and its facets, shape [m, 3]."""
    points = numbers(path, mesh.GetPointsAttr().Get(time), f"{name}: points", None)
    turn = mesh.ComputeLocalToWorldTransform(time)
    matrix = numbers(path, turn, f"{name}: its transform", (4, 4))
    return points @ matrix[:3, :3] + matrix[3, :3], triangles_of(path, mesh, name, len(points))
