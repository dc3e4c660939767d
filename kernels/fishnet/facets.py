"""Facets as flat pieces side by side: places and directions in a facet, and from one to the next.

A half-edge 3 f + k runs from corner k to corner k + 1 of facet f, the facet to its left. A place
is a facet and two coordinates in it: the first from corner 0 towards corner 1, the second square to
it, towards corner 2. A direction is its angle against the first.
"""

import warp as wp

ZERO = wp.constant(wp.float64(0.0))
ONE = wp.constant(wp.float64(1.0))


@wp.struct
class Facets:
    """A surface as its facets know it."""

    corners: wp.array(dtype=wp.vec3i)  # vertices, shape [facet]
    bases: wp.array(dtype=wp.vec3d)  # corner 0 [m], shape [facet]
    firsts: wp.array(dtype=wp.vec3d)  # unit vector from corner 0 to 1, shape [facet]
    seconds: wp.array(dtype=wp.vec3d)  # unit vector square to it in the facet, shape [facet]
    sides: wp.array(dtype=wp.float64)  # from corner 0 to 1 [m], shape [facet]
    tips: wp.array(dtype=wp.vec2d)  # corner 2 in the facet [m], shape [facet]
    twins: wp.array(dtype=wp.int32)  # half-edge on the other side, −1 at a border, shape [3 facet]
    turns: wp.array(dtype=wp.float64)  # added to an angle across a half-edge [rad], shape [3 facet]
    apexes: wp.array(dtype=wp.vec2d)  # third corner over the half-edge [its length], [3 facet]
    around: wp.array(dtype=wp.float64)  # angles round a vertex [rad], −1 at a border, [vertex]


@wp.struct
class Place:
    """A place on the surface."""

    facet: wp.int32
    at: wp.vec2d  # in the facet [m]


@wp.func
def corner_of(facets: Facets, facet: int, k: int) -> wp.vec2d:
    """Corner 0, 1 or 2 in its facet [m]."""
    if k == 0:
        return wp.vec2d(ZERO, ZERO)
    if k == 1:
        return wp.vec2d(facets.sides[facet], ZERO)
    return facets.tips[facet]


@wp.func
def next_corner(k: int) -> int:
    """The corner after one, the way round that has the facet to its left."""
    if k == 2:
        return 0
    return k + 1


@wp.func
def before_corner(k: int) -> int:
    """The corner before one."""
    if k == 0:
        return 2
    return k - 1


@wp.func
def vertex_of(facets: Facets, facet: int, k: int) -> int:
    """Vertex at a corner."""
    return facets.corners[facet][k]


@wp.func
def in_space(facets: Facets, place: Place) -> wp.vec3d:
    """A place as a point [m]."""
    f = place.facet
    return facets.bases[f] + place.at[0] * facets.firsts[f] + place.at[1] * facets.seconds[f]


@wp.func
def in_facet(facets: Facets, facet: int, point: wp.vec3d) -> wp.vec2d:
    """Coordinates in a facet's plane of the point's foot [m]."""
    way = point - facets.bases[facet]
    return wp.vec2d(wp.dot(way, facets.firsts[facet]), wp.dot(way, facets.seconds[facet]))


@wp.func
def cross2(a: wp.vec2d, b: wp.vec2d) -> wp.float64:
    """Sine of the angle from a to b, times both lengths."""
    return a[0] * b[1] - a[1] * b[0]


@wp.func
def heading(angle: wp.float64) -> wp.vec2d:
    """Unit vector of an angle."""
    return wp.vec2d(wp.cos(angle), wp.sin(angle))


@wp.func
def angle_of(v: wp.vec2d) -> wp.float64:
    """Angle of a vector [rad]."""
    return wp.atan2(v[1], v[0])


@wp.struct
class Exit:
    """Where a straight line leaves a facet."""

    edge: wp.int32  # corner at which the half-edge begins; −1 if it ends before
    way: wp.float64  # as far as there [m]
    share: wp.float64  # of the half-edge, from its beginning


@wp.func
def exit_of(facets: Facets, place: Place, along: wp.vec2d, entry: int, way: wp.float64) -> Exit:
    """Where a straight line leaves a facet.

    Args:
        facets: of the surface.
        place: where it begins.
        along: its unit direction.
        entry: corner at which the half-edge begins over which it came in, −1 if over none.
        way: its length [m].
    """
    found = Exit()
    found.edge = -1
    found.way = way
    for k in range(3):
        if k != entry:
            a = corner_of(facets, place.facet, k)
            side = corner_of(facets, place.facet, next_corner(k)) - a
            outward = wp.vec2d(side[1], -side[0])
            speed = wp.dot(outward, along)
            if speed > ZERO:
                far = wp.max(wp.dot(outward, a - place.at) / speed, ZERO)
                if far < found.way:
                    found.edge = k
                    found.way = far
                    share = wp.dot(place.at + far * along - a, side) / wp.dot(side, side)
                    found.share = wp.clamp(share, ZERO, ONE)
    return found


@wp.func
def edge_under(facets: Facets, place: Place, entry: int) -> Exit:
    """The edge nearest to a place, but for that over which it came in."""
    found = Exit()
    found.edge = -1
    found.way = wp.float64(1.0e18)
    for k in range(3):
        if k != entry:
            a = corner_of(facets, place.facet, k)
            side = corner_of(facets, place.facet, next_corner(k)) - a
            share = wp.clamp(wp.dot(place.at - a, side) / wp.dot(side, side), ZERO, ONE)
            far = wp.length(place.at - a - share * side)
            if far < found.way:
                found.edge = k
                found.way = far
                found.share = share
    return found


@wp.func
def across(facets: Facets, half_edge: int, share: wp.float64) -> Place:
    """The place of a half-edge in the facet on its other side, where there is one."""
    twin = facets.twins[half_edge]
    place = Place()
    place.facet = twin // 3
    k = twin % 3
    a = corner_of(facets, place.facet, k)
    b = corner_of(facets, place.facet, next_corner(k))
    place.at = a + (ONE - share) * (b - a)
    return place
