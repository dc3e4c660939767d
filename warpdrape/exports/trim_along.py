"""Curves that cut along a line of sight, as a drawing of the part seen from above does.

Ply and curves are laid into the plane that the line of sight stands on. There every point of a
curve lies in one triangle, unless the ply folds under itself.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from warpdrape.errors import InputError
from warpdrape.exports.on_ply import PlySearch
from warpdrape.exports.trim import AXES, MM, Curves
from warpdrape.exports.trim_curves import stepped
from warpdrape.results.result import FormedPly

STEEP = 0.02
"""Area seen of a triangle, over its own, below which it is left out: walls within 1.1° of the line
of sight. Their neighbours meet where they stood."""
SAME = 1e-9
"""Distance from a triangle up to which a point lies in it [m]."""


def seen_along(ply: FormedPly, trim: Curves) -> tuple[FormedPly, Curves]:
    """Lay a ply and curves into a plane.

    Args:
        ply: the formed ply.
        trim: curves with a line of sight.

    Returns:
        The ply as it is seen, without what is too steep, and the curves.

    Raises:
        InputError: if a curve passes where the ply folds under itself, or nothing of it is seen.
    """
    axis = AXES.index(str(trim.along))
    points = np.array(ply.points, float)
    corners = points[ply.triangles]
    areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    share = areas[:, axis] / np.linalg.norm(areas, axis=1)
    share *= np.sign(areas[:, axis].sum()) or 1.0
    points[:, axis] = 0.0
    seen, under = (
        replace(ply, points=points, triangles=np.asarray(ply.triangles)[chosen])
        for chosen in (share > STEEP, share < -STEEP)
    )
    if not len(seen.triangles):
        raise InputError(f"along = {trim.along}: {ply.name} stands on its edge; take another axis")
    loops = [np.where(np.arange(3) == axis, 0.0, loop) for loop in trim.loops]
    if len(under.triangles):
        _refuse_folds(under, loops, trim)
    return seen, replace(trim, loops=loops)


def _refuse_folds(under: FormedPly, loops: list[np.ndarray], trim: Curves) -> None:
    search = PlySearch(under)
    for loop in loops:
        points = stepped(loop)
        hidden = search.nearest(points).distance < SAME
        if hidden.any():
            place = MM * points[np.argmax(hidden)]
            where = ", ".join(
                f"{axis} = {x:.0f} mm"
                for axis, x in zip(AXES, place, strict=True)
                if axis != trim.along
            )
            raise InputError(
                f"{trim.name} passes where {under.name} folds under itself, seen along "
                f"{trim.along}, at {where}: give the curve on the ply itself, without along"
            )
