"""Temperatures of plies, one a vertex: what contacts and the air do to them in a step.

    C A Ṫ = P + Σ H A (T_tool − T) + n A (α + ε σ (T² + T_air²)(T + T_air)) (T_air − T)

Contacts add what they pass: powers P between plies, and rates at which tools draw a vertex to their
temperatures. They also tell which of its two faces they cover; the n others are open to the air.
"""

import warp as wp

from ..materials.viscosity import Shift, shift_factor

STEFAN_BOLTZMANN = wp.constant(wp.float64(5.670374419e-8))
"""σ [W/(m²·K⁴)]."""


@wp.struct
class HeldHeat:
    """What decides how the temperatures of a ply change."""

    capacity: wp.float64  # per area [J/(m²·K)]
    emissivity: wp.float64  # of its faces [-]
    air: wp.float64  # temperature of the air [K]; 0 where none takes heat
    convection: wp.float64  # of the air on a face [W/(m²·K)]


@wp.func
def approached(now: wp.float64, goal: wp.float64, rate: wp.float64, time: wp.float64) -> wp.float64:
    """Temperature [K] after a time [s] of going to a goal [K] at a rate [1/s]: Ṫ = rate (goal − T).

    Exact, however long the time.
    """
    return goal + (now - goal) * wp.exp(-rate * time)


@wp.func
def covered(cover: wp.vec4d, normal: wp.vec3d) -> wp.vec4d:
    """What covers a vertex's faces, one thing more included.

    Args:
        cover: normal of the first thing, zero without one, and 1 if the other face is covered too.
        normal: from the thing towards the vertex.
    """
    first = wp.vec3d(cover[0], cover[1], cover[2])
    if wp.length_sq(first) == wp.float64(0.0):
        return wp.vec4d(normal[0], normal[1], normal[2], wp.float64(0.0))
    if wp.dot(first, normal) < wp.float64(0.0):
        cover[3] = wp.float64(1.0)
    return cover


@wp.func
def open_faces(cover: wp.vec4d) -> wp.float64:
    """How many of a vertex's two faces nothing covers."""
    if wp.length_sq(wp.vec3d(cover[0], cover[1], cover[2])) == wp.float64(0.0):
        return wp.float64(2.0)
    return wp.float64(1.0) - cover[3]


@wp.func
def air_conductance(held: HeldHeat, temperature: wp.float64) -> wp.float64:
    """Of a face to the air, convection and radiation at its temperature [W/(m²·K)]."""
    both = temperature * temperature + held.air * held.air
    return held.convection + held.emissivity * STEFAN_BOLTZMANN * both * (temperature + held.air)


@wp.kernel(enable_backward=False)
def advance_temperatures(
    first: int,
    held: HeldHeat,
    areas: wp.array(dtype=wp.float64),
    process: wp.array(dtype=wp.float64),
    step: wp.array(dtype=wp.int32),
    power: wp.array(dtype=wp.float64),
    pull: wp.array(dtype=wp.vec2d),
    cover: wp.array(dtype=wp.vec4d),
    temperature: wp.array(dtype=wp.float64),
):
    """Advance temperatures of a ply by a step, and clear what was added; one thread a vertex.

    Args:
        first: number of the first vertex.
        held: of the ply.
        areas: of vertices in the flat plies [m²], shape [vertex].
        process: time of the process before the coming steps and after each [s], shape [step + 1].
        step: number of the step, shape [1].
        power: from other plies [W], shape [vertex]; cleared.
        pull: of tools: rate [1/s], and rate times temperature [K/s], shape [vertex]; cleared.
        cover: see `covered`, shape [vertex]; cleared.
        temperature: [K], shape [vertex]; advanced.
    """
    i = first + wp.tid()
    time = process[step[0] + 1] - process[step[0]]
    now = temperature[i] + time * power[i] / (held.capacity * areas[i])
    rate = pull[i][0]
    drawn = pull[i][1]
    if held.air > wp.float64(0.0):
        to_air = open_faces(cover[i]) * air_conductance(held, now) / held.capacity
        rate += to_air
        drawn += to_air * held.air
    if rate > wp.float64(0.0):
        now = approached(now, drawn / rate, rate, time)
    temperature[i] = now
    power[i] = wp.float64(0.0)
    pull[i] = wp.vec2d()
    cover[i] = wp.vec4d()


@wp.kernel(enable_backward=False)
def compute_shifts(
    first: int,
    shift: Shift,
    temperature: wp.array(dtype=wp.float64),
    shifts: wp.array(dtype=wp.float64),
):
    """Shift factors of a ply's matrix at its vertices; one thread a vertex.

    Args:
        first: number of the first vertex.
        shift: of the ply's matrix.
        temperature: [K], shape [vertex].
        shifts: [-], shape [vertex]; overwritten.
    """
    i = first + wp.tid()
    shifts[i] = shift_factor(shift, temperature[i])
