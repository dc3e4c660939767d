"""How hard contacts press crossings of yarns: what goes through the ply where each of them is.

A crossover bears what goes through at its vertex, and its share of what goes through vertices
without yarns, which it carries: as their force comes to it.
"""

import warp as wp


@wp.struct
class Bearers:
    """Which vertices' forces crossovers bear, row by row, per crossing of single yarns."""

    first: wp.array(dtype=wp.int32)  # entry of each crossover, and their number
    vertex: wp.array(dtype=wp.int32)  # in the model's numbering, shape [entry]
    weight: wp.array(dtype=wp.float64)  # [-], shape [entry]


@wp.kernel(enable_backward=False)
def compute_pressed(
    first: int,
    bearers: Bearers,
    through: wp.array(dtype=wp.float64),
    pressed: wp.array(dtype=wp.float64),
):
    """Compute the force of contacts on each crossing; one thread a crossover.

    Args:
        first: number of the first crossover.
        bearers: of a ply.
        through: force through the ply [N], shape [vertex].
        pressed: at one crossing of single yarns [N], shape [crossover]; overwritten.
    """
    v = first + wp.tid()
    total = wp.float64(0.0)
    for entry in range(bearers.first[v], bearers.first[v + 1]):
        total += bearers.weight[entry] * through[bearers.vertex[entry]]
    pressed[v] = wp.max(total, wp.float64(0.0))
