"""Isotropic membrane at large rotation: St Venant–Kirchhoff, plane stress (paper, Figure 3c)."""

import warp as wp


@wp.struct
class IsotropicMembrane:
    """Plane-stress sheet; ``stiffness`` is Young's modulus times thickness."""

    stiffness: wp.float64  # N/m
    poisson: wp.float64  # -


@wp.func
def membrane_strain(k1: wp.vec3d, k2: wp.vec3d) -> wp.vec3d:
    """Green–Lagrange strain (E11, E22, E12) from the images of two orthonormal directions."""
    half = wp.float64(0.5)
    one = wp.float64(1.0)
    return wp.vec3d(
        half * (wp.dot(k1, k1) - one), half * (wp.dot(k2, k2) - one), half * wp.dot(k1, k2)
    )


@wp.func
def membrane_stress(law: IsotropicMembrane, strain: wp.vec3d) -> wp.vec3d:
    """Second Piola–Kirchhoff stress times thickness (S11, S22, S12) [N/m]."""
    one = wp.float64(1.0)
    factor = law.stiffness / (one - law.poisson * law.poisson)
    return factor * wp.vec3d(
        strain[0] + law.poisson * strain[1],
        strain[1] + law.poisson * strain[0],
        (one - law.poisson) * strain[2],
    )


@wp.func
def membrane_energy(law: IsotropicMembrane, strain: wp.vec3d) -> wp.float64:
    """Energy per area [J/m²]."""
    stress = membrane_stress(law, strain)
    return wp.float64(0.5) * (
        stress[0] * strain[0] + stress[1] * strain[1] + wp.float64(2.0) * stress[2] * strain[2]
    )


@wp.func
def sheet_tension(law: IsotropicMembrane, strain: wp.vec2d) -> wp.vec2d:
    """Stress times thickness on two perpendicular directions [N/m] by Hooke's law."""
    factor = law.stiffness / (wp.float64(1.0) - law.poisson * law.poisson)
    return factor * wp.vec2d(
        strain[0] + law.poisson * strain[1], strain[1] + law.poisson * strain[0]
    )


@wp.func
def sheet_couple(law: IsotropicMembrane, angle: wp.float64) -> wp.float64:
    """Shear stress times thickness [N/m] of a change of the angle between them [rad]."""
    return angle * law.stiffness / (wp.float64(2.0) * (wp.float64(1.0) + law.poisson))
