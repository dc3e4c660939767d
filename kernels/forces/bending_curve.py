"""Bending by a curve M(κ) out of the plane, linear in it, with friction between fibres.

Per area: W = Σ_α [ ∫M_α dκ_n + ½ B_g |κ_α − κ_n n|² ] + 2 B66 κ12·κ12, κ_n = n·κ_α, n the
triangle's normal. Friction, in parallel with the curve, is Dahl's (1968), as fibres that slide one
after the other: dM_f/dκ = σ (1 − sgn(dκ) M_f/M_y); it stores M_f²/2σ, and loses the rest.
"""

import warp as wp

from ..materials.shear import ShearCurve, curve_couple, curve_energy


@wp.struct
class CurvatureRows:
    """Rows of the curvatures κ1, κ2, κ12 of triangles, by triangle."""

    first: wp.array(dtype=wp.int32)  # entry of each triangle, and last of all their number
    vertex: wp.array(dtype=wp.int32)  # of each entry
    weights: wp.array(dtype=wp.vec3d)  # of each entry, for κ1, κ2 and κ12 [1/m²]
    start: wp.array2d(dtype=wp.vec3d)  # what held slopes add to them [1/m], shape [triangle, 3]
    corners: wp.array2d(dtype=wp.int32)  # vertices, shape [triangle, 3]
    areas: wp.array(dtype=wp.float64)  # flat, shape [triangle]


@wp.struct
class BendingLaw:
    """Moments per width of both families."""

    warp: ShearCurve  # moment [N] over curvature [1/m]
    weft: ShearCurve
    in_plane: wp.vec2d  # B_g [N·m]
    twist: wp.float64  # B66 [N·m]
    yield_moment: wp.vec2d  # M_y of the friction [N], 0 without
    onset: wp.vec2d  # σ, its stiffness at the start [N·m]


@wp.struct
class FrictionMemory:
    """What friction remembers of a triangle's two families."""

    curvature: wp.vec2d  # out of the plane, in the step before [1/m]
    change: wp.vec2d  # up to it [1/m]
    moment: wp.vec2d  # of friction [N]
    work: wp.float64  # done on it so far, per area [N/m]


@wp.func
def friction_moment(
    moment: wp.float64, change: wp.float64, yield_moment: wp.float64, onset: wp.float64
) -> wp.float64:
    """Moment of Dahl's friction [N] after a change of curvature [1/m], exact for one direction."""
    if yield_moment <= wp.float64(0.0):
        return wp.float64(0.0)
    limit = wp.sign(change) * yield_moment
    return limit + (moment - limit) * wp.exp(-onset * wp.abs(change) / yield_moment)


@wp.func
def triangle_curvature(rows: CurvatureRows, t: int, x: wp.array(dtype=wp.vec3d)) -> wp.mat33d:
    """κ1, κ2, κ12 [1/m], as rows."""
    warp_ = rows.start[t, 0]
    weft = rows.start[t, 1]
    twist = rows.start[t, 2]
    for k in range(rows.first[t], rows.first[t + 1]):
        at = x[rows.vertex[k]]
        weight = rows.weights[k]
        warp_ += weight[0] * at
        weft += weight[1] * at
        twist += weight[2] * at
    return wp.matrix_from_rows(warp_, weft, twist)


@wp.func
def facing(rows: CurvatureRows, t: int, x: wp.array(dtype=wp.vec3d)) -> wp.vec3d:
    """Twice the area times the normal of a triangle [m²]."""
    a = x[rows.corners[t, 0]]
    return wp.cross(x[rows.corners[t, 1]] - a, x[rows.corners[t, 2]] - a)


@wp.kernel(enable_backward=False)
def add_curve_forces(
    first: int,
    rows: CurvatureRows,
    law: BendingLaw,
    x: wp.array(dtype=wp.vec3d),
    memory: wp.array(dtype=FrictionMemory),
    f: wp.array(dtype=wp.vec3d),
):
    """Add bending forces to ``f``; one thread a triangle.

    Args:
        first: number of the first triangle.
        rows: of the curvatures.
        law: moments.
        x: positions [m], shape [vertex].
        memory: of friction, shape [triangle]; updated where there is any.
        f: forces [N], shape [vertex]; accumulated.
    """
    t = first + wp.tid()
    half = wp.float64(0.5)
    area = rows.areas[t]
    curvature = triangle_curvature(rows, t, x)
    around = facing(rows, t, x)
    size = wp.length(around)
    n = around / size
    out = wp.vec2d(wp.dot(n, curvature[0]), wp.dot(n, curvature[1]))
    moment = wp.vec2d(curve_couple(law.warp, out[0]), curve_couple(law.weft, out[1]))
    if law.yield_moment[0] + law.yield_moment[1] > wp.float64(0.0):
        known = memory[t]
        change = out - known.curvature
        friction = wp.vec2d(
            friction_moment(known.moment[0], change[0], law.yield_moment[0], law.onset[0]),
            friction_moment(known.moment[1], change[1], law.yield_moment[1], law.onset[1]),
        )
        now = FrictionMemory()
        now.curvature = out
        now.change = change
        now.moment = friction
        now.work = known.work + half * wp.dot(known.moment, known.change + change)
        memory[t] = now
        moment += friction
    # ∂W/∂κ_α, and ∂W/∂n, which turns the triangle
    on_warp = (moment[0] - law.in_plane[0] * out[0]) * n + law.in_plane[0] * curvature[0]
    on_weft = (moment[1] - law.in_plane[1] * out[1]) * n + law.in_plane[1] * curvature[1]
    on_twist = wp.float64(4.0) * law.twist * curvature[2]
    for k in range(rows.first[t], rows.first[t + 1]):
        w = area * rows.weights[k]
        wp.atomic_sub(f, rows.vertex[k], w[0] * on_warp + w[1] * on_weft + w[2] * on_twist)
    turning = (moment[0] - law.in_plane[0] * out[0]) * curvature[0]
    turning += (moment[1] - law.in_plane[1] * out[1]) * curvature[1]
    turning = (area / size) * (turning - wp.dot(n, turning) * n)
    a = rows.corners[t, 0]
    b = rows.corners[t, 1]
    c = rows.corners[t, 2]
    at_b = wp.cross(x[c] - x[a], turning)
    at_c = wp.cross(turning, x[b] - x[a])
    wp.atomic_sub(f, b, at_b)
    wp.atomic_sub(f, c, at_c)
    wp.atomic_add(f, a, at_b + at_c)


@wp.kernel(enable_backward=False)
def measure_curve(
    rows: CurvatureRows,
    law: BendingLaw,
    x: wp.array(dtype=wp.vec3d),
    out: wp.array(dtype=wp.vec2d),
    energy: wp.array(dtype=wp.float64),
):
    """Compute curvatures out of the plane [1/m] and energy without friction [J].

    One thread a triangle.
    """
    t = wp.tid()
    half = wp.float64(0.5)
    curvature = triangle_curvature(rows, t, x)
    n = wp.normalize(facing(rows, t, x))
    bent = wp.vec2d(wp.dot(n, curvature[0]), wp.dot(n, curvature[1]))
    out[t] = bent
    stored = curve_energy(law.warp, bent[0]) + curve_energy(law.weft, bent[1])
    for k in range(2):
        flat = wp.length_sq(curvature[k]) - bent[k] * bent[k]
        stored += half * law.in_plane[k] * flat
    stored += wp.float64(2.0) * law.twist * wp.length_sq(curvature[2])
    energy[t] = rows.areas[t] * stored
