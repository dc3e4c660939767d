"""Contact between plies: each ply's vertices against the other's triangles, stacking order kept.

`find_ply_contacts` runs every few steps and finds the nearest triangle; `add_ply_forces` runs every
step on the weights and normal it found there. A contact is a vertex of one ply and a triangle of
another; `side` is +1 where the vertex's ply lies above the triangle's, and never changes.
"""

import warp as wp

from .contact import ContactLaw, contact_traction
from .facets import PlyFacets, ask_for_nearest, is_at_border, no_facet, walk_to_nearest
from .surface import edge_sag, facet_slope, to_single, weighted

MOST_WAITS = wp.constant(wp.float64(100.0))
"""Searches that may leave a vertex out, at most."""


@wp.struct
class PlyContact:
    """Nearest triangle of another ply."""

    a: wp.int32  # vertices of the triangle
    b: wp.int32
    c: wp.int32
    near: wp.int32  # 1 if the vertex may touch before the next search
    weights: wp.vec3d  # of a, b, c at the nearest point
    normal: wp.vec3d  # towards the vertex's side
    rise: wp.float64  # of the tangent plane over the nearest point, less the thickness [m]
    allowance: wp.float64  # penetration still allowed after a jump of the gap [m]
    mass: wp.float64  # with which the vertex meets the triangle [kg]


@wp.struct
class PlyMemory:
    """What the search of a vertex for another ply remembers; zero at first."""

    seen: wp.int32  # number of the nearest triangle plus one; 0 if none was in sight
    wait: wp.int32  # searches until which it cannot have come near


@wp.struct
class PlySearch:
    """How a search looks."""

    asks: wp.int32  # 1 to ask for every vertex; 0 to walk from what it remembers
    reach: wp.float64  # distance beyond the thickness that counts as near [m]
    radius: wp.float64  # of the mesh query [m]
    keep: wp.float64  # share of an allowed penetration that lasts until the next search [-]
    ease: wp.float64  # by which one may shrink at most until then [m]


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
def compute_vertex_normals(
    first: int,
    facets: PlyFacets,
    x: wp.array(dtype=wp.vec3d),
    normals: wp.array(dtype=wp.vec3d),
):
    """Compute unit vertex normals, weighted by area; one thread a vertex, from first.

    Args:
        first: number of the first vertex.
        facets: of all plies.
        x: positions [m], shape [vertex].
        normals: shape [vertex]; overwritten.
    """
    i = first + wp.tid()
    n = wp.vec3d()
    for k in range(facets.first_of_fan[i], facets.first_of_fan[i + 1]):
        at = facets.corners[facets.fans[k]]
        a = x[at[0]]
        n += wp.cross(x[at[1]] - a, x[at[2]] - a)
    normals[i] = wp.normalize(n)


@wp.kernel(enable_backward=False)
def compute_hollows(
    first: int,
    facets: PlyFacets,
    x: wp.array(dtype=wp.vec3d),
    normals: wp.array(dtype=wp.vec3d),
    hollows: wp.array(dtype=wp.vec2d),
):
    """Compute the largest sags of the edges at a vertex; one thread a vertex, from first.

    Args:
        first: number of the first vertex.
        facets: of all plies.
        x: positions [m], shape [vertex].
        normals: unit vertex normals, shape [vertex].
        hollows: room above, where the ply is bent like a bowl, and below, where like a dome [m],
            shape [vertex]; overwritten.
    """
    i = first + wp.tid()
    above = wp.float64(0.0)
    below = wp.float64(0.0)
    for k in range(facets.first_of_ring[i], facets.first_of_ring[i + 1]):
        j = facets.rings[k]
        dome = edge_sag(x[i], x[j], normals[i], normals[j])
        above = wp.max(above, -dome)
        below = wp.max(below, dome)
    hollows[i] = wp.vec2d(above, below)


@wp.func
def contact_gap(contact: PlyContact, thickness: wp.float64, x: wp.array(dtype=wp.vec3d), i: int):
    """Gap [m] of vertex i to the tangent plane of its contact, penetration still allowed added."""
    w = contact.weights
    nearest = w[0] * x[contact.a] + w[1] * x[contact.b] + w[2] * x[contact.c]
    offset = thickness + contact.rise - contact.allowance
    return wp.dot(contact.normal, x[i] - nearest) - offset


@wp.func
def effective_mass(
    mass: wp.array(dtype=wp.float64), corners: wp.vec3i, w: wp.vec3d, i: int
) -> wp.float64:
    """Mass [kg] with which vertex i meets a triangle at the point of weights w."""
    inverse = w[0] * w[0] / mass[corners[0]] + w[1] * w[1] / mass[corners[1]]
    inverse += w[2] * w[2] / mass[corners[2]]
    return wp.float64(1.0) / (wp.float64(1.0) / mass[i] + inverse)


@wp.func
def spring_energy(
    law: ContactLaw,
    contact: PlyContact,
    thickness: wp.float64,
    x: wp.array(dtype=wp.vec3d),
    i: int,
    spring: wp.vec3d,
) -> wp.float64:
    """Energy [J] in the penalty and stick springs of a contact."""
    depth = wp.min(contact_gap(contact, thickness, x, i), wp.float64(0.0))
    stiffness = law.stiffness * contact.mass
    return wp.float64(0.5) * stiffness * (depth * depth + wp.length_sq(spring))


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
    border) the difference is allowed for and fades, slowly where it is large, so that forces stay
    continuous and nothing is thrown out. What it fades is paid for by what friction and damping
    have taken since the last search, so that no energy comes from nowhere; where it jumps out,
    what the springs lose counts as contact damping. A vertex that is far is left out of walks until
    it can have come near, at the speed for which ``reach`` suffices from search to search.

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
            had = spring_energy(law, contacts[slot], faces.thickness, x, i, springs[slot])
        before = wp.min(contact_gap(contacts[slot], faces.thickness, x, i), before)
    contacts[slot].near = 0
    budget = wp.max(spent[slot], wp.float64(0.0))
    spent[slot] = wp.float64(0.0)
    nearest = no_facet()
    if search.asks == 1:
        first = faces.first_triangle
        nearest = ask_for_nearest(facets, faces.mesh, first, search.radius, x, i)
    elif memory[slot].seen > 0:
        nearest = walk_to_nearest(facets, memory[slot].seen - 1, x, hollows, i)
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
        memory[slot].wait = int(wp.min(gap / search.reach, MOST_WAITS)) - 1
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
    contacts[slot].allowance = jump
    stays = spring_energy(law, contacts[slot], faces.thickness, x, i, springs[slot])
    contacts[slot].allowance = wp.max(search.keep * jump, jump - search.ease)
    fades = spring_energy(law, contacts[slot], faces.thickness, x, i, springs[slot])
    # What fades loads the spring: it fades so far as losses pay for it (energy is convex in depth).
    allowance = contacts[slot].allowance
    if fades - stays > budget:
        allowance = jump - budget / (fades - stays) * (jump - allowance)
    contacts[slot].allowance = allowance
    if had + budget > wp.float64(0.0):
        has = spring_energy(law, contacts[slot], faces.thickness, x, i, springs[slot])
        taken = wp.max(had - has, -budget)
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
    gap = contact_gap(contact, thickness, x, i)
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
