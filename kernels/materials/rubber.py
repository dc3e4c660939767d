"""Rubber: an incompressible Mooney–Rivlin solid in plane stress, per area of the flat sheet.

W = C10 (I1 − 3) + C01 (I2 − 3), Mooney (1940), Rivlin (1948); C01 = 0 is neo-Hooke. With a sheet's
C = [[C11, C12], [C12, C22]] and J² = det C, incompressibility makes it J times thinner, C33 = 1/J²:

    I1 = tr C + 1/J²,  I2 = J² + tr C/J²,  S = 2 ∂W/∂C

and no pressure is left to be found.
"""

import warp as wp


@wp.struct
class MooneyRivlin:
    """Constants times the thickness of the flat sheet."""

    c10: wp.float64  # N/m
    c01: wp.float64  # N/m


@wp.func
def rubber_stress(law: MooneyRivlin, strain: wp.vec3d) -> wp.vec3d:
    """Second Piola–Kirchhoff stress times thickness (S11, S22, S12) [N/m] from Green's strain.

    ∂(1/J²)/∂C = −adj C/J⁴, adj C the matrix of cofactors, which is J² C⁻¹.
    """
    one = wp.float64(1.0)
    two = wp.float64(2.0)
    c11 = one + two * strain[0]
    c22 = one + two * strain[1]
    c12 = two * strain[2]
    squeezed = one / (c11 * c22 - c12 * c12)
    whole = law.c10 + law.c01 * squeezed
    cofactor = law.c01 - (law.c10 + law.c01 * (c11 + c22)) * squeezed * squeezed
    return two * wp.vec3d(whole + cofactor * c22, whole + cofactor * c11, -cofactor * c12)


@wp.func
def rubber_energy(law: MooneyRivlin, strain: wp.vec3d) -> wp.float64:
    """Energy per area of the flat sheet [J/m²] from Green's strain (E11, E22, E12)."""
    one = wp.float64(1.0)
    two = wp.float64(2.0)
    three = wp.float64(3.0)
    trace = two * (one + strain[0] + strain[1])
    area_sq = (one + two * strain[0]) * (one + two * strain[1]) - two * two * strain[2] * strain[2]
    return law.c10 * (trace + one / area_sq - three) + law.c01 * (area_sq + trace / area_sq - three)
