"""What a frame that turns with the sheet sees of its change of shape.

With k_α the yarn vectors and h = (k1·dk1, k2·dk2, k1·dk2 + k2·dk1), the part of their change that
no rotation makes, a frame sees strains of its two families and a change of angle between them,

    (de1, de2, dγ) = B(g) h,   g = (k1·k1, k2·k2, k1·k2)

and stresses (N1, N2, C) in it, which do the work N1 de1 + N2 de2 + C dγ per initial area, are the
loads P1 = S1 k1 + S3 k2 and P2 = S3 k1 + S2 k2 on dk1 and dk2, S = Bᵀ (N1, N2, C). Both g and h
are blind to rotation, of any size in a step.
"""

import warp as wp

from ..materials.yarns import COLLAPSE_SINE, guarded_sine


@wp.func
def metric(k1: wp.vec3d, k2: wp.vec3d) -> wp.vec3d:
    """Return (k1·k1, k2·k2, k1·k2) [-]."""
    return wp.vec3d(wp.dot(k1, k1), wp.dot(k2, k2), wp.dot(k1, k2))


@wp.func
def change_of_shape(k1: wp.vec3d, k2: wp.vec3d, d1: wp.vec3d, d2: wp.vec3d) -> wp.vec3d:
    """Return h [-] of vectors that change by d1 and d2."""
    return wp.vec3d(wp.dot(k1, d1), wp.dot(k2, d2), wp.dot(k1, d2) + wp.dot(k2, d1))


@wp.func
def fibre_rows(g: wp.vec3d, rest: wp.vec2d) -> wp.mat33d:
    """B of two frames, one along the warp and one along the weft, whatever the angle at rest.

    de_α = k̂_α·dk_α, the yarn's own; dγ is the mean of the shears that both frames see, which is
    the change of the angle between the yarns.
    """
    zero = wp.float64(0.0)
    one = wp.float64(1.0)
    inverse1 = one / wp.sqrt(g[0])
    inverse2 = one / wp.sqrt(g[1])
    both = inverse1 * inverse2
    cosine = g[2] * both
    inverse = one / guarded_sine(cosine)
    cot = cosine * inverse
    return wp.matrix_from_rows(
        wp.vec3d(inverse1, zero, zero),
        wp.vec3d(zero, inverse2, zero),
        wp.vec3d(-cot * inverse1 * inverse1, -cot * inverse2 * inverse2, both * inverse),
    )


@wp.func
def polar_rows(g: wp.vec3d, rest: wp.vec2d) -> wp.mat33d:
    """B of the frame of the polar decomposition F = R U, in which the flat yarns lie still.

    R t_α = F U⁻¹ t_α = p_α1 k1 + p_α2 k2, and D = sym(dF F⁻¹) is seen along these; U⁻¹ in closed
    form, by the theorem of Cayley and Hamilton. ``rest`` is (cos θ0, sin θ0).
    """
    one = wp.float64(1.0)
    two = wp.float64(2.0)
    cosine = rest[0]
    sine = rest[1]
    inverse = one / sine
    cot = cosine * inverse
    # FᵀF in the orthonormal directions t1 and beside it
    g11 = g[0]
    g12 = inverse * g[2] - cot * g[0]
    g22 = inverse * inverse * (g[1] - two * cosine * g[2]) + cot * cot * g[0]
    least = COLLAPSE_SINE * COLLAPSE_SINE * g11 * g22
    area = wp.sqrt(wp.max(g11 * g22 - g12 * g12, least))
    scale = one / (area * wp.sqrt(g11 + g22 + two * area))
    v11 = scale * (g22 + area)
    v22 = scale * (g11 + area)
    v12 = -scale * g12
    # U⁻¹ t1 and U⁻¹ t2 there, and in terms of k1, k2
    q1 = wp.vec2d(v11, v12)
    q2 = wp.vec2d(cosine * v11 + sine * v12, cosine * v12 + sine * v22)
    p1 = wp.vec2d(q1[0] - cot * q1[1], inverse * q1[1])
    p2 = wp.vec2d(q2[0] - cot * q2[1], inverse * q2[1])
    along1 = wp.vec3d(p1[0] * p1[0], p1[1] * p1[1], p1[0] * p1[1])
    along2 = wp.vec3d(p2[0] * p2[0], p2[1] * p2[1], p2[0] * p2[1])
    between = wp.vec3d(two * p1[0] * p2[0], two * p1[1] * p2[1], p1[0] * p2[1] + p1[1] * p2[0])
    return wp.matrix_from_rows(along1, along2, inverse * between - cot * (along1 + along2))


@wp.func
def along_yarns(g: wp.vec3d, stress: wp.vec3d) -> wp.vec2d:
    """Line tensions [N/m] of the yarns that do the work of S: `fibre_rows` turned round."""
    length1 = wp.sqrt(g[0])
    length2 = wp.sqrt(g[1])
    return wp.vec2d(
        length1 * (stress[0] + stress[2] * g[2] / g[0]),
        length2 * (stress[1] + stress[2] * g[2] / g[1]),
    )
