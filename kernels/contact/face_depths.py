"""How deep places of the plies lie in tools, as contact sees these."""

import warp as wp

from ..sweep import Sweep
from .surface import barycentric, is_on_border, to_single, weighted
from .tool_facets import ToolSurfaces, nearest_facet
from .tool_planes import ToolPlane, is_near, no_plane, plane_gap, tangent_plane


@wp.func
def plane_near(
    surfaces: ToolSurfaces,
    tool: int,
    facet: int,
    at: wp.vec3d,
    half: wp.float64,
    radius: wp.float64,
    beside: ToolPlane,
) -> ToolPlane:
    """Plane of a tool near a place in its frame, on the side on which a place beside it lies.

    ``facet`` is the nearest one, −1 if none is near.
    """
    plane = no_plane()
    if facet >= 0:
        zero = wp.float64(0.0)
        held = is_near(beside)
        plane, _distance = tangent_plane(
            surfaces, tool, facet, at, half, radius, zero, held, beside
        )
    return plane


@wp.func
def beyond_rim(surfaces: ToolSurfaces, facet: int, at: wp.vec3d) -> wp.float64:
    """Distance [m] of a place from the rim of an open tool, beyond which it lies; −1 elsewhere.

    A ply that bends over a rim lies beside the tool there, and behind its face, but not in it.
    """
    a = surfaces.corners[facet, 0]
    b = surfaces.corners[facet, 1]
    c = surfaces.corners[facet, 2]
    w = barycentric(a, b, c, at)
    if is_on_border(w, surfaces.open_edges[facet]):
        return wp.length(at - weighted(w, a, b, c))
    return -wp.float64(1.0)


@wp.func
def passes(surfaces: ToolSurfaces, tool: int, start: wp.vec3d, end: wp.vec3d) -> bool:
    """Whether the straight way between two places of a triangle leads through a tool.

    If not, a ply that is on both sides of an open tool goes round its rim.
    """
    way = end - start
    length = wp.length(way)
    ray = wp.mesh_query_ray(
        surfaces.meshes[tool], to_single(start), to_single(way / length), float(length)
    )
    return ray.result


@wp.kernel(enable_backward=False)
def find_vertex_planes(
    sweep: Sweep,
    surfaces: ToolSurfaces,
    tool: int,
    turned: wp.mat33d,
    shift: wp.vec3d,
    half: wp.array(dtype=wp.float64),
    radius: wp.float64,
    x: wp.array(dtype=wp.vec3d),
    planes: wp.array(dtype=ToolPlane),
    depths: wp.array(dtype=wp.float64),
):
    """How far vertices reach into a tool, and its planes there; a sweep over vertices.

    Args:
        sweep: numbers of the vertices.
        surfaces: the tools' facets.
        tool: number of the tool.
        turned: its rotation.
        shift: its translation [m].
        half: half the thickness of the ply [m], shape [vertex].
        radius: how far to look [m].
        x: positions [m], shape [vertex].
        planes: shape [vertex]; overwritten.
        depths: of the ply's side below the tool's surface, 0 where it is not in it [m],
            shape [vertex]; overwritten.
    """
    for i in range(sweep.first + wp.tid(), sweep.end, sweep.threads):
        at = wp.transpose(turned) * (x[i] - shift)
        facet = nearest_facet(surfaces, tool, at, radius, radius)
        plane = plane_near(surfaces, tool, facet, at, half[i], radius, no_plane())
        if surfaces.open[tool] == 1 and is_near(plane) and plane_gap(plane, at) < -half[i]:
            # It is on the sheet's other side, no deeper than half in it.
            plane.normal = -plane.normal
            plane.level = wp.float64(2.0) * half[i] - plane.level
        planes[i] = plane
        depths[i] = wp.float64(0.0)
        if is_near(plane):
            depths[i] = wp.max(-plane_gap(plane, at), wp.float64(0.0))


@wp.kernel(enable_backward=False)
def find_face_depths(
    sweep: Sweep,
    surfaces: ToolSurfaces,
    tool: int,
    turned: wp.mat33d,
    shift: wp.vec3d,
    half: wp.array(dtype=wp.float64),
    radius: wp.float64,
    x: wp.array(dtype=wp.vec3d),
    planes: wp.array(dtype=ToolPlane),
    corners: wp.array(dtype=wp.vec3i),
    weights: wp.array(dtype=wp.vec3d),
    depths: wp.array(dtype=wp.float64),
):
    """How far places between vertices reach into a tool; a sweep over places.

    Args:
        sweep: numbers of the places.
        surfaces: the tools' facets.
        tool: number of the tool.
        turned: its rotation.
        shift: its translation [m].
        half: half the thickness of the ply [m], shape [vertex].
        radius: how far to look [m].
        x: positions [m], shape [vertex].
        planes: of the tool near the vertices, which say on which side of an open tool the place
            is, shape [vertex].
        corners: vertices of the triangle there, shape [place].
        weights: of these, shape [place].
        depths: of the ply's side below the tool's surface, 0 where it is not in it, or where no
            corner is near [m], shape [place]; overwritten.
    """
    zero = wp.float64(0.0)
    for k in range(sweep.first + wp.tid(), sweep.end, sweep.threads):
        corner = corners[k]
        w = weights[k]
        offset = half[corner[0]]
        place = weighted(w, x[corner[0]], x[corner[1]], x[corner[2]])
        at = wp.transpose(turned) * (place - shift)
        asked = False
        facet = int(-1)
        deepest = wp.float64(0.0)
        for c in range(3):
            if w[c] > zero and is_near(planes[corner[c]]):
                if not asked:
                    facet = nearest_facet(surfaces, tool, at, radius, radius)
                    asked = True
                plane = plane_near(surfaces, tool, facet, at, offset, radius, planes[corner[c]])
                depth = wp.float64(0.0)
                if is_near(plane):
                    depth = -plane_gap(plane, at)
                if surfaces.open[tool] == 1 and depth > offset + surfaces.sag[tool]:
                    start = wp.transpose(turned) * (x[corner[c]] - shift)
                    depth = wp.where(passes(surfaces, tool, start, at), depth, zero)
                deepest = wp.max(deepest, depth)
        if deepest > zero:
            beyond = beyond_rim(surfaces, facet, at)
            if beyond >= zero:
                deepest = wp.max(offset - beyond, zero)
        depths[k] = deepest
