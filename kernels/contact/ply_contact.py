"""Contact between plies: each ply's vertices against the other's triangles, stacking order kept.

`find_ply_contacts` runs every few steps and finds the nearest triangle; `add_ply_forces` runs every
step on the weights and normal it found there. A contact is a vertex of one ply and a triangle of
another; `side` is +1 where the vertex's ply lies above the triangle's, and never changes.
"""

import warp as wp

from .contact import ContactLaw, contact_traction
from .facets import PlyFacets, ask_for_nearest, is_at_border, no_facet, walk_to_nearest
from .on_ply import PlyContact, PlyMemory, PlySearch, contact_gap, settled, spring_energy, waits
from .surface import facet_slope, weighted


@wp.struct
class PlyFaces:
    """The ply whose triangles are searched."""

    mesh: wp.uint64
    first_triangle: wp.int32
    side: wp.float64  # +1: searched from above, −1: from below
    thickness: wp.float64  # m between the mid-surfaces in contact


@wp.func
def effective_mass(
    mass: wp.array(dtype=wp.float64), corners: wp.vec3i, w: wp.vec3d, i: int
) -> wp.float64:
    """Mass [kg] with which vertex i meets a triangle at the point of weights w."""
    inverse = w[0] * w[0] / mass[corners[0]] + w[1] * w[1] / mass[corners[1]]
    inverse += w[2] * w[2] / mass[corners[2]]
    return wp.float64(1.0) / (wp.float64(1.0) / mass[i] + inverse)


@wp.kernel(enable_backward=False)
def find_ply_contacts(
    law: ContactLaw,
    search: PlySearch,
    facets: PlyFacets,
    faces: PlyFaces,
    pair: int,
    first_vertex: int,
    first_slot: int,
    mass: wp.array(dtype=wp.float64),
    x: wp.array(dtype=wp.vec3d),
    normals: wp.array(dtype=wp.vec3d),
    hollows: wp.array(dtype=wp.vec2d),
    springs: wp.array(dtype=wp.vec3d),
    stored: wp.array(dtype=wp.float64),
    spent: wp.array(dtype=wp.float64),
    memory: wp.array(dtype=PlyMemory),
    contacts: wp.array(dtype=PlyContact),
    lost: wp.array(dtype=wp.vec3d),
    deepest: wp.array(dtype=wp.float64),
    largest_jump: wp.array(dtype=wp.float64),
):
    """Find the nearest triangle of another ply; one thread a vertex.

    The gap is the distance to the facet. On the hollow side of a bent ply there is room besides for
    the arcs that its chords cut off: else a vertex of the inner ply would lift the chords of the
    outer one. Beyond a border the surface goes on flat for a thickness, then as a ramp of 45° down
    past the mid-surface, so that a vertex that has slid off climbs back onto the right side.

    When the gap would jump to a deeper penetration (facets change, a vertex comes back over a
    border) the difference is allowed for (`settled`); where it jumps out, what the springs lose
    counts as contact damping. A vertex that is far is left out of walks until it can have come
    near, at the speed for which ``reach`` suffices from search to search.

    Args:
        law: contact law.
        search: how to look.
        facets: of all plies.
        faces: the searched ply.
        pair: number of the pair of plies.
        first_vertex: of the searching ply.
        first_slot: where its contacts with the searched ply are kept.
        mass: shape [vertex] [kg].
        x: positions [m], shape [vertex].
        normals: unit vertex normals, shape [vertex].
        hollows: room on the hollow sides, above and below [m], shape [vertex].
        springs: stick springs [m], shape [slot].
        stored: energy of the contact springs after the last step [J], shape [slot].
        spent: lost to friction and damping since the last search [J], shape [slot]; cleared.
        memory: of the searches, shape [slot]; updated.
        contacts: shape [slot]; overwritten.
        lost: (friction, contact damping, mass damping) [J], shape [vertex]; accumulated.
        deepest: largest penetration so far [m], what is allowed included, shape [pair]; raised.
        largest_jump: largest penetration allowed so far [m], shape [pair]; raised.
    """
    thread = wp.tid()
    i = first_vertex + thread
    slot = first_slot + thread
    if memory[slot].wait > 0 and search.asks == 0:
        memory[slot].wait -= 1
        return
    memory[slot].wait = 0
    before = wp.float64(0.0)
    had = wp.float64(0.0)
    if contacts[slot].near == 1:
        if stored[slot] > wp.float64(0.0):
            had = spring_energy(law, contacts[slot], faces.thickness, x, x[i], springs[slot])
        before = wp.min(contact_gap(contacts[slot], faces.thickness, x, x[i]), before)
    contacts[slot].near = 0
    budget = wp.max(spent[slot], wp.float64(0.0))
    spent[slot] = wp.float64(0.0)
    nearest = no_facet()
    if search.asks == 1:
        first = faces.first_triangle
        nearest = ask_for_nearest(facets, faces.mesh, first, search.radius, x, x[i])
    elif memory[slot].seen > 0:
        nearest = walk_to_nearest(facets, memory[slot].seen - 1, x, hollows, x[i])
    memory[slot].seen = nearest.facet + 1
    if nearest.facet < 0:
        return
    corners = facets.corners[nearest.facet]
    a = corners[0]
    b = corners[1]
    c = corners[2]
    w = nearest.weights
    offset = nearest.offset
    outward = faces.side * wp.normalize(weighted(w, normals[a], normals[b], normals[c]))
    height = wp.dot(offset, outward)
    aside = offset - height * outward
    beyond = wp.length(aside)
    face = wp.where(faces.side > wp.float64(0.0), 0, 1)
    room = wp.vec3d(hollows[a][face], hollows[b][face], hollows[c][face])
    over = faces.thickness - wp.dot(w, room)
    normal = outward
    gap = height - over
    if is_at_border(facets, nearest) and beyond > wp.float64(0.0):
        if height < -wp.float64(0.5) * faces.thickness:
            return
        if beyond > faces.thickness:
            normal = wp.normalize(outward + aside / beyond)
            gap = (height + beyond - over - faces.thickness) * wp.dot(normal, outward)
    else:
        distance = wp.where(height < wp.float64(0.0), -wp.length(offset), wp.length(offset))
        straight = outward
        if wp.abs(distance) > wp.float64(1.0e-3) * faces.thickness:
            straight = offset / distance
        normal = wp.normalize(straight + facet_slope(x[a], x[b], x[c], w, room))
        gap = distance - over
    rise = wp.dot(normal, offset) - gap - faces.thickness
    if gap > search.reach:
        memory[slot].wait = waits(gap, search.reach)
        return
    contacts[slot].near = 1
    contacts[slot].a = a
    contacts[slot].b = b
    contacts[slot].c = c
    contacts[slot].weights = w
    contacts[slot].normal = normal
    contacts[slot].rise = rise
    contacts[slot].mass = effective_mass(mass, corners, w, i)
    jump = wp.max(before - gap, wp.float64(0.0))
    allowance, taken = settled(
        law, search, contacts[slot], faces.thickness, x, x[i], springs[slot], jump, had, budget
    )
    contacts[slot].allowance = allowance
    lost[i] += wp.vec3d(wp.float64(0.0), taken, wp.float64(0.0))
    wp.atomic_max(deepest, pair, -gap)
    wp.atomic_max(largest_jump, pair, allowance)


@wp.kernel(enable_backward=False)
def add_ply_forces(
    law: ContactLaw,
    friction: wp.float64,
    thickness: wp.float64,
    first_vertex: int,
    first_slot: int,
    x: wp.array(dtype=wp.vec3d),
    v: wp.array(dtype=wp.vec3d),
    contacts: wp.array(dtype=PlyContact),
    springs: wp.array(dtype=wp.vec3d),
    dashpots: wp.array(dtype=wp.float64),
    f: wp.array(dtype=wp.vec3d),
    lost: wp.array(dtype=wp.vec3d),
    stored: wp.array(dtype=wp.float64),
    slip: wp.array(dtype=wp.float64),
    spent: wp.array(dtype=wp.float64),
):
    """Add contact forces between two plies to ``f``; one thread a vertex of the searching ply.

    Args:
        law: contact law.
        friction: μ between the plies [-].
        thickness: distance of the mid-surfaces in contact [m].
        first_vertex: of the searching ply.
        first_slot: of its contacts with the other ply.
        x: positions [m], shape [vertex].
        v: velocities half a step ago [m/s], shape [vertex].
        contacts: shape [slot].
        springs: stick springs [m], shape [slot]; updated.
        dashpots: dashpot forces [N], shape [slot]; overwritten.
        f: forces [N], shape [vertex]; accumulated.
        lost: (friction, contact damping, mass damping) [J], shape [vertex]; accumulated.
        stored: energy of the contact springs [J], shape [slot]; overwritten.
        slip: distance slid so far [m], shape [slot]; accumulated.
        spent: lost to friction and damping since the last search [J], shape [slot]; accumulated.
    """
    thread = wp.tid()
    i = first_vertex + thread
    slot = first_slot + thread
    if contacts[slot].near == 0:
        if stored[slot] > wp.float64(0.0):  # slid over the other ply's edge
            lost[i] += wp.vec3d(stored[slot], wp.float64(0.0), wp.float64(0.0))
            stored[slot] = wp.float64(0.0)
            springs[slot] = wp.vec3d()
            dashpots[slot] = wp.float64(0.0)
        return
    contact = contacts[slot]
    gap = contact_gap(contact, thickness, x, x[i])
    if gap >= wp.float64(0.0) and stored[slot] == wp.float64(0.0):
        return
    a = contact.a
    b = contact.b
    c = contact.c
    w = contact.weights
    velocity = v[i] - (w[0] * v[a] + w[1] * v[b] + w[2] * v[c])
    t = contact_traction(
        law,
        contact.mass,
        friction,
        gap,
        contact.normal,
        velocity,
        springs[slot],
        dashpots[slot],
    )
    springs[slot] = t.spring
    dashpots[slot] = t.dashpot
    stored[slot] = t.stored
    slip[slot] += t.slip
    spent[slot] += t.friction + t.damping
    lost[i] += wp.vec3d(t.friction, t.damping, wp.float64(0.0))
    wp.atomic_add(f, i, t.force)
    wp.atomic_sub(f, a, w[0] * t.force)
    wp.atomic_sub(f, b, w[1] * t.force)
    wp.atomic_sub(f, c, w[2] * t.force)
