"""Heights of facets over points of a plane."""

import warp as wp

from ..contact.surface import to_single


@wp.kernel(enable_backward=False)
def compute_heights(
    mesh: wp.uint64,
    corners: wp.array2d(dtype=wp.vec3d),
    points: wp.array(dtype=wp.vec2d),
    far: wp.float64,
    sign: wp.float64,
    heights: wp.array(dtype=wp.float64),
):
    """Highest (sign 1) or lowest (−1) facet over each point; one thread a point.

    Args:
        mesh: query mesh of the facets.
        corners: of the facets [m], shape [facet, 3].
        points: x and y [m], shape [point].
        far: height beyond all facets [m].
        sign: 1 looks from above, −1 from below.
        heights: there [m], shape [point], ``far`` where there is none; overwritten.
    """
    i = wp.tid()
    zero = wp.float64(0.0)
    at = wp.vec3d(points[i][0], points[i][1], sign * far)
    down = wp.vec3d(zero, zero, -sign)
    query = wp.mesh_query_ray(
        mesh, to_single(at), to_single(down), wp.float32(2.0 * wp.float32(far))
    )
    heights[i] = far
    if query.result:
        a = corners[query.face, 0]
        normal = wp.cross(corners[query.face, 1] - a, corners[query.face, 2] - a)
        heights[i] = a[2] - (normal[0] * (at[0] - a[0]) + normal[1] * (at[1] - a[1])) / normal[2]
