"""The shortest way through an unfolded strip: a string pulled tight in a funnel.

Where its end is out of sight of its start the way bends at vertices of the strip's sides (Lee and
Preparata 1984). One that bends round a vertex with less than half a turn on its other side would be
shorter there; it is named, for the strip to be turned to that side.
"""

import warp as wp

from .facets import ZERO, Facets, angle_of, cross2, next_corner, vertex_of
from .strips import Strips

HALF_TURN = wp.constant(wp.float64(3.141592653589793))
WHOLE_TURN = wp.constant(wp.float64(6.283185307179586))
BENT = wp.constant(wp.float64(1.0e-9))
"""Bend of a way [rad] that is no more than rounding."""

STRAIGHTENED = wp.constant(0)
ALONG_BORDER = wp.constant(1)
TANGLED = wp.constant(2)
"""How it went: a geodesic; a way that hugs the border; or too many turns."""


@wp.struct
class Path:
    """A shortest way from one place to another."""

    length: wp.float64  # [m]
    leave: wp.float64  # direction at its start, in the facet there [rad]
    arrive: wp.float64  # direction at its end, in the facet there [rad]
    ended: wp.int32  # one of STRAIGHTENED, ALONG_BORDER, TANGLED
    bend: wp.int32  # crossing at whose end it bends the wrong way, −1 if none
    side: wp.int32  # 1 if that vertex lies to the left, −1 to the right


@wp.func
def bend_at(
    facets: Facets, edges: Strips, thread: int, which: int, i: int, side: int, turn: wp.float64
) -> int:
    """What a bend at an end of a crossed half-edge is: 0 right, 1 to be turned, 2 at a border.

    Args:
        facets: of the surface.
        edges: the strips.
        thread: whose.
        which: strip.
        i: number of the crossing.
        side: 1 for its left end, −1 for its right one.
        turn: of the way there towards that side [rad].
    """
    half_edge = edges.edges[thread, which, i]
    k = half_edge % 3
    if side > 0:
        k = next_corner(k)
    total = facets.around[vertex_of(facets, half_edge // 3, k)]
    if total < ZERO:
        return 2
    if turn < -BENT:  # wound round the vertex by more than half a turn
        turn = turn + WHOLE_TURN
    if total - HALF_TURN - turn < HALF_TURN - BENT:
        return 1
    return 0


@wp.func
def turn_between(a: wp.vec2d, b: wp.vec2d) -> wp.float64:
    """Angle from one vector to another [rad]."""
    return wp.atan2(cross2(a, b), wp.dot(a, b))


@wp.func
def pull_tight(
    facets: Facets, start: wp.vec2d, goal: wp.vec2d, strips: Strips, thread: int, which: int
) -> Path:
    """The shortest way through an unfolded strip, with its first bend that is to be turned round.

    ``arrive`` is in the strip's plane. Source: the funnel of Lee and Preparata (1984).
    """
    path = Path()
    path.bend = -1
    count = strips.counts[thread, which]
    apex = start
    before = wp.vec2d(ZERO, ZERO)  # the way into the corner at the apex
    corner = wp.int32(-1)
    side = wp.int32(0)
    left = start
    right = start
    at_left = wp.int32(-1)
    at_right = wp.int32(-1)
    i = wp.int32(0)
    for _ in range((count + 2) * (count + 2)):
        if i > count:
            break
        to_left = goal
        to_right = goal
        if i < count:
            to_left = strips.left[thread, i]
            to_right = strips.right[thread, i]
        found = wp.int32(0)
        if cross2(right - apex, to_right - apex) >= ZERO:
            if right == apex or cross2(left - apex, to_right - apex) < ZERO:
                right = to_right
                at_right = i
            else:
                found = wp.int32(1)
        if found == 0 and cross2(left - apex, to_left - apex) <= ZERO:
            if left == apex or cross2(right - apex, to_left - apex) > ZERO:
                left = to_left
                at_left = i
            else:
                found = wp.int32(-1)
        if found == 0:
            i = i + 1
        else:
            to = left
            at = at_left
            if found < 0:
                to = right
                at = at_right
            if at == count:  # the goal itself, on the line to it
                break
            if not (to == apex):  # else the next half-edge ends at the same corner
                way = to - apex
                path.length = path.length + wp.length(way)
                if corner < 0:
                    path.leave = angle_of(way)
                elif path.bend < 0:
                    turn = wp.float64(side) * turn_between(before, way)
                    kind = bend_at(facets, strips, thread, which, corner, side, turn)
                    if kind == 1:
                        path.bend = corner
                        path.side = side
                    if kind == 2:
                        path.ended = ALONG_BORDER
                before = way
                corner = at
                side = found
            apex = to
            left = to
            right = to
            at_left = at
            at_right = at
            i = at + 1
    way = goal - apex
    path.length = path.length + wp.length(way)
    path.arrive = angle_of(way)
    if corner < 0:
        path.leave = path.arrive
    elif path.bend < 0:
        turn = wp.float64(side) * turn_between(before, way)
        kind = bend_at(facets, strips, thread, which, corner, side, turn)
        if kind == 1:
            path.bend = corner
            path.side = side
        if kind == 2:
            path.ended = ALONG_BORDER
    return path
