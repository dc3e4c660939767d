"""Sheets without yarns: the constant-strain triangle with a law between Green's strain and stress.

W = A_t w(E), so ∂W/∂k1 = A_t (S11 k1 + S12 k2) and ∂W/∂k2 = A_t (S12 k1 + S22 k2): k1 and k2 are
the images of two orthonormal directions, and each triangle stands alone.
"""

import warp as wp

from ..materials.isotropic import (
    IsotropicMembrane,
    membrane_energy,
    membrane_strain,
    membrane_stress,
)
from ..materials.rubber import MooneyRivlin, rubber_energy, rubber_stress
from ..materials.yarns import warp_vector, weft_vector
from .membrane import add_triangle_loads, triangle_strain


def make_sheet(stress, stored, Law):
    """Make the kernels for one law: ``(add_sheet_forces, measure_sheet)``.

    Args:
        stress: wp.func (law, strain) → second Piola–Kirchhoff stress times thickness [N/m].
        stored: wp.func (law, strain) → energy per area [J/m²].
        Law: struct of the law.
    """

    @wp.kernel(module="unique", enable_backward=False)
    def add_sheet_forces(
        first: int,
        triangles: wp.array2d(dtype=wp.int32),
        gradients: wp.array(dtype=wp.vec4d),
        areas: wp.array(dtype=wp.float64),
        law: Law,
        x: wp.array(dtype=wp.vec3d),
        f: wp.array(dtype=wp.vec3d),
    ):
        """Add the forces of a sheet to ``f``; one thread a triangle."""
        t = first + wp.tid()
        a = triangles[t, 0]
        b = triangles[t, 1]
        c = triangles[t, 2]
        d = gradients[t]
        k1 = warp_vector(d, x[b] - x[a], x[c] - x[a])
        k2 = weft_vector(d, x[b] - x[a], x[c] - x[a])
        load = areas[t] * stress(law, membrane_strain(k1, k2))
        along_1 = load[0] * k1 + load[2] * k2
        along_2 = load[2] * k1 + load[1] * k2
        add_triangle_loads(a, b, c, d, along_1, along_2, f)

    @wp.kernel(module="unique", enable_backward=False)
    def measure_sheet(
        triangles: wp.array2d(dtype=wp.int32),
        gradients: wp.array(dtype=wp.vec4d),
        areas: wp.array(dtype=wp.float64),
        law: Law,
        x: wp.array(dtype=wp.vec3d),
        strain: wp.array(dtype=wp.vec2d),
        line_tension: wp.array(dtype=wp.vec2d),
        energy: wp.array(dtype=wp.vec3d),
    ):
        """Compute what a triangle of a sheet shows; one thread a triangle."""
        t = wp.tid()
        a = triangles[t, 0]
        d = gradients[t]
        edge_b = x[triangles[t, 1]] - x[a]
        edge_c = x[triangles[t, 2]] - x[a]
        k1 = warp_vector(d, edge_b, edge_c)
        k2 = weft_vector(d, edge_b, edge_c)
        green = membrane_strain(k1, k2)
        s = stress(law, green)
        strain[t] = triangle_strain(k1, k2)
        line_tension[t] = wp.vec2d(s[0] * wp.length(k1), s[1] * wp.length(k2))
        energy[t] = wp.vec3d(areas[t] * stored(law, green), wp.float64(0.0), wp.float64(0.0))

    return add_sheet_forces, measure_sheet


add_isotropic_forces, measure_isotropic = make_sheet(
    membrane_stress, membrane_energy, IsotropicMembrane
)
add_rubber_forces, measure_rubber = make_sheet(rubber_stress, rubber_energy, MooneyRivlin)
