"""Ridges: edges at which a ply is bent sharply, to which side they stick out, where two cross."""

import warp as wp

from .facets import PlyFacets, unit_normal

SHARP = wp.constant(wp.float64(0.5))
"""Angle between the facets beside an edge from which on it is a ridge [rad], 29°. Between its ends,
which vertices hold, a flatter one reaches at most an eighth of its length through another: no more
than the room that vertices allow each other in hollows."""
PARALLEL = wp.constant(wp.float64(1e-4))
"""Sine squared of the angle between two edges below which their vertices alone touch."""


@wp.struct
class PlyEdges:
    """Edges of all plies, one ply after the other, by the lower number of their ends."""

    ends: wp.array(dtype=wp.vec2i)  # vertices, the lower number first, shape [edge]
    sides: wp.array(dtype=wp.vec2i)  # triangles beside it, −1 beyond a border, shape [edge]
    of_triangle: wp.array(dtype=wp.vec3i)  # edge across from each corner, shape [triangle]
    first_of_own: wp.array(dtype=wp.int32)  # where those that begin at a vertex do, [vertex + 1]
    first_of_star: wp.array(dtype=wp.int32)  # where a vertex's edges begin, shape [vertex + 1]
    stars: wp.array(dtype=wp.int32)  # edges at each vertex, shape [2 · edge]


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


@wp.func
def ridge_normal(
    facets: PlyFacets, edges: PlyEdges, e: int, side: int, ridge: int, x: wp.array(dtype=wp.vec3d)
) -> wp.vec3d:
    """Unit normal of a facet beside an edge, on the side to which that sticks out."""
    return wp.float64(ridge) * unit_normal(facets, edges.sides[e][side], x)


@wp.func
def is_between(n: wp.vec3d, one: wp.vec3d, other: wp.vec3d) -> bool:
    """Whether a direction across an edge lies between the normals beside it."""
    turn = wp.cross(one, other)
    zero = wp.float64(0.0)
    return wp.dot(wp.cross(one, n), turn) >= zero and wp.dot(wp.cross(n, other), turn) >= zero


@wp.func
def room_over(
    edges: PlyEdges, e: int, ridge: int, share: wp.float64, hollows: wp.array(dtype=wp.vec2d)
):
    """Room [m] in the hollow along a ridge, as vertices have it, and its rise to the second end."""
    face = wp.where(ridge > 0, 0, 1)
    first = hollows[edges.ends[e][0]][face]
    rise = hollows[edges.ends[e][1]][face] - first
    return first + share * rise, rise


@wp.func
def cross_at(
    facets: PlyFacets,
    edges: PlyEdges,
    e: int,
    f: int,
    held: bool,
    thickness: wp.float64,
    rooms: wp.float64,
    x: wp.array(dtype=wp.vec3d),
    hollows: wp.array(dtype=wp.vec2d),
    ridges: wp.array(dtype=wp.int32),
) -> Crossing:
    """Where two ridges that stick out towards each other cross; none where they do not.

    A contact begins where each is the nearest place of its sheet, before they have passed each
    other, room included. Once held it stays, on its side, as long as both are nearest within
    their ends.

    Args:
        facets: of all plies.
        edges: likewise.
        e: the edge that looks.
        f: the other one.
        held: whether e has held f so far.
        thickness: of the mid-surfaces in contact [m].
        rooms: 1 for room in hollows, 0 for none.
        x: positions [m], shape [vertex].
        hollows: room on the hollow sides, above and below [m], shape [vertex].
        ridges: to which side edges stick out, shape [edge].
    """
    zero = wp.float64(0.0)
    one = wp.float64(1.0)
    none = Crossing()
    p = x[edges.ends[e][0]]
    q = x[edges.ends[f][0]]
    u = x[edges.ends[e][1]] - p
    v = x[edges.ends[f][1]] - q
    across = wp.cross(u, v)
    square = wp.length_sq(across)
    if square <= PARALLEL * wp.length_sq(u) * wp.length_sq(v):
        return none
    s = wp.dot(wp.cross(q - p, v), across) / square
    t = wp.dot(wp.cross(q - p, u), across) / square
    if s <= zero or s >= one or t <= zero or t >= one:
        return none
    e1 = ridge_normal(facets, edges, e, 0, ridges[e], x)
    e2 = ridge_normal(facets, edges, e, 1, ridges[e], x)
    f1 = ridge_normal(facets, edges, f, 0, ridges[f], x)
    f2 = ridge_normal(facets, edges, f, 1, ridges[f], x)
    n = across / wp.sqrt(square)
    if wp.dot(n, e1 + e2) < zero:
        n = -n
    if wp.dot(n, f1 + f2) >= zero:
        return none
    offset = p + s * u - q - t * v
    distance = -wp.dot(n, offset)
    if not held:
        if not (is_between(n, e1, e2) and is_between(-n, f1, f2)):
            return none
    room_e, slope_e = room_over(edges, e, ridges[e], s, hollows)
    room_f, slope_f = room_over(edges, f, ridges[f], t, hollows)
    between = distance + rooms * (room_e + room_f)
    if between <= zero and not held:
        return none
    steepness = wp.dot(across, n)
    leaning = (rooms * slope_e / steepness) * wp.cross(v, n)
    leaning += (rooms * slope_f / steepness) * wp.cross(u, n)
    found = Crossing()
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


@wp.func
def ridge_of(facets: PlyFacets, edges: PlyEdges, e: int, x: wp.array(dtype=wp.vec3d)) -> int:
    """To which side an edge sticks out: +1 up, −1 down, 0 where it is flat or on a border."""
    beside = edges.sides[e]
    if beside[1] < 0:
        return 0
    one = unit_normal(facets, beside[0], x)
    if wp.dot(one, unit_normal(facets, beside[1], x)) > wp.cos(SHARP):
        return 0
    corners = facets.corners[beside[1]]
    ends = edges.ends[e]
    rise = wp.float64(0.0)
    for k in range(3):
        if corners[k] != ends[0] and corners[k] != ends[1]:
            rise = wp.dot(x[corners[k]] - x[ends[0]], one)
    return wp.where(rise < wp.float64(0.0), 1, -1)


@wp.kernel(enable_backward=False)
def find_ridges(
    first: int,
    facets: PlyFacets,
    edges: PlyEdges,
    x: wp.array(dtype=wp.vec3d),
    pressing: wp.array(dtype=wp.int32),
    ridges: wp.array(dtype=wp.int32),
    watched: wp.array(dtype=wp.int32),
):
    """Find to which side edges stick out; one thread a vertex, for the edges that begin there.

    Args:
        first: number of the first vertex.
        facets: of all plies.
        edges: likewise.
        x: positions [m], shape [vertex].
        pressing: whether an edge may touch before the next search, shape [edge].
        ridges: +1 up, −1 down, 0 where flat, shape [edge]; overwritten.
        watched: whether edges of a vertex are ridges or touch, shape [vertex]; overwritten.
    """
    i = first + wp.tid()
    watches = wp.int32(0)
    for e in range(edges.first_of_own[i], edges.first_of_own[i + 1]):
        ridge = ridge_of(facets, edges, e, x)
        ridges[e] = ridge
        if ridge != 0 or pressing[e] == 1:
            watches = 1
    watched[i] = watches
