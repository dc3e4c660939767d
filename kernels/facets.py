"""The facet of a ply nearest to a point: by Warp's mesh query, or by a walk from one that was.

A vertex slides over the other ply by a small part of a facet from search to search, so that the
nearest facet is the one of before, or one beside it. The walk looks at those facets only whose
edges are near enough for a bend to bring them closer; a query of the whole ply now and then finds
what a walk cannot: another fold, or a ply that was out of sight.
"""

import warp as wp

from .surface import barycentric, to_single, weighted

BEND = wp.constant(wp.float64(16.0))
"""Twice the bend beside an edge, over the room in the hollow there and the edge's length."""
MOST_MOVES = wp.constant(6)
"""Facets that a walk passes at most; the next search goes on from there."""


@wp.struct
class PlyFacets:
    """Facets of all plies, one after the other."""

    corners: wp.array(dtype=wp.vec3i)  # vertices, shape [triangle]
    open_edges: wp.array(dtype=wp.int32)  # bits of edges without a neighbour, shape [triangle]
    first_of_fan: wp.array(dtype=wp.int32)  # where a vertex's triangles begin, shape [vertex + 1]
    fans: wp.array(dtype=wp.int32)  # triangles round each vertex, shape [3 · triangle]


@wp.struct
class NearestFacet:
    """Point of a facet nearest to a vertex."""

    facet: wp.int32  # −1 if there is none
    weights: wp.vec3d  # of its corners
    offset: wp.vec3d  # from the point to the vertex [m]


@wp.func
def no_facet() -> NearestFacet:
    """None in sight."""
    nearest = NearestFacet()
    nearest.facet = -1
    return nearest


@wp.func
def nearest_on_facet(
    facets: PlyFacets, facet: int, x: wp.array(dtype=wp.vec3d), i: int
) -> NearestFacet:
    """Point of a facet that is nearest to vertex i."""
    at = facets.corners[facet]
    a = x[at[0]]
    b = x[at[1]]
    c = x[at[2]]
    nearest = NearestFacet()
    nearest.facet = facet
    nearest.weights = barycentric(a, b, c, x[i])
    nearest.offset = x[i] - weighted(nearest.weights, a, b, c)
    return nearest


@wp.func
def may_be_nearer_beside(
    facets: PlyFacets,
    nearest: NearestFacet,
    x: wp.array(dtype=wp.vec3d),
    hollows: wp.array(dtype=wp.vec2d),
) -> bool:
    """Whether a facet beside this one may be nearer.

    So it is where the nearest point lies on an edge, or the ply bends beyond an edge towards the
    vertex: by φ it brings nearer what is beyond an edge up to d tan φ aside, d the distance. Along
    an edge of length l the room r in the hollow tells φ = 8 r/l; twice that is allowed for.
    """
    w = nearest.weights
    least = wp.min(w)
    if least <= wp.float64(0.0):
        return True
    at = facets.corners[nearest.facet]
    room = wp.max(wp.max(hollows[at[0]]), wp.max(wp.max(hollows[at[1]]), wp.max(hollows[at[2]])))
    a = x[at[0]]
    area_sq = wp.length_sq(wp.cross(x[at[1]] - a, x[at[2]] - a))  # twice the area, squared
    way = BEND * room
    return least * least * area_sq < way * way * wp.length_sq(nearest.offset)


@wp.func
def heaviest_corner(facets: PlyFacets, nearest: NearestFacet) -> int:
    """Vertex of the facet that the nearest point is at, or nearest to by its weights."""
    at = facets.corners[nearest.facet]
    w = nearest.weights
    vertex = at[0]
    if w[1] > w[0]:
        vertex = at[1]
    if w[2] > wp.max(w[0], w[1]):
        vertex = at[2]
    return vertex


@wp.func
def walk_to_nearest(
    facets: PlyFacets,
    start: int,
    x: wp.array(dtype=wp.vec3d),
    hollows: wp.array(dtype=wp.vec2d),
    i: int,
) -> NearestFacet:
    """Nearest facet that a walk from facet ``start`` finds, each move to one that is nearer."""
    nearest = nearest_on_facet(facets, start, x, i)
    for _ in range(MOST_MOVES):
        if not may_be_nearer_beside(facets, nearest, x, hollows):
            return nearest
        before = nearest.facet
        distance_sq = wp.length_sq(nearest.offset)
        corner = heaviest_corner(facets, nearest)
        for k in range(facets.first_of_fan[corner], facets.first_of_fan[corner + 1]):
            other = facets.fans[k]
            if other != before:
                there = nearest_on_facet(facets, other, x, i)
                if wp.length_sq(there.offset) < distance_sq:
                    distance_sq = wp.length_sq(there.offset)
                    nearest = there
        if nearest.facet == before:
            return nearest
    return nearest


@wp.func
def ask_for_nearest(
    facets: PlyFacets,
    mesh: wp.uint64,
    first_triangle: int,
    radius: wp.float64,
    x: wp.array(dtype=wp.vec3d),
    i: int,
) -> NearestFacet:
    """Nearest facet of a whole ply within ``radius`` [m]."""
    query = wp.mesh_query_point_no_sign(mesh, to_single(x[i]), float(radius))
    nearest = no_facet()
    if query.result:
        nearest = nearest_on_facet(facets, first_triangle + query.face, x, i)
    return nearest
