"""Where two yarns meet: the place at the spacing from two neighbours."""

import warp as wp

from .facets import Facets, Place, angle_of, cross2, heading, in_space
from .funnel import TANGLED
from .nodes import BORDER, COARSE, FINE, PLACED, SHEARED
from .paths import straighten
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
    stopped: wp.int32  # how often the search for it met the border
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
    stopped = wp.int32(0)
    for _ in range(MOST_STEPS):
        u = straighten(facets, beside, found.place, strips, thread, WARP_STRIP)
        v = straighten(facets, below, found.place, strips, thread, WEFT_STRIP)
        if u.ended == TANGLED or v.ended == TANGLED:
            return found
        found.stopped = stopped
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
            if stopped > 0:
                found.status = BORDER
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
    if u.ended == AT_BORDER or v.ended == AT_BORDER:
        guess.stopped = 1
    if join.ended == WALKED:
        guess.status = PLACED
    elif guess.stopped > 0 or join.ended == AT_BORDER:
        guess.status = BORDER
    return guess
