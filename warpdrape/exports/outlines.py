"""Outlines in the plane: borders of meshes, what lies in what, and no more corners than needed."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
import shapely

from warpdrape.blanks.loops import closed_loops, loop_area

STRAIGHT = 1e-3
"""Distance from the line between corners below which a vertex is left out [mm]."""


def border_loops(faces: Iterable[Sequence[int]]) -> list[np.ndarray]:
    """Vertices of the border, loop by loop, the sheet on their left.

    Args:
        faces: vertices of triangles or polygons, all the same way round.
    """
    ends = [(a, b) for face in faces for a, b in zip(face, [*face[1:], face[0]], strict=True)]
    inner = {(b, a) for a, b in ends}
    return closed_loops((a, b) for a, b in ends if (a, b) not in inner)


def inside(points: np.ndarray, loops: Sequence[np.ndarray]) -> np.ndarray:
    """Whether points lie inside, that is across an odd number of lines from far away, shape [k].

    Args:
        points: shape [k, 2].
        loops: closed, each shape [n, 2].
    """
    odd = np.zeros(len(points), bool)
    for loop in loops:
        odd ^= shapely.contains_xy(shapely.Polygon(loop), *np.asarray(points).T)
    return odd


def nested(loops: Sequence[np.ndarray]) -> list[np.ndarray]:
    """The same loops, outer ones anticlockwise and holes clockwise."""
    turned = []
    for k, loop in enumerate(loops):
        others = [*loops[:k], *loops[k + 1 :]]
        hole = bool(inside(loop[:1], others)[0])
        turned.append(loop if (loop_area(loop) < 0.0) == hole else loop[::-1])
    return turned


def without_straight(loop: np.ndarray, straight: float = STRAIGHT) -> np.ndarray:
    """A loop [mm] without the vertices that lie on the line from one corner to the next.

    Args:
        loop: shape [n, 2].
        straight: how far from the line counts as on it [mm].
    """
    first = np.lexsort((loop[:, 1], loop[:, 0]))[0]  # an outermost one, so a corner
    loop = np.roll(loop, -first, axis=0)
    closed = np.concatenate([loop, loop[:1]])
    kept = [0]
    for k in range(1, len(loop)):
        along = closed[k + 1] - closed[kept[-1]]
        to = closed[kept[-1] + 1 : k + 1] - closed[kept[-1]]
        off = np.abs(along[0] * to[:, 1] - along[1] * to[:, 0])
        if (off > straight * np.hypot(*along)).any():
            kept.append(k)
    return loop[kept]
