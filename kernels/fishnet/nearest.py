"""The facet nearest to a point, and the nearest point of it."""

import warp as wp

from ..contact.surface import barycentric, to_single, weighted


@wp.kernel(enable_backward=False)
def compute_nearest(
    mesh: wp.uint64,
    corners: wp.array2d(dtype=wp.vec3d),
    points: wp.array(dtype=wp.vec3d),
    farthest: float,
    facets: wp.array(dtype=wp.int32),
    nearest: wp.array(dtype=wp.vec3d),
):
    """Find the nearest place on a surface; one thread a point.

    Args:
        mesh: query mesh of the surface.
        corners: of its facets [m], shape [facet, 3].
        points: to look from [m], shape [point].
        farthest: how far to look [m].
        facets: the facet, −1 if there is none so near, shape [point]; overwritten.
        nearest: the place [m], shape [point]; overwritten.
    """
    i = wp.tid()
    query = wp.mesh_query_point_no_sign(mesh, to_single(points[i]), farthest)
    facets[i] = -1
    nearest[i] = points[i]
    if query.result:
        f = query.face
        w = barycentric(corners[f, 0], corners[f, 1], corners[f, 2], points[i])
        facets[i] = f
        nearest[i] = weighted(w, corners[f, 0], corners[f, 1], corners[f, 2])
