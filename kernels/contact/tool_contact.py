"""Contact of the plies' vertices with rigid tools that translate and turn.

`find_tool_contacts` runs every few steps: where a vertex has moved, it asks Warp's mesh query for
the nearest facet and keeps the tangent plane of the smoothed surface there. `add_tool_forces` runs
every step on those planes. All that is kept here is in the tool's own frame. A slot is a vertex
of a tool, number tool · vertices + vertex: Warp's CPU code is fastest where all arrays of a kernel
have one dimension.
"""

import warp as wp

from ..sweep import Sweep
from .contact import CompactionLaws, ContactLaw, Pad, contact_traction
from .friction import Rub, at_vertex
from .surface import (
    CURVED,
    barycentric,
    bulge,
    curved_normal,
    is_on_border,
    to_single,
    weighted,
)
from .tool_pose import ToolPoses, velocity_from

SINGLE = wp.constant(wp.float64(1e-6))
"""Beyond the distance known to bound it, a query looks so much farther [m]: it rounds to single."""
ON_RIDGE = wp.constant(wp.float64(0.01))
"""Share of its distance by which a vertex may lie behind a facet whose ridge is nearest: rounding
to single leaves the choice between the two facets there to chance."""
ALIKE = wp.constant(wp.float64(1e-3))
"""… and at least, from a millimetre on: squares of distances are good to 10⁻⁷ of themselves."""
SAME_FACE = wp.constant(wp.float64(0.99))
"""Cosine between a vertex's plane and the surface below which, at a border, it is on the edge."""


@wp.struct
class ToolPlane:
    """Tangent plane of one tool near one vertex; its normal is zero where none is near."""

    normal: wp.vec3d  # outward, unit
    level: wp.float64  # of the plane along the normal, plus half the ply thickness [m]


@wp.struct
class ToolHold:
    """What the contact of a vertex with a tool remembers from step to step."""

    spring: wp.vec3d  # stick spring, tool frame [m]
    dashpot: wp.float64  # force [N]
    pressing: wp.float64  # normal force [N]
    stored: wp.float64  # energy of normal and stick spring [J]


@wp.struct
class ToolQuery:
    """The last query of one vertex for one tool."""

    at: wp.vec3d  # where it was, tool frame [m]
    distance: wp.float64  # from the facets [m]
    way: wp.float64  # that it may move before it is looked at again or, if free, comes near [m]
    facet: wp.int32  # the nearest one, −1 if none
    asked: wp.vec3d  # where the whole tool was asked for it, tool frame [m]


@wp.struct
class ToolSearch:
    """How far a search looks."""

    reach: wp.float64  # m beyond the offset within which a vertex counts as near
    radius: wp.float64  # m, of the mesh query
    keep: wp.float64  # m, way in the tool's frame for which a plane serves
    ahead: wp.float64  # s, for which a free vertex is followed at its present speed
    trust: wp.float64  # m, way for which the nearest facet may serve
    plain: wp.int32  # 1 to ask for every vertex at every search, as far as it looks


@wp.struct
class ToolSurfaces:
    """Facets of all tools, one after the other."""

    meshes: wp.array(dtype=wp.uint64)  # shape [tool]
    first_facet: wp.array(dtype=wp.int32)  # shape [tool]
    corners: wp.array2d(dtype=wp.vec3d)  # m, shape [facet, 3]
    normals: wp.array2d(dtype=wp.vec3d)  # at the corners, shape [facet, 3]
    open_edges: wp.array(dtype=wp.int32)  # bits of edges without a neighbour, shape [facet]
    ridges: wp.array(dtype=wp.int32)  # bits of edges that stick out sharply, shape [facet]
    sag: wp.array(dtype=wp.float64)  # by which facets may lie inside the surface [m], shape [tool]
    hollow: wp.array(dtype=wp.float64)  # weight over distance beyond `facet_hollows` [1/m], [facet]
    exact: wp.array(dtype=wp.int32)  # 1 if the corner normals are those of the true surface
    open: wp.array(dtype=wp.int32)  # 1 if the tool is a sheet, with a back, shape [tool]
    rubs: wp.array(dtype=Rub)  # friction, shape [tool]


@wp.func
def may_touch(bits: wp.int32, tool: int) -> bool:
    """Whether a vertex's bits allow that a tool is near; tools 32 apart share a bit."""
    return (bits >> (tool & 31)) & 1 == 1


@wp.func
def is_near(plane: ToolPlane) -> bool:
    """Whether it is the plane of a tool that is near."""
    return wp.length_sq(plane.normal) > wp.float64(0.0)


@wp.func
def plane_gap(plane: ToolPlane, at: wp.vec3d) -> wp.float64:
    """Gap [m] between a vertex's side of the ply and the plane."""
    return wp.dot(plane.normal, at) - plane.level


@wp.func
def no_plane() -> ToolPlane:
    """A plane that nothing touches."""
    plane = ToolPlane()
    plane.level = -wp.float64(1.0)
    return plane


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


@wp.func
def tangent_plane(
    surfaces: ToolSurfaces,
    tool: int,
    facet: int,
    at: wp.vec3d,
    offset: wp.float64,
    near: wp.float64,
    ahead: wp.float64,
    held: bool,
    before: ToolPlane,
):
    """Tangent plane of the smoothed surface near ``at``, and the distance from the facet [m].

    A surface with borders has a back: a vertex that comes from behind meets it there, half the ply
    thickness away. A border is a rounded edge: a flat end would push at once what comes from aside.

    Args:
        surfaces: the tools' facets.
        tool: number of the tool.
        facet: the nearest one, in ``surfaces``.
        at: position in the tool's frame [m].
        offset: half the ply thickness [m].
        near: distance within which a vertex counts as near [m].
        ahead: farther distance that it may go before the next search [m].
        held: whether the vertex had a plane before.
        before: that plane.
    """
    a = surfaces.corners[facet, 0]
    b = surfaces.corners[facet, 1]
    c = surfaces.corners[facet, 2]
    na = surfaces.normals[facet, 0]
    nb = surfaces.normals[facet, 1]
    nc = surfaces.normals[facet, 2]
    w = barycentric(a, b, c, at)
    flat = weighted(w, a, b, c)
    normal = wp.normalize(weighted(w, na, nb, nc))
    point = flat
    if surfaces.exact[tool] == 1:
        corners = wp.matrix_from_rows(a, b, c)
        at_corners = wp.matrix_from_rows(na, nb, nc)
        point = flat + CURVED * bulge(corners, at_corners, w)
        normal = curved_normal(corners, at_corners, w, CURVED)
    zero = wp.float64(0.0)
    distance = wp.length(at - flat)
    height = wp.dot(normal, at - point)
    gap = height - offset
    aside = wp.length_sq(at - point) - height * height
    border = is_on_border(w, surfaces.open_edges[facet])
    chance = wp.min(wp.max(SINGLE, ALIKE * distance), ON_RIDGE * distance)
    outside = height >= -chance and distance > zero
    if outside and is_on_border(w, surfaces.ridges[facet]):
        normal = (at - flat) / distance  # round a ridge, which both of its facets see alike
        height = distance
        gap = distance - offset
    past_border = border and aside > offset * offset
    plane = no_plane()
    if surfaces.open[tool] == 1:
        alike = wp.dot(before.normal, normal)  # 1 while the vertex stays on its face
        if held:
            back = alike < zero or (border and alike < SAME_FACE)
        else:
            back = height < -offset or (past_border and height < zero)
        if back:
            if border and distance > zero:
                normal = (at - flat) / distance
            else:
                normal = -normal
            if distance - surfaces.sag[tool] <= near + ahead:
                plane.normal = normal
                plane.level = wp.dot(normal, point) + offset
            return plane, distance
    if border and height > zero and aside > zero:  # round the border, from the front too
        normal = wp.normalize(at - point)
        gap = wp.length(at - point) - offset
        past_border = False
    inside = gap < wp.float64(0.0)
    behind = gap < -near and not held  # an open surface, not pressed into it
    if not past_border and not behind and (inside or distance - surfaces.sag[tool] <= near + ahead):
        plane.normal = normal
        plane.level = wp.dot(normal, point) + offset
    return plane, distance


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
                if search.plain == 1:
                    bound = search.radius
                facet = queries[slot].facet
                served = held and wp.length(at - queries[slot].asked) < search.trust
                if served and search.plain == 0 and is_still_nearest(surfaces, facet, at):
                    plane, distance = tangent_plane(
                        surfaces, tool, facet, at, offset[i], near, ahead, held, planes[slot]
                    )
                if not is_near(plane):
                    facet = nearest_facet(surfaces, tool, at, bound, search.radius)
                    queries[slot].facet = facet
                    queries[slot].asked = at
                    distance = search.radius
                    if facet >= 0:
                        plane, distance = tangent_plane(
                            surfaces, tool, facet, at, offset[i], near, ahead, held, planes[slot]
                        )
                queries[slot].at = at
                queries[slot].distance = distance
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


@wp.kernel(enable_backward=False)
def add_tool_forces(
    sweep: Sweep,
    law: ContactLaw,
    laws: CompactionLaws,
    pads: wp.array(dtype=Pad),
    rubs: wp.array(dtype=Rub),
    mass: wp.array(dtype=wp.float64),
    tools: ToolPoses,
    x: wp.array(dtype=wp.vec3d),
    v: wp.array(dtype=wp.vec3d),
    planes: wp.array(dtype=ToolPlane),
    touching: wp.array(dtype=wp.int32),
    holds: wp.array(dtype=ToolHold),
    f: wp.array(dtype=wp.vec3d),
    reaction: wp.array(dtype=wp.vec3d),
    moment: wp.array(dtype=wp.vec3d),
    lost: wp.array(dtype=wp.vec3d),
):
    """Add the tools' contact forces to ``f``; a sweep over vertices.

    Args:
        sweep: numbers of the vertices.
        law: contact law.
        laws: of compaction.
        pads: what gives way of a vertex's ply, shape [vertex].
        rubs: friction, shape [tool].
        mass: shape [vertex] [kg].
        tools: where they are, and their velocities over the last step.
        x: positions [m], shape [vertex].
        v: velocities half a step ago [m/s], shape [vertex].
        planes: tangent planes, shape [tool · vertex].
        touching: bits of the tools that are near, shape [vertex].
        holds: memory of the contacts, shape [tool · vertex]; updated.
        f: forces [N], shape [vertex]; accumulated.
        reaction: forces on the tools [N], shape [place · tool]; accumulated.
        moment: theirs about a point of the axis of tools that turn [N·m], likewise.
        lost: (friction, contact damping, mass damping) [J], shape [vertex]; accumulated.
    """
    for i in range(sweep.first + wp.tid(), sweep.end, sweep.threads):
        bits = touching[i]
        if bits == 0:
            continue
        count = rubs.shape[0]
        place = i % (reaction.shape[0] // count) * count
        for tool in range(count):
            if may_touch(bits, tool):
                slot = tool * x.shape[0] + i
                plane = planes[slot]
                offset = x[i] - tools.shift[tool]
                moving = v[i] - tools.velocity[tool]
                at = offset
                turning = tools.turning.turns[tool] == 1
                if turning:
                    back = wp.transpose(tools.turned[tool])
                    at = back * offset
                    arm = offset - tools.turned[tool] * tools.turning.point[tool]
                    moving = back * velocity_from(tools.spin[tool], arm, moving, law.time_step)
                gap = plane_gap(plane, at)
                if gap < wp.float64(0.0) or holds[slot].stored > wp.float64(0.0):
                    t = contact_traction(
                        law,
                        laws,
                        mass[i],
                        pads[i],
                        at_vertex(law.friction, rubs[tool], i),
                        gap,
                        plane.normal,
                        moving,
                        holds[slot].spring,
                        holds[slot].dashpot,
                    )
                    holds[slot].spring = t.spring
                    holds[slot].dashpot = t.dashpot
                    holds[slot].pressing = t.pressing
                    holds[slot].stored = t.stored
                    force = t.force
                    if turning:
                        force = tools.turned[tool] * force
                        arm = offset - tools.turned[tool] * tools.turning.point[tool]
                        wp.atomic_sub(moment, place + tool, wp.cross(arm, force))
                    f[i] += force
                    lost[i] += wp.vec3d(t.friction, t.damping, wp.float64(0.0))
                    wp.atomic_sub(reaction, place + tool, force)
