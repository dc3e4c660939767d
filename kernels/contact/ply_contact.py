"""Contact between plies: each ply's vertices against the other's triangles, stacking order kept.

`find_ply_contacts` runs every few steps and finds the nearest triangle; `add_ply_forces` runs every
step on the weights and normal it found there. A slot is a vertex and the plies above it, or below:
its contact is with a triangle of one of them. The stacking order is kept, but for vertices that go
round another ply's border: those lie across from then on, until they come back round it.
"""

import warp as wp

from ..sweep import Sweep
from .contact import CompactionLaws, ContactLaw
from .facets import NearestFacet, PlyFacets, ask_for_nearest, no_facet, walk_to_nearest
from .friction import Rub
from .hollow import exists, hollow_at
from .on_ply import (
    PlyContact,
    PlyMemory,
    PlySearch,
    Slots,
    between,
    effective_mass,
    has_gone_through,
    plane_in,
    press_on_ply,
    radius_of,
    reach_of,
)
from .ply_planes import PlyPlane, is_same_place, plane_on_side
from .settling import hold, let_go
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
class Sighting:
    """What a vertex sees of the plies on one side of it."""

    nearest: NearestFacet
    plane: PlyPlane  # left alone where none is in sight
    ply: wp.int32  # number of that ply
    loose: wp.int32  # as `PlyMemory.loose`


@wp.func
def look_in_order(
    search: PlySearch,
    facets: PlyFacets,
    stack: PlyStack,
    searching: int,
    way: int,
    known: PlyMemory,
    through: bool,
    x: wp.array(dtype=wp.vec3d),
    normals: wp.array(dtype=wp.vec3d),
    hollows: wp.array(dtype=wp.vec2d),
    point: wp.vec3d,
) -> Sighting:
    """Ask the plies on a side, from the next one on, up to one that covers the point in its order.

    The ply with the least gap counts.

    Args:
        search: how to look.
        facets: of all plies.
        stack: the plies.
        searching: number of the point's ply.
        way: +1 to look at the plies above, −1 below.
        known: from the search before.
        through: whether the point has been pressed through the ply that it touches.
        x: positions [m], shape [vertex].
        normals: unit vertex normals, shape [vertex].
        hollows: room on the hollow sides, above and below [m], shape [vertex].
        point: that looks [m].
    """
    best = Sighting()
    best.nearest = no_facet()
    best.plane.beyond = 2
    last = wp.where(known.seen > 0, known.ply - 1, -1)
    side = -wp.float64(way)
    covered = wp.int32(0)
    radius = radius_of(search)
    count = stack.half.shape[0]
    ply = searching + way
    while ply >= 0 and ply < count:
        first = stack.first_triangle[ply]
        there = ask_for_nearest(facets, stack.meshes[ply], first, radius, x, point)
        if there.facet >= 0:
            if search.asks == 0:  # the query mesh is of the last search in which all asked
                there = walk_to_nearest(facets, there.facet, x, hollows, point)
            thickness = stack.half[searching] + stack.half[ply]
            lay = wp.int32(2)
            if ply == last:
                walked = walk_to_nearest(facets, known.seen - 1, x, hollows, point)
                if is_same_place(there, walked, thickness):
                    lay = known.across
            pressed = through and lay < 2
            plane = plane_on_side(facets, there, side, lay, pressed, thickness, x, normals, hollows)
            if best.nearest.facet < 0 or (
                plane.beyond < 2 and (best.plane.beyond == 2 or plane.gap < best.plane.gap)
            ):
                best.nearest = there
                best.plane = plane
                best.ply = ply
            if plane.beyond == 0 and plane.across == 0:
                covered = 1
                ply = wp.where(way > 0, count, -1)
        ply += way
    best.loose = wp.where(best.nearest.facet >= 0, 1 - covered, 0)
    return best


@wp.func
def look_again(
    facets: PlyFacets,
    stack: PlyStack,
    searching: int,
    way: int,
    known: PlyMemory,
    through: bool,
    x: wp.array(dtype=wp.vec3d),
    normals: wp.array(dtype=wp.vec3d),
    hollows: wp.array(dtype=wp.vec2d),
    point: wp.vec3d,
) -> Sighting:
    """Walk over the ply that was seen before, if one was; else as `look_in_order`."""
    best = Sighting()
    best.nearest = no_facet()
    if known.seen > 0:
        best.ply = known.ply - 1
        best.nearest = walk_to_nearest(facets, known.seen - 1, x, hollows, point)
        thickness = stack.half[searching] + stack.half[best.ply]
        side = -wp.float64(way)
        best.plane = plane_on_side(
            facets, best.nearest, side, known.across, through, thickness, x, normals, hollows
        )
        if best.plane.beyond > 0 or best.plane.across != 0:
            best.loose = 1
    return best


@wp.func
def contact_with(
    law: ContactLaw,
    facets: PlyFacets,
    stack: PlyStack,
    searching: int,
    i: int,
    seen: Sighting,
    mass: wp.array(dtype=wp.float64),
    x: wp.array(dtype=wp.vec3d),
) -> PlyContact:
    """The contact of vertex i of a ply with what it has seen."""
    corners = facets.corners[seen.nearest.facet]
    pair = searching * stack.half.shape[0] + seen.ply
    found = PlyContact()
    found.a = corners[0]
    found.b = corners[1]
    found.c = corners[2]
    found.weights = seen.nearest.weights
    found.normal = seen.plane.normal
    found.rise = seen.plane.rise
    found.mass = effective_mass(mass, corners, seen.nearest.weights, i)
    found.thickness = stack.half[searching] + stack.half[seen.ply]
    found.rub = at_angle(law.friction, stack.rubs[pair], facets, i, seen.nearest.facet, x)
    found.pad.law = stack.pads[pair]
    found.pad.area = stack.areas[i]
    return found


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
        point = x[i]
        through = has_gone_through(slots.contacts[slot], x, point)
        earlier = let_go(law, laws, slots, slot, x, point)
        known = memory[slot]
        seen = Sighting()
        asks = search.asks == 1 or known.loose == 1
        if asks:
            seen = look_in_order(
                search, facets, stack, searching, way, known, through, x, normals, hollows, point
            )
        else:
            seen = look_again(
                facets, stack, searching, way, known, through, x, normals, hollows, point
            )
        memory[slot].loose = seen.loose
        memory[slot].seen = seen.nearest.facet + 1
        if seen.nearest.facet < 0:
            continue
        if known.ply != seen.ply + 1 or known.across != seen.plane.across:
            slots.springs[slot] = wp.vec3d()
            memory[slot].ply = seen.ply + 1
            memory[slot].across = seen.plane.across
        if seen.plane.beyond == 2:
            continue
        gap = seen.plane.gap
        if gap > reach:
            if seen.loose == 0 or asks:
                memory[slot].way = gap
            continue
        found = contact_with(law, facets, stack, searching, i, seen, mass, x)
        if seen.plane.beyond == 0:
            on = wp.where(seen.plane.across == 0, wp.float64(-way), wp.float64(way))
            own = plane_in(found)
            own.gap = gap
            hollow = hollow_at(
                facets, seen.nearest, own, on, reach, found.thickness, x, hollows, point
            )
            if exists(hollow.other):
                found = between(slots, slot, found, hollow)
                gap = wp.min(hollow.own.gap, hollow.other.gap)
        allowed = hold(law, laws, search, slots, slot, found, x, point, gap, earlier, i, lost)
        pair = searching * stack.half.shape[0] + seen.ply
        wp.atomic_max(deepest, pair, -gap)
        wp.atomic_max(largest_jump, pair, allowed)


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
