"""How deep places of the plies lie in tools, as contact sees these.

The distance from a tool changes by no more than a place moves. So a place that was far from being
the deepest is not asked again before it has moved, in the tool's frame, as far as it takes.
"""

import warp as wp

from ..sweep import Sweep
from .surface import barycentric, is_on_edge, to_single, weighted
from .tool_facets import SINGLE, ToolSurfaces, nearest_facet
from .tool_planes import FREE, TURNING, ToolPlane, is_near, no_plane, plane_gap, tangent_plane

UNKNOWN = wp.constant(wp.float64(1e9))
"""More than any place is deep [m]."""


@wp.struct
class Look:
    """One tool as it is looked at."""

    tool: wp.int32
    turned: wp.mat33d  # its rotation
    shift: wp.vec3d  # its translation [m]
    radius: wp.float64  # how far to look [m]
    known: wp.float64  # depth of the deepest place between vertices so far [m]


@wp.struct
class PlaceSeen:
    """A place as it was when a tool was asked for it; single precision, a million may be kept."""

    at: wp.vec3f  # tool frame [m]
    most: wp.float32  # its depth there, at most [m]
    turns: wp.int32  # how often planes at its corners had turned over, plus one; 0 for not asked


@wp.struct
class PlaceDepth:
    """What a tool makes of a place."""

    depth: wp.float64  # 0 where it is not in it [m]
    most: wp.float64  # as in `PlaceSeen`


@wp.func
def in_frame(look: Look, x: wp.vec3d) -> wp.vec3d:
    """A point in the tool's frame [m]."""
    return wp.transpose(look.turned) * (x - look.shift)


@wp.func
def plane_near(
    surfaces: ToolSurfaces,
    look: Look,
    facet: int,
    at: wp.vec3d,
    half: wp.float64,
    beside: ToolPlane,
) -> ToolPlane:
    """Plane of a tool near a place in its frame, on the side on which a place beside it lies.

    ``facet`` is the nearest one, −1 if none is near.
    """
    plane = no_plane()
    if facet >= 0:
        zero = wp.float64(0.0)
        side = wp.where(is_near(beside), TURNING, FREE)
        plane, _distance, _side = tangent_plane(
            surfaces, look.tool, facet, at, half, look.radius, zero, side, beside
        )
    return plane


@wp.func
def from_facet(surfaces: ToolSurfaces, facet: int, at: wp.vec3d):
    """Distance of a place from its facet [m], and whether it lies beyond the rim of an open tool.

    A ply that bends over a rim lies beside the tool there, and behind its face, but not in it.
    """
    a = surfaces.corners[facet, 0]
    b = surfaces.corners[facet, 1]
    c = surfaces.corners[facet, 2]
    w = barycentric(a, b, c, at)
    distance = wp.length(at - weighted(w, a, b, c))
    return distance, is_on_edge(w, surfaces.borders[facet])


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


@wp.func
def depth_of_place(
    surfaces: ToolSurfaces,
    look: Look,
    at: wp.vec3d,
    offset: wp.float64,
    corner: wp.vec3i,
    weights: wp.vec3d,
    planes: wp.array(dtype=ToolPlane),
    x: wp.array(dtype=wp.vec3d),
) -> PlaceDepth:
    """How deep a place lies in a tool, seen from each corner of its triangle that is near.

    In front of the tool the most is what its height says, as it must go through the surface to be
    behind it; beside a rim, or behind already, it is the distance.
    """
    zero = wp.float64(0.0)
    found = PlaceDepth()
    facet = nearest_facet(surfaces, look.tool, at, look.radius, look.radius)
    if facet < 0:
        found.most = UNKNOWN
        return found
    distance, beyond = from_facet(surfaces, facet, at)
    sag = surfaces.sag[look.tool]
    farthest = offset + distance
    found.most = offset - distance
    for c in range(3):
        beside = planes[look.tool * x.shape[0] + corner[c]]
        if weights[c] > zero and is_near(beside):
            plane = plane_near(surfaces, look, facet, at, offset, beside)
            depth = zero
            most = farthest
            if is_near(plane):
                depth = -plane_gap(plane, at)
                if depth <= offset and not beyond:
                    most = depth
            if surfaces.open[look.tool] == 1 and depth > offset + sag:
                start = in_frame(look, x[corner[c]])
                depth = wp.where(passes(surfaces, look.tool, start, at), depth, zero)
            found.depth = wp.max(found.depth, depth)
            found.most = wp.max(found.most, most)
    if found.depth > zero and beyond:
        found.depth = wp.max(offset - distance, zero)
    found.most += sag + wp.float64(2.0) * SINGLE
    return found


@wp.kernel(enable_backward=False)
def find_vertex_planes(
    sweep: Sweep,
    surfaces: ToolSurfaces,
    look: Look,
    half: wp.array(dtype=wp.float64),
    x: wp.array(dtype=wp.vec3d),
    planes: wp.array(dtype=ToolPlane),
    turns: wp.array(dtype=wp.int32),
    depths: wp.array(dtype=wp.float64),
):
    """How far vertices reach into a tool, and its planes there; a sweep over vertices.

    Args:
        sweep: numbers of the vertices.
        surfaces: the tools' facets.
        look: the tool.
        half: half the thickness of the ply [m], shape [vertex].
        x: positions [m], shape [vertex].
        planes: shape [tool · vertex]; overwritten.
        turns: how often a plane has come, gone, or turned over, likewise; counted on.
        depths: of the ply's side below the tool's surface, 0 where it is not in it [m],
            shape [vertex]; overwritten.
    """
    zero = wp.float64(0.0)
    for i in range(sweep.first + wp.tid(), sweep.end, sweep.threads):
        at = in_frame(look, x[i])
        facet = nearest_facet(surfaces, look.tool, at, look.radius, look.radius)
        plane = plane_near(surfaces, look, facet, at, half[i], no_plane())
        if surfaces.open[look.tool] == 1 and is_near(plane) and plane_gap(plane, at) < -half[i]:
            # It is on the sheet's other side, no deeper than half in it.
            plane.normal = -plane.normal
            plane.level = wp.float64(2.0) * half[i] - plane.level
        slot = look.tool * x.shape[0] + i
        before = planes[slot]
        if is_near(plane) != is_near(before) or wp.dot(plane.normal, before.normal) < zero:
            turns[slot] += 1
        planes[slot] = plane
        depths[i] = zero
        if is_near(plane):
            depths[i] = wp.max(-plane_gap(plane, at), zero)


@wp.kernel(enable_backward=False)
def find_face_depths(
    sweep: Sweep,
    surfaces: ToolSurfaces,
    look: Look,
    half: wp.array(dtype=wp.float64),
    x: wp.array(dtype=wp.vec3d),
    planes: wp.array(dtype=ToolPlane),
    turns: wp.array(dtype=wp.int32),
    corners: wp.array(dtype=wp.vec3i),
    weights: wp.array(dtype=wp.vec3d),
    seen: wp.array(dtype=PlaceSeen),
    depths: wp.array(dtype=wp.float64),
):
    """How far places between vertices reach into a tool; a sweep over places.

    Args:
        sweep: numbers of the places.
        surfaces: the tools' facets.
        look: the tool.
        half: half the thickness of the ply [m], shape [vertex].
        x: positions [m], shape [vertex].
        planes: of the tool near the vertices, which say on which side of an open tool the place
            is, shape [tool · vertex].
        turns: how often these have turned over, likewise.
        corners: vertices of the triangle there, shape [place].
        weights: of these, shape [place].
        seen: places when they were asked for, shape [tool · place]; overwritten where asked anew.
        depths: of the ply's side below the tool's surface, 0 where it is not in it, where no corner
            is near, or where it cannot be the deepest so far [m], shape [place]; overwritten.
    """
    for k in range(sweep.first + wp.tid(), sweep.end, sweep.threads):
        depths[k] = wp.float64(0.0)
        corner = corners[k]
        first = look.tool * x.shape[0]
        near = False
        turned = wp.int32(1)
        for c in range(3):
            if weights[k][c] > wp.float64(0.0):
                near = near or is_near(planes[first + corner[c]])
                turned += turns[first + corner[c]]
        if near:
            place = weighted(weights[k], x[corner[0]], x[corner[1]], x[corner[2]])
            at = in_frame(look, place)
            slot = look.tool * corners.shape[0] + k
            before = seen[slot]
            most = wp.float64(before.most) + wp.float64(wp.length(to_single(at) - before.at))
            if before.turns != turned or most > look.known:
                found = depth_of_place(
                    surfaces, look, at, half[corner[0]], corner, weights[k], planes, x
                )
                depths[k] = found.depth
                before.at = to_single(at)
                before.most = float(found.most)
                before.turns = turned
                seen[slot] = before
