"""The semi-discrete triangle, in pairs that share one strain per yarn family.

Source: Hamila & Boisse 2008, eqs. 22 and 28, with the current yarn length (so that the loads are
the exact gradient of an energy) and the shear gradient in its regular form; pairs: docs/theory.md.

    W = Σ_patch A Φ(ε̄1, ε̄2) + Σ_t A_t [Ψ(γ_t) + ½ κ Σ_α (ε_α,t − ε̄_α)²],  ε̄ the patch's mean

A patch is two triangles with a common edge; three where the matching leaves one over; one for the
plain element. Forces are −∂W/∂x. Most patches are pairs, whose forces `pairs` computes faster.
"""

import warp as wp

from ..materials.yarns import (
    angle_from_cosine,
    guarded_sine,
    shear_angle,
    warp_vector,
    weft_vector,
    yarn_strain,
)
from .recovery import Recovery, RecoveryRates, beside_softened, recover


@wp.func
def triangle_strain(k1: wp.vec3d, k2: wp.vec3d) -> wp.vec2d:
    """Yarn strains (ε1, ε2) [-]."""
    return wp.vec2d(yarn_strain(k1), yarn_strain(k2))


@wp.func
def add_triangle_loads(
    a: int,
    b: int,
    c: int,
    gradient: wp.vec4d,
    along_warp: wp.vec3d,
    along_weft: wp.vec3d,
    f: wp.array(dtype=wp.vec3d),
):
    """Scatter −∂W/∂x from ∂W/∂k1, ∂W/∂k2 [N m]."""
    load_b = gradient[0] * along_warp + gradient[2] * along_weft
    load_c = gradient[1] * along_warp + gradient[3] * along_weft
    wp.atomic_sub(f, b, load_b)
    wp.atomic_sub(f, c, load_c)
    wp.atomic_add(f, a, load_b + load_c)


@wp.struct
class PatchMemory:
    """What a patch remembers of its yarns' mean strains."""

    strain: wp.vec2d  # in the step before [-]
    change: wp.vec2d  # up to it [-]
    lost: wp.float64  # to the viscosity [J]


@wp.func
def after_step(
    known: PatchMemory, now: wp.vec2d, change: wp.vec2d, viscosity: wp.vec2d, area: wp.float64
) -> PatchMemory:
    """Memory after a step: the tension before, η times the last change, acted over half of each."""
    out = PatchMemory()
    out.strain = now
    out.change = change
    half = wp.float64(0.5) * wp.cw_mul(known.change, known.change + change)
    out.lost = known.lost + area * wp.dot(viscosity, half)
    return out


def make_yarn_membrane(tension, tension_energy, shear, shear_energy, Tension, Shear):
    """Make the kernels for one pair of laws: ``(add_patch_forces, measure)``.

    Args:
        tension: wp.func (law, strain) → line tensions [N/m].
        tension_energy: wp.func (law, strain) → energy per area [J/m²].
        shear: wp.func (law, angle) → couple per area [N/m].
        shear_energy: wp.func (law, angle) → energy per area [J/m²].
        Tension: struct of the tension law.
        Shear: struct of the shear law.
    """

    @wp.struct
    class Loads:
        """∂W/∂k1 and ∂W/∂k2 per area [N/m]."""

        warp: wp.vec3d
        weft: wp.vec3d

    @wp.func
    def yarn_loads(
        k1: wp.vec3d,
        k2: wp.vec3d,
        lengths: wp.vec2d,
        line_tension: wp.vec2d,
        shear_law: Shear,
        rest_angle: wp.float64,
    ) -> Loads:
        one = wp.float64(1.0)
        inverse = wp.vec2d(one / lengths[0], one / lengths[1])
        u1 = inverse[0] * k1
        u2 = inverse[1] * k2
        cosine = wp.dot(u1, u2)
        couple = shear(shear_law, angle_from_cosine(cosine, rest_angle)) / guarded_sine(cosine)
        out = Loads()
        # ∂γ/∂k = (u_other − cos θ u)/(sin θ ‖k‖): [25] in its regular form
        out.warp = line_tension[0] * u1 + (couple * inverse[0]) * (u2 - cosine * u1)
        out.weft = line_tension[1] * u2 + (couple * inverse[1]) * (u1 - cosine * u2)
        return out

    @wp.func
    def mean_strain(
        first: int,
        last: int,
        patch_triangles: wp.array(dtype=wp.int32),
        triangles: wp.array2d(dtype=wp.int32),
        gradients: wp.array(dtype=wp.vec4d),
        areas: wp.array(dtype=wp.float64),
        x: wp.array(dtype=wp.vec3d),
    ) -> wp.vec2d:
        total = wp.vec2d()
        area = wp.float64(0.0)
        for slot in range(first, last):
            t = patch_triangles[slot]
            origin = x[triangles[t, 0]]
            edge_b = x[triangles[t, 1]] - origin
            edge_c = x[triangles[t, 2]] - origin
            d = gradients[t]
            total += areas[t] * triangle_strain(
                warp_vector(d, edge_b, edge_c), weft_vector(d, edge_b, edge_c)
            )
            area += areas[t]
        return total / area

    @wp.kernel(module="unique", enable_backward=False)
    def add_patch_forces(
        first_patch: int,
        offsets: wp.array(dtype=wp.int32),
        patch_triangles: wp.array(dtype=wp.int32),
        triangles: wp.array2d(dtype=wp.int32),
        gradients: wp.array(dtype=wp.vec4d),
        areas: wp.array(dtype=wp.float64),
        tension_law: Tension,
        shear_law: Shear,
        stabiliser: wp.array(dtype=wp.float64),
        rest_angle: wp.float64,
        viscosity: wp.vec2d,
        rates: RecoveryRates,
        x: wp.array(dtype=wp.vec3d),
        memory: wp.array(dtype=PatchMemory),
        recovered: wp.array(dtype=Recovery),
        f: wp.array(dtype=wp.vec3d),
    ):
        """Add yarn and shear forces to ``f``; one thread a patch of any number of triangles.

        ``viscosity`` [N/m], ``rates``, ``memory`` and ``recovered``, shape [patch], are as those of
        `pairs.make_pair_forces`.
        """
        patch = first_patch + wp.tid()
        first = offsets[patch]
        last = offsets[patch + 1]
        mean = mean_strain(first, last, patch_triangles, triangles, gradients, areas, x)
        line = tension(tension_law, mean)
        none = wp.float64(0.0)
        if viscosity[0] + viscosity[1] + rates.taken_up > none:
            area = wp.float64(0.0)
            for slot in range(first, last):
                area += areas[patch_triangles[slot]]
            known = memory[patch]
            change = mean - known.strain
            if rates.taken_up > none:
                kept = recover(rates, recovered[patch], line, mean, known.change, change, area)
                line += beside_softened(rates, kept, mean)
                recovered[patch] = kept
            line += wp.cw_mul(viscosity, change)
            memory[patch] = after_step(known, mean, change, viscosity, area)
        for slot in range(first, last):
            t = patch_triangles[slot]
            a = triangles[t, 0]
            b = triangles[t, 1]
            c = triangles[t, 2]
            d = gradients[t]
            k1 = warp_vector(d, x[b] - x[a], x[c] - x[a])
            k2 = weft_vector(d, x[b] - x[a], x[c] - x[a])
            own = line + stabiliser[patch] * (triangle_strain(k1, k2) - mean)
            lengths = wp.vec2d(wp.length(k1), wp.length(k2))
            loads = yarn_loads(k1, k2, lengths, own, shear_law, rest_angle)
            add_triangle_loads(a, b, c, d, areas[t] * loads.warp, areas[t] * loads.weft, f)

    @wp.kernel(module="unique", enable_backward=False)
    def measure(
        offsets: wp.array(dtype=wp.int32),
        patch_triangles: wp.array(dtype=wp.int32),
        triangles: wp.array2d(dtype=wp.int32),
        gradients: wp.array(dtype=wp.vec4d),
        areas: wp.array(dtype=wp.float64),
        tension_law: Tension,
        shear_law: Shear,
        stabiliser: wp.array(dtype=wp.float64),
        rest_angle: wp.float64,
        x: wp.array(dtype=wp.vec3d),
        strain: wp.array(dtype=wp.vec2d),
        line_tension: wp.array(dtype=wp.vec2d),
        energy: wp.array(dtype=wp.vec3d),
    ):
        """Compute what every triangle shows; one thread a patch.

        Args:
            offsets: first slot of each patch, shape [patch + 1].
            patch_triangles: triangles by patch, shape [triangle].
            triangles: vertices, shape [triangle, 3].
            gradients: D [1/m], shape [triangle].
            areas: initial areas [m²], shape [triangle].
            tension_law: line tension law [N/m].
            shear_law: shear couple law [N/m].
            stabiliser: κ C'(0) [N/m], shape [patch].
            rest_angle: angle between warp and weft of the flat ply [rad].
            x: positions [m], shape [vertex].
            strain: patch mean of the yarn strains [-], shape [triangle]; overwritten.
            line_tension: line tensions [N/m], shape [triangle]; overwritten.
            energy: yarn, shear, stabiliser energy [J], shape [triangle]; overwritten.
        """
        patch = wp.tid()
        first = offsets[patch]
        last = offsets[patch + 1]
        mean = mean_strain(first, last, patch_triangles, triangles, gradients, areas, x)
        line = tension(tension_law, mean)
        yarn_energy = tension_energy(tension_law, mean)
        for slot in range(first, last):
            t = patch_triangles[slot]
            a = triangles[t, 0]
            d = gradients[t]
            edge_b = x[triangles[t, 1]] - x[a]
            edge_c = x[triangles[t, 2]] - x[a]
            k1 = warp_vector(d, edge_b, edge_c)
            k2 = weft_vector(d, edge_b, edge_c)
            own = triangle_strain(k1, k2) - mean
            strain[t] = mean
            line_tension[t] = line
            energy[t] = areas[t] * wp.vec3d(
                yarn_energy,
                shear_energy(shear_law, shear_angle(k1, k2, rest_angle)),
                wp.float64(0.5) * stabiliser[patch] * wp.dot(own, own),
            )

    return add_patch_forces, measure
