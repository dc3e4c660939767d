"""Ties: vertices without yarns are carried by crossovers, x_v = Σ w x; W = ½ k ‖x_v − Σ w x‖²."""

import warp as wp


@wp.struct
class Ties:
    """Rows of one ply, Σ_j c_j x_j = 0, the vertex's own c 1 and its carriers' −w."""

    first: wp.array(dtype=wp.int32)  # entry of each tie, and their number
    vertex: wp.array(dtype=wp.int32)  # in the model's numbering, shape [entry]
    weight: wp.array(dtype=wp.float64)  # c [-], shape [entry]
    stiffness: wp.array(dtype=wp.float64)  # k [N/m], shape [tie]


@wp.func
def tie_gap(ties: Ties, tie: int, x: wp.array(dtype=wp.vec3d)) -> wp.vec3d:
    """By how much the carriers miss the vertex [m]."""
    gap = wp.vec3d()
    for entry in range(ties.first[tie], ties.first[tie + 1]):
        gap += ties.weight[entry] * x[ties.vertex[entry]]
    return gap


@wp.func
def tie_energy(stiffness: wp.float64, gap: wp.vec3d) -> wp.float64:
    """Energy [J]."""
    return wp.float64(0.5) * stiffness * wp.dot(gap, gap)


@wp.kernel(enable_backward=False)
def add_tie_forces(
    first: int, ties: Ties, x: wp.array(dtype=wp.vec3d), f: wp.array(dtype=wp.vec3d)
):
    """Add the ties' forces −k c_j gap to ``f``; one thread a tie.

    Args:
        first: number of the first tie.
        ties: of a ply.
        x: positions [m], shape [vertex].
        f: forces [N], shape [vertex]; accumulated.
    """
    tie = first + wp.tid()
    pull = ties.stiffness[tie] * tie_gap(ties, tie, x)
    for entry in range(ties.first[tie], ties.first[tie + 1]):
        wp.atomic_sub(f, ties.vertex[entry], ties.weight[entry] * pull)


@wp.kernel(enable_backward=False)
def measure_ties(ties: Ties, x: wp.array(dtype=wp.vec3d), energy: wp.array(dtype=wp.float64)):
    """Compute the energy [J] of every tie, shape [tie]; one thread a tie."""
    tie = wp.tid()
    energy[tie] = tie_energy(ties.stiffness[tie], tie_gap(ties, tie, x))
