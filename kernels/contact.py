"""The contact law: penalty with damping along the normal, Coulomb friction that sticks.

Penalty stiffness follows the masses that meet, k = share · m / Δt², so that no vertex is driven
beyond its own stable step. A stuck point hangs on a tangential spring of the same stiffness; where
the spring would exceed μ times the normal force it slips. Forces act over the step centred on them,
so what friction and dashpot take in a step is the work of the mean of its two ends' forces.
"""

import warp as wp


@wp.struct
class ContactLaw:
    """What every contact of a run shares."""

    share: wp.float64  # k Δt² / m [-]
    damping_ratio: wp.float64  # of the contact's critical damping [-]
    time_step: wp.float64  # s


@wp.struct
class Traction:
    """Force of a contact on the vertex, and what it stored and lost in this step."""

    force: wp.vec3d  # N
    spring: wp.vec3d  # tangential elastic displacement [m]
    dashpot: wp.float64  # N along the normal, part of the force
    stored: wp.float64  # J, penalty and stick springs
    friction: wp.float64  # J lost in slip in this step
    damping: wp.float64  # J lost in the dashpot in this step
    slip: wp.float64  # m slid in this step


@wp.func
def contact_stiffness(law: ContactLaw, mass: wp.float64) -> wp.float64:
    """Penalty stiffness [N/m] of a contact of effective mass [kg]."""
    return law.share * mass / (law.time_step * law.time_step)


@wp.func
def contact_traction(
    law: ContactLaw,
    mass: wp.float64,
    friction: wp.float64,
    gap: wp.float64,
    normal: wp.vec3d,
    velocity: wp.vec3d,
    spring: wp.vec3d,
    dashpot: wp.float64,
) -> Traction:
    """Traction of one contact in one step.

    Args:
        law: shared parameters.
        mass: effective mass of the contact [kg].
        friction: Coulomb coefficient μ [-].
        gap: distance less the offset [m]; negative in contact.
        normal: unit normal, towards the vertex.
        velocity: of the vertex relative to the surface, over the last step [m/s].
        spring: tangential elastic displacement after the last step [m].
        dashpot: the dashpot's force in the last step [N].
    """
    t = Traction()
    stiffness = contact_stiffness(law, mass)
    half = wp.float64(0.5)
    trial = spring + law.time_step * velocity
    trial = trial - wp.dot(normal, trial) * normal
    if gap < wp.float64(0.0):
        approach = wp.dot(normal, velocity)
        elastic = -stiffness * gap
        viscosity = wp.float64(2.0) * law.damping_ratio * wp.sqrt(stiffness * mass)
        pressure = wp.max(elastic - viscosity * approach, wp.float64(0.0))
        t.dashpot = pressure - elastic
        length = wp.length(trial)
        limit = friction * pressure / stiffness
        t.spring = trial
        if length > limit:
            t.spring = (limit / length) * trial
            t.slip = length - limit
        t.force = pressure * normal - stiffness * t.spring
        t.stored = half * stiffness * (gap * gap + wp.dot(t.spring, t.spring))
    # Work of the mean of a step's two end forces over its way, less what the spring took up.
    way = law.time_step * wp.dot(normal, velocity)
    t.damping = -half * (dashpot + t.dashpot) * way
    t.friction = half * stiffness * wp.dot(spring + t.spring, trial - t.spring)
    return t
