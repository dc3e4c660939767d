"""What mesh files are: units that they may be in; why one could not be read, and what to do."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import trimesh

FORMATS = "STL, OBJ, PLY, OFF or GLB"
"""What can be read with the packages that are installed along; others need `MORE`."""

MORE = "trimesh[easy]"
"""What brings the packages for the other formats, such as 3MF and DAE."""

UNITS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "inch": 25.4e-3}
"""Units of length that a mesh or a drawing may be said to be in → metres."""

FARTHEST = 1e9
"""Largest coordinate, in the file's unit, beyond which vertices cannot be compared to 1e-8."""


def why_unreadable(path: str | os.PathLike, error: Exception) -> str:
    """The cause that a reader of trimesh gave, and the remedy.

    Args:
        path: the file.
        error: what was raised: readers raise whatever theirs raise.
    """
    kind = os.path.splitext(os.fspath(path))[1]
    if isinstance(error, ImportError):
        package = getattr(error, "name", None)
        lacking = f"the Python package {package!r}" if package else f"one more package ({error})"
        return f"{kind} files need {lacking}: pip install {MORE!r}, or save the mesh as {FORMATS}"
    return f"{error or type(error).__name__}; save it as {FORMATS}"


def fault_of(mesh: trimesh.Trimesh) -> str:
    """What makes a mesh unusable that was read from a damaged file, in words; empty for nothing."""
    vertices, facets = np.asarray(mesh.vertices), np.asarray(mesh.faces)
    if vertices.ndim != 2 or vertices.shape[1] != 3 or facets.ndim != 2 or facets.shape[1] != 3:
        return "holds other things than triangles in space: save it as triangles"
    finite = vertices[np.isfinite(vertices)]
    if np.abs(finite).max(initial=0.0) > FARTHEST:
        return f"reaches {np.abs(finite).max():.4g}: repair it, or give another unit"
    outside = ((facets < 0) | (facets >= len(vertices))).any(axis=1)
    if outside.any():
        at = int(np.argmax(outside))
        return f"has a facet, number {at}, of vertices that it does not have: repair it"
    return ""
