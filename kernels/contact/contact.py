"""The contact law: penalty with damping along the normal, friction that sticks.

Where a ply can be compacted its law of pressure against thickness takes the penalty's place; the
dashpot follows its slope, so that slow presses feel no viscosity of ours.

Penalty stiffness follows the masses that meet, k = share · m / Δt², so that no vertex is driven
beyond its own stable step. A stuck point hangs on a tangential spring of the same stiffness; where
the spring would exceed μ times the normal force it slips. Forces act over the step centred on them,
so what friction and dashpot take in a step is the work of the mean of its two ends' forces.
"""

import warp as wp

from .friction import FrictionLaws, Rub, bearable

TINY = wp.constant(wp.float64(1e-30))
"""Keeps a slack spring's length from dividing by zero [m]."""


@wp.struct
class ContactLaw:
    """What every contact of a run shares."""

    stiffness: wp.float64  # k / m = share / Δt² [1/s²]
    lag: wp.float64  # of the dashpot, 2 ζ √(k m) / k [s]
    time_step: wp.float64  # s
    friction: FrictionLaws


@wp.struct
class CompactionLaws:
    """Pressure and energy per area against depth, of plies that can be compacted, sampled evenly.

    A law is that of one face of a ply, which gives way by half of what the ply does, or of the two
    faces of plies on each other. It is no steeper than the penalty that the step allows for.
    """

    pressures: wp.array(dtype=wp.float64)  # Pa, shape [law · samples]
    energies: wp.array(dtype=wp.float64)  # J/m², likewise
    samples: wp.int32  # of each law
    spacing: wp.array(dtype=wp.float64)  # of its depths [m], shape [law]
    beyond: wp.array(dtype=wp.float64)  # slope beyond its last sample [Pa/m], shape [law]
    steepest: wp.array(dtype=wp.float64)  # largest slope [Pa/m], shape [law]


@wp.struct
class Pad:
    """What gives way in a contact."""

    law: wp.int32  # number of its compaction law plus one; 0 for the penalty alone
    area: wp.float64  # m²


@wp.func
def compacted(laws: CompactionLaws, number: int, depth: wp.float64) -> wp.vec3d:
    """Pressure [Pa], energy per area [J/m²] and slope [Pa/m] of a law at a depth [m]."""
    last = laws.samples - 1
    first = number * laws.samples
    spacing = laws.spacing[number]
    k = int(wp.min(depth / spacing, wp.float64(last)))
    beyond = depth - wp.float64(k) * spacing
    slope = laws.beyond[number]
    if k < last:
        slope = (laws.pressures[first + k + 1] - laws.pressures[first + k]) / spacing
    pressure = laws.pressures[first + k]
    energy = laws.energies[first + k]
    energy += (pressure + wp.float64(0.5) * slope * beyond) * beyond
    return wp.vec3d(pressure + slope * beyond, energy, slope)


@wp.func
def padded_area(law: ContactLaw, mass: wp.float64, laws: CompactionLaws, pad: Pad) -> wp.float64:
    """Area [m²] that a pad's law acts on: less where a light vertex could not bear its slope."""
    return wp.min(pad.area, law.stiffness * mass / laws.steepest[pad.law - 1])


@wp.func
def normal_energy(
    law: ContactLaw, mass: wp.float64, laws: CompactionLaws, pad: Pad, depth: wp.float64
) -> wp.float64:
    """Energy [J] of a contact that is pressed in by a depth [m]."""
    if pad.law == 0:
        return wp.float64(0.5) * law.stiffness * mass * depth * depth
    return padded_area(law, mass, laws, pad) * compacted(laws, pad.law - 1, depth)[1]


@wp.func
def normal_response(
    law: ContactLaw, laws: CompactionLaws, mass: wp.float64, pad: Pad, depth: wp.float64
):
    """Energy [J] of a contact that is pressed in by a depth [m], and what acts on it.

    Returns:
        The energy, the depth at which the penalty would bear what the contact does [m], and the lag
        of the dashpot [s].
    """
    energy = normal_energy(law, mass, laws, pad, depth)
    if pad.law == 0:
        return energy, depth, law.lag
    stiffness = law.stiffness * mass
    area = padded_area(law, mass, laws, pad)
    soft = compacted(laws, pad.law - 1, depth)
    slope = wp.min(area * soft[2] / stiffness, wp.float64(1.0))
    return energy, area * soft[0] / stiffness, law.lag * wp.sqrt(slope)


@wp.struct
class Traction:
    """Force of a contact on the vertex, and what it stored and lost in this step."""

    force: wp.vec3d  # N
    spring: wp.vec3d  # tangential elastic displacement [m]
    dashpot: wp.float64  # N along the normal, part of the force
    pressing: wp.float64  # normal force [N]
    stored: wp.float64  # J, normal and stick springs
    friction: wp.float64  # J lost in slip in this step
    damping: wp.float64  # J lost in the dashpot in this step
    slip: wp.float64  # m slid in this step


@wp.func
def pressure_on(pad: Pad, force: wp.float64) -> wp.float64:
    """Pressure [Pa] of a normal force [N] on a pad; below zero where nothing tells its area."""
    if pad.area > wp.float64(0.0):
        return force / pad.area
    return wp.float64(-1.0)


@wp.func
def contact_traction(
    law: ContactLaw,
    laws: CompactionLaws,
    mass: wp.float64,
    pad: Pad,
    rub: Rub,
    gap: wp.float64,
    normal: wp.vec3d,
    velocity: wp.vec3d,
    spring: wp.vec3d,
    dashpot: wp.float64,
) -> Traction:
    """Traction of one contact in one step.

    Args:
        law: shared parameters.
        laws: of compaction.
        mass: effective mass of the contact [kg].
        pad: what gives way.
        rub: its friction.
        gap: distance less the offset [m]; negative in contact.
        normal: unit normal, towards the vertex.
        velocity: of the vertex relative to the surface, over the last step [m/s].
        spring: tangential elastic displacement after the last step [m].
        dashpot: the dashpot's force in the last step [N].
    """
    t = Traction()
    zero = wp.float64(0.0)
    half = wp.float64(0.5)
    stiffness = law.stiffness * mass
    approach = wp.dot(normal, velocity)
    trial = spring + law.time_step * velocity
    trial = trial - wp.dot(normal, trial) * normal
    if gap < zero:
        energy, pressed, lag = normal_response(law, laws, mass, pad, -gap)
        depth = wp.max(pressed - lag * approach, zero)  # … with the dashpot
        t.dashpot = stiffness * (depth - pressed)
        t.pressing = stiffness * depth
        t.spring = trial
        square = wp.length_sq(trial)
        holds = rub.coefficient * depth  # where no law says otherwise
        if rub.law > 0 or square > holds * holds:
            length = wp.sqrt(square)
            pressure = pressure_on(pad, t.pressing)
            limit = bearable(law.friction, rub, pressure, depth, length, law.time_step)
            t.spring = (limit / wp.max(wp.max(length, limit), TINY)) * trial
            t.slip = wp.max(length - limit, zero)
        t.force = stiffness * (depth * normal - t.spring)
        t.stored = energy + half * stiffness * wp.length_sq(t.spring)
    # Work of the mean of a step's two end forces over its way, less what the spring took up.
    t.damping = -half * law.time_step * (dashpot + t.dashpot) * approach
    t.friction = half * stiffness * wp.dot(spring + t.spring, trial - t.spring)
    return t
