"""Forces of pairs of triangles, two pairs at a time: nearly all the work of a ply's membrane.

The formulas are those of `membrane`, with γ's gradient in terms of k1, k2 themselves:

    ∂γ/∂k1 = (k2 − (k1·k2) k1/‖k1‖²)/J,  J = ‖k1 × k2‖ = √(‖k1‖²‖k2‖² − (k1·k2)²) = ‖k1‖‖k2‖ sin θ
"""

import warp as wp

from ..materials.yarns import COLLAPSE_SINE, QUARTER_TURN, angles_within_quarter_turn
from .lanes import (
    WIDE,
    Vectors,
    combination,
    difference,
    dots,
    inverses,
    lane,
    larger,
    of_pairs,
    pair_sums,
    roots,
    vectors,
)
from .recovery import Recovery, RecoveryRates, beside_softened, recover

FETCHED_AHEAD = wp.constant(6)
"""Elements of two pairs ahead of the one at work that are fetched: some 0.4 µs."""


@wp.struct
class TwoPairs:
    """Pairs P = (i, j, k), (i, l, j) and Q alike; lanes: P's two triangles, then Q's two.

    Of D only what the shared edge's end j and a triangle's own tip (k or l) need.
    """

    vertices_p: wp.vec4i  # i, j, k, l
    vertices_q: wp.vec4i
    warp_at_j: wp.vec4d  # 1/m
    warp_at_tip: wp.vec4d  # 1/m
    weft_at_j: wp.vec4d  # 1/m
    weft_at_tip: wp.vec4d  # 1/m
    areas: wp.vec4d  # m², initial
    stabiliser: wp.vec4d  # κ C'(0) of each pair [N/m]


@wp.func_native(
    """
#if !defined(__CUDACC__)
    const char* two = reinterpret_cast<const char*>(pairs.data + number);
    __builtin_prefetch(two);
    __builtin_prefetch(two + 64);
    __builtin_prefetch(two + 128);
#endif
"""
)
def fetch_pairs(pairs: wp.array(dtype=TwoPairs), number: int):
    """Have a processor fetch two pairs while it works on others; there need be none."""
    ...


@wp.struct
class PairMemory:
    """What two pairs remember of their yarns' mean strains: P's warp and weft, then Q's."""

    strain: wp.vec4d  # in the step before [-]
    change: wp.vec4d  # up to it [-]
    lost: wp.float64  # to the viscosity [J]


@wp.func
def after_step(
    known: PairMemory, now: wp.vec4d, change: wp.vec4d, viscosity: wp.vec2d, areas: wp.vec4d
) -> PairMemory:
    """Memory after a step: the tension before, η times the last change, acted over half of each."""
    out = PairMemory()
    out.strain = now
    out.change = change
    area = pair_sums(areas)
    half = wp.float64(0.5) * wp.cw_mul(known.change, known.change + change)
    out.lost = (
        known.lost
        + area[0] * (viscosity[0] * half[0] + viscosity[1] * half[1])
        + area[2] * (viscosity[0] * half[2] + viscosity[1] * half[3])
    )
    return out


@wp.func
def subtract_pair(
    first: int, at_j: Vectors, at_tip: Vectors, v: wp.vec4i, f: wp.array(dtype=wp.vec3d)
):
    """Subtract ∂W/∂x of the pair in lanes ``first``, ``first`` + 1; all four add up to zero."""
    j = lane(at_j, first) + lane(at_j, first + 1)
    k = lane(at_tip, first)
    l = lane(at_tip, first + 1)  # noqa: E741
    wp.atomic_add(f, v[0], j + k + l)
    wp.atomic_sub(f, v[1], j)
    wp.atomic_sub(f, v[2], k)
    wp.atomic_sub(f, v[3], l)


def make_pair_forces(tension, shear, Tension, Shear):
    """Make the kernel ``add_pair_forces`` for one pair of laws.

    Args:
        tension: wp.func (law, strain) → line tensions [N/m].
        shear: wp.func (law, angle) → couple per area [N/m].
        Tension: struct of the tension law.
        Shear: struct of the shear law.
    """

    @wp.func
    def couples(law: Shear, angles: wp.vec4d) -> wp.vec4d:
        return wp.vec4d(
            shear(law, angles[0]),
            shear(law, angles[1]),
            shear(law, angles[2]),
            shear(law, angles[3]),
        )

    @wp.kernel(module="unique", enable_backward=False, module_options=WIDE)
    def add_pair_forces(
        first: int,
        pairs: wp.array(dtype=TwoPairs),
        tension_law: Tension,
        shear_law: Shear,
        rest_angle: wp.float64,
        viscosity: wp.vec2d,
        rates: RecoveryRates,
        x: wp.array(dtype=wp.vec3d),
        memory: wp.array(dtype=PairMemory),
        recovered: wp.array(dtype=Recovery),
        f: wp.array(dtype=wp.vec3d),
    ):
        """Add yarn and shear forces to ``f``; one thread two pairs of triangles.

        Args:
            first: number of the first two.
            pairs: shape [pairs / 2].
            tension_law: line tension law [N/m].
            shear_law: shear couple law [N/m].
            rest_angle: angle between warp and weft of the flat ply [rad].
            viscosity: of warp and weft, line tension per change of strain in a step [N/m].
            rates: of the yarns' recovery.
            x: positions [m], shape [vertex].
            memory: strains of the step before, and what the viscosity has lost, shape of pairs;
                updated.
            recovered: by the yarns of each pair, shape [pairs]; updated.
            f: forces [N], shape [vertex]; accumulated.
        """
        fetch_pairs(pairs, first + wp.tid() + FETCHED_AHEAD)
        two = pairs[first + wp.tid()]
        p = two.vertices_p
        q = two.vertices_q
        xi = vectors(x[p[0]], x[p[0]], x[q[0]], x[q[0]])
        xj = vectors(x[p[1]], x[p[1]], x[q[1]], x[q[1]])
        edges = difference(xj, xi)
        tips = difference(vectors(x[p[2]], x[p[3]], x[q[2]], x[q[3]]), xi)
        k1 = combination(two.warp_at_j, edges, two.warp_at_tip, tips)
        k2 = combination(two.weft_at_j, edges, two.weft_at_tip, tips)

        square1 = dots(k1, k1)
        square2 = dots(k2, k2)
        dot12 = dots(k1, k2)
        length1 = roots(square1)
        length2 = roots(square2)
        both = wp.cw_mul(length1, length2)
        cross = roots(larger(wp.cw_mul(square1, square2) - wp.cw_mul(dot12, dot12), wp.vec4d()))
        inverse1 = inverses(length1)
        inverse2 = inverses(length2)
        inverse_cross = inverses(larger(cross, COLLAPSE_SINE * both))

        # each pair's mean stretch, its tensions, and what the stabiliser adds
        share = wp.cw_div(two.areas, pair_sums(two.areas))
        mean1 = pair_sums(wp.cw_mul(share, length1))
        mean2 = pair_sums(wp.cw_mul(share, length2))
        one = wp.float64(1.0)
        strain_p = wp.vec2d(mean1[0] - one, mean2[0] - one)
        strain_q = wp.vec2d(mean1[2] - one, mean2[2] - one)
        line_p = tension(tension_law, strain_p)
        line_q = tension(tension_law, strain_q)
        none = wp.float64(0.0)
        if viscosity[0] + viscosity[1] + rates.taken_up > none:
            known = memory[first + wp.tid()]
            now = wp.vec4d(strain_p[0], strain_p[1], strain_q[0], strain_q[1])
            change = now - known.strain
            if rates.taken_up > none:
                area = pair_sums(two.areas)
                at = 2 * (first + wp.tid())
                kept_p = recover(
                    rates,
                    recovered[at],
                    line_p,
                    strain_p,
                    wp.vec2d(known.change[0], known.change[1]),
                    wp.vec2d(change[0], change[1]),
                    area[0],
                )
                kept_q = recover(
                    rates,
                    recovered[at + 1],
                    line_q,
                    strain_q,
                    wp.vec2d(known.change[2], known.change[3]),
                    wp.vec2d(change[2], change[3]),
                    area[2],
                )
                line_p += beside_softened(rates, kept_p, strain_p)
                line_q += beside_softened(rates, kept_q, strain_q)
                recovered[at] = kept_p
                recovered[at + 1] = kept_q
            line_p += wp.cw_mul(viscosity, wp.vec2d(change[0], change[1]))
            line_q += wp.cw_mul(viscosity, wp.vec2d(change[2], change[3]))
            memory[first + wp.tid()] = after_step(known, now, change, viscosity, two.areas)
        line1 = of_pairs(line_p[0], line_q[0]) + wp.cw_mul(two.stabiliser, length1 - mean1)
        line2 = of_pairs(line_p[1], line_q[1]) + wp.cw_mul(two.stabiliser, length2 - mean2)

        # γ = θ0 − π/2 + arcsin(cos θ)
        inverse12 = wp.cw_mul(inverse1, inverse2)
        angles = angles_within_quarter_turn(
            wp.cw_mul(dot12, inverse12), wp.cw_mul(cross, inverse12)
        )
        skew = wp.vec4d(rest_angle - QUARTER_TURN)
        turning = wp.cw_mul(two.areas, wp.cw_mul(couples(shear_law, angles + skew), inverse_cross))

        # ∂W/∂k1 = along1 k1 + turning k2, and likewise ∂W/∂k2
        back = wp.cw_mul(turning, dot12)
        along1 = wp.cw_mul(inverse1, wp.cw_mul(two.areas, line1) - wp.cw_mul(back, inverse1))
        along2 = wp.cw_mul(inverse2, wp.cw_mul(two.areas, line2) - wp.cw_mul(back, inverse2))
        load1 = combination(along1, k1, turning, k2)
        load2 = combination(turning, k1, along2, k2)
        at_j = combination(two.warp_at_j, load1, two.weft_at_j, load2)
        at_tip = combination(two.warp_at_tip, load1, two.weft_at_tip, load2)
        subtract_pair(0, at_j, at_tip, p, f)
        subtract_pair(2, at_j, at_tip, q, f)

    return add_pair_forces
