"""Shear of the matrix of a prepreg: a dashpot in series with a spring, beside the fabric's own.

    γ̇ = Ċ/G + γ̇_v,   C = h φ(γ) η(a γ̇_v) a γ̇_v

C is a couple per initial area, h the ply's thickness, φ = 1 + r1 γ² + r2 γ⁴, a the temperature's
shift of rates. Rates are those of the process, by its own clock. A step is taken implicitly in the
rate, so that no viscosity is too much for it: the stiffness that the step feels is G at most. Its
couple is the slope of ½ C²/G + Δt D(γ̇_v), where C = dD/dγ̇_v and Δt is time of the process.
"""

import warp as wp

from ..materials.viscosity import Shift, Viscosity, flow_rate, shift_factor
from ..materials.yarns import angle_from_cosine, guarded_sine, warp_vector, weft_vector
from .membrane import add_triangle_loads


@wp.struct
class MatrixLaw:
    """The matrix of one ply."""

    viscosity: Viscosity
    shift: Shift
    thickness: wp.float64  # h [m]
    rise: wp.vec2d  # r1, r2 [-]
    stiffness: wp.float64  # G of the spring in series [N/m]
    temperature: wp.float64  # of the ply where it keeps it [K]
    cools: wp.int32  # 1 where vertices have temperatures of their own


@wp.struct
class MatrixMemory:
    """What a triangle remembers of its matrix."""

    angle: wp.float64  # shear angle in the step before [rad]
    couple: wp.float64  # C per initial area [N/m]
    rate: wp.float64  # size of the shifted rate [1/s]
    lost: wp.float64  # to the viscosity [J]


@wp.func
def shear_matrix(
    law: MatrixLaw,
    known: MatrixMemory,
    angle: wp.float64,
    temperature: wp.float64,
    time: wp.float64,
    area: wp.float64,
) -> MatrixMemory:
    """Memory after a step; couples act over half of the step before and half of the one after.

    Args:
        law: of the matrix.
        known: memory before.
        angle: shear angle now [rad].
        temperature: [K].
        time: of the process in the step [s].
        area: initial one of the triangle [m²].
    """
    one = wp.float64(1.0)
    square = angle * angle
    scale = law.thickness * (one + square * (law.rise[0] + square * law.rise[1]))
    turned = time / shift_factor(law.shift, temperature)  # by a shifted rate of 1/s [rad]
    load = known.couple + law.stiffness * (angle - known.angle)
    rate = known.rate
    if time > wp.float64(0.0):  # else nothing flows, whatever the rate
        rate = flow_rate(law.viscosity, scale, law.stiffness * turned, wp.abs(load), known.rate)
    flowed = wp.sign(load) * rate * turned
    out = MatrixMemory()
    out.angle = angle
    out.rate = rate
    out.couple = load - law.stiffness * flowed
    out.lost = known.lost + area * wp.float64(0.5) * (known.couple + out.couple) * flowed
    return out


@wp.kernel(enable_backward=False)
def add_matrix_forces(
    first: int,
    triangles: wp.array2d(dtype=wp.int32),
    gradients: wp.array(dtype=wp.vec4d),
    areas: wp.array(dtype=wp.float64),
    law: MatrixLaw,
    rest_angle: wp.float64,
    x: wp.array(dtype=wp.vec3d),
    temperature: wp.array(dtype=wp.float64),
    part: int,
    passed: wp.array(dtype=wp.float64),
    memory: wp.array(dtype=MatrixMemory),
    f: wp.array(dtype=wp.vec3d),
):
    """Add the matrix's forces to ``f``; one thread a triangle.

    Args:
        first: number of the first triangle.
        triangles: vertices, shape [triangle, 3].
        gradients: D [1/m], shape [triangle].
        areas: initial areas [m²], shape [triangle].
        law: of the matrix.
        rest_angle: angle between warp and weft of the flat ply [rad].
        x: positions [m], shape [vertex].
        temperature: [K], shape [vertex]; not read where the ply keeps its temperature.
        part: number of the part of the model that this one is.
        passed: time of the process since the step before [s], shape [part].
        memory: shape [triangle]; updated.
        f: forces [N], shape [vertex]; accumulated.
    """
    t = first + wp.tid()
    a = triangles[t, 0]
    b = triangles[t, 1]
    c = triangles[t, 2]
    d = gradients[t]
    k1 = warp_vector(d, x[b] - x[a], x[c] - x[a])
    k2 = weft_vector(d, x[b] - x[a], x[c] - x[a])
    inverse1 = wp.float64(1.0) / wp.length(k1)
    inverse2 = wp.float64(1.0) / wp.length(k2)
    u1 = inverse1 * k1
    u2 = inverse2 * k2
    cosine = wp.dot(u1, u2)
    now = law.temperature
    if law.cools == 1:
        now = (temperature[a] + temperature[b] + temperature[c]) / wp.float64(3.0)
    angle = angle_from_cosine(cosine, rest_angle)
    known = shear_matrix(law, memory[t], angle, now, passed[part], areas[t])
    memory[t] = known
    turning = areas[t] * known.couple / guarded_sine(cosine)
    on_warp = (turning * inverse1) * (u2 - cosine * u1)
    on_weft = (turning * inverse2) * (u1 - cosine * u2)
    add_triangle_loads(a, b, c, d, on_warp, on_weft, f)


@wp.kernel(enable_backward=False)
def compute_passed(
    part: int,
    process: wp.array(dtype=wp.float64),
    step: wp.array(dtype=wp.int32),
    passed: wp.array(dtype=wp.float64),
):
    """Note how much of the process passes in a step; one thread in all.

    The forces that follow the step are added while another part may be counting it.

    Args:
        part: number of the part of the model that this one is.
        process: time of the process before the coming steps and after each [s], shape [step + 1].
        step: number of the step, shape [1].
        passed: [s], shape [part]; the part's own entry is overwritten.
    """
    passed[part] = process[step[0] + 1] - process[step[0]]
