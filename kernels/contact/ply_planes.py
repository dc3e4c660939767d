"""Tangent planes of plies at vertices of others: which side, what room, and beyond borders."""

import warp as wp

from .facets import NearestFacet, PlyFacets, is_at_border, is_on_side
from .surface import facet_slope, weighted


@wp.struct
class PlyPlane:
    """Tangent plane of a ply near a vertex of another."""

    normal: wp.vec3d  # towards the vertex's side
    gap: wp.float64  # m
    rise: wp.float64  # of the plane over the nearest point, less the thickness [m]
    height: wp.float64  # of the vertex over the ply's mid-surface, room in the hollow included [m]
    beyond: wp.int32  # 1 past the ply's border, 2 where it is left alone there
    across: wp.int32  # 1 on the other side than the stacking order says, 2 undecided


@wp.func
def plane_of(
    facets: PlyFacets,
    nearest: NearestFacet,
    side: wp.float64,
    thickness: wp.float64,
    x: wp.array(dtype=wp.vec3d),
    normals: wp.array(dtype=wp.vec3d),
    hollows: wp.array(dtype=wp.vec2d),
) -> PlyPlane:
    """Plane of a ply at the place nearest to a vertex.

    The gap is the distance to the facet. On the hollow side of a bent ply there is room besides for
    the arcs that its chords cut off: else a vertex of the inner ply would lift the chords of the
    outer one. Beyond a border the surface goes on flat for a thickness, then as a ramp of 45° down
    past the mid-surface, so that a vertex that has slid off climbs back onto the right side.

    Args:
        facets: of all plies.
        nearest: the place.
        side: +1 for a vertex above the ply, −1 for one below.
        thickness: of the mid-surfaces in contact [m].
        x: positions [m], shape [vertex].
        normals: unit vertex normals, shape [vertex].
        hollows: room on the hollow sides, above and below [m], shape [vertex].
    """
    plane = PlyPlane()
    corners = facets.corners[nearest.facet]
    a = corners[0]
    b = corners[1]
    c = corners[2]
    w = nearest.weights
    offset = nearest.offset
    outward = side * wp.normalize(weighted(w, normals[a], normals[b], normals[c]))
    height = wp.dot(offset, outward)
    aside = offset - height * outward
    beyond = wp.length(aside)
    face = wp.where(side > wp.float64(0.0), 0, 1)
    room = wp.vec3d(hollows[a][face], hollows[b][face], hollows[c][face])
    over = thickness - wp.dot(w, room)
    plane.height = height + wp.dot(w, room)
    plane.normal = outward
    plane.gap = height - over
    if is_at_border(facets, nearest) and beyond > wp.float64(0.0):
        plane.beyond = 1
        if height < -wp.float64(0.5) * thickness:
            plane.beyond = 2
        if beyond > thickness:
            plane.normal = wp.normalize(outward + aside / beyond)
            plane.gap = (height + beyond - over - thickness) * wp.dot(plane.normal, outward)
    else:
        distance = wp.length(offset)
        if not is_on_side(facets, nearest, side, x):
            distance = -distance
        plane.height = distance + wp.dot(w, room)
        straight = outward
        if wp.abs(distance) > wp.float64(1.0e-3) * thickness:
            straight = offset / distance
        plane.normal = wp.normalize(straight + facet_slope(x[a], x[b], x[c], w, room))
        plane.gap = distance - over
    plane.rise = wp.dot(plane.normal, offset) - plane.gap - thickness
    return plane


@wp.func
def is_same_place(asked: NearestFacet, walked: NearestFacet, thickness: wp.float64) -> bool:
    """Whether a vertex sees the place that it has seen so far, and none on another fold."""
    return wp.length(asked.offset - walked.offset) < wp.float64(0.1) * thickness


@wp.func
def plane_on_side(
    facets: PlyFacets,
    nearest: NearestFacet,
    side: wp.float64,
    before: int,
    through: bool,
    thickness: wp.float64,
    x: wp.array(dtype=wp.vec3d),
    normals: wp.array(dtype=wp.vec3d),
    hollows: wp.array(dtype=wp.vec2d),
) -> PlyPlane:
    """Plane of a ply on the side on which a vertex lies.

    A vertex changes sides past the ply's border, once it is a thickness beyond the mid-surface and
    so touches neither side. One that comes in sight, or back from where it was left alone, takes
    the side into which it reaches less deep: room in a hollow makes no vertex that has come over a
    border lie on the other side of the ply. So does one that lies more than a thickness behind the
    mid-surface without having gone through it: a walk has come round a fold.

    Args:
        facets: of all plies.
        nearest: the place.
        side: +1 for a vertex that the stacking order puts above the ply, −1 for one below.
        before: 0 if it lay in the stacking order at the last search, 1 across, 2 if undecided.
        through: whether it has been pressed through the mid-surface.
        thickness: of the mid-surfaces in contact [m].
        x: positions [m], shape [vertex].
        normals: unit vertex normals, shape [vertex].
        hollows: room on the hollow sides, above and below [m], shape [vertex].
    """
    across = before % 2
    side_now = wp.where(across == 1, -side, side)
    plane = plane_of(facets, nearest, side_now, thickness, x, normals, hollows)
    far = plane.height < -thickness and (plane.beyond > 0 or not through)
    new = before == 2 and plane.beyond == 0 and plane.gap < wp.float64(0.0)
    if far or new:
        other = plane_of(facets, nearest, -side_now, thickness, x, normals, hollows)
        if far or other.gap > plane.gap:
            across = 1 - across
            plane = other
    if before == 2 and plane.beyond == 1 and plane.gap < -wp.float64(0.5) * thickness:
        plane.beyond = 2  # not from nothing to one and a half thicknesses deep
    plane.across = wp.where(plane.beyond == 2, 2, across)
    return plane
