"""Laws sampled at given strains and angles, for material cards and tests."""

import warp as wp


def make_law_samplers(tension, tension_energy, shear, shear_energy, Tension, Shear):
    """Make the kernels for one pair of laws: ``(compute_tensions, compute_couples)``.

    The arguments are those of `membrane.make_yarn_membrane`.
    """

    @wp.kernel(module="unique", enable_backward=False)
    def compute_tensions(
        law: Tension,
        strain: wp.array(dtype=wp.vec2d),
        line_tension: wp.array(dtype=wp.vec2d),
        energy: wp.array(dtype=wp.float64),
    ):
        """Compute line tensions [N/m] and energy [J/m²]; one thread a pair of strains."""
        i = wp.tid()
        line_tension[i] = tension(law, strain[i])
        energy[i] = tension_energy(law, strain[i])

    @wp.kernel(module="unique", enable_backward=False)
    def compute_couples(
        law: Shear,
        angle: wp.array(dtype=wp.float64),
        couple: wp.array(dtype=wp.float64),
        energy: wp.array(dtype=wp.float64),
    ):
        """Compute couples [N/m] and energy [J/m²]; one thread an angle."""
        i = wp.tid()
        couple[i] = shear(law, angle[i])
        energy[i] = shear_energy(law, angle[i])

    return compute_tensions, compute_couples
