"""Chains of bars between crossovers through which the yarns slide: how much yarn is where.

A bar from crossover to crossover has l = l0 + s_upper − s_lower of yarn in it, s being how much of
a yarn has gone through a crossover, along the yarn's own direction (Eulerian along the yarns, as
crossovers stay vertices). c is the share of a crossover in which there still is yarn: it falls
from 1 to 0 as a yarn's end goes by, and a bar holds while both of its crossovers have some.
"""

import warp as wp


@wp.struct
class Bars:
    """Bars of a ply; see `warpdrape.blanks.yarn_chains`."""

    ends: wp.array(dtype=wp.vec2i)  # lower and upper vertex, in the model's numbering
    numbers: wp.array(dtype=wp.vec2i)  # … and crossover
    family: wp.array(dtype=wp.int32)  # 0 warp, 1 weft
    lengths: wp.array(dtype=wp.float64)  # l0 [m]
    widths: wp.array(dtype=wp.float64)  # w [m]
    mates: wp.array(dtype=wp.vec4i)  # bars of the other family in its quadrants; −1 for none
    areas: wp.array(dtype=wp.vec4d)  # flat areas of these quadrants [m²]
    viscosity: wp.vec2d  # line tension per change of lengthening in a step [N/m]


@wp.struct
class Crossovers:
    """Crossovers of a ply; of pairs the first is the warp's, the second the weft's."""

    bars: wp.array(dtype=wp.vec4i)  # before and after on the warp, and on the weft; −1 for none
    slip: wp.array(dtype=wp.vec2d)  # F without tension [N]
    stiffness: wp.array(dtype=wp.vec2d)  # k [N/m]
    inertia: wp.array(dtype=wp.vec2d)  # M [N/m]
    friction: wp.array(dtype=wp.vec2d)  # F added per line tension of the other family [m]
    rubbing: wp.array(dtype=wp.float64)  # F added per force of a crossing's yarns on each other [-]
    pressed: wp.array(dtype=wp.float64)  # of this force what contacts bring [N]
    below: wp.array(dtype=wp.vec2d)  # yarn before its share's upper end, flat [m]
    above: wp.array(dtype=wp.vec2d)  # yarn after its share's lower end, flat [m]
    span: wp.array(dtype=wp.vec2d)  # length of its share [m]
    held: wp.array(dtype=wp.int32)  # 1 where a clamp grips the yarns


@wp.struct
class Slide:
    """State of a crossover's two yarns, warp and weft."""

    s: wp.vec2d  # yarn gone through it [m]
    grip: wp.vec2d  # e, elongation of its springs [m]
    rate: wp.vec2d  # r, change of s in the last step [m]
    work: wp.float64  # done by the pulls up to half of it [J]


@wp.func
def share_left(below: wp.float64, above: wp.float64, span: wp.float64, s: wp.float64) -> wp.float64:
    """Share c of a crossover in which there is yarn [-]: 1 until an end comes, 0 after it."""
    zero = wp.float64(0.0)
    one = wp.float64(1.0)
    if span <= zero:
        return zero
    left = wp.clamp((below + s) / span, zero, one) + wp.clamp((above - s) / span, zero, one) - one
    return wp.max(left, zero)


@wp.func
def share_slope(
    below: wp.float64, above: wp.float64, span: wp.float64, s: wp.float64
) -> wp.float64:
    """∂c/∂s [1/m]."""
    zero = wp.float64(0.0)
    slope = zero
    if share_left(below, above, span, s) > zero:
        if below + s < span:
            slope += wp.float64(1.0) / span
        if above - s < span:
            slope -= wp.float64(1.0) / span
    return slope


@wp.func
def yarn_left(crossovers: Crossovers, v: int, f: int, s: wp.float64) -> wp.float64:
    """`share_left` of a crossover's yarn."""
    return share_left(crossovers.below[v][f], crossovers.above[v][f], crossovers.span[v][f], s)


@wp.func
def left_slope(crossovers: Crossovers, v: int, f: int, s: wp.float64) -> wp.float64:
    """`share_slope` of a crossover's yarn."""
    return share_slope(crossovers.below[v][f], crossovers.above[v][f], crossovers.span[v][f], s)


@wp.func
def bar_material(bars: Bars, b: int, slides: wp.array(dtype=Slide)) -> wp.float64:
    """Yarn l in a bar [m]."""
    f = bars.family[b]
    ends = bars.numbers[b]
    return bars.lengths[b] + slides[ends[1]].s[f] - slides[ends[0]].s[f]


@wp.func
def bar_distance(bars: Bars, b: int, x: wp.array(dtype=wp.vec3d)) -> wp.float64:
    """Distance of a bar's ends [m]."""
    ends = bars.ends[b]
    return wp.length(x[ends[1]] - x[ends[0]])


@wp.func
def bar_strain(
    bars: Bars, b: int, slides: wp.array(dtype=Slide), x: wp.array(dtype=wp.vec3d)
) -> wp.float64:
    """ε of the yarn in a bar [-]."""
    return bar_distance(bars, b, x) / bar_material(bars, b, slides) - wp.float64(1.0)


@wp.func
def end_shares(
    bars: Bars, crossovers: Crossovers, b: int, slides: wp.array(dtype=Slide)
) -> wp.vec2d:
    """Shares c of a bar's lower and upper crossover [-]; it holds while both are above 0."""
    f = bars.family[b]
    lower = bars.numbers[b][0]
    upper = bars.numbers[b][1]
    return wp.vec2d(
        yarn_left(crossovers, lower, f, slides[lower].s[f]),
        yarn_left(crossovers, upper, f, slides[upper].s[f]),
    )


@wp.func
def bar_holds(bars: Bars, crossovers: Crossovers, b: int, slides: wp.array(dtype=Slide)) -> bool:
    """Whether there is yarn in both of a bar's crossovers."""
    shares = end_shares(bars, crossovers, b, slides)
    return shares[0] * shares[1] > wp.float64(0.0)
