"""The part of a formed ply on one side of a plane, on the flat blank."""

from __future__ import annotations

import warnings

import numpy as np

from warpdrape.exports.outlines import border_loops
from warpdrape.exports.trim import MM, Side
from warpdrape.results.result import FormedPly


def on_side(ply: FormedPly, side: Side) -> list[np.ndarray]:
    """Loops round what lies on a side of a plane, points on the plane included [mm].

    Args:
        ply: the formed ply.
        side: what is kept.
    """
    above = np.asarray(ply.points) @ side.normal - side.limit
    flat = [tuple(point) for point in MM * np.asarray(ply.rest_points)[:, :2]]
    if above.max() <= 0.0:
        warnings.warn(f"trim takes nothing off {ply.name}: all of it is kept", stacklevel=2)
    crossings: dict[tuple[int, int], int] = {}

    def crossing(a: int, b: int) -> int:
        low, high = min(a, b), max(a, b)
        if (low, high) not in crossings:
            share = above[low] / (above[low] - above[high])
            start, end = np.array(flat[low]), np.array(flat[high])
            crossings[low, high] = len(flat)
            flat.append(tuple(start + share * (end - start)))
        return crossings[low, high]

    faces = []
    for corners in np.asarray(ply.triangles).tolist():
        face = []
        for a, b in zip(corners, [*corners[1:], corners[0]], strict=True):
            if above[a] <= 0.0:
                face.append(a)
            if (above[a] <= 0.0) != (above[b] <= 0.0):
                face.append(crossing(a, b))
        if face:
            faces.append(face)
    places = np.array(flat)
    return [places[loop] for loop in border_loops(faces)]
