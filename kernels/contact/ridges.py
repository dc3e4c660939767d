"""Ridges: edges at which a ply is bent sharply or ends, and to which side they stick out."""

import warp as wp

from ..sweep import Sweep
from .facets import PlyFacets, unit_normal

SHARP = wp.constant(wp.float64(0.5))
"""Angle between the facets beside an edge from which on it is a ridge [rad], 29°. Between its ends,
which vertices hold, a flatter one reaches at most an eighth of its length through another: no more
than the room that vertices allow each other in hollows."""
BOTH = wp.constant(2)
"""Way of an edge on a border, which sticks out to both sides."""


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
class Ridges:
    """Where the plies' ridges are now."""

    x: wp.array(dtype=wp.vec3d)  # positions [m], shape [vertex]
    hollows: wp.array(dtype=wp.vec2d)  # room on the hollow sides, above and below [m], [vertex]
    ways: wp.array(dtype=wp.int32)  # to which side edges stick out, or `BOTH`, shape [edge]


@wp.func
def sticks_out(now: Ridges, e: int, way: int) -> bool:
    """Whether an edge is a ridge towards a side of its ply: +1 above it, −1 below."""
    return now.ways[e] == way or now.ways[e] == BOTH


@wp.func
def room_over(edges: PlyEdges, now: Ridges, e: int, way: int, share: wp.float64):
    """Room [m] in the hollow along a ridge, as vertices have it, and its rise to the second end."""
    face = wp.where(way > 0, 0, 1)
    first = now.hollows[edges.ends[e][0]][face]
    rise = now.hollows[edges.ends[e][1]][face] - first
    return first + share * rise, rise


@wp.func
def corner_across(facets: PlyFacets, facet: int, ends: wp.vec2i) -> int:
    """Vertex of a facet that is no end of its edge."""
    corners = facets.corners[facet]
    across = corners[2]
    for k in range(2):
        if corners[k] != ends[0] and corners[k] != ends[1]:
            across = corners[k]
    return across


@wp.func
def ridge_of(facets: PlyFacets, edges: PlyEdges, e: int, x: wp.array(dtype=wp.vec3d)) -> int:
    """To which side an edge sticks out: +1 up, −1 down, 0 where it is flat, `BOTH` at a border."""
    beside = edges.sides[e]
    if beside[1] < 0:
        return BOTH
    one = unit_normal(facets, beside[0], x)
    if wp.dot(one, unit_normal(facets, beside[1], x)) > wp.cos(SHARP):
        return 0
    ends = edges.ends[e]
    rise = wp.dot(x[corner_across(facets, beside[1], ends)] - x[ends[0]], one)
    return wp.where(rise < wp.float64(0.0), 1, -1)


@wp.kernel(enable_backward=False)
def find_ridges(
    sweep: Sweep,
    facets: PlyFacets,
    edges: PlyEdges,
    x: wp.array(dtype=wp.vec3d),
    pressing: wp.array(dtype=wp.int32),
    ridges: wp.array(dtype=wp.int32),
    watched: wp.array(dtype=wp.int32),
):
    """Find to which side edges stick out; a sweep over vertices, for the edges that begin there.

    Args:
        sweep: numbers of the vertices.
        facets: of all plies.
        edges: likewise.
        x: positions [m], shape [vertex].
        pressing: whether an edge may touch before the next search, shape [edge].
        ridges: +1 up, −1 down, 0 where flat, `BOTH` at borders, shape [edge]; overwritten.
        watched: whether edges of a vertex are ridges or touch, shape [vertex]; overwritten.
    """
    for i in range(sweep.first + wp.tid(), sweep.end, sweep.threads):
        watches = wp.int32(0)
        for e in range(edges.first_of_own[i], edges.first_of_own[i + 1]):
            ridge = ridge_of(facets, edges, e, x)
            ridges[e] = ridge
            if ridge != 0 or pressing[e] == 1:
                watches = 1
        watched[i] = watches
