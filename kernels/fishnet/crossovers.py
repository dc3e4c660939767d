"""Crossovers: places at the spacing from both neighbours, row by row from the generators."""

import warp as wp

from .facets import ZERO, Facets, Place, cross2, heading, in_space
from .funnel import HALF_TURN
from .meeting import Crossover, approach, first_guess
from .nodes import BEHIND, BORDER, CUT_OFF, FINE, PLACED, SHEARED, Net, place_of, put
from .strips import AT_BORDER, WALKED, WARP_STRIP, Strips, walk_straight


@wp.func
def inner_angle(net: Net, i: int, j: int, di: int, dj: int, sense: wp.float64) -> wp.float64:
    """Angle from warp to weft at the cell's corner by the start [rad]; a right one if unknown."""
    if net.status[i - di, j - dj] != PLACED:
        return sense * wp.float64(0.5) * HALF_TURN
    return net.weft_leave[i - di, j] - net.warp_leave[i, j - dj]


@wp.func
def shear_of(found: Crossover, sense: wp.float64, yarn_angle: wp.float64) -> wp.float64:
    """Shear angle at a crossover [rad], more than a right angle where the yarns have swapped sides.

    Args:
        found: the crossover.
        sense: 1 in the first and third quadrant, −1 in the others.
        yarn_angle: from warp to weft in the flat ply [rad].
    """
    a = heading(found.warp_arrive)
    b = heading(found.weft_arrive)
    angle = wp.atan2(sense * cross2(a, b), wp.dot(a, b))
    if sense < ZERO:
        angle = HALF_TURN - angle
    return yarn_angle - angle


@wp.func
def cross_over(
    facets: Facets,
    net: Net,
    i: int,
    j: int,
    di: int,
    dj: int,
    spacing: wp.float64,
    strips: Strips,
    thread: int,
) -> Crossover:
    """Look for node (i, j) from its neighbours (i − di, j) and (i, j − dj)."""
    beside = place_of(net, i - di, j)
    below = place_of(net, i, j - dj)
    sense = wp.float64(di * dj)
    inner = inner_angle(net, i, j, di, dj, sense)
    warp_angle = net.weft_arrive[i - di, j] - inner
    weft_angle = net.warp_arrive[i, j - dj] + inner
    guess = first_guess(facets, beside, below, warp_angle, weft_angle, spacing, strips, thread)
    if guess.status != PLACED:
        return guess
    found = approach(facets, beside, below, guess.place, spacing, strips, thread)
    found.stopped = found.stopped + guess.stopped
    return found


@wp.func
def true_direction(angle: wp.float64, forth: int) -> wp.float64:
    """A yarn's own direction from that in which the net grows along it, or the other way round."""
    if forth < 0:
        return angle + HALF_TURN
    return angle


@wp.func
def warp_beside(net: Net, i: int, j: int, d: wp.vec2i, on_axis: bool, yarn_angle: wp.float64):
    """Direction in which the net grows along the warp at a node; unsheared where there is none."""
    if on_axis:
        return true_direction(true_direction(net.weft_arrive[i, j], d[1]) - yarn_angle, d[0])
    return net.warp_arrive[i, j]


@wp.func
def weft_beside(net: Net, i: int, j: int, d: wp.vec2i, on_axis: bool, yarn_angle: wp.float64):
    """The same along the weft."""
    if on_axis:
        return true_direction(true_direction(net.warp_arrive[i, j], d[0]) + yarn_angle, d[1])
    return net.weft_arrive[i, j]


@wp.func
def go_on(
    facets: Facets,
    net: Net,
    i: int,
    j: int,
    d: wp.vec2i,
    middle: wp.vec2i,
    along_warp: bool,
    spacing: wp.float64,
    yarn_angle: wp.float64,
    strips: Strips,
    thread: int,
) -> int:
    """Let a yarn whose neighbour lies beyond a border go straight on; return what became of it.

    Its crossing yarn's direction there is taken as unsheared; the next crossovers start from it.
    """
    at = Place()
    along = ZERO
    if along_warp:
        at = place_of(net, i - d[0], j)
        along = warp_beside(net, i - d[0], j, d, i - d[0] == middle[0], yarn_angle)
    else:
        at = place_of(net, i, j - d[1])
        along = weft_beside(net, i, j - d[1], d, j - d[1] == middle[1], yarn_angle)
    strips.counts[thread, WARP_STRIP] = 0
    walk = walk_straight(facets, at, along, spacing, strips, thread, WARP_STRIP)
    net.seen[i, j] = in_space(facets, walk.place)
    if walk.ended == AT_BORDER:
        return BORDER
    if walk.ended != WALKED:
        return FINE
    put(net, i, j, walk.place)
    if along_warp:
        net.warp_leave[i, j] = along
        net.warp_arrive[i, j] = walk.angle
        own = true_direction(walk.angle, d[0])
        net.weft_arrive[i, j] = true_direction(own + yarn_angle, d[1])
    else:
        net.weft_leave[i, j] = along
        net.weft_arrive[i, j] = walk.angle
        own = true_direction(walk.angle, d[1])
        net.warp_arrive[i, j] = true_direction(own - yarn_angle, d[0])
    return PLACED


@wp.func
def by_border(status: int) -> bool:
    """Whether a node is missing because the surface ends."""
    return status == BORDER or status == BEHIND


@wp.func
def place_node(
    facets: Facets,
    net: Net,
    i: int,
    j: int,
    d: wp.vec2i,
    middle: wp.vec2i,
    spacing: wp.float64,
    yarn_angle: wp.float64,
    limit: wp.float64,
    strips: Strips,
    thread: int,
):
    """Place node (i, j) from its neighbours towards the start, or say why it cannot be.

    Args:
        facets: of the surface.
        net: changed.
        i: node along the warp.
        j: node along the weft.
        d: 1 or −1 along warp and weft, away from the start.
        middle: node of the start.
        spacing: of the net [m].
        yarn_angle: from warp to weft in the flat ply [rad].
        limit: largest shear angle [rad].
        strips: room for each thread.
        thread: whose.
    """
    beside = net.status[i - d[0], j]
    below = net.status[i, j - d[1]]
    if beside == PLACED and below == PLACED:
        found = cross_over(facets, net, i, j, d[0], d[1], spacing, strips, thread)
        net.seen[i, j] = in_space(facets, found.place)
        if found.status == PLACED:
            sense = wp.float64(d[0] * d[1])
            if wp.abs(shear_of(found, sense, yarn_angle)) > limit:
                found.status = SHEARED
                if found.stopped > 0:  # the other crossing of the circles: this one lies beyond
                    found.status = BORDER
        if found.status == PLACED:
            put(net, i, j, found.place)
            net.warp_leave[i, j] = found.warp_leave
            net.warp_arrive[i, j] = found.warp_arrive
            net.weft_leave[i, j] = found.weft_leave
            net.weft_arrive[i, j] = found.weft_arrive
        net.status[i, j] = found.status
    elif beside == PLACED and by_border(below):
        net.status[i, j] = go_on(
            facets, net, i, j, d, middle, True, spacing, yarn_angle, strips, thread
        )
    elif below == PLACED and by_border(beside):
        net.status[i, j] = go_on(
            facets, net, i, j, d, middle, False, spacing, yarn_angle, strips, thread
        )
    elif by_border(beside) and by_border(below):
        net.status[i, j] = BEHIND
    else:
        net.status[i, j] = CUT_OFF
