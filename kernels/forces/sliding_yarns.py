"""Bars of yarns that slide through the crossovers between them.

    W = Σ_bars w l φ(ε) + Σ_crossovers Σ_families ½ c k e²
    l = l0 + s_upper − s_lower,   ε = ‖x_upper − x_lower‖/l − 1,   φ = ∫N dε

s is how much of a yarn has gone through a crossover, along the yarn's own direction: bars get
longer and shorter of it (Eulerian along the yarns, as crossovers stay vertices). On a crossover the
bars pull with Q = −∂W/∂s = w_b G_b − w_a G_a, b before and a after it, G = (1 + ε) N − φ. The
crossing's spring, of elongation e, holds up to a limit c F, at which the yarn slips. c is the share
of the crossover in which there still is yarn: it falls to zero as a yarn's end goes by.

Slides have an inertia, as vertices have, so that yarn that moves need not be driven anew in every
step; it is counted in steps, M = m/Δt² [N/m], and follows from the bars' stiffness alone. With r
the slide in a step, M Δr = Q − c k e: explicit in the bars, implicit in the spring, which may be as
stiff as it likes. Vertices and slides share the bars: (Δt ω)² ≤ q_x + q_s, see `SLIDES_SHARE`.
"""

import warp as wp

from ..materials.tension import LinearTension, kinked

LEAST_SPACING = wp.constant(wp.float64(0.75))
"""Length of a bar over its flat one below which no more yarn slides out of it [-]: its crossing
yarns lie on each other by then."""
SLIDES_SHARE = 1.0
"""q_s, what slides take at most of the 4 in (Δt ω)² ≤ 4 [-]: their inertia is 2/q_s times the sum
of the bars beside them, as stiff as these may be."""
ANY = wp.constant(wp.float64(1.0e30))
"""Yarn that may leave where no bar could run out of it [m]."""


@wp.struct
class Bars:
    """Bars of a ply; see `warpdrape.blanks.yarn_chains`."""

    ends: wp.array(dtype=wp.vec2i)  # lower and upper vertex, in the model's numbering
    numbers: wp.array(dtype=wp.vec2i)  # … and crossover
    family: wp.array(dtype=wp.int32)  # 0 warp, 1 weft
    lengths: wp.array(dtype=wp.float64)  # l0 [m]
    widths: wp.array(dtype=wp.float64)  # w [m]
    stiffness: wp.vec2d  # line stiffness of warp and weft [N/m]
    compressive_factor: wp.float64  # [-]
    viscosity: wp.vec2d  # line tension per change of lengthening in a step [N/m]


@wp.struct
class Crossovers:
    """Crossovers of a ply; of pairs the first is the warp's, the second the weft's."""

    bars: wp.array(dtype=wp.vec4i)  # before and after on the warp, and on the weft; −1 for none
    slip: wp.array(dtype=wp.vec2d)  # F without tension [N]
    stiffness: wp.array(dtype=wp.vec2d)  # k [N/m]
    inertia: wp.array(dtype=wp.vec2d)  # M [N/m]
    friction: wp.array(dtype=wp.vec2d)  # F added per line tension of the other family [m]
    below: wp.array(dtype=wp.vec2d)  # yarn before its share's upper end, flat [m]
    above: wp.array(dtype=wp.vec2d)  # yarn after its share's lower end, flat [m]
    span: wp.array(dtype=wp.vec2d)  # length of its share [m]
    held: wp.array(dtype=wp.int32)  # 1 where a clamp grips the yarns


@wp.struct
class BarMemory:
    """What a bar remembers for its viscosity."""

    lengthening: wp.float64  # distance of its ends less its yarn, over l0, in the step before [-]
    change: wp.float64  # up to it [-]
    lost: wp.float64  # [J]


@wp.struct
class Slide:
    """State of a crossover's two yarns, warp and weft."""

    s: wp.vec2d  # yarn gone through it [m]
    grip: wp.vec2d  # e, elongation of its springs [m]
    rate: wp.vec2d  # r, change of s in the last step [m]
    work: wp.float64  # done by the pulls up to half of it [J]


@wp.struct
class Pulls:
    """What the bars do to a crossover."""

    pull: wp.vec2d  # Q [N]
    tension: wp.vec2d  # mean line tension of the bars beside it [N/m]
    room_below: wp.vec2d  # yarn that may leave the bars before it [m]
    room_above: wp.vec2d  # … after it


@wp.struct
class Grip:
    """Answer of a crossing's spring."""

    rate: wp.float64  # r [m]
    elongation: wp.float64  # e after it [m]


@wp.func
def no_tension(law: LinearTension, strain: wp.vec2d) -> wp.vec2d:
    """Of quadrants, whose bars are counted once, here [N/m]."""
    return wp.vec2d()


@wp.func
def no_energy(law: LinearTension, strain: wp.vec2d) -> wp.float64:
    """Likewise [J/m²]."""
    return wp.float64(0.0)


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
def bar_tension(strain: wp.float64, stiffness: wp.float64, factor: wp.float64) -> wp.float64:
    """Line tension N [N/m]."""
    return stiffness * kinked(strain, factor)


@wp.func
def bar_energy(
    width: wp.float64,
    length: wp.float64,
    strain: wp.float64,
    stiffness: wp.float64,
    factor: wp.float64,
) -> wp.float64:
    """Energy w l φ [J] of a bar with l of yarn."""
    return wp.float64(0.5) * width * length * strain * bar_tension(strain, stiffness, factor)


@wp.func
def material_pull(strain: wp.float64, stiffness: wp.float64, factor: wp.float64) -> wp.float64:
    """G = (1 + ε) N − φ [N/m]: −∂(l φ)/∂l at a fixed distance of the ends."""
    tension = bar_tension(strain, stiffness, factor)
    return tension * (wp.float64(1.0) + wp.float64(0.5) * strain)


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
        spring: c k [N/m], above 0.
        limit: c F [N].
    """
    one = wp.float64(1.0)
    out = Grip()
    most = limit / spring
    driven = rate + pull / inertia
    e = wp.clamp(elongation, -most, most)
    out.rate = (driven - spring * e / inertia) / (one + spring / inertia)
    out.elongation = e + out.rate
    if wp.abs(out.elongation) > most:
        out.elongation = wp.sign(out.elongation) * most
        out.rate = driven - spring * out.elongation / inertia
    return out


@wp.func
def yarn_left(crossovers: Crossovers, v: int, f: int, s: wp.float64) -> wp.float64:
    """`share_left` of a crossover's yarn."""
    return share_left(crossovers.below[v][f], crossovers.above[v][f], crossovers.span[v][f], s)


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
def bar_drag(
    bars: Bars, b: int, known: BarMemory, distance: wp.float64, material: wp.float64
) -> wp.float64:
    """Line tension of the yarns' viscosity [N/m], against vertices and slides alike."""
    lengthening = (distance - material) / bars.lengths[b]
    return bars.viscosity[bars.family[b]] * (lengthening - known.lengthening)


@wp.func
def bar_holds(bars: Bars, crossovers: Crossovers, b: int, slides: wp.array(dtype=Slide)) -> bool:
    """Whether there is yarn in both of a bar's crossovers."""
    f = bars.family[b]
    lower = bars.numbers[b][0]
    upper = bars.numbers[b][1]
    zero = wp.float64(0.0)
    return (
        yarn_left(crossovers, lower, f, slides[lower].s[f]) > zero
        and yarn_left(crossovers, upper, f, slides[upper].s[f]) > zero
    )


@wp.kernel(enable_backward=False)
def add_bar_forces(
    first: int,
    bars: Bars,
    crossovers: Crossovers,
    slides: wp.array(dtype=Slide),
    x: wp.array(dtype=wp.vec3d),
    memory: wp.array(dtype=BarMemory),
    kept: wp.array(dtype=BarMemory),
    f: wp.array(dtype=wp.vec3d),
):
    """Add the bars' tensions to ``f``; one thread a bar.

    Args:
        first: number of the first bar.
        bars: of a ply.
        crossovers: of the ply.
        slides: of its crossovers, shape [crossover].
        x: positions [m], shape [vertex].
        memory: of bars, shape [bar].
        kept: the same after the step, shape [bar]; overwritten.
        f: forces [N], shape [vertex]; accumulated.
    """
    b = first + wp.tid()
    family = bars.family[b]
    ends = bars.ends[b]
    along = x[ends[1]] - x[ends[0]]
    distance = wp.length(along)
    material = bar_material(bars, b, slides)
    known = memory[b]
    now = BarMemory()
    now.lengthening = (distance - material) / bars.lengths[b]
    now.lost = known.lost
    if bar_holds(bars, crossovers, b, slides):
        now.change = now.lengthening - known.lengthening
        half = wp.float64(0.5) * known.change * (known.change + now.change)
        now.lost += bars.widths[b] * bars.lengths[b] * bars.viscosity[family] * half
        strain = distance / material - wp.float64(1.0)
        tension = bar_tension(strain, bars.stiffness[family], bars.compressive_factor)
        tension += bar_drag(bars, b, known, distance, material)
        force = (bars.widths[b] * tension / distance) * along
        wp.atomic_add(f, ends[0], force)
        wp.atomic_sub(f, ends[1], force)
    kept[b] = now


@wp.func
def pulls_on(
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
            if b >= 0 and bar_holds(bars, crossovers, b, slides):
                material = bar_material(bars, b, slides)
                distance = bar_distance(bars, b, x)
                strain = distance / material - one
                tension = bar_tension(strain, bars.stiffness[f], bars.compressive_factor)
                pull = material_pull(strain, bars.stiffness[f], bars.compressive_factor)
                pull = bars.widths[b] * (pull + bar_drag(bars, b, memory[b], distance, material))
                total += tension
                beside += one
                room = wp.max(material - LEAST_SPACING * bars.lengths[b], wp.float64(0.0))
                if side == 0:
                    out.pull[f] += pull
                    out.room_below[f] = room
                else:
                    out.pull[f] -= pull
                    out.room_above[f] = room
        out.tension[f] = total / wp.max(beside, one)
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
def slide_yarns(
    first: int,
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
    on = pulls_on(bars, crossovers, v, slides, memory, x)
    now = Slide()
    now.s = known.s
    now.grip = known.grip
    for f in range(2):
        left = yarn_left(crossovers, v, f, known.s[f])
        if crossovers.held[v] == 0 and left > wp.float64(0.0):
            spring = left * crossovers.stiffness[v][f]
            pressed = wp.max(on.tension[1 - f], wp.float64(0.0))
            limit = left * (crossovers.slip[v][f] + crossovers.friction[v][f] * pressed)
            grip = gripped(
                on.pull[f], known.rate[f], known.grip[f], crossovers.inertia[v][f], spring, limit
            )
            # its neighbour may take the other half of a bar's
            rate = wp.clamp(grip.rate, -half * on.room_below[f], half * on.room_above[f])
            if rate != grip.rate:
                most = limit / spring
                grip.elongation = wp.clamp(known.grip[f] + rate, -most, most)
            now.s[f] = known.s[f] + rate
            now.rate[f] = rate
            now.grip[f] = grip.elongation
    now.work = known.work + half * wp.dot(on.pull, known.rate + now.rate)
    moved[v] = now


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


@wp.kernel(enable_backward=False)
def take_bars(first: int, kept: wp.array(dtype=BarMemory), memory: wp.array(dtype=BarMemory)):
    """Go on from what bars remember after a step; one thread a bar.

    Args:
        first: number of the first bar.
        kept: from `add_bar_forces`, shape [bar].
        memory: shape [bar]; overwritten.
    """
    b = first + wp.tid()
    memory[b] = kept[b]


@wp.kernel(enable_backward=False)
def measure_bars(
    bars: Bars,
    crossovers: Crossovers,
    slides: wp.array(dtype=Slide),
    x: wp.array(dtype=wp.vec3d),
    strain: wp.array(dtype=wp.float64),
    line_tension: wp.array(dtype=wp.float64),
    energy: wp.array(dtype=wp.float64),
):
    """Compute what bars show, nothing of those that a yarn has left; one thread a bar.

    Args:
        bars: of a ply.
        crossovers: of the ply.
        slides: of its crossovers, shape [crossover].
        x: positions [m], shape [vertex].
        strain: [-], shape [bar]; overwritten.
        line_tension: [N/m], shape [bar]; overwritten.
        energy: [J], shape [bar]; overwritten.
    """
    b = wp.tid()
    f = bars.family[b]
    strain[b] = wp.float64(0.0)
    if bar_holds(bars, crossovers, b, slides):
        material = bar_material(bars, b, slides)
        strain[b] = bar_distance(bars, b, x) / material - wp.float64(1.0)
        energy[b] = bar_energy(
            bars.widths[b], material, strain[b], bars.stiffness[f], bars.compressive_factor
        )
    else:
        energy[b] = wp.float64(0.0)
    line_tension[b] = bar_tension(strain[b], bars.stiffness[f], bars.compressive_factor)


@wp.kernel(enable_backward=False)
def measure_slides(
    bars: Bars,
    crossovers: Crossovers,
    slides: wp.array(dtype=Slide),
    memory: wp.array(dtype=BarMemory),
    x: wp.array(dtype=wp.vec3d),
    energies: wp.array(dtype=wp.vec3d),
):
    """Compute what crossovers show; one thread a crossover.

    Args:
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
    on = pulls_on(bars, crossovers, v, slides, memory, x)
    springs = spring_energy(crossovers, v, known)
    moving = half * wp.dot(crossovers.inertia[v], wp.cw_mul(known.rate, known.rate))
    work = known.work + half * wp.dot(on.pull, known.rate)
    energies[v] = wp.vec3d(springs, moving, work - springs - moving)
