"""Shear couple laws, per initial area: C = C_s/S [N/m], C_s the couple of one cell of area S.

A law is a struct of its parameters, ``*_couple(law, γ)`` and ``*_energy(law, γ)`` [J/m²] with
couple = ∂energy/∂γ, γ the shear angle [rad]. Locking is part of the curve.
"""

import warp as wp


@wp.struct
class ShearPolynomial:
    """C = c0 γ + c1 γ³ + c2 γ⁵ + c3 γ⁷; all zero for a fabric without shear stiffness."""

    coefficients: wp.vec4d  # N/m


@wp.struct
class ShearCurve:
    """Odd cubic-Hermite curve through measured points, continued linearly past the last."""

    angles: wp.array(dtype=wp.float64)  # rad, shape [knot], rising from 0
    couples: wp.array(dtype=wp.float64)  # N/m, shape [knot]
    slopes: wp.array(dtype=wp.float64)  # N/m per rad, shape [knot]
    energies: wp.array(dtype=wp.float64)  # J/m², shape [knot]


@wp.func
def polynomial_couple(law: ShearPolynomial, angle: wp.float64) -> wp.float64:
    """Couple per area [N/m]."""
    c = law.coefficients
    q = angle * angle
    return angle * (c[0] + q * (c[1] + q * (c[2] + q * c[3])))


@wp.func
def polynomial_energy(law: ShearPolynomial, angle: wp.float64) -> wp.float64:
    """Energy per area [J/m²]."""
    c = law.coefficients
    q = angle * angle
    return q * (
        c[0] / wp.float64(2.0)
        + q * (c[1] / wp.float64(4.0) + q * (c[2] / wp.float64(6.0) + q * c[3] / wp.float64(8.0)))
    )


@wp.func
def curve_interval(law: ShearCurve, size: wp.float64) -> int:
    """Index of the knot at or below a positive angle; the last knot beyond the table."""
    last = law.angles.shape[0] - 1
    if size >= law.angles[last]:
        return last
    return wp.max(wp.lower_bound(law.angles, size) - 1, 0)


@wp.func
def curve_couple(law: ShearCurve, angle: wp.float64) -> wp.float64:
    """Couple per area [N/m]."""
    size = wp.abs(angle)
    i = curve_interval(law, size)
    couple = law.couples[i] + law.slopes[i] * (size - law.angles[i])
    if i + 1 < law.angles.shape[0]:
        h = law.angles[i + 1] - law.angles[i]
        u = (size - law.angles[i]) / h
        rise = law.couples[i + 1] - law.couples[i]
        square = wp.float64(3.0) * rise - h * (wp.float64(2.0) * law.slopes[i] + law.slopes[i + 1])
        cube = h * (law.slopes[i] + law.slopes[i + 1]) - wp.float64(2.0) * rise
        couple = law.couples[i] + u * (h * law.slopes[i] + u * (square + u * cube))
    return wp.sign(angle) * couple


@wp.func
def curve_energy(law: ShearCurve, angle: wp.float64) -> wp.float64:
    """Energy per area [J/m²]."""
    size = wp.abs(angle)
    i = curve_interval(law, size)
    step = size - law.angles[i]
    energy = law.energies[i] + step * (law.couples[i] + wp.float64(0.5) * step * law.slopes[i])
    if i + 1 < law.angles.shape[0]:
        h = law.angles[i + 1] - law.angles[i]
        u = step / h
        rise = law.couples[i + 1] - law.couples[i]
        square = wp.float64(3.0) * rise - h * (wp.float64(2.0) * law.slopes[i] + law.slopes[i + 1])
        cube = h * (law.slopes[i] + law.slopes[i + 1]) - wp.float64(2.0) * rise
        polynomial = law.couples[i] + u * (
            h * law.slopes[i] / wp.float64(2.0)
            + u * (square / wp.float64(3.0) + u * cube / wp.float64(4.0))
        )
        energy = law.energies[i] + h * u * polynomial
    return energy
