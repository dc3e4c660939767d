"""Strips: the half-edges that a way crosses, one after the other, and walks that lengthen them."""

import warp as wp

from .facets import (
    Exit,
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
ON_THE_WAY = wp.constant(4)
"""How a walk ended: there; at the surface's border; after more facets than a strip holds; it did
not find the facet that it looked for; or it did not yet."""


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
    entry: wp.int32  # corner at which the half-edge begins over which it came in, −1 if over none
    ended: wp.int32  # one of WALKED, AT_BORDER, …


@wp.struct
class Step:
    """A walk after one facet more."""

    walk: Walk
    left: wp.float64  # of the way [m]


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
def set_out(place: Place, angle: wp.float64) -> Walk:
    """A walk that begins."""
    walk = Walk()
    walk.place = place
    walk.angle = angle
    walk.entry = -1
    walk.ended = ON_THE_WAY
    return walk


@wp.func
def cross_edge(
    facets: Facets, walk: Walk, out: Exit, strips: Strips, thread: int, which: int
) -> Walk:
    """Leave a facet for the one across, its direction unfolded; or end there."""
    half_edge = 3 * walk.place.facet + out.edge
    if facets.twins[half_edge] < 0:
        walk.ended = AT_BORDER
    elif push(facets, strips, thread, which, half_edge) == 0:
        walk.ended = OVERFULL
    else:
        walk.angle = walk.angle + facets.turns[half_edge]
        walk.place = across(facets, half_edge, out.share)
        walk.entry = facets.twins[half_edge] % 3
    return walk


@wp.func
def go_on(
    facets: Facets,
    walk: Walk,
    along: wp.vec2d,
    left: wp.float64,
    strips: Strips,
    thread: int,
    which: int,
) -> Step:
    """Go straight on to the end of the way, or into the next facet.

    Args:
        facets: of the surface.
        walk: so far.
        along: unit direction in its facet.
        left: of the way [m].
        strips: take down the half-edges crossed.
        thread: whose strips.
        which: strip to lengthen.
    """
    step = Step()
    step.walk = walk
    out = exit_of(facets, walk.place, along, walk.entry, left)
    step.walk.place.at = walk.place.at + out.way * along
    step.left = left - out.way
    if out.edge < 0:
        step.walk.ended = WALKED
    else:
        step.walk = cross_edge(facets, step.walk, out, strips, thread, which)
    return step


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
    step = Step()
    step.walk = set_out(start, angle)
    step.left = length
    for _ in range(strips.edges.shape[2]):
        along = heading(step.walk.angle)
        step = go_on(facets, step.walk, along, step.left, strips, thread, which)
        if step.walk.ended != ON_THE_WAY:
            return step.walk
    step.walk.ended = OVERFULL
    return step.walk


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
    walk = set_out(start, wp.float64(0.0))
    for _ in range(strips.edges.shape[2]):
        if walk.place.facet == goal.facet:
            walk.place = goal
            walk.ended = WALKED
            return walk
        way = in_facet(facets, walk.place.facet, point) - walk.place.at
        far = wp.length(way)
        out = edge_under(facets, walk.place, walk.entry)
        if far > SAME_PLACE * facets.sides[walk.place.facet]:
            out = exit_of(facets, walk.place, way / far, walk.entry, wp.float64(1.0e9))
        if out.edge < 0:
            walk.ended = ASTRAY
            return walk
        walk = cross_edge(facets, walk, out, strips, thread, which)
        if walk.ended != ON_THE_WAY:
            return walk
    walk.ended = ASTRAY
    return walk
