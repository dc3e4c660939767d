"""Kinematics of the two yarn families in a triangle: strain and shear angle.

Notation of the docs: k_α = Σ_a D[α,a] x_a is the current material vector of yarn family α, where
D[α,a] = t_α · ∇N_a. As Σ_a D[α,a] = 0, only the edges from the triangle's first vertex are needed:
k_α = D[α,b] (x_b − x_a) + D[α,c] (x_c − x_a), and `gradient` = (D1b, D1c, D2b, D2c) [1/m].
"""

import warp as wp

COLLAPSE_SINE = wp.constant(wp.float64(0.05))
"""Smallest sin θ divided by: warp and weft 2.9° from parallel, far past locking (the one guard)."""

QUARTER_TURN = wp.constant(wp.float64(1.5707963267948966))
"""π/2 [rad]."""

THIRD_OF_HALF_TURN = wp.constant(wp.float64(1.0471975511965976))
"""π/3 [rad]."""

SINE_OF_60 = wp.constant(wp.float64(0.8660254037844386))
"""sin 60° [-]."""


@wp.func
def warp_vector(gradient: wp.vec4d, edge_b: wp.vec3d, edge_c: wp.vec3d) -> wp.vec3d:
    """Current material vector k1 [-] of the warp."""
    return gradient[0] * edge_b + gradient[1] * edge_c


@wp.func
def weft_vector(gradient: wp.vec4d, edge_b: wp.vec3d, edge_c: wp.vec3d) -> wp.vec3d:
    """Current material vector k2 [-] of the weft."""
    return gradient[2] * edge_b + gradient[3] * edge_c


@wp.func
def yarn_strain(k: wp.vec3d) -> wp.float64:
    """Yarn strain ε = ‖k‖ − 1 [-]."""
    return wp.length(k) - wp.float64(1.0)


@wp.func
def arc_sine_series(x: wp.float64) -> wp.float64:
    """Arcsine of |x| ≤ 1/2: x times a Chebyshev interpolant in x², error below 3e-16 [rad]."""
    t = x * x
    tt = t * t
    low = (
        wp.float64(0.9999999999999998)
        + t * wp.float64(0.16666666666689706)
        + tt * (wp.float64(0.07499999995624415) + t * wp.float64(0.04464286038603156))
    )
    middle = (
        wp.float64(0.030381820752221768)
        + t * wp.float64(0.022374928823605693)
        + tt * (wp.float64(0.017313700945909897) + t * wp.float64(0.01432423514994457))
    )
    high = (
        wp.float64(0.009376473481056654)
        + t * wp.float64(0.01825637024213353)
        + tt * (wp.float64(-0.011693559679531318) + t * wp.float64(0.03150477675162431))
    )
    return x * (low + tt * tt * (middle + tt * tt * high))


@wp.func
def arc_sine(x: wp.float64) -> wp.float64:
    """Arcsine [rad] of x, clamped to −1 … 1; several times faster than the library's."""
    size = wp.min(wp.abs(x), wp.float64(1.0))
    if size <= wp.float64(0.5):
        return arc_sine_series(x)
    half = arc_sine_series(wp.sqrt(wp.float64(0.5) * (wp.float64(1.0) - size)))
    angle = QUARTER_TURN - wp.float64(2.0) * half
    if x < wp.float64(0.0):
        angle = -angle
    return angle


@wp.func
def turned_sine(sine: wp.float64, cosine: wp.float64) -> wp.float64:
    """Sine of an angle, turned 60° towards zero where it is beyond 30°, for `arc_sine_series`."""
    half = wp.float64(0.5)
    turned = half * sine - wp.sign(sine) * SINE_OF_60 * cosine
    return wp.where(wp.abs(sine) <= half, sine, turned)


@wp.func
def turn(sine: wp.float64) -> wp.float64:
    """The angle [rad] that `turned_sine` took away."""
    taken = wp.sign(sine) * THIRD_OF_HALF_TURN
    return wp.where(wp.abs(sine) <= wp.float64(0.5), wp.float64(0.0), taken)


@wp.func
def arc_sine_series_4(x: wp.vec4d) -> wp.vec4d:
    """`arc_sine_series` of four."""
    return wp.vec4d(
        arc_sine_series(x[0]),
        arc_sine_series(x[1]),
        arc_sine_series(x[2]),
        arc_sine_series(x[3]),
    )


@wp.func
def angles_within_quarter_turn(s: wp.vec4d, c: wp.vec4d) -> wp.vec4d:
    """Four angles in −π/2 … π/2 [rad] from their sines and cosines.

    The two ways out also tell the compiler that the four belong together.
    """
    if wp.dot(s, s) <= wp.float64(0.25):
        return arc_sine_series_4(s)
    turned = wp.vec4d(
        turned_sine(s[0], c[0]),
        turned_sine(s[1], c[1]),
        turned_sine(s[2], c[2]),
        turned_sine(s[3], c[3]),
    )
    return arc_sine_series_4(turned) + wp.vec4d(turn(s[0]), turn(s[1]), turn(s[2]), turn(s[3]))


@wp.func
def angle_from_cosine(cosine: wp.float64, rest_angle: wp.float64) -> wp.float64:
    """Shear angle γ = θ0 − arccos(cos θ) [rad]."""
    return (rest_angle - QUARTER_TURN) + arc_sine(cosine)


@wp.func
def shear_angle(k1: wp.vec3d, k2: wp.vec3d, rest_angle: wp.float64) -> wp.float64:
    """Shear angle γ = θ0 − θ [rad], θ the current angle between warp and weft."""
    cosine = wp.dot(k1, k2) / (wp.length(k1) * wp.length(k2))
    return angle_from_cosine(cosine, rest_angle)


@wp.func
def guarded_sine(cosine: wp.float64) -> wp.float64:
    """Return sin θ from cos θ, kept away from the singularity of full collapse."""
    square = wp.float64(1.0) - cosine * cosine
    return wp.sqrt(wp.max(square, COLLAPSE_SINE * COLLAPSE_SINE))
