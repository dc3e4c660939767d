"""Plan outlines of tools: closed curves of lines and arcs in x, y, counter-clockwise seen from +z.

Pieces are tangent where they meet, so that what is swept along them is smooth.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from warpdrape.errors import InputError
from warpdrape.errors import length as size
from warpdrape.tools.profile import Arc, Line, Piece

FLAT = 1e-9
"""Length below which a side is none, over the outline's size [-]."""


def rounded_polygon(points: Sequence[Sequence[float]], radius: float) -> list[Piece]:
    """A convex polygon with round corners.

    Args:
        points: corners before rounding, counter-clockwise [m], shape [n, 2].
        radius: of the corners [m].

    Raises:
        InputError: if it is not convex and counter-clockwise, or the radius leaves no side.
    """
    size("corner radius", radius)
    corners = np.asarray(points, dtype=float)
    sides = np.roll(corners, -1, axis=0) - corners
    lengths = np.linalg.norm(sides, axis=1)
    along = sides / lengths[:, None]
    before = np.roll(along, 1, axis=0)
    turns = np.arctan2(
        before[:, 0] * along[:, 1] - before[:, 1] * along[:, 0], (before * along).sum(axis=1)
    )
    if turns.min() <= 0.0 or not math.isclose(turns.sum(), 2.0 * math.pi):
        raise InputError("an outline's corners must be convex and go round counter-clockwise")
    cut = radius * np.tan(0.5 * turns)
    both = cut + np.roll(cut, -1)
    if (both - lengths).max() > FLAT * lengths.max():
        raise InputError(
            f"corner radius = {radius:.4g} m does not fit into the outline: at most "
            f"{radius * (lengths / both).min():.4g} m"
        )
    starts, ends = corners - before * cut[:, None], corners + along * cut[:, None]
    pieces: list[Piece] = []
    for k, turn in enumerate(turns):
        tx, ty = before[k]
        center = starts[k] + radius * np.array([-ty, tx])
        first = math.atan2(-tx, ty)
        pieces.append(Arc((float(center[0]), float(center[1])), radius, first, first + turn))
        if lengths[k] - both[k] > FLAT * lengths.max():
            (x, y), (u, v) = ends[k].tolist(), starts[(k + 1) % len(corners)].tolist()
            pieces.append(Line((x, y), (u, v)))
    return pieces


def rounded_rectangle(length: float, width: float, radius: float) -> list[Piece]:
    """A rectangle with round corners, centred at the origin.

    Args:
        length: along x [m].
        width: along y [m].
        radius: of the corners [m].
    """
    x, y = 0.5 * size("length", length), 0.5 * size("width", width)
    return rounded_polygon([(-x, -y), (x, -y), (x, y), (-x, y)], radius)


def waist_radius(radius: float, distance: float, waist: float) -> float:
    """Radius of the hollow arcs of a `waisted` outline [m]; infinite where its sides are straight.

    An arc that touches both ends from outside and comes within ``waist`` of the middle: with a half
    the distance, (waist + q)² + a² = (radius + q)².

    Raises:
        InputError: if there is no such outline.
    """
    a = 0.5 * size("distance", distance)
    size("radius", radius)
    narrower = radius - size("waist", waist)
    if narrower < -FLAT * radius:
        raise InputError(f"waist = {waist:.4g} m must not exceed the ends' radius, {radius:.4g} m")
    if narrower < FLAT * radius:
        return math.inf
    hollow = (a * a + waist * waist - radius * radius) / (2.0 * narrower)
    if hollow <= 0.0:
        least = math.sqrt(radius * radius - a * a)
        raise InputError(
            f"waist = {waist:.4g} m lies within the ends: they are {2.0 * least:.4g} m across in "
            f"the middle; take more than {least:.4g} m, or a larger distance"
        )
    return hollow


def waisted(radius: float, distance: float, waist: float) -> list[Piece]:
    """Two round ends with a waist between them, along x, centred at the origin.

    Args:
        radius: of the ends [m].
        distance: between the centres of the ends [m].
        waist: half the width in the middle [m]; the radius for straight sides.
    """
    upper = waisted_half(radius, distance, waist)
    return upper + [_turned_half_round(piece) for piece in upper]


def waisted_half(radius: float, distance: float, waist: float) -> list[Piece]:
    """The half of a `waisted` outline with y > 0, from its right tip to its left one."""
    hollow, a = waist_radius(radius, distance, waist), 0.5 * distance
    quarter = 0.5 * math.pi
    between: Piece
    if math.isinf(hollow):
        turn, between = 0.0, Line((a, radius), (-a, radius))
    else:
        beside = waist + hollow
        turn = math.atan2(a, beside)  # how far the ends go round beyond a half circle
        between = Arc((0.0, beside), hollow, turn - quarter, -turn - quarter)
    return [
        Arc((a, 0.0), radius, 0.0, quarter + turn),
        between,
        Arc((-a, 0.0), radius, quarter - turn, 2.0 * quarter),
    ]


def _turned_half_round(piece: Piece) -> Piece:
    def opposite(point: tuple[float, float]) -> tuple[float, float]:
        return (-point[0], -point[1])

    if isinstance(piece, Line):
        return Line(opposite(piece.start), opposite(piece.end))
    half = math.pi
    return Arc(opposite(piece.center), piece.radius, piece.start + half, piece.end + half)
