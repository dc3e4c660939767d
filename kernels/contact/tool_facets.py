"""Facets of all tools, and which of them is nearest to a point."""

import warp as wp

from .friction import Rub
from .surface import to_single

SINGLE = wp.constant(wp.float64(1e-6))
"""Beyond the distance known to bound it, a query looks so much farther [m]: it rounds to single."""


@wp.struct
class ToolSurfaces:
    """Facets of all tools, one after the other."""

    meshes: wp.array(dtype=wp.uint64)  # shape [tool]
    first_facet: wp.array(dtype=wp.int32)  # shape [tool]
    corners: wp.array2d(dtype=wp.vec3d)  # m, shape [facet, 3]
    normals: wp.array2d(dtype=wp.vec3d)  # at the corners, shape [facet, 3]
    borders: wp.array(dtype=wp.int32)  # bits of edges without a neighbour, and ends, shape [facet]
    ridges: wp.array(dtype=wp.int32)  # bits of edges at which facets meet, and ends, shape [facet]
    sag: wp.array(dtype=wp.float64)  # by which facets may lie inside the surface [m], shape [tool]
    hollow: wp.array(dtype=wp.float64)  # weight over distance beyond `facet_hollows` [1/m], [facet]
    exact: wp.array(dtype=wp.int32)  # 1 if the corner normals are those of the true surface
    open: wp.array(dtype=wp.int32)  # 1 if the tool is a sheet, with a back, shape [tool]
    rubs: wp.array(dtype=Rub)  # friction, shape [tool]


@wp.func
def nearest_facet(
    surfaces: ToolSurfaces, tool: int, at: wp.vec3d, bound: wp.float64, radius: wp.float64
) -> int:
    """Facet of a tool that is nearest to a point in its frame; −1 if none within ``radius`` [m].

    Known not to be farther than ``bound`` [m], it is found faster.
    """
    mesh = surfaces.meshes[tool]
    point = to_single(at)
    query = wp.mesh_query_point_no_sign(mesh, point, float(wp.min(bound + SINGLE, radius)))
    if query.result:
        return surfaces.first_facet[tool] + query.face
    if bound + SINGLE < radius:  # rounding hid it
        query = wp.mesh_query_point_no_sign(mesh, point, float(radius))
        if query.result:
            return surfaces.first_facet[tool] + query.face
    return -1


@wp.func
def is_still_nearest(surfaces: ToolSurfaces, facet: int, at: wp.vec3d) -> bool:
    """Whether a facet that was nearest must be so still, of those near it.

    So it is if the point lies over its inside, and by more from its edges than d tan φ, where those
    beside it rise by φ at most and d is the distance.
    """
    if facet < 0:
        return False
    a = surfaces.corners[facet, 0]
    ab = surfaces.corners[facet, 1] - a
    ac = surfaces.corners[facet, 2] - a
    r = at - a
    n = wp.cross(ab, ac)
    area_sq = wp.length_sq(n)  # twice the area, squared
    of_b = wp.dot(wp.cross(r, ac), n)
    of_c = wp.dot(wp.cross(ab, r), n)
    height = wp.dot(r, n)  # times twice the area, as the weights are times its square
    least = wp.min(area_sq - of_b - of_c, wp.min(of_b, of_c))
    zero = wp.float64(0.0)
    return height > zero and least > surfaces.hollow[facet] * height * wp.sqrt(area_sq)
