"""Yarn tension laws, as line tensions N_α [N/m] of the sheet: N1 = T1/L2, N2 = T2/L1.

A law is a struct of its parameters, ``*_tension(law, strain)`` and ``*_energy(law, strain)``
[J/m²] with tension = ∂energy/∂strain, strain = (ε1, ε2).
"""

import warp as wp

LEAST_STRAIN = 1e-12
"""Strain over which a border tension fades, at least [-]: far below any that shows in a tension."""


@wp.struct
class LinearTension:
    """N_α = stiffness_α ε_α; in compression times ``compressive_factor``."""

    stiffness: wp.vec2d  # N/m per unit strain
    compressive_factor: wp.float64  # -


@wp.struct
class TabulatedTension:
    """Cubic-spline energy surface over a regular grid of (ε1, ε2), continued outside it.

    With β the strain outside the grid and W, N, N12 those of the grid's nearest point,

        W + g(N1, β1) + g(N2, β2) + N12 ∂g/∂N1 ∂g/∂N2 + ½ Σ stiffness β²,

    g as in `continuation`. Above the grid the tensions so go on linearly; below it a yarn goes
    slack and lets go of the other family, instead of pressing it together without end.
    """

    origin: wp.vec2d  # strain at the first knot
    spacing: wp.vec2d  # strain
    intervals: wp.vec2i
    stiffness: wp.vec2d  # N/m per unit strain
    compressive_stiffness: wp.vec2d  # N/m per unit strain
    coefficients: wp.array2d(dtype=wp.float64)  # J/m², shape [intervals_1 + 3, intervals_2 + 3]


@wp.func
def kinked(strain: wp.float64, compressive_factor: wp.float64) -> wp.float64:
    """Return ε, in compression times a factor; without a branch, as signs change everywhere."""
    half = wp.float64(0.5)
    one = wp.float64(1.0)
    return half * (
        (one + compressive_factor) * strain + (one - compressive_factor) * wp.abs(strain)
    )


@wp.func
def linear_tension(law: LinearTension, strain: wp.vec2d) -> wp.vec2d:
    """Line tensions [N/m]."""
    factor = wp.float64(law.compressive_factor)
    return wp.vec2d(
        law.stiffness[0] * kinked(strain[0], factor), law.stiffness[1] * kinked(strain[1], factor)
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
def surface(law: TabulatedTension, strain: wp.vec2d) -> wp.vec4d:
    """Return (W, ∂W/∂ε1, ∂W/∂ε2, ∂²W/∂ε1∂ε2) [J/m²] at the grid's point nearest to a strain."""
    zero = wp.float64(0.0)
    one = wp.float64(1.0)
    i = knot_interval(strain[0], law.origin[0], law.spacing[0], law.intervals[0])
    j = knot_interval(strain[1], law.origin[1], law.spacing[1], law.intervals[1])
    u = wp.clamp((strain[0] - law.origin[0]) / law.spacing[0] - wp.float64(i), zero, one)
    v = wp.clamp((strain[1] - law.origin[1]) / law.spacing[1] - wp.float64(j), zero, one)
    values_1 = spline_values(u)
    values_2 = spline_values(v)
    slopes_1 = spline_slopes(u) / law.spacing[0]
    slopes_2 = spline_slopes(v) / law.spacing[1]
    return wp.vec4d(
        spline_sum(law.coefficients, i, j, values_1, values_2),
        spline_sum(law.coefficients, i, j, slopes_1, values_2),
        spline_sum(law.coefficients, i, j, values_1, slopes_2),
        spline_sum(law.coefficients, i, j, slopes_1, slopes_2),
    )


@wp.func
def beyond_grid(law: TabulatedTension, family: int, strain: wp.float64) -> wp.float64:
    """Strain outside the grid: negative below it, positive above it."""
    first = law.origin[family]
    last = first + law.spacing[family] * wp.float64(law.intervals[family])
    return strain - wp.clamp(strain, first, last)


@wp.func
def continuation(tension: wp.float64, beyond: wp.float64, stiffness: wp.float64) -> wp.vec4d:
    """Continue a border tension N over a strain β: (g, ∂g/∂β, ∂g/∂N, ∂²g/∂N∂β), g the energy.

    Above the grid g = N β; below it N fades as exp(β/d), d = |N|/stiffness the strain that makes
    the yarn slack.
    """
    one = wp.float64(1.0)
    two = wp.float64(2.0)
    if beyond >= wp.float64(0.0):
        return wp.vec4d(tension * beyond, tension, beyond, one)
    d = wp.max(wp.abs(tension) / stiffness, wp.float64(LEAST_STRAIN))
    x = beyond / d
    e = wp.exp(x)
    return wp.vec4d(
        tension * d * (e - one), tension * e, -d * (two * (one - e) + x * e), e * (one - x)
    )


@wp.func
def outside_stiffness(law: TabulatedTension, family: int, beyond: wp.float64) -> wp.float64:
    """Stiffness that the strain outside the grid adds [N/m]."""
    below = law.compressive_stiffness[family]
    above = law.stiffness[family]
    return below if beyond < wp.float64(0.0) else above


@wp.func
def tabulated_tension(law: TabulatedTension, strain: wp.vec2d) -> wp.vec2d:
    """Line tensions [N/m]: the gradient of `tabulated_energy`."""
    at = surface(law, strain)
    b1 = beyond_grid(law, 0, strain[0])
    b2 = beyond_grid(law, 1, strain[1])
    c1 = continuation(at[1], b1, law.stiffness[0])
    c2 = continuation(at[2], b2, law.stiffness[1])
    return wp.vec2d(
        c1[1] + at[3] * c1[3] * c2[2] + outside_stiffness(law, 0, b1) * b1,
        c2[1] + at[3] * c2[3] * c1[2] + outside_stiffness(law, 1, b2) * b2,
    )


@wp.func
def tabulated_energy(law: TabulatedTension, strain: wp.vec2d) -> wp.float64:
    """Energy per area [J/m²]."""
    at = surface(law, strain)
    b1 = beyond_grid(law, 0, strain[0])
    b2 = beyond_grid(law, 1, strain[1])
    c1 = continuation(at[1], b1, law.stiffness[0])
    c2 = continuation(at[2], b2, law.stiffness[1])
    added = outside_stiffness(law, 0, b1) * b1 * b1 + outside_stiffness(law, 1, b2) * b2 * b2
    return at[0] + c1[0] + c2[0] + at[3] * c1[2] * c2[2] + wp.float64(0.5) * added
