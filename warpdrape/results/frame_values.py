"""A frame of the animation in single precision: every value checked before any is written."""

from __future__ import annotations

from dataclasses import fields

import numpy as np
from numpy.typing import ArrayLike, NDArray

from warpdrape.results.frame_data import PlyFrame
from warpdrape.results.shading import ply_normals
from warpdrape.results.shear_colors import shear_color
from warpdrape.results.usd_stage import (
    MAY_BE_EMPTY,
    VERTEX_PRIMVARS,
    MeshPrim,
    extent,
)


def checked(label: str, quantity: str, values: ArrayLike, shape: tuple[int, ...]) -> NDArray:
    """Return values as an array; raise ValueError where its shape is another, or one not finite."""
    values = np.asarray(values)
    if values.shape != shape:
        raise ValueError(f"{label}: {quantity} has shape {values.shape}, must be {shape}")
    finite = np.isfinite(values)
    if not finite.all():
        bad = ~finite
        first = int(np.argwhere(bad)[0, 0])
        raise ValueError(
            f"{label}: {quantity} has {int(bad.sum())} non-finite values, the first at {first}; "
            "the frame was not written"
        )
    return values


def frame_values(mesh: MeshPrim, frame: PlyFrame) -> dict[str, NDArray]:
    """Return a frame's values by field name, checked, with colour, extent and normals added.

    Args:
        mesh: of the ply.
        frame: the moment.

    Raises:
        ValueError: naming ply and quantity where one is not finite, or its shape is wrong.
    """
    n, m = len(mesh.points), len(mesh.triangles)
    shapes: dict[str, tuple[int, ...]] = {"points": (n, 3), "warp": (m, 3), "weft": (m, 3)}
    with np.errstate(over="ignore"):  # an overflow becomes infinite and is refused below
        values = {
            f.name: np.asarray(getattr(frame, f.name), np.float64).astype(np.float32)
            for f in fields(PlyFrame)
            if getattr(frame, f.name) is not None
        }
    shapes |= dict.fromkeys(VERTEX_PRIMVARS, (n,)) | {"slip": (n, 3)}
    for name, value in values.items():
        checked(mesh.label, name, value, shapes.get(name, (m,)))
    for name in MAY_BE_EMPTY:
        values.setdefault(name, np.zeros(0, np.float32))
    values["color"] = shear_color(values["shear_angle_deg"])
    values["extent"] = extent(values["points"])
    values["normals"] = ply_normals(values["points"], mesh.triangles)
    return values
