"""Two ridges that cross: where, how far apart, and along which direction they push each other."""

import warp as wp

from .facets import PlyFacets, unit_normal
from .ridges import BOTH, PlyEdges, Ridges, corner_across, room_over

PARALLEL = wp.constant(wp.float64(1e-4))
"""Sine squared of the angle between two edges below which their vertices alone touch."""
LEANING = wp.constant(wp.float64(0.25))
"""Slope over a ply up to which what crosses its border comes from beyond it, not from inside, 14°:
what lies flat on the border does."""


@wp.struct
class Crossing:
    """Two ridges where they are nearest."""

    other: wp.int32  # number of the other edge plus one, 0 for none
    ply: wp.int32  # of the other one
    share: wp.float64  # of the first edge's second end
    other_share: wp.float64  # of the other's
    normal: wp.vec3d  # from the other towards the first; its length is 1
    gap: wp.float64  # m
    rise: wp.float64  # of the tangent plane over the place on the other, less the thickness [m]


@wp.struct
class Outer:
    """Directions in which a ridge is the nearest place of its ply: those between two."""

    one: wp.vec3d
    other: wp.vec3d


@wp.func
def outer_of(facets: PlyFacets, edges: PlyEdges, now: Ridges, e: int, way: int) -> Outer:
    """Where a ridge is nearest on a side: between the facets' normals, beside the ply at a border.

    At a border that is from the facet's normal, or slightly inward, to where the ply ends.
    """
    outer = Outer()
    outer.one = wp.float64(way) * unit_normal(facets, edges.sides[e][0], now.x)
    if now.ways[e] == BOTH:
        ends = edges.ends[e]
        along = wp.normalize(now.x[ends[1]] - now.x[ends[0]])
        outward = now.x[ends[0]] - now.x[corner_across(facets, edges.sides[e][0], ends)]
        outer.other = wp.normalize(outward - wp.dot(outward, along) * along)
        outer.one -= LEANING * outer.other
    else:
        outer.other = wp.float64(way) * unit_normal(facets, edges.sides[e][1], now.x)
    return outer


@wp.func
def is_between(n: wp.vec3d, outer: Outer) -> bool:
    """Whether a direction across a ridge is one in which that is the nearest place."""
    turn = wp.cross(outer.one, outer.other)
    zero = wp.float64(0.0)
    return (
        wp.dot(wp.cross(outer.one, n), turn) >= zero
        and wp.dot(wp.cross(n, outer.other), turn) >= zero
    )


@wp.func
def way_across(one: Outer, other: Outer, held: bool, across: wp.vec3d) -> wp.vec3d:
    """Direction from one ridge to another on its outer side; zero unless they face each other.

    Args:
        one: where the one is nearest.
        other: where the other is.
        held: whether it is enough that each is on the outer side of the other; else each must be
            the nearest place of its sheet.
        across: unit vector across both.
    """
    none = wp.vec3d()
    zero = wp.float64(0.0)
    n = across
    if wp.dot(n, one.one + one.other) < zero:
        n = -n
    if wp.dot(n, other.one + other.other) >= zero:
        return none
    if not held:
        if not (is_between(n, one) and is_between(-n, other)):
            return none
    return n


@wp.func
def cross_at(
    facets: PlyFacets,
    edges: PlyEdges,
    now: Ridges,
    e: int,
    way: int,
    f: int,
    way_back: int,
    held: bool,
    thickness: wp.float64,
    rooms: wp.float64,
) -> Crossing:
    """Where two ridges that stick out towards each other cross; none where they do not.

    A contact begins where each is the nearest place of its sheet, before they have passed each
    other, room included. Once held it stays, on its side, as long as both are nearest within
    their ends.

    Args:
        facets: of all plies.
        edges: likewise.
        now: where the ridges are.
        e: the edge that looks.
        way: to which side of its ply.
        f: the other one.
        way_back: to which side of its own ply that one looks.
        held: whether e has held f so far.
        thickness: of the mid-surfaces in contact [m].
        rooms: 1 for room in hollows, 0 for none.
    """
    zero = wp.float64(0.0)
    one = wp.float64(1.0)
    found = Crossing()
    p = now.x[edges.ends[e][0]]
    q = now.x[edges.ends[f][0]]
    u = now.x[edges.ends[e][1]] - p
    v = now.x[edges.ends[f][1]] - q
    across = wp.cross(u, v)
    square = wp.length_sq(across)
    if square <= PARALLEL * wp.length_sq(u) * wp.length_sq(v):
        return found
    s = wp.dot(wp.cross(q - p, v), across) / square
    t = wp.dot(wp.cross(q - p, u), across) / square
    if s <= zero or s >= one or t <= zero or t >= one:
        return found
    mine = outer_of(facets, edges, now, e, way)
    n = way_across(mine, outer_of(facets, edges, now, f, way_back), held, across / wp.sqrt(square))
    if wp.length_sq(n) == zero:
        return found
    offset = p + s * u - q - t * v
    room_e, slope_e = room_over(edges, now, e, way, s)
    room_f, slope_f = room_over(edges, now, f, way_back, t)
    between = rooms * (room_e + room_f) - wp.dot(n, offset)
    if between <= zero and not held:
        return found
    steepness = wp.dot(across, n)
    leaning = (rooms * slope_e / steepness) * wp.cross(v, n)
    leaning += (rooms * slope_f / steepness) * wp.cross(u, n)
    found.other = f + 1
    found.share = s
    found.other_share = t
    found.gap = between - thickness
    found.normal = -wp.normalize(n + leaning)
    found.rise = wp.dot(found.normal, offset) - found.gap - thickness
    return found


@wp.func
def apart(p: wp.vec3d, u: wp.vec3d, q: wp.vec3d, v: wp.vec3d) -> wp.float64:
    """Distance [m] of the segments from p to p + u and from q to q + v."""
    zero = wp.float64(0.0)
    one = wp.float64(1.0)
    r = p - q
    uu = wp.dot(u, u)
    uv = wp.dot(u, v)
    vv = wp.dot(v, v)
    ur = wp.dot(u, r)
    vr = wp.dot(v, r)
    square = uu * vv - uv * uv
    s = zero
    if square > zero:
        s = wp.clamp((uv * vr - vv * ur) / square, zero, one)
    t = (uv * s + vr) / vv
    if t < zero or t > one:
        t = wp.clamp(t, zero, one)
        s = wp.clamp((uv * t - ur) / uu, zero, one)
    return wp.length(r + s * u - t * v)
