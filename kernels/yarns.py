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
