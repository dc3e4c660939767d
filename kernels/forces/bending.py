"""Bending whose energy is quadratic in positions: f = −K x, the same K for all three components.

Its rows come from `warpdrape.forces.curvature`; x are positions, not displacements, as curvatures
of the flat ply are zero.
"""

import warp as wp

from .lanes import WIDE


@wp.struct
class Rows:
    """A sparse matrix by rows."""

    first: wp.array(dtype=wp.int32)  # entry of each row, and last of all their number
    vertex: wp.array(dtype=wp.int32)  # of each entry
    value: wp.array(dtype=wp.float64)  # of each entry [N/m]


@wp.func_native(
    """
    const double* points = reinterpret_cast<const double*>(x.data);
    const int* vertex = rows.vertex.data;
    const double* value = rows.value.data;
    int k = rows.first.data[i];
    const int end = rows.first.data[i + 1];
#if !defined(__CUDACC__)
    // Four numbers at a time, of which the last is the next vertex's; the very last has no next.
    typedef double four __attribute__((vector_size(32), aligned(8)));
    four even = {0.0, 0.0, 0.0, 0.0}, odd = {0.0, 0.0, 0.0, 0.0};
    // Other forces have driven the matrix out of the near caches since the last step: fetched some
    // ten rows ahead, as many lines as 40 entries fill, it is there in time.
    for (int a = 0; a < 5; ++a) __builtin_prefetch(value + k + 400 + 8 * a);
    for (int a = 0; a < 3; ++a) __builtin_prefetch(vertex + k + 400 + 16 * a);
    const int safe = end > k && vertex[end - 1] == last ? end - 1 : end;
    for (; k + 1 < safe; k += 2) {
        even += value[k] * *reinterpret_cast<const four*>(points + 3 * vertex[k]);
        odd += value[k + 1] * *reinterpret_cast<const four*>(points + 3 * vertex[k + 1]);
    }
    even += odd;
    double sum[3] = {even[0], even[1], even[2]};
#else
    double sum[3] = {0.0, 0.0, 0.0};
#endif
    for (; k < end; ++k)
        for (int c = 0; c < 3; ++c) sum[c] += value[k] * points[3 * vertex[k] + c];
    return wp::vec_t<3, wp::float64>(sum[0], sum[1], sum[2]);
"""
)
def row_product(i: int, last: int, rows: Rows, x: wp.array(dtype=wp.vec3d)) -> wp.vec3d:
    """Σ_j K_ij x_j; the entries of a row are sorted by vertex, ``last`` is the last vertex."""
    ...


@wp.kernel(enable_backward=False, module_options=WIDE, module="unique")
def add_bending_forces(
    first: int,
    first_vertex: int,
    rows: Rows,
    x: wp.array(dtype=wp.vec3d),
    f: wp.array(dtype=wp.vec3d),
):
    """Add bending forces to ``f``; one thread a vertex.

    Args:
        first: number of the first vertex.
        first_vertex: number of the vertex of the first row.
        rows: K [N/m], vertices in the model's numbering.
        x: positions [m], shape [vertex].
        f: forces [N], shape [vertex]; accumulated.
    """
    i = first + wp.tid()
    f[i] -= row_product(i - first_vertex, x.shape[0] - 1, rows, x)


@wp.struct
class Slopes:
    """What slopes held by clamps do; a slope is the first two columns of a clamp's matrix.

    Each entry is there twice, by rows of vertices and by clamps.
    """

    first_of_vertex: wp.array(dtype=wp.int32)  # entry of each row, and last of all their number
    clamp: wp.array(dtype=wp.int32)  # of each entry
    on_vertex: wp.array(dtype=wp.vec2d)  # for the two columns [N]
    first_of_clamp: wp.array(dtype=wp.int32)
    vertex: wp.array(dtype=wp.int32)  # of each entry
    on_clamp: wp.array(dtype=wp.vec2d)  # [N]
    between: wp.array2d(dtype=wp.float64)  # columns of all clamps [N·m], shape [2 clamp, 2 clamp]
    anchor: wp.array(dtype=wp.int32)  # a vertex that each clamp holds, −1 without any
    steps: wp.int32  # entries of a clamp in its table of matrices


@wp.func
def column(matrix: wp.mat33d, k: int) -> wp.vec3d:
    """Column k of a matrix."""
    return wp.vec3d(matrix[0, k], matrix[1, k], matrix[2, k])


@wp.kernel(enable_backward=False)
def add_slope_forces(
    first: int,
    first_vertex: int,
    slopes: Slopes,
    step: wp.array(dtype=wp.int32),
    clamp_matrix: wp.array(dtype=wp.mat33d),
    f: wp.array(dtype=wp.vec3d),
):
    """Add what the slopes that clamps hold exert; one thread a vertex.

    Args:
        first: number of the first vertex.
        first_vertex: number of the vertex of the first row.
        slopes: of the ply.
        step: number of the step since the tables of motion began, shape [1].
        clamp_matrix: before each step and after it, shape [clamp · step].
        f: forces [N], shape [vertex]; accumulated.
    """
    i = first + wp.tid()
    row = i - first_vertex
    force = wp.vec3d()
    for k in range(slopes.first_of_vertex[row], slopes.first_of_vertex[row + 1]):
        matrix = clamp_matrix[slopes.clamp[k] * slopes.steps + step[0]]
        share = slopes.on_vertex[k]
        force += share[0] * column(matrix, 0) + share[1] * column(matrix, 1)
    f[i] -= force


@wp.kernel(enable_backward=False)
def add_slope_work(
    slopes: Slopes,
    step: wp.array(dtype=wp.int32),
    clamp_matrix: wp.array(dtype=wp.mat33d),
    x: wp.array(dtype=wp.vec3d),
    turned: wp.array(dtype=wp.vec3d),
    clamp_work: wp.array(dtype=wp.float64),
):
    """Add the work of turning the slopes, half of the step before and of the coming one each.

    One thread a clamp.

    Args:
        slopes: of a ply.
        step: number of the step since the tables of motion began, shape [1].
        clamp_matrix: before each step and after it, shape [clamp · step].
        x: positions [m], shape [vertex].
        turned: by what the columns changed in the step before, shape [2 clamp]; overwritten.
        clamp_work: work done by the clamps [J], shape [vertex]; accumulated at their anchors.
    """
    c = wp.tid()
    if slopes.anchor[c] < 0:
        return
    moment_0 = wp.vec3d()
    moment_1 = wp.vec3d()
    for k in range(slopes.first_of_clamp[c], slopes.first_of_clamp[c + 1]):
        share = slopes.on_clamp[k]
        moment_0 += share[0] * x[slopes.vertex[k]]
        moment_1 += share[1] * x[slopes.vertex[k]]
    half = wp.float64(0.5)
    for other in range(slopes.anchor.shape[0]):
        matrix = clamp_matrix[other * slopes.steps + step[0]]
        for k in range(2):
            edge = column(matrix, k)
            moment_0 += slopes.between[2 * c, 2 * other + k] * edge
            moment_1 += slopes.between[2 * c + 1, 2 * other + k] * edge
    at = c * slopes.steps + step[0]
    coming = clamp_matrix[at + 1] - clamp_matrix[at]
    work = wp.dot(moment_0, column(coming, 0) + turned[2 * c])
    work += wp.dot(moment_1, column(coming, 1) + turned[2 * c + 1])
    clamp_work[slopes.anchor[c]] += half * work
    turned[2 * c] = column(coming, 0)
    turned[2 * c + 1] = column(coming, 1)
