"""Facets of tools and plies as contact sees them: nearest points, and the curved surface over them.

Tools: over a facet with corner normals n_i the surface is p*(w) = p + β Σ w_i ((x_i − p)·n_i) n_i,
p = Σ w_i x_i, a share β of the mean projection on the corners' tangent planes. With β = 1/2 and
normals of a smooth surface it is exact to second order. Its own normal makes the gap fall and rise
just as the contact force pushes, so that sliding over facets creates no energy.

Plies, which fold: the facet itself, and on its hollow side room for the arcs that its chords cut
off, c/4 at the middle of an edge with c = ½ (x_i − x_j)·(n_i − n_j). Each vertex has the largest of
its edges, interpolated over the facets, so that the room changes little from one to the next.
"""

import warp as wp

CURVED = wp.constant(wp.float64(0.5))
"""β of a surface that is exact to second order."""


STEEPEST = wp.constant(wp.float64(0.175))
"""Largest height of an arc over its chord: normals 90° apart; more is a fold, not a curve."""


@wp.func
def to_single(x: wp.vec3d) -> wp.vec3f:
    """Position for a mesh query, which works in single precision."""
    return wp.vec3f(float(x[0]), float(x[1]), float(x[2]))


@wp.func
def barycentric(a: wp.vec3d, b: wp.vec3d, c: wp.vec3d, x: wp.vec3d) -> wp.vec3d:
    """Weights of the triangle's corners at its point nearest to x."""
    zero = wp.float64(0.0)
    one = wp.float64(1.0)
    e1 = b - a
    e2 = c - a
    r = x - a
    d11 = wp.dot(e1, e1)
    d12 = wp.dot(e1, e2)
    d22 = wp.dot(e2, e2)
    r1 = wp.dot(r, e1)
    r2 = wp.dot(r, e2)
    determinant = d11 * d22 - d12 * d12
    v = (d22 * r1 - d12 * r2) / determinant
    w = (d11 * r2 - d12 * r1) / determinant
    if v >= zero and w >= zero and v + w <= one:
        return wp.vec3d(one - v - w, v, w)
    # Outside: the nearest of the three edges' nearest points.
    e3 = c - b
    s_ab = wp.clamp(r1 / d11, zero, one)
    s_ac = wp.clamp(r2 / d22, zero, one)
    s_bc = wp.clamp(wp.dot(x - b, e3) / wp.dot(e3, e3), zero, one)
    on_ab = wp.length_sq(r - s_ab * e1)
    on_ac = wp.length_sq(r - s_ac * e2)
    on_bc = wp.length_sq(x - b - s_bc * e3)
    best = wp.vec3d(one - s_ab, s_ab, zero)
    if on_ac < on_ab and on_ac <= on_bc:
        best = wp.vec3d(one - s_ac, zero, s_ac)
    elif on_bc < on_ab:
        best = wp.vec3d(zero, one - s_bc, s_bc)
    return best


@wp.func
def is_on_edge(weights: wp.vec3d, bits: wp.int32) -> bool:
    """Whether a nearest point lies on a marked edge, whichever facet at its end it is of.

    Bit e marks the edge across from corner e, bit 3 + k a corner k that ends one.
    """
    for corner in range(3):
        if weights[corner] <= wp.float64(0.0) and (bits >> corner) & 1 == 1:
            return True
        if weights[corner] >= wp.float64(1.0) and (bits >> (3 + corner)) & 1 == 1:
            return True
    return False


@wp.func
def weighted(w: wp.vec3d, a: wp.vec3d, b: wp.vec3d, c: wp.vec3d) -> wp.vec3d:
    """Interpolate corner values."""
    return w[0] * a + w[1] * b + w[2] * c


@wp.func
def projected(w: wp.vec3d, r: wp.mat33d, normals: wp.mat33d) -> wp.vec3d:
    """Σ w_i (r_i·n_i) n_i, rows r_i and n_i."""
    total = wp.vec3d()
    for i in range(3):
        total += (w[i] * wp.dot(r[i], normals[i])) * normals[i]
    return total


@wp.func
def bulge(corners: wp.mat33d, normals: wp.mat33d, w: wp.vec3d) -> wp.vec3d:
    """Σ w_i ((x_i − p)·n_i) n_i [m]: β times this leads from the facet to the curved surface."""
    p = weighted(w, corners[0], corners[1], corners[2])
    r = wp.matrix_from_rows(corners[0] - p, corners[1] - p, corners[2] - p)
    return projected(w, r, normals)


@wp.func
def bulge_slope(corners: wp.mat33d, normals: wp.mat33d, w: wp.vec3d, dw: wp.vec3d) -> wp.vec3d:
    """Derivative of `bulge` as the weights change by dw."""
    p = weighted(w, corners[0], corners[1], corners[2])
    dp = weighted(dw, corners[0], corners[1], corners[2])
    r = wp.matrix_from_rows(corners[0] - p, corners[1] - p, corners[2] - p)
    return projected(dw, r, normals) - projected(w, wp.matrix_from_rows(dp, dp, dp), normals)


@wp.func
def curved_normal(
    corners: wp.mat33d, normals: wp.mat33d, w: wp.vec3d, share: wp.float64
) -> wp.vec3d:
    """Unit normal of the curved surface, on the facet's own side (by its winding)."""
    zero = wp.float64(0.0)
    one = wp.float64(1.0)
    along_b = corners[1] - corners[0]
    along_c = corners[2] - corners[0]
    along_b += share * bulge_slope(corners, normals, w, wp.vec3d(-one, one, zero))
    along_c += share * bulge_slope(corners, normals, w, wp.vec3d(-one, zero, one))
    return wp.normalize(wp.cross(along_b, along_c))


@wp.func
def edge_sag(a: wp.vec3d, b: wp.vec3d, na: wp.vec3d, nb: wp.vec3d) -> wp.float64:
    """Height [m] of the arc over the chord from a to b, ⅛ (a − b)·(n_a − n_b); unit normals."""
    along = a - b
    sag = wp.float64(0.125) * wp.dot(along, na - nb)
    if sag * sag > STEEPEST * STEEPEST * wp.length_sq(along):
        return wp.sign(sag) * STEEPEST * wp.length(along)
    return sag


@wp.func
def facet_slope(a: wp.vec3d, b: wp.vec3d, c: wp.vec3d, w: wp.vec3d, value: wp.vec3d) -> wp.vec3d:
    """Gradient along a facet of what its corners interpolate; along the edge if w lies on one."""
    zero = wp.float64(0.0)
    if w[0] <= zero or w[1] <= zero or w[2] <= zero:
        start = a
        end = b
        rise = value[1] - value[0]
        if w[0] <= zero:
            start = b
            end = c
            rise = value[2] - value[1]
        elif w[1] <= zero:
            start = c
            end = a
            rise = value[0] - value[2]
        along = end - start
        if wp.max(wp.max(w[0], w[1]), w[2]) >= wp.float64(1.0):
            return wp.vec3d()
        return (rise / wp.length_sq(along)) * along
    e1 = b - a
    e2 = c - a
    d11 = wp.dot(e1, e1)
    d12 = wp.dot(e1, e2)
    d22 = wp.dot(e2, e2)
    r1 = value[1] - value[0]
    r2 = value[2] - value[0]
    return ((d22 * r1 - d12 * r2) * e1 + (d11 * r2 - d12 * r1) * e2) / (d11 * d22 - d12 * d12)
