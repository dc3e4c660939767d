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

    Above the grid the tensions go on linearly; below it they change by ``compressive_stiffness``.
    """

    origin: wp.vec2d  # strain at the first knot
    spacing: wp.vec2d  # strain
    intervals: wp.vec2i
    compressive_stiffness: wp.vec2d  # N/m per unit strain
    coefficients: wp.array2d(dtype=wp.float64)  # J/m², shape [intervals_1 + 3, intervals_2 + 3]


@wp.func
def linear_tension(law: LinearTension, strain: wp.vec2d) -> wp.vec2d:
    """Line tensions [N/m]."""
    factor1 = wp.where(strain[0] < wp.float64(0.0), law.compressive_factor, wp.float64(1.0))
    factor2 = wp.where(strain[1] < wp.float64(0.0), law.compressive_factor, wp.float64(1.0))
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
def spline_curvatures(u: wp.float64) -> wp.vec4d:
    """Their second derivatives by u."""
    w = wp.float64(1.0) - u
    return wp.vec4d(
        w, wp.float64(3.0) * u - wp.float64(2.0), wp.float64(3.0) * w - wp.float64(2.0), u
    )


@wp.func
def continued_values(u: wp.float64) -> wp.vec4d:
    """B-splines continued with slope below 0, and with slope and curvature above 1."""
    inside = wp.clamp(u, wp.float64(0.0), wp.float64(1.0))
    beyond = u - inside
    values = spline_values(inside) + beyond * spline_slopes(inside)
    if beyond > wp.float64(0.0):
        values += (wp.float64(0.5) * beyond * beyond) * spline_curvatures(inside)
    return values


@wp.func
def continued_slopes(u: wp.float64) -> wp.vec4d:
    """Derivative of `continued_values`."""
    inside = wp.clamp(u, wp.float64(0.0), wp.float64(1.0))
    slopes = spline_slopes(inside)
    if u > wp.float64(1.0):
        slopes += (u - inside) * spline_curvatures(inside)
    return slopes


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
    n1 = spline_sum(law.coefficients, i, j, continued_slopes(u), continued_values(v))
    n2 = spline_sum(law.coefficients, i, j, continued_values(u), continued_slopes(v))
    below = wp.vec2d(
        wp.min(strain[0] - law.origin[0], wp.float64(0.0)),
        wp.min(strain[1] - law.origin[1], wp.float64(0.0)),
    )
    return wp.vec2d(n1 / law.spacing[0], n2 / law.spacing[1]) + wp.cw_mul(
        law.compressive_stiffness, below
    )


@wp.func
def tabulated_energy(law: TabulatedTension, strain: wp.vec2d) -> wp.float64:
    """Energy per area [J/m²]."""
    i = knot_interval(strain[0], law.origin[0], law.spacing[0], law.intervals[0])
    j = knot_interval(strain[1], law.origin[1], law.spacing[1], law.intervals[1])
    u = (strain[0] - law.origin[0]) / law.spacing[0] - wp.float64(i)
    v = (strain[1] - law.origin[1]) / law.spacing[1] - wp.float64(j)
    surface = spline_sum(law.coefficients, i, j, continued_values(u), continued_values(v))
    below = wp.vec2d(
        wp.min(strain[0] - law.origin[0], wp.float64(0.0)),
        wp.min(strain[1] - law.origin[1], wp.float64(0.0)),
    )
    return surface + wp.float64(0.5) * wp.dot(wp.cw_mul(law.compressive_stiffness, below), below)
