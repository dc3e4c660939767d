"""Tangent planes of the tools' smoothed surfaces, on which vertices feel them."""

import warp as wp

from .surface import CURVED, barycentric, bulge, curved_normal, is_on_edge, weighted
from .tool_facets import SINGLE, ToolSurfaces

ON_RIDGE = wp.constant(wp.float64(0.01))
"""Share of its distance by which a vertex may lie behind a facet whose ridge is nearest: rounding
to single leaves the choice between the two facets there to chance."""
ALIKE = wp.constant(wp.float64(1e-3))
"""… and at least, from a millimetre on: squares of distances are good to 10⁻⁷ of themselves."""
SAME_FACE = wp.constant(wp.float64(0.99))
"""Cosine between a vertex's plane and the surface below which, at a border, it is on the edge."""


FREE = wp.constant(0)
"""Side of a vertex that has had no plane."""
FRONT = wp.constant(1)
"""… that is in front of its facet."""
BACK = wp.constant(2)
"""… that is behind it, at an open surface."""
TURNING = wp.constant(3)
"""… that its plane's normal tells: round a border it goes from one to the other."""


@wp.struct
class ToolPlane:
    """Tangent plane of one tool near one vertex; its normal is zero where none is near."""

    normal: wp.vec3d  # outward, unit
    level: wp.float64  # of the plane along the normal, plus half the ply thickness [m]


@wp.func
def is_near(plane: ToolPlane) -> bool:
    """Whether it is the plane of a tool that is near."""
    return wp.length_sq(plane.normal) > wp.float64(0.0)


@wp.func
def plane_gap(plane: ToolPlane, at: wp.vec3d) -> wp.float64:
    """Gap [m] between a vertex's side of the ply and the plane."""
    return wp.dot(plane.normal, at) - plane.level


@wp.func
def no_plane() -> ToolPlane:
    """A plane that nothing touches."""
    plane = ToolPlane()
    plane.level = -wp.float64(1.0)
    return plane


@wp.func
def is_behind(
    side: int, border: bool, past: bool, height: wp.float64, offset: wp.float64, alike: wp.float64
) -> bool:
    """Whether a vertex meets an open surface from behind, or has gone over its border.

    Args:
        side: on which it was held, as of `tangent_plane`.
        border: whether a border is nearest.
        past: whether it lies beyond that by more than half the ply thickness.
        height: over the surface [m].
        offset: half the ply thickness [m].
        alike: cosine between the plane that held it and the surface [-].
    """
    zero = wp.float64(0.0)
    if side == FREE:
        return height < -offset or (past and height < zero)
    if border and alike < SAME_FACE:
        return True
    return side == BACK or (side == TURNING and alike < zero)


@wp.func
def tangent_plane(
    surfaces: ToolSurfaces,
    tool: int,
    facet: int,
    at: wp.vec3d,
    offset: wp.float64,
    near: wp.float64,
    ahead: wp.float64,
    side: int,
    before: ToolPlane,
):
    """Tangent plane of the smoothed surface near ``at``, the distance from the facet [m], the side.

    A surface with borders has a back: a vertex that comes from behind meets it there, half the ply
    thickness away, and stays on its side from facet to facet, however these bend. A border is a
    rounded edge: a flat end would push at once what comes from aside.

    Args:
        surfaces: the tools' facets.
        tool: number of the tool.
        facet: the nearest one, in ``surfaces``.
        at: position in the tool's frame [m].
        offset: half the ply thickness [m].
        near: distance within which a vertex counts as near [m].
        ahead: farther distance that it may go before the next search [m].
        side: `FRONT`, `BACK` or `TURNING` as the vertex was held before, `FREE` if it was not.
        before: the plane that held it.
    """
    a = surfaces.corners[facet, 0]
    b = surfaces.corners[facet, 1]
    c = surfaces.corners[facet, 2]
    na = surfaces.normals[facet, 0]
    nb = surfaces.normals[facet, 1]
    nc = surfaces.normals[facet, 2]
    w = barycentric(a, b, c, at)
    flat = weighted(w, a, b, c)
    normal = wp.normalize(weighted(w, na, nb, nc))
    point = flat
    if surfaces.exact[tool] == 1:
        corners = wp.matrix_from_rows(a, b, c)
        at_corners = wp.matrix_from_rows(na, nb, nc)
        point = flat + CURVED * bulge(corners, at_corners, w)
        normal = curved_normal(corners, at_corners, w, CURVED)
    zero = wp.float64(0.0)
    distance = wp.length(at - flat)
    height = wp.dot(normal, at - point)
    gap = height - offset
    aside = wp.length_sq(at - point) - height * height
    border = is_on_edge(w, surfaces.borders[facet])
    chance = wp.min(wp.max(SINGLE, ALIKE * distance), ON_RIDGE * distance)
    outside = height >= -chance and wp.length_sq(at - point) > zero
    ridge = is_on_edge(w, surfaces.ridges[facet])
    if outside and ridge:
        height = wp.length(at - point)
        normal = (at - point) / height  # round a ridge, which both of its facets see alike
        gap = height - offset
    past = border and aside > offset * offset
    plane = no_plane()
    in_sight = distance - surfaces.sag[tool] <= near + ahead
    if surfaces.open[tool] == 1:
        alike = wp.dot(before.normal, normal)  # 1 while the vertex stays on its face
        if is_behind(side, border, past, height, offset, alike):
            if (border or ridge) and distance > zero:
                normal = (at - flat) / distance
            else:
                normal = -normal
            if in_sight:
                plane.normal = normal
                plane.level = wp.dot(normal, point) + offset
            return plane, distance, wp.where(border, TURNING, BACK)
    if border and height > zero and aside > zero:  # round the border, from the front too
        normal = wp.normalize(at - point)
        gap = wp.length(at - point) - offset
        past = False
    behind = gap < -near and side == FREE  # an open surface, not pressed into it
    if not past and not behind and (in_sight or gap < zero):
        plane.normal = normal
        plane.level = wp.dot(normal, point) + offset
    return plane, distance, wp.where(border, TURNING, FRONT)
