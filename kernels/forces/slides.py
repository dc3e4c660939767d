"""Yarns that slide through crossovers: their inertia, and the springs that slip which hold them.

On a crossover the bars pull with Q = −∂W/∂s (`bar_loads`). The crossing's spring, W = ½ c k e² of
elongation e, holds up to a limit c F, at which the yarn slips.

Slides have an inertia, as vertices have, so that yarn that moves need not be driven anew in every
step; it is counted in steps, M = m/Δt² [N/m], and follows from the bars' stiffness alone. With r
the slide in a step, M Δr = Q − c k e: explicit in the bars, implicit in the spring, which may be as
stiff as it likes. Vertices and slides share the bars: (Δt ω)² ≤ q_x + q_s, see `SLIDES_SHARE`.
"""

import warp as wp

from .bar_loads import NONE, drawn_out, of_both
from .sliding_bars import BarMemory, bar_drag
from .yarn_chains import (
    Bars,
    Crossovers,
    Slide,
    bar_holds,
    yarn_left,
)

LEAST_SPACING = wp.constant(wp.float64(0.75))
"""Length of a bar over its flat one below which no more yarn slides out of it [-]: its crossing
yarns lie on each other by then."""
SLIDES_SHARE = 1.0
"""q_s, what slides take at most of the 4 in (Δt ω)² ≤ 4 [-]: their inertia is 2/q_s times the sum
of the bars beside them, as stiff as these may be."""
ANY = wp.constant(wp.float64(1.0e30))
"""Yarn that may leave where no bar could run out of it, elongation where nothing holds [m]."""


@wp.struct
class Pulls:
    """What the bars do to a crossover."""

    pull: wp.vec2d  # Q [N]
    tension: wp.vec2d  # mean line tension of the bars beside it [N/m]
    press: wp.float64  # of its yarns on each other, at one crossing of them [N]
    room_below: wp.vec2d  # yarn that may leave the bars before it [m]
    room_above: wp.vec2d  # … after it


@wp.struct
class Grip:
    """Answer of a crossing's spring."""

    rate: wp.float64  # r [m]
    elongation: wp.float64  # e after it [m]


@wp.func
def most_held(spring: wp.float64, limit: wp.float64) -> wp.float64:
    """Elongation at which a crossing slips [m]."""
    if spring > wp.float64(0.0):
        return limit / spring
    return ANY


@wp.func
def gripped(
    pull: wp.float64,
    rate: wp.float64,
    elongation: wp.float64,
    inertia: wp.float64,
    spring: wp.float64,
    limit: wp.float64,
) -> Grip:
    """Slide of a crossing in a step.

    Args:
        pull: Q of the bars [N].
        rate: r in the step before [m].
        elongation: e of the spring [m].
        inertia: M [N/m].
        spring: c k [N/m]; 0 where yarns end on each other without a crossing.
        limit: c F [N].
    """
    one = wp.float64(1.0)
    out = Grip()
    most = most_held(spring, limit)
    driven = rate + pull / inertia
    e = wp.clamp(elongation, -most, most)
    out.rate = (driven - spring * e / inertia) / (one + spring / inertia)
    out.elongation = e + out.rate
    if wp.abs(out.elongation) > most:
        out.elongation = wp.sign(out.elongation) * most
        out.rate = driven - spring * out.elongation / inertia
    return out


@wp.func
def spring_energy(crossovers: Crossovers, v: int, slide: Slide) -> wp.float64:
    """Energy of a crossover's springs [J]."""
    total = wp.float64(0.0)
    for f in range(2):
        spring = yarn_left(crossovers, v, f, slide.s[f]) * crossovers.stiffness[v][f]
        total += wp.float64(0.5) * spring * slide.grip[f] * slide.grip[f]
    return total


@wp.kernel(enable_backward=False)
def take_slides(first: int, moved: wp.array(dtype=Slide), slides: wp.array(dtype=Slide)):
    """Go on from the slides after a step; one thread a crossover.

    Args:
        first: number of the first crossover.
        moved: from `slide_yarns`, shape [crossover].
        slides: shape [crossover]; overwritten.
    """
    v = first + wp.tid()
    slides[v] = moved[v]


def make_slide_kernels(bar_loads, press, Tension):
    """Make the kernels of slides for one law: ``(slide_yarns, measure_slides)``.

    Args:
        bar_loads: from `bar_loads.make_lone_loads` or `make_coupled_loads`.
        press: wp.func (law, ρ, λ) → force of a crossing's yarns on each other [N].
        Tension: struct of the tension law.
    """

    @wp.func
    def press_at(
        law: Tension,
        bars: Bars,
        crossovers: Crossovers,
        v: int,
        slides: wp.array(dtype=Slide),
        x: wp.array(dtype=wp.vec3d),
    ) -> wp.float64:
        """Mean over the pairs of bars beside a crossover."""
        total = wp.float64(0.0)
        pairs = wp.float64(0.0)
        for k in range(4):
            warp = crossovers.bars[v][k // 2]
            weft = crossovers.bars[v][2 + k % 2]
            if warp != NONE and weft != NONE:
                if bar_holds(bars, crossovers, warp, slides) and bar_holds(
                    bars, crossovers, weft, slides
                ):
                    a = drawn_out(bars, warp, slides, x)
                    b = drawn_out(bars, weft, slides, x)
                    total += press(law, of_both(0, a[0], b[0]), of_both(0, a[1], b[1]))
                    pairs += wp.float64(1.0)
        return total / wp.max(pairs, wp.float64(1.0))

    @wp.func
    def pulls_on(
        law: Tension,
        bars: Bars,
        crossovers: Crossovers,
        v: int,
        slides: wp.array(dtype=Slide),
        memory: wp.array(dtype=BarMemory),
        x: wp.array(dtype=wp.vec3d),
    ) -> Pulls:
        """What the bars beside a crossover do to it."""
        one = wp.float64(1.0)
        out = Pulls()
        out.room_below = wp.vec2d(ANY, ANY)
        out.room_above = wp.vec2d(ANY, ANY)
        for f in range(2):
            beside = wp.float64(0.0)
            total = wp.float64(0.0)
            for side in range(2):
                b = crossovers.bars[v][2 * f + side]
                if b != NONE:
                    loads = bar_loads(law, bars, crossovers, b, slides, x)
                    if loads.holds:
                        drag = bar_drag(bars, b, memory[b], loads.distance, loads.material)
                        pull = bars.widths[b] * (loads.draw + drag)
                        total += loads.tension
                        beside += one
                        room = loads.material - LEAST_SPACING * bars.lengths[b]
                        room = wp.max(room, wp.float64(0.0))
                        if side == 0:
                            out.pull[f] += pull + loads.ends[1]
                            out.room_below[f] = room
                        else:
                            out.pull[f] += loads.ends[0] - pull
                            out.room_above[f] = room
            out.tension[f] = total / wp.max(beside, one)
        if crossovers.rubbing[v] > wp.float64(0.0):
            out.press = press_at(law, bars, crossovers, v, slides, x) + crossovers.pressed[v]
        return out

    @wp.kernel(module="unique", enable_backward=False)
    def slide_yarns(
        first: int,
        law: Tension,
        bars: Bars,
        crossovers: Crossovers,
        slides: wp.array(dtype=Slide),
        memory: wp.array(dtype=BarMemory),
        x: wp.array(dtype=wp.vec3d),
        moved: wp.array(dtype=Slide),
    ):
        """Compute the slides after a step from those before; one thread a crossover.

        Args:
            first: number of the first crossover.
            law: line tension law [N/m].
            bars: of a ply.
            crossovers: of the ply.
            slides: of its crossovers, shape [crossover].
            memory: of its bars, shape [bar].
            x: positions [m], shape [vertex].
            moved: slides after the step, shape [crossover]; overwritten.
        """
        v = first + wp.tid()
        half = wp.float64(0.5)
        known = slides[v]
        on = pulls_on(law, bars, crossovers, v, slides, memory, x)
        now = Slide()
        now.s = known.s
        now.grip = known.grip
        for f in range(2):
            left = yarn_left(crossovers, v, f, known.s[f])
            if crossovers.held[v] == 0 and left > wp.float64(0.0):
                spring = left * crossovers.stiffness[v][f]
                pressed = wp.max(on.tension[1 - f], wp.float64(0.0))
                limit = crossovers.slip[v][f] + crossovers.friction[v][f] * pressed
                limit = left * (limit + crossovers.rubbing[v] * on.press)
                grip = gripped(
                    on.pull[f],
                    known.rate[f],
                    known.grip[f],
                    crossovers.inertia[v][f],
                    spring,
                    limit,
                )
                # its neighbour may take the other half of a bar's
                rate = wp.clamp(grip.rate, -half * on.room_below[f], half * on.room_above[f])
                if rate != grip.rate:
                    most = most_held(spring, limit)
                    grip.elongation = wp.clamp(known.grip[f] + rate, -most, most)
                now.s[f] = known.s[f] + rate
                now.rate[f] = rate
                now.grip[f] = grip.elongation
        now.work = known.work + half * wp.dot(on.pull, known.rate + now.rate)
        moved[v] = now

    @wp.kernel(module="unique", enable_backward=False)
    def measure_slides(
        law: Tension,
        bars: Bars,
        crossovers: Crossovers,
        slides: wp.array(dtype=Slide),
        memory: wp.array(dtype=BarMemory),
        x: wp.array(dtype=wp.vec3d),
        energies: wp.array(dtype=wp.vec3d),
    ):
        """Compute what crossovers show; one thread a crossover.

        Args:
            law: line tension law [N/m].
            bars: of a ply.
            crossovers: of the ply.
            slides: of its crossovers, shape [crossover].
            memory: of its bars, shape [bar].
            x: positions [m], shape [vertex].
            energies: of springs, of motion, lost in slip [J], shape [crossover]; overwritten.
        """
        v = wp.tid()
        known = slides[v]
        half = wp.float64(0.5)
        on = pulls_on(law, bars, crossovers, v, slides, memory, x)
        springs = spring_energy(crossovers, v, known)
        moving = half * wp.dot(crossovers.inertia[v], wp.cw_mul(known.rate, known.rate))
        work = known.work + half * wp.dot(on.pull, known.rate)
        energies[v] = wp.vec3d(springs, moving, work - springs - moving)

    return slide_yarns, measure_slides
