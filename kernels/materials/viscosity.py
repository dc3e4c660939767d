"""Viscosity of a matrix: stress over the rate of shear, and the shift of rates with temperature.

At the reference temperature σ(s) = η(s) s. At another one a rate r counts as s = a r, a the shift
factor: σ = η(a r) a r. Stress rises with rate, ever less: σ' > 0, σ'' ≤ 0.
"""

import warp as wp

NEWTONIAN = wp.constant(0)
POWER = wp.constant(1)
CROSS = wp.constant(2)
UNSHIFTED = wp.constant(0)
ARRHENIUS = wp.constant(1)
WLF = wp.constant(2)
LOG_10 = wp.constant(wp.float64(2.302585092994046))
"""ln 10 [-]."""
ITERATIONS = wp.constant(60)
"""Newton's at most; from the rate of the step before it takes two or three."""
EXACT = wp.constant(wp.float64(1e-12))
"""Share of a stress that may be missed [-]."""


@wp.struct
class Viscosity:
    """η0; η0 (1 + (s/s0)²)^((n − 1)/2); or η∞ + (η0 − η∞)/(1 + (s/s0)^m)."""

    law: wp.int32  # NEWTONIAN, POWER or CROSS
    at_rest: wp.float64  # η0 [Pa·s]
    at_last: wp.float64  # η∞ [Pa·s]
    rate: wp.float64  # s0 [1/s]
    exponent: wp.float64  # n or m [-]


@wp.struct
class Shift:
    """Shift factor of rates with temperature, held at that of the lowest one below it."""

    law: wp.int32  # UNSHIFTED, ARRHENIUS or WLF
    reference: wp.float64  # T0 [K]
    lowest: wp.float64  # K
    first: wp.float64  # E/R [K], or C1 [-]
    second: wp.float64  # C2 [K]


@wp.func
def shift_factor(shift: Shift, temperature: wp.float64) -> wp.float64:
    """Factor a on rates: ln a = (E/R)(1/T − 1/T0), or lg a = −C1 (T − T0)/(C2 + T − T0).

    Sources: Arrhenius; Williams, Landel & Ferry 1955.
    """
    if shift.law == UNSHIFTED:
        return wp.float64(1.0)
    t = wp.max(temperature, shift.lowest)
    if shift.law == ARRHENIUS:
        one = wp.float64(1.0)
        return wp.exp(shift.first * (one / t - one / shift.reference))
    above = t - shift.reference
    return wp.exp(-LOG_10 * shift.first * above / (shift.second + above))


@wp.func
def flow_stress(law: Viscosity, rate: wp.float64) -> wp.vec2d:
    """Stress σ [Pa] at a shifted rate s ≥ 0 [1/s], and its slope σ' [Pa·s]."""
    one = wp.float64(1.0)
    if law.law == NEWTONIAN:
        return wp.vec2d(law.at_rest * rate, law.at_rest)
    share = rate / law.rate
    if law.law == POWER:
        square = share * share
        less = law.exponent - one
        eta = law.at_rest * wp.pow(one + square, wp.float64(0.5) * less)
        return wp.vec2d(eta * rate, eta * (one + less * square / (one + square)))
    y = wp.pow(share, law.exponent)
    fall = (law.at_rest - law.at_last) / (one + y)
    slope = law.at_last + fall * (one + (one - law.exponent) * y) / (one + y)
    return wp.vec2d((law.at_last + fall) * rate, slope)


@wp.func
def flow_rate(
    law: Viscosity, scale: wp.float64, drag: wp.float64, load: wp.float64, guess: wp.float64
) -> wp.float64:
    """Shifted rate s ≥ 0 [1/s] at which scale · σ(s) + drag · s = load.

    The left side is concave and rises: Newton's method comes to the root from below, whatever it
    begins with.

    Args:
        law: viscosity.
        scale: of the stress [m].
        drag: of all else that grows with the rate, above zero: a stress may have an end [N·s/m].
        load: zero or more [N/m].
        guess: zero or more [1/s].
    """
    rate = guess
    for _ in range(ITERATIONS):
        stress = flow_stress(law, rate)
        miss = scale * stress[0] + drag * rate - load
        if wp.abs(miss) <= EXACT * load:
            break
        rate = wp.max(rate - miss / (scale * stress[1] + drag), wp.float64(0.0))
    return rate
