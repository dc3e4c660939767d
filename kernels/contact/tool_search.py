"""The search for the tools' tangent planes near the plies' vertices.

It runs every few steps: where a vertex has moved, it asks Warp's mesh query for the nearest facet
and keeps the tangent plane of the smoothed surface there, in the tool's own frame. A slot is a
vertex of a tool, number tool · vertices + vertex: Warp's CPU code is fastest where all arrays of a
kernel have one dimension.
"""

import warp as wp

from ..sweep import Sweep
from ..tool_pose import ToolPoses, velocity_from
from .surface import to_single
from .tool_contact import ToolHold, may_touch
from .tool_facets import ToolSurfaces, is_still_nearest, nearest_facet
from .tool_planes import FREE, ToolPlane, is_near, no_plane, plane_gap, tangent_plane


@wp.struct
class ToolQuery:
    """The last query of one vertex for one tool."""

    at: wp.vec3d  # where it was, tool frame [m]
    distance: wp.float64  # from the facets [m]
    way: wp.float64  # that it may move before it is looked at again or, if free, comes near [m]
    facet: wp.int32  # the nearest one, −1 if none
    side: wp.int32  # of the plane there: `FRONT`, `BACK`, `TURNING`
    asked: wp.vec3d  # where the whole tool was asked for it, tool frame [m]


@wp.struct
class ToolSearch:
    """How far a search looks."""

    reach: wp.float64  # m beyond the offset within which a vertex counts as near
    radius: wp.float64  # m, of the mesh query; farther for what is held deep in a tool
    keep: wp.float64  # m, way in the tool's frame for which a plane serves
    ahead: wp.float64  # s, for which a free vertex is followed at its present speed
    trust: wp.float64  # m, way for which the nearest facet may serve
    plain: wp.int32  # 1 to ask for every vertex at every search, as far as it looks


@wp.func
def outrun(
    mesh: wp.uint64, query: ToolQuery, at: wp.vec3d, seen: wp.float64, needed: wp.float64
) -> wp.float64:
    """Way of a free vertex since its last query over what was free then [-], if it passed the tool.

    Args:
        mesh: of the tool.
        query: the last one.
        at: where the vertex is now, tool frame [m].
        seen: how far off the tool it was then, at least [m].
        needed: distance from which on it would have been held [m].
    """
    way = at - query.at
    moved = wp.length(way)
    if seen <= needed or moved <= seen:
        return wp.float64(0.0)
    ray = wp.mesh_query_ray(mesh, to_single(query.at), to_single(way / moved), float(moved))
    return wp.where(ray.result, moved / seen, wp.float64(0.0))


@wp.kernel(enable_backward=False)
def find_tool_contacts(
    sweep: Sweep,
    surfaces: ToolSurfaces,
    search: ToolSearch,
    offset: wp.array(dtype=wp.float64),
    tools: ToolPoses,
    x: wp.array(dtype=wp.vec3d),
    v: wp.array(dtype=wp.vec3d),
    planes: wp.array(dtype=ToolPlane),
    queries: wp.array(dtype=ToolQuery),
    touching: wp.array(dtype=wp.int32),
    holds: wp.array(dtype=ToolHold),
    lost: wp.array(dtype=wp.vec3d),
    deepest: wp.array(dtype=wp.float64),
    fastest: wp.array(dtype=wp.float64),
):
    """Find the tangent planes near the vertices; a sweep over these.

    A vertex is asked anew once it has moved as far as its plane serves, or where, at its speed, it
    may come near a tool before the next search: a sheet that snaps is faster than its tools. No
    facet can be farther than the last one was, plus the way since: that bounds the query.
    Where the facet must still be the nearest, of those near it, its plane is renewed without a
    query.

    Args:
        sweep: numbers of the vertices.
        surfaces: the tools' facets.
        search: how far to look.
        offset: half the ply thickness [m], shape [vertex].
        tools: where they are, and their velocities over the last step.
        x: positions [m], shape [vertex].
        v: velocities [m/s], shape [vertex].
        planes: shape [tool · vertex]; overwritten where asked anew.
        queries: the last ones, shape [tool · vertex]; likewise.
        touching: bits of the tools that are near, shape [vertex]; overwritten.
        holds: shape [tool · vertex]; let go where the tool is near no more.
        lost: (friction, contact damping, mass damping) [J], shape [vertex]; accumulated.
        deepest: largest penetration seen so far [m], shape [tool]; raised.
        fastest: largest `outrun` of vertices [-], shape [tool]; raised.
    """
    for i in range(sweep.first + wp.tid(), sweep.end, sweep.threads):
        before = touching[i]
        near = offset[i] + search.reach
        now = wp.int32(0)
        for tool in range(tools.shift.shape[0]):
            slot = tool * x.shape[0] + i
            at = x[i] - tools.shift[tool]
            moving = v[i] - tools.velocity[tool]
            if tools.turning.turns[tool] == 1:
                turned = tools.turned[tool]
                arm = at - turned * tools.turning.point[tool]
                moving = velocity_from(tools.spin[tool], arm, moving, wp.float64(0.0))
                at = wp.transpose(turned) * at
            moved = wp.length(at - queries[slot].at)
            held = may_touch(before, tool) and is_near(planes[slot])
            ahead = search.ahead * wp.length(moving)
            used = moved
            if not held:
                used += ahead
                if moved > queries[slot].way:
                    seen = queries[slot].distance - surfaces.sag[tool]
                    over = outrun(surfaces.meshes[tool], queries[slot], at, seen, near)
                    wp.atomic_max(fastest, tool, over)
            if used >= queries[slot].way or search.plain == 1:
                plane = no_plane()
                distance = search.radius
                bound = queries[slot].distance + moved
                farthest = search.radius
                if held:
                    farthest = wp.max(farthest, bound + near)  # what lies deep is not let go
                if search.plain == 1:
                    bound = search.radius
                facet = queries[slot].facet
                side = wp.where(held, queries[slot].side, FREE)
                now_on = side
                served = held and wp.length(at - queries[slot].asked) < search.trust
                if served and search.plain == 0 and is_still_nearest(surfaces, facet, at):
                    plane, distance, now_on = tangent_plane(
                        surfaces, tool, facet, at, offset[i], near, ahead, side, planes[slot]
                    )
                if not is_near(plane):
                    facet = nearest_facet(surfaces, tool, at, bound, farthest)
                    queries[slot].facet = facet
                    queries[slot].asked = at
                    distance = search.radius
                    if facet >= 0:
                        plane, distance, now_on = tangent_plane(
                            surfaces, tool, facet, at, offset[i], near, ahead, side, planes[slot]
                        )
                queries[slot].at = at
                queries[slot].distance = distance
                queries[slot].side = now_on
                queries[slot].way = wp.max(distance - surfaces.sag[tool] - near, search.keep)
                planes[slot] = plane
                if held and not is_near(plane):  # slid past the tool's border
                    lost[i] += wp.vec3d(holds[slot].stored, wp.float64(0.0), wp.float64(0.0))
                    holds[slot] = ToolHold()
                if is_near(plane):
                    now |= wp.int32(1) << (tool & 31)
            elif held:
                now |= wp.int32(1) << (tool & 31)
            if may_touch(now, tool):
                gap = plane_gap(planes[slot], at)
                if gap < wp.float64(0.0):
                    wp.atomic_max(deepest, tool, -gap)
        touching[i] = now
