"""The two generator yarns: geodesics, bent ones, or sections by planes."""

import warp as wp

from .facets import ZERO, Facets, Place, angle_of, heading, in_space
from .nodes import BEHIND, BORDER, COARSE, CUT_OFF, FINE, Net, put
from .paths import straighten
from .strips import (
    AT_BORDER,
    ON_THE_WAY,
    OVERFULL,
    WALKED,
    WARP_STRIP,
    Step,
    Strips,
    Walk,
    go_on,
    set_out,
    walk_straight,
)


@wp.func
def node_of_half(middle: wp.vec2i, half: int, n: int) -> wp.vec2i:
    """Node n of a half generator: 0 and 1 are the warp forth and back, 2 and 3 the weft."""
    step = n * (1 - 2 * (half % 2))
    if half < 2:
        return wp.vec2i(middle[0] + step, middle[1])
    return wp.vec2i(middle[0], middle[1] + step)


@wp.func
def put_on_half(
    net: Net, at: wp.vec2i, half: int, place: Place, leave: wp.float64, arrive: wp.float64
):
    """Set a node of a generator."""
    put(net, at[0], at[1], place)
    if half < 2:
        net.warp_leave[at[0], at[1]] = leave
        net.warp_arrive[at[0], at[1]] = arrive
    else:
        net.weft_leave[at[0], at[1]] = leave
        net.weft_arrive[at[0], at[1]] = arrive


@wp.func
def missing(ended: int) -> int:
    """What becomes of a node where a walk ended otherwise than it should."""
    if ended == AT_BORDER:
        return BORDER
    if ended == OVERFULL:
        return FINE
    return COARSE


@wp.func
def end_half(net: Net, middle: wp.vec2i, half: int, n: int, count: int, status: int):
    """Give up a half generator at node n."""
    for m in range(n, count + 1):
        at = node_of_half(middle, half, m)
        if m == n:
            net.status[at[0], at[1]] = status
        elif status == BORDER:
            net.status[at[0], at[1]] = BEHIND
        else:
            net.status[at[0], at[1]] = CUT_OFF


@wp.func
def in_plane(facets: Facets, facet: int, normal: wp.vec3d) -> wp.vec2d:
    """Unit direction in a facet in which a plane cuts it."""
    upward = wp.cross(facets.firsts[facet], facets.seconds[facet])
    along = wp.cross(normal, upward)
    return wp.normalize(
        wp.vec2d(wp.dot(along, facets.firsts[facet]), wp.dot(along, facets.seconds[facet]))
    )


@wp.func
def walk_in_plane(
    facets: Facets,
    start: Place,
    normal: wp.vec3d,
    length: wp.float64,
    strips: Strips,
    thread: int,
) -> Walk:
    """Go along the section of the surface by a plane; the strip WARP_STRIP is lengthened.

    Args:
        facets: of the surface.
        start: where to begin, in the plane.
        normal: of the plane; the way has it to its left, seen from outside.
        length: of the way [m]; backwards where negative.
        strips: take down the half-edges crossed.
        thread: whose strips.
    """
    step = Step()
    step.walk = set_out(start, ZERO)
    step.left = wp.abs(length)
    for _ in range(strips.edges.shape[2]):
        along = in_plane(facets, step.walk.place.facet, normal)
        if length < ZERO:
            along = -along
        step.walk.angle = angle_of(along)
        step = go_on(facets, step.walk, along, step.left, strips, thread, WARP_STRIP)
        if step.walk.ended != ON_THE_WAY:
            return step.walk
    step.walk.ended = OVERFULL
    return step.walk


@wp.func
def next_in_plane(
    facets: Facets,
    net: Net,
    at: wp.vec2i,
    half: int,
    start: Place,
    normal: wp.vec3d,
    spacing: wp.float64,
    strips: Strips,
    thread: int,
) -> Place:
    """Place the next node of a plane generator: on the section, at the spacing from the last.

    The yarn between them is a geodesic of that length, as everywhere in the net.
    """
    strips.counts[thread, WARP_STRIP] = 0
    walk = walk_in_plane(facets, start, normal, spacing, strips, thread)
    for _ in range(30):
        if walk.ended != WALKED:
            break
        path = straighten(facets, start, walk.place, strips, thread, WARP_STRIP)
        if wp.abs(path.length - spacing) <= wp.float64(2.0e-12) * spacing:
            put_on_half(net, at, half, walk.place, path.leave, path.arrive)
            return walk.place
        along = in_plane(facets, walk.place.facet, normal)
        gain = wp.max(wp.dot(along, heading(path.arrive)), wp.float64(0.1))
        step = (spacing - path.length) / gain
        walk = walk_in_plane(facets, walk.place, normal, step, strips, thread)
    net.seen[at[0], at[1]] = in_space(facets, walk.place)
    net.status[at[0], at[1]] = missing(walk.ended)
    return walk.place


@wp.func
def lay_half(
    facets: Facets,
    net: Net,
    middle: wp.vec2i,
    start: Place,
    angles: wp.array(dtype=wp.float64),
    counts: wp.array(dtype=wp.int32),
    turns: wp.array2d(dtype=wp.float64),
    spacing: wp.float64,
    strips: Strips,
    half: int,
    thread: int,
):
    """Lay half a generator out from the start, straight but for given turns.

    Args:
        facets: of the surface.
        net: changed.
        middle: node of the start.
        start: its place.
        angles: directions in which the halves leave it [rad], shape [4].
        counts: nodes of the halves after the start, shape [4].
        turns: of the yarn at each node, to its left [rad], shape [4, node].
        spacing: of the net [m].
        strips: room for each thread.
        half: which; 0 and 1 are the warp forth and back, 2 and 3 the weft.
        thread: whose strips.
    """
    place = start
    along = angles[half]
    for n in range(1, counts[half] + 1):
        at = node_of_half(middle, half, n)
        along = along + turns[half, n - 1]
        strips.counts[thread, WARP_STRIP] = 0
        walk = walk_straight(facets, place, along, spacing, strips, thread, WARP_STRIP)
        if walk.ended != WALKED:
            net.seen[at[0], at[1]] = in_space(facets, walk.place)
            end_half(net, middle, half, n, counts[half], missing(walk.ended))
            return
        put_on_half(net, at, half, walk.place, along, walk.angle)
        place = walk.place
        along = walk.angle


@wp.func
def lay_half_in_plane(
    facets: Facets,
    net: Net,
    middle: wp.vec2i,
    start: Place,
    normals: wp.array(dtype=wp.vec3d),
    counts: wp.array(dtype=wp.int32),
    spacing: wp.float64,
    strips: Strips,
    half: int,
    thread: int,
):
    """Lay half a generator out along the section by a plane through the start.

    Args:
        facets: of the surface.
        net: changed.
        middle: node of the start.
        start: its place.
        normals: of the planes, to the left of each half, shape [4].
        counts: nodes of the halves after the start, shape [4].
        spacing: of the net [m].
        strips: room for each thread.
        half: which, as for `lay_half`.
        thread: whose strips.
    """
    place = start
    for n in range(1, counts[half] + 1):
        at = node_of_half(middle, half, n)
        normal = normals[half]
        place = next_in_plane(facets, net, at, half, place, normal, spacing, strips, thread)
        if net.facets[at[0], at[1]] < 0:
            end_half(net, middle, half, n, counts[half], net.status[at[0], at[1]])
            return
