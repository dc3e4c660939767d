"""Why a mesh file could not be read, in words that say what to do."""

from __future__ import annotations

import os

FORMATS = "STL, OBJ, PLY, OFF or GLB"
"""What can be read with the packages that are installed along; others need one more."""


def why_unreadable(path: str | os.PathLike, error: Exception) -> str:
    """The cause that a reader of trimesh gave, and the remedy.

    Args:
        path: the file.
        error: what was raised: readers raise whatever theirs raise.
    """
    kind = os.path.splitext(os.fspath(path))[1]
    if isinstance(error, ImportError):
        package = getattr(error, "name", None)
        needs = f"the Python package {package!r}" if package else f"one more package ({error})"
        return f"{kind} files need {needs}: install it, or save the mesh as {FORMATS}"
    return f"{error or type(error).__name__}; save it as {FORMATS}"
