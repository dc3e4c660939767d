"""What searches need of the plies as they are now: query points, normals, room in hollows."""

import warp as wp

from ..sweep import Sweep
from .facets import PlyFacets, ask_for_nearest
from .surface import edge_sag, to_single


@wp.kernel(enable_backward=False)
def copy_to_single(first: int, x: wp.array(dtype=wp.vec3d), points: wp.array(dtype=wp.vec3f)):
    """Copy a ply's positions into its query mesh; one thread a vertex of the ply."""
    i = wp.tid()
    points[i] = to_single(x[first + i])


@wp.kernel(enable_backward=False)
def compute_vertex_normals(
    sweep: Sweep,
    facets: PlyFacets,
    x: wp.array(dtype=wp.vec3d),
    normals: wp.array(dtype=wp.vec3d),
):
    """Compute unit vertex normals, weighted by area; a sweep over vertices.

    Args:
        sweep: numbers of the vertices.
        facets: of all plies.
        x: positions [m], shape [vertex].
        normals: shape [vertex]; overwritten.
    """
    for i in range(sweep.first + wp.tid(), sweep.end, sweep.threads):
        n = wp.vec3d()
        for k in range(facets.first_of_fan[i], facets.first_of_fan[i + 1]):
            at = facets.corners[facets.fans[k]]
            a = x[at[0]]
            n += wp.cross(x[at[1]] - a, x[at[2]] - a)
        normals[i] = wp.normalize(n)


@wp.kernel(enable_backward=False)
def compute_hollows(
    sweep: Sweep,
    facets: PlyFacets,
    x: wp.array(dtype=wp.vec3d),
    normals: wp.array(dtype=wp.vec3d),
    hollows: wp.array(dtype=wp.vec2d),
):
    """Compute the largest sags of the edges at vertices; a sweep over these.

    Args:
        sweep: numbers of the vertices.
        facets: of all plies.
        x: positions [m], shape [vertex].
        normals: unit vertex normals, shape [vertex].
        hollows: room above, where the ply is bent like a bowl, and below, where like a dome [m],
            shape [vertex]; overwritten.
    """
    for i in range(sweep.first + wp.tid(), sweep.end, sweep.threads):
        above = wp.float64(0.0)
        below = wp.float64(0.0)
        for k in range(facets.first_of_ring[i], facets.first_of_ring[i + 1]):
            j = facets.rings[k]
            dome = edge_sag(x[i], x[j], normals[i], normals[j])
            above = wp.max(above, -dome)
            below = wp.max(below, dome)
        hollows[i] = wp.vec2d(above, below)


@wp.kernel(enable_backward=False)
def find_places(
    first: int,
    facets: PlyFacets,
    mesh: wp.uint64,
    first_triangle: int,
    radius: wp.float64,
    x: wp.array(dtype=wp.vec3d),
    corners: wp.array(dtype=wp.vec3i),
    weights: wp.array(dtype=wp.vec3d),
):
    """Find the place of a ply nearest to each vertex of another; one thread a vertex, from first.

    Args:
        first: number of the first vertex.
        facets: of all plies.
        mesh: query mesh of the searched ply.
        first_triangle: of that ply.
        radius: how far it may be [m].
        x: positions [m], shape [vertex].
        corners: of the triangle there, shape [vertex]; overwritten where there is one.
        weights: of its corners, zero where there is none, shape [vertex]; overwritten.
    """
    i = first + wp.tid()
    place = ask_for_nearest(facets, mesh, first_triangle, radius, x, x[i])
    weights[i] = wp.vec3d()
    if place.facet >= 0:
        corners[i] = facets.corners[place.facet]
        weights[i] = place.weights
