"""The contact law: penalty with damping along the normal, Coulomb friction that sticks.

Penalty stiffness follows the masses that meet, k = share · m / Δt², so that no vertex is driven
beyond its own stable step. A stuck point hangs on a tangential spring of the same stiffness; where
the spring would exceed μ times the normal force it slips. Forces act over the step centred on them,
so what friction and dashpot take in a step is the work of the mean of its two ends' forces.
"""

import warp as wp

TINY = wp.constant(wp.float64(1e-30))
"""Keeps a slack spring's length from dividing by zero [m]."""


@wp.struct
class ContactLaw:
    """What every contact of a run shares."""

    stiffness: wp.float64  # k / m = share / Δt² [1/s²]
    lag: wp.float64  # of the dashpot, 2 ζ √(k m) / k [s]
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
    zero = wp.float64(0.0)
    half = wp.float64(0.5)
    stiffness = law.stiffness * mass
    approach = wp.dot(normal, velocity)
    trial = spring + law.time_step * velocity
    trial = trial - wp.dot(normal, trial) * normal
    if gap < zero:
        depth = wp.max(-gap - law.lag * approach, zero)  # at which the spring alone presses so
        t.dashpot = stiffness * (depth + gap)
        limit = friction * depth
        length = wp.length(trial)
        t.spring = (limit / wp.max(wp.max(length, limit), TINY)) * trial
        t.slip = wp.max(length - limit, zero)
        t.force = stiffness * (depth * normal - t.spring)
        t.stored = half * stiffness * (gap * gap + wp.length_sq(t.spring))
    # Work of the mean of a step's two end forces over its way, less what the spring took up.
    t.damping = -half * law.time_step * (dashpot + t.dashpot) * approach
    t.friction = half * stiffness * wp.dot(spring + t.spring, trial - t.spring)
    return t
