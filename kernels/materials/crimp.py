"""Biaxial tension of a weave whose yarns straighten each other: saw-tooth crimp interchange.

Every cell stretches its two yarns; the height h1 + h2 = H of the weave is kept, and minimising the
yarns' energy over the share h1 gives the balance t1 h1/L1 = t2 h2/L2. So the energy is that
minimum and the line tensions are its gradient at fixed h1 (envelope theorem).

A slack yarn carries nothing and so leaves the minimum unique; what a fabric resists in compression
is counted apart, c EA_α p_α/S · ε_α where ε_α < 0.
"""

import warp as wp

MOST_STEPS = 80
"""Newton and bisection steps; bisection alone needs 54 to reach float64's end."""
STEP_TOLERANCE = 1e-16
"""Last step of the height over the height of the weave."""


@wp.struct
class CrimpInterchange:
    """The two yarns of a cell, as (warp, weft)."""

    spacing: wp.vec2d  # m, a yarn's cell along it, p
    length: wp.vec2d  # m, of the yarn in a cell at rest, l
    height: wp.vec2d  # m, that it climbs in a cell at rest, h0
    stiffness: wp.vec2d  # N, EA
    cell_area: wp.float64  # m², S
    compressive_factor: wp.float64  # -, c


@wp.func
def yarn_length(spacing: wp.float64, height: wp.float64, strain: wp.float64) -> wp.float64:
    """Current length L of a yarn in a cell [m]."""
    across = spacing * (wp.float64(1.0) + strain)
    return wp.sqrt(across * across + height * height)


@wp.func
def yarn_extension(
    spacing: wp.float64,
    length: wp.float64,
    height: wp.float64,
    strain: wp.float64,
    rise: wp.float64,
) -> wp.float64:
    """L − l [m], where the yarn climbs ``height + rise``; without cancellation."""
    two = wp.float64(2.0)
    change = spacing * spacing * strain * (two + strain) + rise * (two * height + rise)
    return change / (yarn_length(spacing, height + rise, strain) + length)


@wp.func
def climb_force(
    law: CrimpInterchange, family: int, strain: wp.float64, rise: wp.float64
) -> wp.vec2d:
    """Force t h/L [N], by which a taut yarn flattens itself, and its slope by h [N/m]."""
    length = law.length[family]
    height = law.height[family]
    extension = yarn_extension(law.spacing[family], length, height, strain, rise)
    if extension <= wp.float64(0.0):
        return wp.vec2d(wp.float64(0.0), wp.float64(0.0))
    climb = (height + rise) / (length + extension)
    stretch = extension / length
    slope = stretch / (length + extension) + climb * climb / (length + extension)
    return law.stiffness[family] * wp.vec2d(stretch * climb, slope)


@wp.func
def exchanged_height(law: CrimpInterchange, strain: wp.vec2d) -> wp.float64:
    """Height [m] that the warp yarn takes from the weft yarn at balance: safeguarded Newton."""
    half = wp.float64(0.5)
    low = -law.height[0]
    high = wp.float64(law.height[1])
    tolerance = wp.float64(STEP_TOLERANCE) * (high - low)
    rise = wp.float64(0.0)
    last = high - low
    for _step in range(MOST_STEPS):
        warp_force = climb_force(law, 0, strain[0], rise)
        weft_force = climb_force(law, 1, strain[1], -rise)
        excess = warp_force[0] - weft_force[0]
        slope = warp_force[1] + weft_force[1]
        if excess > wp.float64(0.0):
            high = rise
        else:
            low = rise
        change = half * (low + high) - rise
        if wp.abs(excess) <= half * slope * wp.abs(last):
            newton = wp.clamp(rise - excess / wp.max(slope, wp.float64(1.0e-300)), low, high)
            change = newton - rise
        rise = rise + change
        last = change
        if wp.abs(change) <= tolerance:
            break
    return rise


@wp.func
def yarn_stretches(law: CrimpInterchange, strain: wp.vec2d) -> wp.vec2d:
    """L/l − 1 [-] of both yarns at balance, 0 where slack."""
    zero = wp.float64(0.0)
    rise = exchanged_height(law, strain)
    warp_extension = yarn_extension(law.spacing[0], law.length[0], law.height[0], strain[0], rise)
    weft_extension = yarn_extension(law.spacing[1], law.length[1], law.height[1], strain[1], -rise)
    return wp.vec2d(
        wp.max(warp_extension, zero) / law.length[0], wp.max(weft_extension, zero) / law.length[1]
    )


@wp.func
def family_tension(
    law: CrimpInterchange, family: int, strain: wp.float64, stretch: wp.float64
) -> wp.float64:
    """Line tension [N/m] of one family: t p (1 + ε)/L · p/S, and what resists compression."""
    one = wp.float64(1.0)
    spacing = law.spacing[family]
    length = law.length[family] * (one + stretch)
    taut = stretch * spacing * (one + strain) / length
    compressed = wp.float64(law.compressive_factor) * wp.min(strain, wp.float64(0.0))
    return law.stiffness[family] * spacing / wp.float64(law.cell_area) * (taut + compressed)


@wp.func
def family_energy(
    law: CrimpInterchange, family: int, strain: wp.float64, stretch: wp.float64
) -> wp.float64:
    """Energy per area [J/m²] of one family: ½ EA stretch² l/S, and that of compression."""
    half = wp.float64(0.5)
    below = wp.min(strain, wp.float64(0.0))
    taut = law.length[family] * stretch * stretch
    compressed = wp.float64(law.compressive_factor) * law.spacing[family] * below * below
    return half * law.stiffness[family] / wp.float64(law.cell_area) * (taut + compressed)


@wp.func
def crimp_tension(law: CrimpInterchange, strain: wp.vec2d) -> wp.vec2d:
    """Line tensions [N/m]: the gradient of `crimp_energy`."""
    stretch = yarn_stretches(law, strain)
    return wp.vec2d(
        family_tension(law, 0, strain[0], stretch[0]), family_tension(law, 1, strain[1], stretch[1])
    )


@wp.func
def crimp_energy(law: CrimpInterchange, strain: wp.vec2d) -> wp.float64:
    """Energy per area [J/m²]."""
    stretch = yarn_stretches(law, strain)
    return family_energy(law, 0, strain[0], stretch[0]) + family_energy(
        law, 1, strain[1], stretch[1]
    )
