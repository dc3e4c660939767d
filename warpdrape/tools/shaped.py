"""Tools of any outline: box punch, die with an opening, blank holder, double dome with its cavity.

Punches point down, their lowest point at z = 0; dies face up and blank holders down, their flats
at z = 0.
"""

from __future__ import annotations

import math

import numpy as np

from warpdrape.errors import InputError
from warpdrape.errors import length as size
from warpdrape.tools.plan import waisted, waisted_half
from warpdrape.tools.profile import Arc, Line, Piece, Surface, revolve
from warpdrape.tools.sweep import flat_inside, flat_outside, joined, sweep, turned_over

HOLDER_EDGE = 2e-3
"""Radius of the rounding at a blank holder's opening [m]."""


def box_punch(plan: list[Piece], edge_radius: float, height: float, facet: float) -> Surface:
    """A flat-bottomed punch with a rounded bottom edge.

    Args:
        plan: its outline; see `warpdrape.tools.plan`.
        edge_radius: of the rounding between bottom and wall [m]; at most the outline's corners'.
        height: from the bottom to the top [m].
        facet: facet size [m].
    """
    r = size("punch edge_radius", edge_radius)
    if size("punch height", height) <= r:
        raise InputError(f"punch height = {height} m must exceed its edge_radius {r} m")
    profile: list[Piece] = [Line((0.0, height), (0.0, r)), Arc((-r, r), r, 0.0, -0.5 * math.pi)]
    wall = sweep(plan, profile, facet)
    return joined([wall, flat_inside(plan, -r, 0.0, False, facet)])


def opening(
    plan: list[Piece], edge_radius: float, outer_radius: float, depth: float, facet: float
) -> Surface:
    """A flat die with an opening, its edge rounded.

    Args:
        plan: outline of the opening.
        edge_radius: of the rounding between flat and wall [m].
        outer_radius: of the die about the origin [m].
        depth: of the wall below the flat [m].
        facet: facet size [m].
    """
    wall = sweep(plan, _rim(edge_radius, -max(depth, 1.1 * edge_radius)), facet)
    return joined([wall, flat_outside(plan, edge_radius, outer_radius, 0.0, True, facet)])


def holder(plan: list[Piece], offset: float, outer_radius: float, facet: float) -> Surface:
    """A flat blank holder round an opening.

    Args:
        plan: outline of the die's opening.
        offset: of the holder's wall from it, outward [m]; such as the die's edge radius.
        outer_radius: of the holder about the origin [m].
        facet: facet size [m].
    """
    e, d = HOLDER_EDGE, size("holder offset", offset)
    profile: list[Piece] = [
        Arc((d + e, e), e, -0.5 * math.pi, -math.pi),
        Line((d, e), (d, 5.0 * e)),
    ]
    flat = flat_outside(plan, d + e, outer_radius, 0.0, False, facet)
    return joined([flat, sweep(plan, profile, facet)])


def double_dome(
    radius: float, distance: float, waist: float, height: float, facet: float
) -> Surface:
    """A punch of two spherical domes with a saddle between them, walls above its widest outline.

    Its lower half is a body of revolution about the line through the domes' centres, `waisted` in
    every section along it.

    Args:
        radius: of the domes [m].
        distance: between their centres, along x [m].
        waist: half the width, and the depth, of the saddle in the middle [m].
        height: from the lowest points to the top [m].
        facet: facet size [m].
    """
    if size("punch height", height) <= radius:
        raise InputError(f"punch height = {height} m must exceed the domes' radius {radius} m")
    plan = waisted(radius, distance, waist)
    wall = sweep(plan, [Line((0.0, height), (0.0, radius))], facet)
    return joined([wall, _domes(radius, distance, waist, radius, facet)])


def double_dome_cavity(
    radius: float,
    distance: float,
    waist: float,
    *,
    depth: float,
    edge_radius: float,
    outer_radius: float,
    facet: float,
) -> Surface:
    """The die that a `double_dome` punch of the same dimensions would fill.

    Args:
        radius: of the domes [m].
        distance: between their centres, along x [m].
        waist: half the width, and the depth, of the saddle in the middle [m].
        depth: of its lowest points below the flat [m].
        edge_radius: of the rounding between flat and wall [m].
        outer_radius: of the die about the origin [m].
        facet: facet size [m].
    """
    axis = radius - size("cavity depth", depth)
    if axis > -edge_radius * (1.0 - 1e-9):
        raise InputError(
            f"cavity depth = {depth:.4g} m must be at least {radius + edge_radius:.4g} m, the "
            "domes' radius and that of the die's edge"
        )
    plan = waisted(radius, distance, waist)
    rim = sweep(plan, _rim(edge_radius, axis), facet)
    flat = flat_outside(plan, edge_radius, outer_radius, 0.0, True, facet)
    bottom = turned_over(_domes(radius, distance, waist, axis, facet))
    return joined([bottom, rim, flat])


def _rim(edge_radius: float, bottom: float) -> list[Piece]:
    """Profile of a die from its wall's bottom to its flat at z = 0."""
    e = size("die edge_radius", edge_radius)
    edge = Arc((e, -e), e, math.pi, 0.5 * math.pi)
    return [edge] if bottom > -e * (1.0 + 1e-9) else [Line((0.0, bottom), (0.0, -e)), edge]


def _domes(radius: float, distance: float, waist: float, axis: float, facet: float) -> Surface:
    """Lower half of the body of revolution, its axis along x at height ``axis`` [m]."""
    profile = [_about_axis(piece) for piece in waisted_half(radius, distance, waist)]
    body = revolve(profile, facet, (math.pi, 2.0 * math.pi))
    turn = np.eye(4)[[2, 0, 1, 3]]  # z → x, x → y, y → z
    turn[2, 3] = axis
    mesh = body.mesh.copy()
    mesh.apply_transform(turn)
    return Surface(mesh, body.normals @ turn[:3, :3].T, body.exact)


def _about_axis(piece: Piece) -> Piece:
    """A piece in (x, y) as one in (r, z), r = y and z = x: mirrored, so that it turns about."""
    if isinstance(piece, Line):
        return Line(piece.start[::-1], piece.end[::-1])
    quarter = 0.5 * math.pi
    return Arc(piece.center[::-1], piece.radius, quarter - piece.start, quarter - piece.end)
