"""How far points are from the curved surface of a tool, or the triangles of a ply."""

import warp as wp

from ..contact.surface import CURVED, barycentric, bulge, to_single, weighted


@wp.func
def nearest_on_surface(corners: wp.mat33d, normals: wp.mat33d, at: wp.vec3d) -> wp.vec3d:
    """Point of the curved surface over a facet that is nearest to ``at``, to second order."""
    w = barycentric(corners[0], corners[1], corners[2], at)
    flat = weighted(w, corners[0], corners[1], corners[2])
    return flat + CURVED * bulge(corners, normals, w)


@wp.kernel(enable_backward=False)
def compute_surface_ways(
    mesh: wp.uint64,
    corners: wp.array2d(dtype=wp.vec3d),
    normals: wp.array2d(dtype=wp.vec3d),
    points: wp.array(dtype=wp.vec3d),
    farthest: float,
    ways: wp.array(dtype=wp.vec3d),
):
    """Way from a surface to each point; one thread a point.

    Args:
        mesh: query mesh of the surface.
        corners: of its facets [m], shape [facet, 3].
        normals: there, shape [facet, 3]; zero where the facets themselves are the surface.
        points: in the frame of the surface [m], shape [point].
        farthest: how far to look [m].
        ways: from the nearest point of the surface [m], shape [point]; overwritten.
    """
    i = wp.tid()
    at = points[i]
    query = wp.mesh_query_point_no_sign(mesh, to_single(at), farthest)
    if not query.result:
        far = wp.float64(farthest)
        ways[i] = wp.vec3d(wp.float64(0.0), wp.float64(0.0), far)
        return
    f = query.face
    of = wp.matrix_from_rows(corners[f, 0], corners[f, 1], corners[f, 2])
    across = wp.matrix_from_rows(normals[f, 0], normals[f, 1], normals[f, 2])
    ways[i] = at - nearest_on_surface(of, across, at)


@wp.kernel(enable_backward=False)
def compute_hits(
    mesh: wp.uint64,
    points: wp.array(dtype=wp.vec3d),
    directions: wp.array(dtype=wp.vec3d),
    farthest: float,
    hits: wp.array(dtype=wp.int32),
):
    """Whether a ray from each point meets a surface; one thread a point.

    Args:
        mesh: query mesh of the surface.
        points: in the frame of the surface [m], shape [point].
        directions: of the rays, unit, shape [point].
        farthest: how far to look [m].
        hits: 1 where it does, shape [point]; overwritten.
    """
    i = wp.tid()
    query = wp.mesh_query_ray(mesh, to_single(points[i]), to_single(directions[i]), farthest)
    hits[i] = 0
    if query.result:
        hits[i] = 1
