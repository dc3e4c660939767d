"""Tension that softened yarns recover: what softening withholds from them, taken up at a rate.

Softened yarns carry T_s = T/s at once. What they lack, (s − 1) T_s, comes as a tension R:

    N = T_s(ε) + R + c (ε − ε̂),   dR/dt = g T_s(ε) − g/(s − 1) R,  R ≥ 0,   dε̂/dt = ω (ε − ε̂)

At rest N = T(ε), the fabric's own; what is fast feels T_s alone. R follows the strain by a quarter
turn and so feeds what swings, at g/2; the guard c = 2 g k_s/ω takes more than that from all that is
faster than ω (docs/theory.md).
"""

import warp as wp


@wp.struct
class RecoveryRates:
    """How a ply's yarns recover; all zero where they do not."""

    taken_up: wp.float64  # g Δt [-]
    let_go: wp.float64  # g Δt/(s − 1) [-]
    followed: wp.float64  # ω Δt [-]
    guard: wp.vec2d  # c of warp and weft [N/m]


@wp.struct
class Recovery:
    """What a patch remembers of it."""

    tension: wp.vec2d  # R of warp and weft [N/m]
    followed: wp.vec2d  # ε̂ [-]
    taken: wp.float64  # work of all that is beside T_s [J]


@wp.func
def beside_softened(rates: RecoveryRates, known: Recovery, strain: wp.vec2d) -> wp.vec2d:
    """Line tensions R + c (ε − ε̂) [N/m]."""
    return known.tension + wp.cw_mul(rates.guard, strain - known.followed)


@wp.func
def recover(
    rates: RecoveryRates,
    known: Recovery,
    softened: wp.vec2d,
    strain: wp.vec2d,
    before: wp.vec2d,
    change: wp.vec2d,
    area: wp.float64,
) -> Recovery:
    """Memory after a step.

    Args:
        rates: of the ply.
        known: after the step before.
        softened: T_s [N/m].
        strain: ε [-].
        before: change of the strain up to the step before [-].
        change: from there to now [-].
        area: initial [m²].
    """
    out = Recovery()
    # the tension before acted over half of each change, as positions and velocities alternate
    acted = beside_softened(rates, known, strain - change)
    out.taken = known.taken + wp.float64(0.5) * area * wp.dot(acted, before + change)
    full = known.tension + rates.taken_up * softened - rates.let_go * known.tension
    none = wp.float64(0.0)
    out.tension = wp.vec2d(wp.max(full[0], none), wp.max(full[1], none))
    out.followed = known.followed + rates.followed * (strain - known.followed)
    return out
