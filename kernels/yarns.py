"""Kinematics of the two yarn families in a triangle: strain, shear angle and its gradient.

Notation of the docs: k_α = Σ_a D[α,a] x_a is the current material vector of yarn family α, where
D[α,a] = t_α · ∇N_a. As Σ_a D[α,a] = 0, only the edges from the triangle's first vertex are needed:
k_α = D[α,b] (x_b − x_a) + D[α,c] (x_c − x_a), and `gradient` = (D1b, D1c, D2b, D2c) [1/m].
"""

import warp as wp

COLLAPSE_SINE = wp.constant(wp.float64(0.05))
"""Smallest sin θ divided by: warp and weft 2.9° from parallel, far past locking (the one guard)."""


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
def shear_angle(k1: wp.vec3d, k2: wp.vec3d, rest_angle: wp.float64) -> wp.float64:
    """Shear angle γ = θ0 − θ [rad], θ the current angle between warp and weft."""
    cosine = wp.dot(k1, k2) / (wp.length(k1) * wp.length(k2))
    return rest_angle - wp.acos(wp.clamp(cosine, wp.float64(-1.0), wp.float64(1.0)))


@wp.func
def guarded_sine(cosine: wp.float64) -> wp.float64:
    """Return sin θ from cos θ, kept away from the singularity of full collapse."""
    square = wp.float64(1.0) - cosine * cosine
    return wp.sqrt(wp.max(square, COLLAPSE_SINE * COLLAPSE_SINE))


@wp.func
def shear_gradient(k: wp.vec3d, other: wp.vec3d) -> wp.vec3d:
    """∂γ/∂k = (other/(‖k‖‖other‖) − cos θ k/‖k‖²)/sin θ [rad]. Source: [25], regular form."""
    length = wp.length(k)
    direction = k / length
    towards = other / wp.length(other)
    cosine = wp.dot(direction, towards)
    return (towards - cosine * direction) / (guarded_sine(cosine) * length)
