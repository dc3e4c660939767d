"""Strips: the half-edges that a way crosses, one after the other, and walks that lengthen them."""

import warp as wp

from .facets import (
    Facets,
    Place,
    across,
    edge_under,
    exit_of,
    heading,
    in_facet,
)

WARP_STRIP = wp.constant(0)
WEFT_STRIP = wp.constant(1)
SPARE_STRIP = wp.constant(2)
BOTH_STRIPS = wp.constant(3)
"""Which strip a walk lengthens: that of the warp, of the weft, or both."""

SAME_PLACE = wp.constant(wp.float64(1.0e-9))
"""Distance over a facet's side within which two places on different facets are one [-]."""

WALKED = wp.constant(0)
AT_BORDER = wp.constant(1)
OVERFULL = wp.constant(2)
ASTRAY = wp.constant(3)
"""How a walk ended: there; at the surface's border; after more facets than a strip holds; or it did
not find the facet that it looked for."""


@wp.struct
class Strips:
    """Room for the strips of one thread each."""

    edges: wp.array3d(dtype=wp.int32)  # half-edges, shape [thread, strip, room]
    counts: wp.array2d(dtype=wp.int32)  # crossed, shape [thread, strip]
    left: wp.array2d(dtype=wp.vec2d)  # their ends to the left, unfolded [m], shape [thread, room]
    right: wp.array2d(dtype=wp.vec2d)  # … and to the right


@wp.struct
class Walk:
    """Where a walk has come to."""

    place: Place
    angle: wp.float64  # its direction there [rad]
    ended: wp.int32  # one of WALKED, AT_BORDER, …


@wp.func
def push_one(facets: Facets, strips: Strips, thread: int, which: int, half_edge: int) -> int:
    """Lengthen a strip by a half-edge, or shorten it where it goes back; return 0 if it is full."""
    count = strips.counts[thread, which]
    if count > 0:
        if facets.twins[strips.edges[thread, which, count - 1]] == half_edge:
            strips.counts[thread, which] = count - 1
            return 1
    if count >= strips.edges.shape[2]:
        return 0
    strips.edges[thread, which, count] = half_edge
    strips.counts[thread, which] = count + 1
    return 1


@wp.func
def push(facets: Facets, strips: Strips, thread: int, which: int, half_edge: int) -> int:
    """Lengthen a strip, or both."""
    if which == BOTH_STRIPS:
        one = push_one(facets, strips, thread, WARP_STRIP, half_edge)
        other = push_one(facets, strips, thread, WEFT_STRIP, half_edge)
        return one * other
    return push_one(facets, strips, thread, which, half_edge)


@wp.func
def walk_straight(
    facets: Facets,
    start: Place,
    angle: wp.float64,
    length: wp.float64,
    strips: Strips,
    thread: int,
    which: int,
) -> Walk:
    """Go straight on across facets, each unfolded into the plane of the one before.

    Args:
        facets: of the surface.
        start: where to begin.
        angle: direction there [rad].
        length: of the way [m].
        strips: take down the half-edges crossed.
        thread: whose strips.
        which: strip to lengthen.
    """
    walk = Walk()
    walk.place = start
    walk.angle = angle
    left = length
    entry = wp.int32(-1)
    for _ in range(strips.edges.shape[2]):
        along = heading(walk.angle)
        out = exit_of(facets, walk.place, along, entry, left)
        if out.edge < 0:
            walk.place.at = walk.place.at + left * along
            walk.ended = WALKED
            return walk
        half_edge = 3 * walk.place.facet + out.edge
        if facets.twins[half_edge] < 0:
            walk.place.at = walk.place.at + out.way * along
            walk.ended = AT_BORDER
            return walk
        if push(facets, strips, thread, which, half_edge) == 0:
            walk.ended = OVERFULL
            return walk
        left = left - out.way
        walk.angle = walk.angle + facets.turns[half_edge]
        walk.place = across(facets, half_edge, out.share)
        entry = facets.twins[half_edge] % 3
    walk.ended = OVERFULL
    return walk


@wp.func
def walk_towards(
    facets: Facets,
    start: Place,
    goal: Place,
    point: wp.vec3d,
    strips: Strips,
    thread: int,
    which: int,
) -> Walk:
    """Go to a place near by, in each facet straight towards its foot.

    Where that is reached, and the place is one of the facet across an edge or round a corner, over
    that edge.

    Args:
        facets: of the surface.
        start: where to begin.
        goal: where to go.
        point: the same in space [m].
        strips: take down the half-edges crossed.
        thread: whose strips.
        which: strip to lengthen.
    """
    walk = Walk()
    walk.place = start
    entry = wp.int32(-1)
    for _ in range(strips.edges.shape[2]):
        if walk.place.facet == goal.facet:
            walk.place = goal
            walk.ended = WALKED
            return walk
        way = in_facet(facets, walk.place.facet, point) - walk.place.at
        far = wp.length(way)
        out = edge_under(facets, walk.place, entry)
        if far > SAME_PLACE * facets.sides[walk.place.facet]:
            out = exit_of(facets, walk.place, way / far, entry, wp.float64(1.0e9))
        if out.edge < 0:
            walk.ended = ASTRAY
            return walk
        half_edge = 3 * walk.place.facet + out.edge
        if facets.twins[half_edge] < 0:
            walk.ended = AT_BORDER
            return walk
        if push(facets, strips, thread, which, half_edge) == 0:
            walk.ended = OVERFULL
            return walk
        walk.place = across(facets, half_edge, out.share)
        entry = facets.twins[half_edge] % 3
    walk.ended = ASTRAY
    return walk
