"""Contact between plies: each ply's vertices against the other's triangles, stacking order kept.

`find_ply_contacts` runs every few steps with Warp's mesh query; `add_ply_forces` runs every step on
the triangle, weights and normal it found. A contact is a vertex of one ply and a triangle of another;
`side` is +1 where the vertex's ply lies above the triangle's, so that it can never change sides.
"""

import warp as wp

from .contact import ContactLaw, contact_traction
from .tool_contact import barycentric, to_single


@wp.struct
class PlyContact:
    """Nearest triangle of another ply."""

    a: wp.int32  # vertices of the triangle
    b: wp.int32
    c: wp.int32
    near: wp.int32  # 1 if the vertex may touch before the next search
    weights: wp.vec3d  # of a, b, c at the nearest point
    normal: wp.vec3d  # towards the vertex's side


@wp.struct
class PlyFaces:
    """The ply whose triangles are searched."""

    mesh: wp.uint64
    first_triangle: wp.int32
    side: wp.float64  # +1: searched from above, −1: from below
    thickness: wp.float64  # m between the mid-surfaces in contact


@wp.kernel(enable_backward=False)
def copy_to_single(first: int, x: wp.array(dtype=wp.vec3d), points: wp.array(dtype=wp.vec3f)):
    """Copy a ply's positions into its query mesh; one thread a vertex of the ply."""
    i = wp.tid()
    points[i] = to_single(x[first + i])


@wp.kernel(enable_backward=False)
def add_vertex_normals(
    triangles: wp.array2d(dtype=wp.int32),
    x: wp.array(dtype=wp.vec3d),
    normals: wp.array(dtype=wp.vec3d),
):
    """Add area-weighted triangle normals to their vertices; one thread a triangle."""
    t = wp.tid()
    a = triangles[t, 0]
    b = triangles[t, 1]
    c = triangles[t, 2]
    n = wp.cross(x[b] - x[a], x[c] - x[a])
    wp.atomic_add(normals, a, n)
    wp.atomic_add(normals, b, n)
    wp.atomic_add(normals, c, n)


@wp.func
def leaves_the_edge(
    weights: wp.vec3d, open_edges: wp.int32, offset: wp.vec3d, normal: wp.vec3d
) -> bool:
    """Whether the nearest point lies on an open edge with the vertex beyond it.

    Bit e of ``open_edges`` is set if the edge opposite corner e borders the ply.
    """
    aside = wp.length_sq(offset - wp.dot(offset, normal) * normal)
    if aside <= wp.float64(1.0e-4) * wp.length_sq(offset):
        return False
    for corner in range(3):
        if weights[corner] <= wp.float64(0.0) and (open_edges >> corner) & 1 == 1:
            return True
    return False


@wp.kernel(enable_backward=False)
def find_ply_contacts(
    faces: PlyFaces,
    pair: int,
    first_vertex: int,
    first_slot: int,
    reach: wp.float64,
    radius: wp.float64,
    triangles: wp.array2d(dtype=wp.int32),
    open_edges: wp.array(dtype=wp.int32),
    x: wp.array(dtype=wp.vec3d),
    normals: wp.array(dtype=wp.vec3d),
    contacts: wp.array(dtype=PlyContact),
    deepest: wp.array(dtype=wp.float64),
):
    """Find the nearest triangle of another ply; one thread a vertex.

    Args:
        faces: the searched ply.
        pair: number of the pair of plies.
        first_vertex: of the searching ply.
        first_slot: where its contacts with the searched ply are kept.
        reach: distance beyond the thickness that counts as near [m].
        radius: of the mesh query [m].
        triangles: vertices, shape [triangle, 3].
        open_edges: bits of the edges that border the ply, shape [triangle].
        x: positions [m], shape [vertex].
        normals: vertex normals, any length, shape [vertex].
        contacts: shape [slot]; overwritten.
        deepest: largest penetration seen so far [m], shape [pair]; raised.
    """
    thread = wp.tid()
    i = first_vertex + thread
    slot = first_slot + thread
    query = wp.mesh_query_point_no_sign(faces.mesh, to_single(x[i]), float(radius))
    contacts[slot].near = 0
    if not query.result:
        return
    t = faces.first_triangle + query.face
    a = triangles[t, 0]
    b = triangles[t, 1]
    c = triangles[t, 2]
    w = barycentric(x[a], x[b], x[c], x[i])
    offset = x[i] - (w[0] * x[a] + w[1] * x[b] + w[2] * x[c])
    normal = faces.side * wp.normalize(
        w[0] * wp.normalize(normals[a])
        + w[1] * wp.normalize(normals[b])
        + w[2] * wp.normalize(normals[c])
    )
    gap = wp.dot(normal, offset) - faces.thickness
    if gap > reach or leaves_the_edge(w, open_edges[t], offset, normal):
        return
    contacts[slot].near = 1
    contacts[slot].a = a
    contacts[slot].b = b
    contacts[slot].c = c
    contacts[slot].weights = w
    contacts[slot].normal = normal
    if gap < wp.float64(0.0):
        wp.atomic_max(deepest, pair, -gap)


@wp.kernel(enable_backward=False)
def add_ply_forces(
    law: ContactLaw,
    friction: wp.float64,
    thickness: wp.float64,
    first_vertex: int,
    first_slot: int,
    mass: wp.array(dtype=wp.float64),
    x: wp.array(dtype=wp.vec3d),
    v: wp.array(dtype=wp.vec3d),
    contacts: wp.array(dtype=PlyContact),
    springs: wp.array(dtype=wp.vec3d),
    f: wp.array(dtype=wp.vec3d),
    lost: wp.array(dtype=wp.vec3d),
    stored: wp.array(dtype=wp.float64),
    slip: wp.array(dtype=wp.float64),
):
    """Add contact forces between two plies to ``f``; one thread a vertex of the searching ply.

    Args:
        law: contact law.
        friction: μ between the plies [-].
        thickness: distance of the mid-surfaces in contact [m].
        first_vertex: of the searching ply.
        first_slot: of its contacts with the other ply.
        mass: shape [vertex] [kg].
        x: positions [m], shape [vertex].
        v: velocities half a step ago [m/s], shape [vertex].
        contacts: shape [slot].
        springs: stick springs [m], shape [slot]; updated.
        f: forces [N], shape [vertex]; accumulated.
        lost: (friction, contact damping, mass damping) [J], shape [vertex]; accumulated.
        stored: energy of the contact springs [J], shape [slot]; overwritten.
        slip: distance slid so far [m], shape [slot]; accumulated.
    """
    thread = wp.tid()
    i = first_vertex + thread
    slot = first_slot + thread
    if contacts[slot].near == 0:
        if stored[slot] > wp.float64(0.0):  # slid over the other ply's edge
            lost[i] += wp.vec3d(stored[slot], wp.float64(0.0), wp.float64(0.0))
            stored[slot] = wp.float64(0.0)
            springs[slot] = wp.vec3d()
        return
    a = contacts[slot].a
    b = contacts[slot].b
    c = contacts[slot].c
    w = contacts[slot].weights
    normal = contacts[slot].normal
    gap = wp.dot(normal, x[i] - (w[0] * x[a] + w[1] * x[b] + w[2] * x[c])) - thickness
    old = springs[slot]
    if gap >= wp.float64(0.0) and stored[slot] == wp.float64(0.0):
        return
    velocity = v[i] - (w[0] * v[a] + w[1] * v[b] + w[2] * v[c])
    inverse = wp.float64(1.0) / mass[i] + (
        w[0] * w[0] / mass[a] + w[1] * w[1] / mass[b] + w[2] * w[2] / mass[c]
    )
    t = contact_traction(
        law, wp.float64(1.0) / inverse, friction, gap, normal, velocity, old
    )
    springs[slot] = t.spring
    stored[slot] = t.stored
    slip[slot] += t.slip
    lost[i] += wp.vec3d(t.friction, t.damping, wp.float64(0.0))
    wp.atomic_add(f, i, t.force)
    wp.atomic_sub(f, a, w[0] * t.force)
    wp.atomic_sub(f, b, w[1] * t.force)
    wp.atomic_sub(f, c, w[2] * t.force)
