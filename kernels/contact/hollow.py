"""A point in the hollow between two facets: the plane across their edge, which may be nearer soon.

The gap to a ply is there the smaller one of those to two planes. If only the one that a search
found were held, a point that rests between both would come deeper into the other until the next
search, at each search again. Room on a hollow side bends the gap over an edge as facets do.
"""

import warp as wp

from .facets import NearestFacet, PlyFacets, nearest_on_facet, unit_normal
from .surface import facet_slope

MIDDLE = wp.constant(wp.vec3d(1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0))
"""Weights of a facet's middle, where a slope is one along the whole facet."""


@wp.struct
class OtherPlane:
    """Tangent plane of a facet beside a point, with the place on it nearest to that."""

    corners: wp.vec3i  # vertices of the facet; the same three if there is none
    weights: wp.vec3d  # of these at the place
    normal: wp.vec3d  # towards the point's side
    rise: wp.float64  # of the plane over the place, less the thickness [m]
    gap: wp.float64  # of the point when it was found [m]


@wp.struct
class Hollow:
    """The two planes between which a point lies; none unless the second exists."""

    own: OtherPlane  # of the nearest facet
    other: OtherPlane  # of one across an edge


@wp.func
def exists(other: OtherPlane) -> bool:
    """Whether there is a plane."""
    return other.corners[0] != other.corners[1]


@wp.func
def gap_slope(plane: OtherPlane, side: wp.float64, x: wp.array(dtype=wp.vec3d)) -> wp.vec3d:
    """Gradient of the gap to a plane [-]: its normal, as long as to rise by 1 over the facet."""
    at = plane.corners
    n = side * wp.normalize(wp.cross(x[at[1]] - x[at[0]], x[at[2]] - x[at[0]]))
    return plane.normal / wp.dot(plane.normal, n)


@wp.func
def plane_over(
    facets: PlyFacets,
    facet: int,
    side: wp.float64,
    thickness: wp.float64,
    x: wp.array(dtype=wp.vec3d),
    hollows: wp.array(dtype=wp.vec2d),
    point: wp.vec3d,
) -> OtherPlane:
    """Plane of a facet, over which the point need not lie, with the room as that changes over it.

    Args:
        facets: of all plies.
        facet: its number.
        side: of the ply on which the point lies, +1 above it, −1 below.
        thickness: of the mid-surfaces in contact [m].
        x: positions [m], shape [vertex].
        hollows: room on the hollow sides, above and below [m], shape [vertex].
        point: the point [m].
    """
    there = nearest_on_facet(facets, facet, x, point)
    at = facets.corners[facet]
    face = wp.where(side > wp.float64(0.0), 0, 1)
    room = wp.vec3d(hollows[at[0]][face], hollows[at[1]][face], hollows[at[2]][face])
    slope = side * unit_normal(facets, facet, x)
    slope += facet_slope(x[at[0]], x[at[1]], x[at[2]], MIDDLE, room)
    plane = OtherPlane()
    plane.corners = at
    plane.weights = there.weights
    plane.normal = wp.normalize(slope)
    plane.gap = wp.dot(slope, there.offset) - thickness + wp.dot(there.weights, room)
    plane.rise = wp.dot(plane.normal, there.offset) - plane.gap - thickness
    return plane


@wp.func
def may_be_nearer(own: OtherPlane, bend: wp.vec3d, way: wp.float64, plane: OtherPlane) -> bool:
    """Whether a plane may become the nearer one on a way [m].

    Two gaps change against each other by no more than the way times the difference of their slopes.

    Args:
        own: the one of now.
        bend: difference of the slopes of both gaps [-].
        way: that the point may go [m].
        plane: the other one.
    """
    return plane.gap - own.gap < wp.length(bend) * way


@wp.func
def hollow_at_corner(
    facets: PlyFacets,
    corner: int,
    own: OtherPlane,
    side: wp.float64,
    way: wp.float64,
    thickness: wp.float64,
    x: wp.array(dtype=wp.vec3d),
    hollows: wp.array(dtype=wp.vec2d),
    point: wp.vec3d,
) -> Hollow:
    """Planes of a corner that is nearest, and of a facet round it; else as `hollow_at`."""
    found = Hollow()
    found.own = own
    if wp.dot(own.normal, point - x[corner]) <= wp.float64(0.0):
        return found
    for k in range(facets.first_of_fan[corner], facets.first_of_fan[corner + 1]):
        at = facets.corners[facets.fans[k]]
        outward = x[at[0]] + x[at[1]] + x[at[2]] - wp.float64(3.0) * x[corner]
        plane = plane_over(facets, facets.fans[k], side, thickness, x, hollows, point)
        bend = own.normal - gap_slope(plane, side, x)
        if wp.dot(bend, outward) > wp.float64(0.0) and may_be_nearer(own, bend, way, plane):
            if not exists(found.other) or plane.gap < found.other.gap:
                found.other = plane
    return found


@wp.func
def is_beside(
    facets: PlyFacets, nearest: NearestFacet, k: int, way: wp.float64, x: wp.array(dtype=wp.vec3d)
) -> bool:
    """Whether a point lies so near to the edge across from a corner that it may cross its hollow.

    At a height d over facets that bend by φ up to 90° the two are as near d tan φ/2 ≤ d aside.
    """
    at = facets.corners[nearest.facet]
    one = x[at[(k + 1) % 3]]
    along = x[at[(k + 2) % 3]] - one
    twice = wp.length(wp.cross(along, x[at[k]] - one))
    return nearest.weights[k] * twice <= (way + wp.length(nearest.offset)) * wp.length(along)


@wp.func
def hollow_over_edge(
    facets: PlyFacets,
    nearest: NearestFacet,
    side: wp.float64,
    way: wp.float64,
    thickness: wp.float64,
    x: wp.array(dtype=wp.vec3d),
    hollows: wp.array(dtype=wp.vec2d),
    point: wp.vec3d,
) -> Hollow:
    """Planes of the nearest facet and of one across an edge of it; else as `hollow_at`.

    Where the nearest place lies on an edge the facet across that one is asked alone. A point that
    has been pressed through finds an edge where a valley was: that it leaves alone.
    """
    zero = wp.float64(0.0)
    found = Hollow()
    own = wp.vec3d()
    through = side * wp.dot(unit_normal(facets, nearest.facet, x), nearest.offset) < zero
    corners = facets.corners[nearest.facet]
    beside = facets.beside[nearest.facet]
    w = nearest.weights
    on_edge = wp.min(w) <= zero
    for k in range(3):
        if beside[k] < 0 or (on_edge and w[k] > zero):
            continue
        if not is_beside(facets, nearest, k, way, x):
            continue
        inward = x[corners[k]] - x[corners[(k + 1) % 3]]
        if through and side * wp.dot(unit_normal(facets, beside[k], x), inward) > zero:
            continue
        there = nearest_on_facet(facets, beside[k], x, point)
        if wp.length(there.offset) > wp.length(nearest.offset) + wp.float64(2.0) * way:
            continue  # out of reach, though its plane, of a flat ply, is as near
        if not exists(found.own):
            found.own = plane_over(facets, nearest.facet, side, thickness, x, hollows, point)
            own = gap_slope(found.own, side, x)
        plane = plane_over(facets, beside[k], side, thickness, x, hollows, point)
        bend = own - gap_slope(plane, side, x)
        if wp.dot(bend, inward) < zero and may_be_nearer(found.own, bend, way, plane):
            if not exists(found.other) or plane.gap < found.other.gap:
                found.other = plane
    return found


@wp.func
def hollow_at(
    facets: PlyFacets,
    nearest: NearestFacet,
    own: OtherPlane,
    side: wp.float64,
    way: wp.float64,
    thickness: wp.float64,
    x: wp.array(dtype=wp.vec3d),
    hollows: wp.array(dtype=wp.vec2d),
    point: wp.vec3d,
) -> Hollow:
    """The plane at a point, and the one beside it that may become the nearer one.

    Over a hollow edge the gap grows from one facet towards the edge faster than it goes on to do
    beyond. Of a facet and the edge on which the nearest place lies the facets' planes count.

    Args:
        facets: of all plies.
        nearest: the place.
        own: plane there.
        side: of the ply on which the point lies, +1 above it, −1 below.
        way: that the point may go until the next search [m].
        thickness: of the mid-surfaces in contact [m].
        x: positions [m], shape [vertex].
        hollows: room on the hollow sides, above and below [m], shape [vertex].
        point: the point [m].
    """
    w = nearest.weights
    if wp.max(w) >= wp.float64(1.0):
        at = facets.corners[nearest.facet]
        corner = wp.where(w[1] >= wp.float64(1.0), at[1], at[0])
        corner = wp.where(w[2] >= wp.float64(1.0), at[2], corner)
        return hollow_at_corner(facets, corner, own, side, way, thickness, x, hollows, point)
    return hollow_over_edge(facets, nearest, side, way, thickness, x, hollows, point)
