"""Yarn tension laws, as line tensions N_α [N/m] of the sheet: N1 = T1/L2, N2 = T2/L1.

A law is a struct of its parameters, ``*_tension(law, strain)`` and ``*_energy(law, strain)``
[J/m²] with tension = ∂energy/∂strain, strain = (ε1, ε2).
"""

import warp as wp


@wp.struct
class LinearTension:
    """N_α = stiffness_α ε_α; in compression times ``compressive_factor``."""

    stiffness: wp.vec2d  # N/m per unit strain
    compressive_factor: wp.float64  # -


@wp.struct
class TabulatedTension:
    """Cubic-spline energy surface over a regular grid of (ε1, ε2), continued outside it.

    Above the grid the tensions go on linearly, with ``stiffness``. Below it a yarn's tension fades
    over the strain ``fading`` and ``compressive_stiffness`` takes over: a linear continuation would
    press the other family together without end.
    """

    origin: wp.vec2d  # strain at the first knot
    spacing: wp.vec2d  # strain
    intervals: wp.vec2i
    stiffness: wp.vec2d  # N/m per unit strain
    compressive_stiffness: wp.vec2d  # N/m per unit strain
    fading: wp.vec2d  # strain
    coefficients: wp.array2d(dtype=wp.float64)  # J/m², shape [intervals_1 + 3, intervals_2 + 3]


@wp.func
def linear_tension(law: LinearTension, strain: wp.vec2d) -> wp.vec2d:
    """Line tensions [N/m]."""
    one = wp.float64(1.0)
    compressed = wp.float64(law.compressive_factor)
    factor1 = compressed if strain[0] < wp.float64(0.0) else one
    factor2 = compressed if strain[1] < wp.float64(0.0) else one
    return wp.vec2d(
        factor1 * law.stiffness[0] * strain[0], factor2 * law.stiffness[1] * strain[1]
    )


@wp.func
def linear_energy(law: LinearTension, strain: wp.vec2d) -> wp.float64:
    """Energy per area [J/m²]."""
    return wp.float64(0.5) * wp.dot(linear_tension(law, strain), strain)


@wp.func
def knot_interval(strain: wp.float64, origin: wp.float64, spacing: wp.float64, n: int) -> int:
    """Index of the spline interval that holds (or is nearest to) a strain."""
    return wp.clamp(int(wp.floor((strain - origin) / spacing)), 0, n - 1)


@wp.func
def spline_values(u: wp.float64) -> wp.vec4d:
    """Four uniform cubic B-splines at u in [0, 1]."""
    one = wp.float64(1.0)
    w = one - u
    sixth = one / wp.float64(6.0)
    return sixth * wp.vec4d(
        w * w * w,
        wp.float64(3.0) * u * u * u - wp.float64(6.0) * u * u + wp.float64(4.0),
        wp.float64(3.0) * w * w * w - wp.float64(6.0) * w * w + wp.float64(4.0),
        u * u * u,
    )


@wp.func
def spline_slopes(u: wp.float64) -> wp.vec4d:
    """Their first derivatives by u."""
    half = wp.float64(0.5)
    w = wp.float64(1.0) - u
    return wp.vec4d(
        -half * w * w,
        wp.float64(1.5) * u * u - wp.float64(2.0) * u,
        wp.float64(2.0) * w - wp.float64(1.5) * w * w,
        half * u * u,
    )


@wp.func
def continued_values(u: wp.float64, fading: wp.float64) -> wp.vec4d:
    """B-splines continued with their slope above 1, and with a slope that fades below 0."""
    zero = wp.float64(0.0)
    one = wp.float64(1.0)
    inside = wp.clamp(u, zero, one)
    step = wp.max(u - one, zero) + fading * (wp.exp(wp.min(u, zero) / fading) - one)
    return spline_values(inside) + step * spline_slopes(inside)


@wp.func
def continued_slopes(u: wp.float64, fading: wp.float64) -> wp.vec4d:
    """Derivative of `continued_values`."""
    zero = wp.float64(0.0)
    inside = wp.clamp(u, zero, wp.float64(1.0))
    return wp.exp(wp.min(u, zero) / fading) * spline_slopes(inside)


@wp.func
def outside(law: TabulatedTension, family: int, strain: wp.float64) -> wp.vec2d:
    """Strain below the grid (negative) and above it (positive)."""
    zero = wp.float64(0.0)
    first = law.origin[family]
    last = first + law.spacing[family] * wp.float64(law.intervals[family])
    return wp.vec2d(wp.min(strain - first, zero), wp.max(strain - last, zero))


@wp.func
def outside_stiffness(law: TabulatedTension, family: int) -> wp.vec2d:
    """Stiffness below and above the grid [N/m]."""
    return wp.vec2d(law.compressive_stiffness[family], law.stiffness[family])


@wp.func
def spline_sum(
    coefficients: wp.array2d(dtype=wp.float64), i: int, j: int, a: wp.vec4d, b: wp.vec4d
) -> wp.float64:
    """Sum over the 4 × 4 splines that reach a point."""
    total = wp.float64(0.0)
    for p in range(4):
        for q in range(4):
            total += a[p] * b[q] * coefficients[i + p, j + q]
    return total


@wp.func
def tabulated_tension(law: TabulatedTension, strain: wp.vec2d) -> wp.vec2d:
    """Line tensions [N/m]: the gradient of `tabulated_energy`."""
    i = knot_interval(strain[0], law.origin[0], law.spacing[0], law.intervals[0])
    j = knot_interval(strain[1], law.origin[1], law.spacing[1], law.intervals[1])
    u = (strain[0] - law.origin[0]) / law.spacing[0] - wp.float64(i)
    v = (strain[1] - law.origin[1]) / law.spacing[1] - wp.float64(j)
    fade_u = law.fading[0] / law.spacing[0]
    fade_v = law.fading[1] / law.spacing[1]
    n1 = spline_sum(
        law.coefficients, i, j, continued_slopes(u, fade_u), continued_values(v, fade_v)
    )
    n2 = spline_sum(
        law.coefficients, i, j, continued_values(u, fade_u), continued_slopes(v, fade_v)
    )
    return wp.vec2d(
        n1 / law.spacing[0] + wp.dot(outside_stiffness(law, 0), outside(law, 0, strain[0])),
        n2 / law.spacing[1] + wp.dot(outside_stiffness(law, 1), outside(law, 1, strain[1])),
    )


@wp.func
def tabulated_energy(law: TabulatedTension, strain: wp.vec2d) -> wp.float64:
    """Energy per area [J/m²]."""
    i = knot_interval(strain[0], law.origin[0], law.spacing[0], law.intervals[0])
    j = knot_interval(strain[1], law.origin[1], law.spacing[1], law.intervals[1])
    u = (strain[0] - law.origin[0]) / law.spacing[0] - wp.float64(i)
    v = (strain[1] - law.origin[1]) / law.spacing[1] - wp.float64(j)
    inside = spline_sum(
        law.coefficients,
        i,
        j,
        continued_values(u, law.fading[0] / law.spacing[0]),
        continued_values(v, law.fading[1] / law.spacing[1]),
    )
    out1 = outside(law, 0, strain[0])
    out2 = outside(law, 1, strain[1])
    beyond = wp.dot(outside_stiffness(law, 0), wp.cw_mul(out1, out1)) + wp.dot(
        outside_stiffness(law, 1), wp.cw_mul(out2, out2)
    )
    return inside + wp.float64(0.5) * beyond
