"""The facet of a ply nearest to a point: by Warp's mesh query, or by a walk from one that was.

A point slides over the ply by a small part of a facet from search to search, so that the
nearest facet is the one of before, or one beside it. The walk looks at those facets only whose
edges are near enough for a bend to bring them closer; a query of the whole ply now and then finds
what a walk cannot: another fold, or a ply that was out of sight.
"""

import warp as wp

from .surface import barycentric, is_on_edge, to_single, weighted

BEND = wp.constant(wp.float64(32.0))
"""Bend between facets times an edge's length over the room in the hollow: 8 where a ply bends
evenly, and up to so much at a fold, which the vertex normals even out."""
MOST_MOVES = wp.constant(6)
"""Facets that a walk passes at most; the next search goes on from there."""


@wp.struct
class PlyFacets:
    """Facets of all plies, one after the other."""

    corners: wp.array(dtype=wp.vec3i)  # vertices, shape [triangle]
    borders: wp.array(dtype=wp.int32)  # bits: edges 0 to 2 and corners 3 to 5 on a border
    beside: wp.array(dtype=wp.vec3i)  # across from each corner, −1 if none, shape [triangle]
    first_of_fan: wp.array(dtype=wp.int32)  # where a vertex's triangles begin, shape [vertex + 1]
    fans: wp.array(dtype=wp.int32)  # triangles round each vertex, shape [3 · triangle]
    first_of_ring: wp.array(dtype=wp.int32)  # where its neighbours begin, shape [vertex + 1]
    rings: wp.array(dtype=wp.int32)  # neighbours of each vertex, shape [2 · edge]


@wp.struct
class NearestFacet:
    """Place on a facet nearest to a point."""

    facet: wp.int32  # −1 if there is none
    weights: wp.vec3d  # of its corners
    offset: wp.vec3d  # from there to the point [m]


@wp.func
def no_facet() -> NearestFacet:
    """None in sight."""
    nearest = NearestFacet()
    nearest.facet = -1
    return nearest


@wp.func
def nearest_on_facet(
    facets: PlyFacets, facet: int, x: wp.array(dtype=wp.vec3d), point: wp.vec3d
) -> NearestFacet:
    """Place on a facet that is nearest to a point."""
    at = facets.corners[facet]
    a = x[at[0]]
    b = x[at[1]]
    c = x[at[2]]
    nearest = NearestFacet()
    nearest.facet = facet
    nearest.weights = barycentric(a, b, c, point)
    nearest.offset = point - weighted(nearest.weights, a, b, c)
    return nearest


@wp.func
def is_at_border(facets: PlyFacets, nearest: NearestFacet) -> bool:
    """Whether a nearest point lies on the ply's border."""
    return is_on_edge(nearest.weights, facets.borders[nearest.facet])


@wp.func
def unit_normal(facets: PlyFacets, facet: int, x: wp.array(dtype=wp.vec3d)) -> wp.vec3d:
    """Unit normal of a facet."""
    at = facets.corners[facet]
    return wp.normalize(wp.cross(x[at[1]] - x[at[0]], x[at[2]] - x[at[0]]))


@wp.func
def fan_facing(facets: PlyFacets, vertex: int, x: wp.array(dtype=wp.vec3d)) -> wp.vec3d:
    """Normals of a vertex's facets, each by its angle there."""
    n = wp.vec3d()
    for k in range(facets.first_of_fan[vertex], facets.first_of_fan[vertex + 1]):
        at = facets.corners[facets.fans[k]]
        one = x[at[1]]
        other = x[at[2]]
        if at[1] == vertex:
            one = x[at[2]]
            other = x[at[0]]
        if at[2] == vertex:
            one = x[at[0]]
            other = x[at[1]]
        one = one - x[vertex]
        other = other - x[vertex]
        area = wp.cross(one, other)
        size = wp.length(area)
        if size > wp.float64(0.0):
            n += (wp.atan2(size, wp.dot(one, other)) / size) * area
    return n


@wp.func
def facing(facets: PlyFacets, nearest: NearestFacet, x: wp.array(dtype=wp.vec3d)) -> wp.vec3d:
    """Which way a ply faces at the place nearest to a point, so that its sign tells the side.

    The facet's normal inside it, the sum of two on an edge, that weighted by angles at a corner:
    with these the sign is right however sharp the fold (Baerentzen and Aanaes 2005), not so with
    what vertex normals are interpolated to.
    """
    w = nearest.weights
    n = unit_normal(facets, nearest.facet, x)
    if wp.max(w) >= wp.float64(1.0):
        at = facets.corners[nearest.facet]
        corner = wp.where(w[1] >= wp.float64(1.0), at[1], at[0])
        return fan_facing(facets, wp.where(w[2] >= wp.float64(1.0), at[2], corner), x)
    beside = facets.beside[nearest.facet]
    for k in range(3):
        if w[k] <= wp.float64(0.0) and beside[k] >= 0:
            n += unit_normal(facets, beside[k], x)
    return n


@wp.func
def is_on_side(
    facets: PlyFacets, nearest: NearestFacet, side: wp.float64, x: wp.array(dtype=wp.vec3d)
) -> bool:
    """Whether a point lies on a side of a ply, +1 above it, −1 below, or on the ply itself."""
    n = wp.vec3d()
    if wp.min(nearest.weights) > wp.float64(0.0):  # inside the facet: of any length
        at = facets.corners[nearest.facet]
        n = wp.cross(x[at[1]] - x[at[0]], x[at[2]] - x[at[0]])
    else:
        n = facing(facets, nearest, x)
    return side * wp.dot(nearest.offset, n) >= wp.float64(0.0)


@wp.func
def shadow(
    facets: PlyFacets,
    nearest: NearestFacet,
    x: wp.array(dtype=wp.vec3d),
    hollows: wp.array(dtype=wp.vec2d),
) -> wp.float64:
    """Weight of a corner up to which the facet across from it may be nearer than this one.

    A bend φ towards the vertex at distance d brings nearer what is beyond an edge up to d tan φ
    aside. The room r in the hollow tells φ = BEND r/l, l the length of an edge, and d φ over that
    edge a corner has the weight d φ l/2A.
    """
    at = facets.corners[nearest.facet]
    room = wp.max(wp.max(hollows[at[0]]), wp.max(wp.max(hollows[at[1]]), wp.max(hollows[at[2]])))
    a = x[at[0]]
    area_sq = wp.length_sq(wp.cross(x[at[1]] - a, x[at[2]] - a))
    return BEND * room * wp.sqrt(wp.length_sq(nearest.offset) / area_sq)


@wp.func
def nearer(
    facets: PlyFacets, best: NearestFacet, facet: int, x: wp.array(dtype=wp.vec3d), point: wp.vec3d
) -> NearestFacet:
    """The best so far, or another facet where that is nearer to a point."""
    there = nearest_on_facet(facets, facet, x, point)
    if wp.length_sq(there.offset) < wp.length_sq(best.offset):
        return there
    return best


@wp.func
def nearest_round(
    facets: PlyFacets,
    nearest: NearestFacet,
    corner: int,
    x: wp.array(dtype=wp.vec3d),
    point: wp.vec3d,
) -> NearestFacet:
    """Nearest facet of those round a corner."""
    best = nearest
    for k in range(facets.first_of_fan[corner], facets.first_of_fan[corner + 1]):
        best = nearer(facets, best, facets.fans[k], x, point)
    return best


@wp.func
def nearest_beside(
    facets: PlyFacets,
    nearest: NearestFacet,
    x: wp.array(dtype=wp.vec3d),
    hollows: wp.array(dtype=wp.vec2d),
    point: wp.vec3d,
) -> NearestFacet:
    """Nearest of a facet and those beside it that may be nearer."""
    w = nearest.weights
    most = wp.max(w)
    if most >= wp.float64(1.0):
        corners = facets.corners[nearest.facet]
        corner = wp.where(w[0] == most, corners[0], wp.where(w[1] == most, corners[1], corners[2]))
        return nearest_round(facets, nearest, corner, x, point)
    best = nearest
    limit = shadow(facets, nearest, x, hollows)
    beside = facets.beside[nearest.facet]
    for k in range(3):
        if w[k] <= limit and beside[k] >= 0:
            best = nearer(facets, best, beside[k], x, point)
    return best


@wp.func
def walk_to_nearest(
    facets: PlyFacets,
    start: int,
    x: wp.array(dtype=wp.vec3d),
    hollows: wp.array(dtype=wp.vec2d),
    point: wp.vec3d,
) -> NearestFacet:
    """Nearest facet that a walk from facet ``start`` finds, each move to one that is nearer."""
    nearest = nearest_on_facet(facets, start, x, point)
    moves = wp.int32(0)
    while moves < MOST_MOVES:
        there = nearest_beside(facets, nearest, x, hollows, point)
        moves = wp.where(there.facet == nearest.facet, MOST_MOVES, moves + 1)
        nearest = there
    return nearest


@wp.func
def ask_for_nearest(
    facets: PlyFacets,
    mesh: wp.uint64,
    first_triangle: int,
    radius: wp.float64,
    x: wp.array(dtype=wp.vec3d),
    point: wp.vec3d,
) -> NearestFacet:
    """Nearest facet of a whole ply within ``radius`` [m]."""
    query = wp.mesh_query_point_no_sign(mesh, to_single(point), float(radius))
    nearest = no_facet()
    if query.result:
        nearest = nearest_on_facet(facets, first_triangle + query.face, x, point)
    return nearest
