"""Formed plies cut where the part ends, mapped back to the flat blank.

Within a triangle the ply is the image of the blank by one linear map, so that a point of it keeps
its weights of the corners there.
"""

from __future__ import annotations

import numpy as np

from warpdrape.blanks.loops import loop_area
from warpdrape.errors import InputError
from warpdrape.exports.outlines import border_loops, inside, nested, without_straight
from warpdrape.exports.trim import MM, Curves, Side
from warpdrape.exports.trim_along import seen_along
from warpdrape.exports.trim_curves import on_blank
from warpdrape.exports.trim_side import on_side
from warpdrape.results.result import FormedPly

FINE = 5e-3
"""How far a pattern's line may lie off the points found [mm]."""
LEAST = 1.0
"""Area below which a pattern is none [mm²]."""


def trimmed(ply: FormedPly, trim: Side | Curves) -> list[np.ndarray]:
    """Outlines of what is kept of a ply, on the flat blank [mm], holes clockwise.

    Args:
        ply: the formed ply.
        trim: where to cut.

    Raises:
        InputError: if nothing is kept, or the curve lies too far from the ply.
    """
    loops = on_side(ply, trim) if isinstance(trim, Side) else _inside_curves(ply, trim)
    loops = nested([without_straight(loop, FINE) for loop in loops if len(loop) > 2])
    if sum(map(loop_area, loops)) < LEAST:
        raise InputError(
            f"trim keeps nothing of {ply.name}: give the other side, or the run's coordinates"
        )
    return loops


def _inside_curves(ply: FormedPly, trim: Curves) -> list[np.ndarray]:
    """The curves on the flat blank [mm], and holes of the blank that lie inside them."""
    loops = on_blank(*((ply, trim) if trim.along is None else seen_along(ply, trim)))
    borders = border_loops(np.asarray(ply.triangles).tolist())
    flat = [MM * np.asarray(ply.rest_points)[border, :2] for border in borders]
    return loops + [hole for hole in flat if loop_area(hole) < 0.0 and inside(hole, loops).all()]
