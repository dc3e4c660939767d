"""Crossovers: places at the spacing from both neighbours, diagonal by diagonal from the start."""

import warp as wp

from .facets import ZERO, Facets, Place, angle_of, cross2, heading, in_space
from .nodes import BEHIND, BORDER, COARSE, CUT_OFF, FINE, PLACED, SHEARED, Net, place_of, put
from .paths import HALF_TURN, TANGLED, straighten
from .strips import (
    AT_BORDER,
    BOTH_STRIPS,
    OVERFULL,
    WALKED,
    WARP_STRIP,
    WEFT_STRIP,
    Strips,
    walk_straight,
    walk_towards,
)

MOST_STEPS = wp.constant(40)
"""Newton steps towards a crossover: three or four where the surface is smooth."""
MOST_STOPS = wp.constant(6)
"""Steps that end at the border before a crossover counts as beyond it."""
CLOSE = wp.constant(wp.float64(2.0e-12))
"""Error of both lengths over the spacing at which a crossover is found [-]."""
LEAST_SINE = wp.constant(wp.float64(1.0e-3))
"""Sine of the angle between the yarns below which two circles have no crossing to speak of."""


@wp.struct
class Crossover:
    """A crossover that was looked for."""

    place: Place
    status: wp.int32
    warp_leave: wp.float64
    warp_arrive: wp.float64
    weft_leave: wp.float64
    weft_arrive: wp.float64


@wp.func
def step_to(a: wp.vec2d, b: wp.vec2d, short: wp.vec2d) -> wp.vec2d:
    """The step x with a·x and b·x as given: Newton's for the two lengths."""
    det = cross2(a, b)
    return wp.vec2d(short[0] * b[1] - short[1] * a[1], short[1] * a[0] - short[0] * b[0]) / det


@wp.func
def approach(
    facets: Facets,
    beside: Place,
    below: Place,
    start: Place,
    spacing: wp.float64,
    strips: Strips,
    thread: int,
) -> Crossover:
    """Find the place at the spacing from two neighbours, from one that strips join to both.

    Args:
        facets: of the surface.
        beside: the neighbour along the warp.
        below: the neighbour along the weft.
        start: where to begin.
        spacing: length of both segments [m].
        strips: from ``beside`` (warp) and ``below`` (weft) to ``start``.
        thread: whose.
    """
    found = Crossover()
    found.place = start
    found.status = COARSE
    stopped = int(0)
    for _ in range(MOST_STEPS):
        u = straighten(facets, beside, found.place, strips, thread, WARP_STRIP)
        v = straighten(facets, below, found.place, strips, thread, WEFT_STRIP)
        if u.ended == TANGLED or v.ended == TANGLED:
            return found
        short = wp.vec2d(spacing - u.length, spacing - v.length)
        if wp.max(wp.abs(short[0]), wp.abs(short[1])) <= CLOSE * spacing:
            found.status = PLACED
            if u.ended != 0 or v.ended != 0:
                found.status = BORDER
            found.warp_leave = u.leave
            found.warp_arrive = u.arrive
            found.weft_leave = v.leave
            found.weft_arrive = v.arrive
            return found
        a = heading(u.arrive)
        b = heading(v.arrive)
        if wp.abs(cross2(a, b)) < LEAST_SINE:
            found.status = SHEARED
            return found
        step = step_to(a, b, short)
        far = wp.length(step)
        if far > wp.float64(0.5) * spacing:
            step = step * (wp.float64(0.5) * spacing / far)
            far = wp.float64(0.5) * spacing
        walk = walk_straight(facets, found.place, angle_of(step), far, strips, thread, BOTH_STRIPS)
        found.place = walk.place
        if walk.ended == OVERFULL:
            found.status = FINE
            return found
        if walk.ended == AT_BORDER:
            stopped = stopped + 1
            if stopped > MOST_STOPS:
                break
    if stopped > 0:
        found.status = BORDER
    return found


@wp.func
def first_guess(
    facets: Facets,
    beside: Place,
    below: Place,
    warp_angle: wp.float64,
    weft_angle: wp.float64,
    spacing: wp.float64,
    strips: Strips,
    thread: int,
) -> Crossover:
    """Go straight from both neighbours by the spacing, and join the two ends.

    Args:
        facets: of the surface.
        beside: the neighbour along the warp.
        below: the neighbour along the weft.
        warp_angle: in which the warp may leave ``beside`` [rad].
        weft_angle: in which the weft may leave ``below`` [rad].
        spacing: of the net [m].
        strips: filled from both to the guess.
        thread: whose.
    """
    guess = Crossover()
    guess.status = COARSE
    strips.counts[thread, WARP_STRIP] = 0
    strips.counts[thread, WEFT_STRIP] = 0
    u = walk_straight(facets, beside, warp_angle, spacing, strips, thread, WARP_STRIP)
    v = walk_straight(facets, below, weft_angle, spacing, strips, thread, WEFT_STRIP)
    if u.ended == OVERFULL or v.ended == OVERFULL:
        guess.status = FINE
        return guess
    goal = in_space(facets, v.place)
    join = walk_towards(facets, u.place, v.place, goal, strips, thread, WARP_STRIP)
    guess.place = v.place
    if join.ended != WALKED:
        strips.counts[thread, WARP_STRIP] = 0
        u = walk_straight(facets, beside, warp_angle, spacing, strips, thread, WARP_STRIP)
        goal = in_space(facets, u.place)
        join = walk_towards(facets, v.place, u.place, goal, strips, thread, WEFT_STRIP)
        guess.place = u.place
    if join.ended == WALKED:
        guess.status = PLACED
    elif u.ended == AT_BORDER or v.ended == AT_BORDER or join.ended == AT_BORDER:
        guess.status = BORDER
    return guess


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
    return approach(facets, beside, below, guess.place, spacing, strips, thread)


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


@wp.kernel(enable_backward=False)
def compute_crossovers(
    facets: Facets,
    net: Net,
    middle: wp.vec2i,
    diagonal: int,
    spacing: wp.float64,
    yarn_angle: wp.float64,
    limit: wp.float64,
    strips: Strips,
):
    """Place the nodes of one diagonal, in all four quadrants; one thread a node.

    Args:
        facets: of the surface.
        net: of which the diagonals before are placed; changed.
        middle: node of the start.
        diagonal: how many yarns from the start, along warp and weft together.
        spacing: of the net [m].
        yarn_angle: from warp to weft in the flat ply [rad].
        limit: largest shear angle [rad].
        strips: room for each thread; for one, where threads take turns as on the processor.
    """
    quadrant, k = wp.tid()
    d = wp.vec2i(1 - 2 * (quadrant % 2), 1 - 2 * (quadrant // 2))
    i = middle[0] + d[0] * (k + 1)
    j = middle[1] + d[1] * (diagonal - 1 - k)
    if i < 0 or j < 0 or i >= net.status.shape[0] or j >= net.status.shape[1]:
        return
    thread = wp.min(quadrant * (diagonal - 1) + k, strips.counts.shape[0] - 1)
    beside = net.status[i - d[0], j]
    below = net.status[i, j - d[1]]
    if beside == PLACED and below == PLACED:
        found = cross_over(facets, net, i, j, d[0], d[1], spacing, strips, thread)
        net.seen[i, j] = in_space(facets, found.place)
        if found.status == PLACED:
            sense = wp.float64(d[0] * d[1])
            if wp.abs(shear_of(found, sense, yarn_angle)) > limit:
                found.status = SHEARED
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
