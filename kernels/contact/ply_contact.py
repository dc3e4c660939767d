"""Contact between plies: each ply's vertices against the other's triangles, stacking order kept.

`find_ply_contacts` runs every few steps and finds the nearest triangle; `add_ply_forces` runs every
step on the weights and normal it found there. A slot is a vertex and the plies above it, or below:
its contact is with a triangle of one of them. The stacking order is kept, but for vertices that go
round another ply's border: those lie across from then on, until they come back round it.
"""

import warp as wp

from ..sweep import Sweep
from .contact import CompactionLaws, ContactLaw
from .facets import (
    NearestFacet,
    PlyFacets,
    ask_for_nearest,
    is_at_border,
    is_on_side,
    no_facet,
    walk_to_nearest,
)
from .friction import Rub
from .on_ply import (
    PlyMemory,
    PlySearch,
    Slots,
    before_search,
    effective_mass,
    press_on_ply,
    radius_of,
    reach_of,
    settled,
)
from .surface import facet_slope, weighted
from .yarn_angle import at_angle


@wp.struct
class PlyStack:
    """The plies that are searched, from the lowest to the highest."""

    meshes: wp.array(dtype=wp.uint64)  # shape [ply]
    first_triangle: wp.array(dtype=wp.int32)  # shape [ply]
    half: wp.array(dtype=wp.float64)  # of the thickness [m], shape [ply]
    rubs: wp.array(dtype=Rub)  # friction between each two, shape [ply · ply]
    pads: wp.array(dtype=wp.int32)  # their compaction laws plus one, 0 for none, likewise
    areas: wp.array(dtype=wp.float64)  # that their vertices' contacts stand for [m²], [vertex]


@wp.struct
class PlyPlane:
    """Tangent plane of a ply near a vertex of another."""

    normal: wp.vec3d  # towards the vertex's side
    gap: wp.float64  # m
    rise: wp.float64  # of the plane over the nearest point, less the thickness [m]
    height: wp.float64  # of the vertex over the ply's mid-surface, room in the hollow included [m]
    beyond: wp.int32  # 1 past the ply's border, 2 where it is left alone there
    across: wp.int32  # 1 on the other side than the stacking order says, 2 undecided


@wp.func
def plane_of(
    facets: PlyFacets,
    nearest: NearestFacet,
    side: wp.float64,
    thickness: wp.float64,
    x: wp.array(dtype=wp.vec3d),
    normals: wp.array(dtype=wp.vec3d),
    hollows: wp.array(dtype=wp.vec2d),
) -> PlyPlane:
    """Plane of a ply at the place nearest to a vertex.

    The gap is the distance to the facet. On the hollow side of a bent ply there is room besides for
    the arcs that its chords cut off: else a vertex of the inner ply would lift the chords of the
    outer one. Beyond a border the surface goes on flat for a thickness, then as a ramp of 45° down
    past the mid-surface, so that a vertex that has slid off climbs back onto the right side.

    Args:
        facets: of all plies.
        nearest: the place.
        side: +1 for a vertex above the ply, −1 for one below.
        thickness: of the mid-surfaces in contact [m].
        x: positions [m], shape [vertex].
        normals: unit vertex normals, shape [vertex].
        hollows: room on the hollow sides, above and below [m], shape [vertex].
    """
    plane = PlyPlane()
    corners = facets.corners[nearest.facet]
    a = corners[0]
    b = corners[1]
    c = corners[2]
    w = nearest.weights
    offset = nearest.offset
    outward = side * wp.normalize(weighted(w, normals[a], normals[b], normals[c]))
    height = wp.dot(offset, outward)
    aside = offset - height * outward
    beyond = wp.length(aside)
    face = wp.where(side > wp.float64(0.0), 0, 1)
    room = wp.vec3d(hollows[a][face], hollows[b][face], hollows[c][face])
    over = thickness - wp.dot(w, room)
    plane.height = height + wp.dot(w, room)
    plane.normal = outward
    plane.gap = height - over
    if is_at_border(facets, nearest) and beyond > wp.float64(0.0):
        plane.beyond = 1
        if height < -wp.float64(0.5) * thickness:
            plane.beyond = 2
        if beyond > thickness:
            plane.normal = wp.normalize(outward + aside / beyond)
            plane.gap = (height + beyond - over - thickness) * wp.dot(plane.normal, outward)
    else:
        distance = wp.length(offset)
        if not is_on_side(facets, nearest, side, x):
            distance = -distance
        plane.height = distance + wp.dot(w, room)
        straight = outward
        if wp.abs(distance) > wp.float64(1.0e-3) * thickness:
            straight = offset / distance
        plane.normal = wp.normalize(straight + facet_slope(x[a], x[b], x[c], w, room))
        plane.gap = distance - over
    plane.rise = wp.dot(plane.normal, offset) - plane.gap - thickness
    return plane


@wp.func
def is_same_place(asked: NearestFacet, walked: NearestFacet, thickness: wp.float64) -> bool:
    """Whether a vertex sees the place that it has seen so far, and none on another fold."""
    return wp.length(asked.offset - walked.offset) < wp.float64(0.1) * thickness


@wp.func
def plane_on_side(
    facets: PlyFacets,
    nearest: NearestFacet,
    side: wp.float64,
    before: int,
    thickness: wp.float64,
    x: wp.array(dtype=wp.vec3d),
    normals: wp.array(dtype=wp.vec3d),
    hollows: wp.array(dtype=wp.vec2d),
) -> PlyPlane:
    """Plane of a ply on the side on which a vertex lies.

    A vertex changes sides past the ply's border, once it is a thickness beyond the mid-surface and
    so touches neither side. One that comes in sight, or back from where it was left alone, takes
    the side into which it reaches less deep: room in a hollow makes no vertex that has come over a
    border lie on the other side of the ply.

    Args:
        facets: of all plies.
        nearest: the place.
        side: +1 for a vertex that the stacking order puts above the ply, −1 for one below.
        before: 0 if it lay in the stacking order at the last search, 1 across, 2 if undecided.
        thickness: of the mid-surfaces in contact [m].
        x: positions [m], shape [vertex].
        normals: unit vertex normals, shape [vertex].
        hollows: room on the hollow sides, above and below [m], shape [vertex].
    """
    across = before % 2
    side_now = wp.where(across == 1, -side, side)
    plane = plane_of(facets, nearest, side_now, thickness, x, normals, hollows)
    far = plane.beyond > 0 and plane.height < -thickness
    new = before == 2 and plane.beyond == 0 and plane.gap < wp.float64(0.0)
    if far or new:
        other = plane_of(facets, nearest, -side_now, thickness, x, normals, hollows)
        if far or other.gap > plane.gap:
            across = 1 - across
            plane = other
    if before == 2 and plane.beyond == 1 and plane.gap < -wp.float64(0.5) * thickness:
        plane.beyond = 2  # not from nothing to one and a half thicknesses deep
    plane.across = wp.where(plane.beyond == 2, 2, across)
    return plane


@wp.kernel(enable_backward=False)
def find_ply_contacts(
    sweep: Sweep,
    law: ContactLaw,
    laws: CompactionLaws,
    search: PlySearch,
    facets: PlyFacets,
    stack: PlyStack,
    searching: int,
    way: int,
    first_slot: int,
    mass: wp.array(dtype=wp.float64),
    x: wp.array(dtype=wp.vec3d),
    normals: wp.array(dtype=wp.vec3d),
    hollows: wp.array(dtype=wp.vec2d),
    memory: wp.array(dtype=PlyMemory),
    slots: Slots,
    lost: wp.array(dtype=wp.vec3d),
    deepest: wp.array(dtype=wp.float64),
    largest_jump: wp.array(dtype=wp.float64),
):
    """Find the nearest triangle of the next ply above or below; a sweep over vertices.

    Where that ply does not cover a vertex, or lies across, those beyond it are asked, up to one
    that covers it in its order: the ply with the least gap counts. So each vertex touches one ply
    above and one below at most, however high the stack.

    When the gap would jump to a deeper penetration (facets change, a vertex comes back over a
    border) the difference is allowed for (`settled`); where it jumps out, what the springs lose
    counts as contact damping. A vertex that is far is left out of walks until it can have come
    near.

    Args:
        sweep: numbers of the vertices.
        law: contact law.
        laws: of compaction.
        search: how to look.
        facets: of all plies.
        stack: the plies.
        searching: number of the ply whose vertices these are.
        way: +1 to look at the plies above, −1 below.
        first_slot: where the first one's contact with those plies is kept.
        mass: shape [vertex] [kg].
        x: positions [m], shape [vertex].
        normals: unit vertex normals, shape [vertex].
        hollows: room on the hollow sides, above and below [m], shape [vertex].
        memory: of the searches, shape [slot]; updated.
        slots: memory of the contacts; these are overwritten, springs let go where another ply is
            met.
        lost: (friction, contact damping, mass damping) [J], shape [vertex]; accumulated.
        deepest: largest penetration so far [m], what is allowed included, shape [ply · ply];
            raised.
        largest_jump: largest penetration allowed so far [m], shape [ply · ply]; raised.
    """
    for i in range(sweep.first + wp.tid(), sweep.end, sweep.threads):
        slot = first_slot + i - sweep.first
        reach = reach_of(search)
        memory[slot].way -= reach
        if memory[slot].way > reach and search.asks == 0:
            continue
        memory[slot].way = wp.float64(0.0)
        before, had = before_search(
            law, laws, slots.contacts[slot], x, x[i], slots.springs[slot], slots.stored[slot]
        )
        slots.contacts[slot].near = 0
        budget = wp.max(slots.spent[slot], wp.float64(0.0))
        slots.spent[slot] = wp.float64(0.0)
        side = -wp.float64(way)
        nearest = no_facet()
        plane = PlyPlane()
        plane.beyond = 2
        met = memory[slot].ply - 1
        last = wp.where(memory[slot].seen > 0, met, -1)
        asks = search.asks == 1 or memory[slot].loose == 1
        if asks:
            count = stack.half.shape[0]
            covered = wp.int32(0)
            radius = radius_of(search)
            ply = searching + way
            met = ply
            while ply >= 0 and ply < count:
                first = stack.first_triangle[ply]
                there = ask_for_nearest(facets, stack.meshes[ply], first, radius, x, x[i])
                if there.facet >= 0:
                    if search.asks == 0:  # the query mesh is of the last search in which all asked
                        there = walk_to_nearest(facets, there.facet, x, hollows, x[i])
                    thickness = stack.half[searching] + stack.half[ply]
                    lay = wp.int32(2)
                    if ply == last:
                        walked = walk_to_nearest(facets, memory[slot].seen - 1, x, hollows, x[i])
                        if is_same_place(there, walked, thickness):
                            lay = memory[slot].across
                    other = plane_on_side(facets, there, side, lay, thickness, x, normals, hollows)
                    if nearest.facet < 0 or (
                        other.beyond < 2 and (plane.beyond == 2 or other.gap < plane.gap)
                    ):
                        nearest = there
                        plane = other
                        met = ply
                    if other.beyond == 0 and other.across == 0:
                        covered = 1
                        ply = wp.where(way > 0, count, -1)
                ply += way
            memory[slot].loose = wp.where(nearest.facet >= 0, 1 - covered, 0)
        elif memory[slot].seen > 0:
            nearest = walk_to_nearest(facets, memory[slot].seen - 1, x, hollows, x[i])
            thickness = stack.half[searching] + stack.half[met]
            lay = memory[slot].across
            plane = plane_on_side(facets, nearest, side, lay, thickness, x, normals, hollows)
            if plane.beyond > 0 or plane.across != 0:
                memory[slot].loose = 1
        memory[slot].seen = nearest.facet + 1
        if nearest.facet < 0:
            continue
        if memory[slot].ply != met + 1 or memory[slot].across != plane.across:
            slots.springs[slot] = wp.vec3d()
            memory[slot].ply = met + 1
            memory[slot].across = plane.across
        if plane.beyond == 2:
            continue
        gap = plane.gap
        if gap > reach:
            if memory[slot].loose == 0 or asks:
                memory[slot].way = gap
            continue
        corners = facets.corners[nearest.facet]
        slots.contacts[slot].near = 1
        slots.contacts[slot].a = corners[0]
        slots.contacts[slot].b = corners[1]
        slots.contacts[slot].c = corners[2]
        slots.contacts[slot].weights = nearest.weights
        slots.contacts[slot].normal = plane.normal
        slots.contacts[slot].rise = plane.rise
        slots.contacts[slot].mass = effective_mass(mass, corners, nearest.weights, i)
        slots.contacts[slot].thickness = stack.half[searching] + stack.half[met]
        pair = searching * stack.half.shape[0] + met
        slots.contacts[slot].rub = at_angle(
            law.friction, stack.rubs[pair], facets, i, nearest.facet, x
        )
        slots.contacts[slot].pad.law = stack.pads[pair]
        slots.contacts[slot].pad.area = stack.areas[i]
        jump = wp.max(before - gap, wp.float64(0.0))
        allowance, taken = settled(
            law, laws, search, slots.contacts[slot], x, x[i], slots.springs[slot], jump, had, budget
        )
        slots.contacts[slot].allowance = allowance
        slots.spent[slot] = budget + taken
        lost[i] += wp.vec3d(wp.float64(0.0), taken, wp.float64(0.0))
        wp.atomic_max(deepest, pair, -gap)
        wp.atomic_max(largest_jump, pair, allowance)


@wp.kernel(enable_backward=False)
def add_ply_forces(
    sweep: Sweep,
    law: ContactLaw,
    laws: CompactionLaws,
    first_slot: int,
    x: wp.array(dtype=wp.vec3d),
    v: wp.array(dtype=wp.vec3d),
    slots: Slots,
    f: wp.array(dtype=wp.vec3d),
    lost: wp.array(dtype=wp.vec3d),
):
    """Add contact forces between two plies to ``f``; a sweep over vertices of the searching ply.

    Args:
        sweep: numbers of the vertices.
        law: contact law.
        laws: of compaction.
        first_slot: of the first one's contact with the plies above or below.
        x: positions [m], shape [vertex].
        v: velocities half a step ago [m/s], shape [vertex].
        slots: memory of the contacts; updated.
        f: forces [N], shape [vertex]; accumulated.
        lost: (friction, contact damping, mass damping) [J], shape [vertex]; accumulated.
    """
    for i in range(sweep.first + wp.tid(), sweep.end, sweep.threads):
        press_on_ply(law, laws, i, first_slot + i - sweep.first, x, v, slots, f, lost)
