"""Contact of the plies' vertices with rigid tools that translate.

`find_tool_contacts` runs every few steps: it asks Warp's mesh query for the nearest facet and keeps
the tangent plane of the smoothed surface there. `add_tool_forces` runs every step on that plane.
All positions kept here are in the tool's own frame.
"""

import warp as wp

from .contact import ContactLaw, contact_traction
from .surface import (
    CURVED,
    barycentric,
    bulge,
    curved_normal,
    is_on_border,
    to_single,
    weighted,
)


@wp.struct
class ToolContact:
    """Tangent plane of one tool near one vertex."""

    point: wp.vec3d  # m, tool frame
    normal: wp.vec3d  # outward
    near: wp.int32  # 1 if the vertex may touch before the next search


@wp.struct
class ToolSearch:
    """How far a search looks."""

    reach: wp.float64  # m beyond the offset within which a vertex counts as near
    radius: wp.float64  # m, of the mesh query


@wp.struct
class ToolSurfaces:
    """Facets of all tools, one after the other."""

    meshes: wp.array(dtype=wp.uint64)  # shape [tool]
    first_facet: wp.array(dtype=wp.int32)  # shape [tool]
    corners: wp.array2d(dtype=wp.vec3d)  # m, shape [facet, 3]
    normals: wp.array2d(dtype=wp.vec3d)  # at the corners, shape [facet, 3]
    open_edges: wp.array(dtype=wp.int32)  # bits of edges without a neighbour, shape [facet]
    sag: wp.array(dtype=wp.float64)  # by which facets may lie inside the surface [m], shape [tool]
    exact: wp.array(dtype=wp.int32)  # 1 if the corner normals are those of the true surface
    friction: wp.array(dtype=wp.float64)  # μ, shape [tool]


@wp.kernel(enable_backward=False)
def find_tool_contacts(
    surfaces: ToolSurfaces,
    search: ToolSearch,
    offset: wp.array(dtype=wp.float64),
    tool_shift: wp.array(dtype=wp.vec3d),
    x: wp.array(dtype=wp.vec3d),
    contacts: wp.array2d(dtype=ToolContact),
    asked_at: wp.array2d(dtype=wp.vec3d),
    clearance: wp.array2d(dtype=wp.float64),
    deepest: wp.array(dtype=wp.float64),
):
    """Find the tangent planes near the vertices; one thread a (tool, vertex).

    Args:
        surfaces: the tools' facets.
        search: how far to look.
        offset: half the ply thickness [m], shape [vertex].
        tool_shift: the tools' translations [m], shape [tool].
        x: positions [m], shape [vertex].
        contacts: shape [tool, vertex]; overwritten where asked anew.
        asked_at: position at the last query, tool frame [m], shape [tool, vertex]; updated.
        clearance: distance known free at that query [m], shape [tool, vertex]; updated.
        deepest: largest penetration seen so far [m], shape [tool]; raised.
    """
    tool, i = wp.tid()
    at = x[i] - tool_shift[tool]
    near = offset[i] + search.reach
    if clearance[tool, i] - wp.length(at - asked_at[tool, i]) > near:
        return
    asked_at[tool, i] = at
    query = wp.mesh_query_point_no_sign(surfaces.meshes[tool], to_single(at), float(search.radius))
    if not query.result:
        clearance[tool, i] = search.radius - surfaces.sag[tool]
        contacts[tool, i].near = 0
        return
    facet = surfaces.first_facet[tool] + query.face
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
    clearance[tool, i] = wp.length(at - flat) - surfaces.sag[tool]
    gap = wp.dot(normal, at - point) - offset[i]
    touched = contacts[tool, i].near == 1
    past_border = is_on_border(w, surfaces.open_edges[facet]) and (
        wp.length_sq(at - point) - (gap + offset[i]) * (gap + offset[i]) > offset[i] * offset[i]
    )
    inside = gap < wp.float64(0.0)
    contacts[tool, i].near = 0
    if past_border or (not inside and clearance[tool, i] > near):
        return
    if gap < -near and not touched:  # behind an open surface, not pressed into it
        return
    contacts[tool, i].near = 1
    contacts[tool, i].point = point
    contacts[tool, i].normal = normal
    if gap < wp.float64(0.0):
        wp.atomic_max(deepest, tool, -gap)


@wp.kernel(enable_backward=False)
def add_tool_forces(
    law: ContactLaw,
    friction: wp.array(dtype=wp.float64),
    offset: wp.array(dtype=wp.float64),
    mass: wp.array(dtype=wp.float64),
    tool_shift: wp.array(dtype=wp.vec3d),
    tool_velocity: wp.array(dtype=wp.vec3d),
    x: wp.array(dtype=wp.vec3d),
    v: wp.array(dtype=wp.vec3d),
    contacts: wp.array2d(dtype=ToolContact),
    springs: wp.array2d(dtype=wp.vec3d),
    dashpots: wp.array2d(dtype=wp.float64),
    f: wp.array(dtype=wp.vec3d),
    reaction: wp.array(dtype=wp.vec3d),
    lost: wp.array(dtype=wp.vec3d),
    stored: wp.array2d(dtype=wp.float64),
):
    """Add the tools' contact forces to ``f``; one thread a vertex.

    Args:
        law: contact law.
        friction: μ, shape [tool].
        offset: half the ply thickness [m], shape [vertex].
        mass: shape [vertex] [kg].
        tool_shift: translations [m], shape [tool].
        tool_velocity: over the last step [m/s], shape [tool].
        x: positions [m], shape [vertex].
        v: velocities half a step ago [m/s], shape [vertex].
        contacts: tangent planes, shape [tool, vertex].
        springs: stick springs [m], shape [tool, vertex]; updated.
        dashpots: dashpot forces [N], shape [tool, vertex]; overwritten.
        f: forces [N], shape [vertex]; accumulated.
        reaction: forces on the tools [N], shape [tool]; accumulated.
        lost: (friction, contact damping, mass damping) [J], shape [vertex]; accumulated.
        stored: energy of the contact springs [J], shape [tool, vertex]; overwritten.
    """
    i = wp.tid()
    for tool in range(friction.shape[0]):
        if contacts[tool, i].near == 0:
            if stored[tool, i] > wp.float64(0.0):  # slid past the tool's border
                lost[i] += wp.vec3d(stored[tool, i], wp.float64(0.0), wp.float64(0.0))
                stored[tool, i] = wp.float64(0.0)
                springs[tool, i] = wp.vec3d()
                dashpots[tool, i] = wp.float64(0.0)
        else:
            normal = contacts[tool, i].normal
            gap = wp.dot(normal, x[i] - tool_shift[tool] - contacts[tool, i].point) - offset[i]
            old = springs[tool, i]
            if gap < wp.float64(0.0) or stored[tool, i] > wp.float64(0.0):
                t = contact_traction(
                    law,
                    mass[i],
                    friction[tool],
                    gap,
                    normal,
                    v[i] - tool_velocity[tool],
                    old,
                    dashpots[tool, i],
                )
                springs[tool, i] = t.spring
                dashpots[tool, i] = t.dashpot
                stored[tool, i] = t.stored
                f[i] += t.force
                wp.atomic_sub(reaction, tool, t.force)
                lost[i] += wp.vec3d(t.friction, t.damping, wp.float64(0.0))
