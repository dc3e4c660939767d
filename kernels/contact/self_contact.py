"""Contact of a ply with itself: where its folds close, vertices against its own triangles.

A slot is a vertex and a side: its contact is with a triangle on whose upper, or lower, side the
vertex lies, so that a layer between two others touches both. What is near along the flat ply is
left out.
"""

import warp as wp

from ..sweep import Sweep
from .contact import CompactionLaws, ContactLaw
from .facets import (
    NearestFacet,
    PlyFacets,
    facing,
    is_at_border,
    nearest_on_facet,
    no_facet,
)
from .fold_search import (
    FlatPly,
    is_all_near,
    is_another_fold,
    is_same_place,
    walk_on_fold,
)
from .folds import Patches
from .friction import Rub
from .on_ply import (
    PlyContact,
    PlySearch,
    Slots,
    effective_mass,
    has_gone_through,
    press_on_ply,
    radius_of,
    reach_of,
)
from .settling import hold, let_go
from .surface import to_single, weighted
from .yarn_angle import at_angle


@wp.struct
class SearchedSelf:
    """The ply that is held against itself."""

    mesh: wp.uint64
    number: wp.int32
    first_triangle: wp.int32
    first_vertex: wp.int32
    vertices: wp.int32
    first_slot: wp.int32  # upper sides first, then the lower ones
    thickness: wp.float64  # m
    rub: Rub  # friction of its folds
    pad: wp.int32  # compaction law between its faces plus one, 0 for none


@wp.struct
class SelfSlots:
    """What a ply's vertices remember of their own ply, and how deep they have been in it."""

    seen: wp.array(dtype=wp.int32)  # nearest triangle plus one, 0 if none in sight, shape [slot]
    slots: Slots  # of the contacts, shape [slot]
    pressing: wp.array(dtype=wp.int32)  # 1 if it may touch before the next search, shape [vertex]
    deepest: wp.array(dtype=wp.float64)  # so far, what is allowed included [m], shape [ply]
    jump: wp.array(dtype=wp.float64)  # largest penetration allowed so far [m], shape [ply]
    passed: wp.array(dtype=wp.float64)  # `Pace.outrun` where folds passed each other, shape [ply]


@wp.func
def signed_distance(
    facets: PlyFacets,
    ply: SearchedSelf,
    nearest: NearestFacet,
    side: wp.float64,
    through: bool,
    reach: wp.float64,
    x: wp.array(dtype=wp.vec3d),
):
    """Whether a vertex may touch a place on a side of its ply, its height [m], and the normal.

    Args:
        facets: of all plies.
        ply: the vertex's.
        nearest: the place.
        side: +1 for a vertex above it, −1 for one below.
        through: whether it has been pressed through the mid-surface from that side.
        reach: distance beyond the thickness that counts as near [m].
        x: positions [m], shape [vertex].
    """
    zero = wp.float64(0.0)
    offset = nearest.offset
    distance = wp.length(offset)
    near = distance <= ply.thickness + reach
    outward = side * wp.normalize(facing(facets, nearest, x))
    height = wp.dot(offset, outward)
    if is_at_border(facets, nearest):
        beyond = distance * distance - height * height
        if beyond > wp.float64(0.25) * ply.thickness * ply.thickness:
            near = False
    if height < zero:
        if not through:  # a walk has come round a fold, to where it lies on the other side
            near = False
        distance = -distance
    normal = outward
    if wp.abs(distance) > wp.float64(1.0e-3) * ply.thickness:
        normal = offset / distance
    return near, distance, normal


@wp.func
def watch_passing(
    search: PlySearch,
    facets: PlyFacets,
    ply: SearchedSelf,
    i: int,
    side: wp.float64,
    seen: int,
    found: int,
    x: wp.array(dtype=wp.vec3d),
    v: wp.array(dtype=wp.vec3d),
    kept: SelfSlots,
):
    """Note it where a fold has gone through a vertex that did not touch it.

    Either it lies on the other side of the triangle that it saw at the last search, from which, at
    their speed, it was more than a thickness off on its own side. A walk that comes round a fold is
    not so fast. Or it leaves a triangle that has come in sight, from the other side of which it
    was out of sight when all asked last, and vertices have gone farther than they saw then.

    Args:
        search: how to look.
        facets: of all plies.
        ply: the vertex's.
        i: the vertex.
        side: of the triangle on which it lay, or lies, +1 above.
        seen: number of the triangle that it saw, −1 if none.
        found: of the one that it sees now, −1 if none.
        x: positions [m], shape [vertex].
        v: velocities half a step ago [m/s], shape [vertex].
        kept: what vertices remember; updated.
    """
    pace = search.paces[search.part]
    facet = wp.where(seen >= 0, seen, found)
    if pace.outrun <= wp.float64(1.0) or facet < 0:
        return
    there = nearest_on_facet(facets, facet, x, x[i])
    if is_at_border(facets, there):
        return
    outward = side * wp.normalize(facing(facets, there, x))
    height = wp.dot(there.offset, outward)
    at = facets.corners[facet]
    leaving = wp.dot(outward, v[i] - weighted(there.weights, v[at[0]], v[at[1]], v[at[2]]))
    passed = height < wp.float64(0.0) and height - search.interval * leaving > ply.thickness
    if seen < 0:
        passed = pace.blind > wp.float64(0.0) and height - search.asked * leaving < -pace.blind
    if passed:
        wp.atomic_max(kept.passed, ply.number, pace.outrun)


@wp.func
def touch(
    law: ContactLaw,
    laws: CompactionLaws,
    search: PlySearch,
    facets: PlyFacets,
    flat: FlatPly,
    ply: SearchedSelf,
    i: int,
    slot: int,
    side: wp.float64,
    nearest: NearestFacet,
    mass: wp.array(dtype=wp.float64),
    x: wp.array(dtype=wp.vec3d),
    v: wp.array(dtype=wp.vec3d),
    kept: SelfSlots,
    lost: wp.array(dtype=wp.vec3d),
):
    """Make a slot's contact that with the nearest triangle on its side, or none."""
    held = kept.slots.contacts[slot].near
    through = has_gone_through(kept.slots.contacts[slot], x, x[i])
    earlier = let_go(law, laws, kept.slots, slot, x, x[i])
    if held == 0:
        seen = kept.seen[slot] - 1
        watch_passing(search, facets, ply, i, side, seen, nearest.facet, x, v, kept)
    kept.seen[slot] = nearest.facet + 1
    if nearest.facet < 0:
        return
    reach = reach_of(search)
    near, height, normal = signed_distance(facets, ply, nearest, side, through, reach, x)
    if not near:
        return
    gap = height - ply.thickness
    corners = facets.corners[nearest.facet]
    found = PlyContact()
    found.a = corners[0]
    found.b = corners[1]
    found.c = corners[2]
    found.weights = nearest.weights
    found.normal = normal
    found.rise = wp.dot(normal, nearest.offset) - height
    found.mass = effective_mass(mass, corners, nearest.weights, i)
    found.thickness = ply.thickness
    found.rub = at_angle(law.friction, ply.rub, facets, i, nearest.facet, x)
    found.pad.law = ply.pad
    found.pad.area = flat.areas[i]
    allowed = hold(law, laws, search, kept.slots, slot, found, x, x[i], gap, earlier, i, lost)
    wp.atomic_max(kept.deepest, ply.number, -gap)
    wp.atomic_max(kept.jump, ply.number, allowed)


@wp.kernel(enable_backward=False)
def find_self_contacts(
    sweep: Sweep,
    law: ContactLaw,
    laws: CompactionLaws,
    search: PlySearch,
    facets: PlyFacets,
    flat: FlatPly,
    ply: SearchedSelf,
    patches: Patches,
    mass: wp.array(dtype=wp.float64),
    x: wp.array(dtype=wp.vec3d),
    v: wp.array(dtype=wp.vec3d),
    kept: SelfSlots,
    lost: wp.array(dtype=wp.vec3d),
):
    """Find the triangles of a vertex's own ply nearest to it on both sides; a sweep.

    A vertex keeps to the side of a fold on which it came near. Beyond a border it touches for half
    a thickness more, then nothing. Where the ply has not folded vertices are left out.

    Args:
        sweep: numbers of the vertices.
        law: contact law.
        laws: of compaction.
        search: how to look.
        facets: of all plies.
        flat: the flat plies.
        ply: the searched one.
        patches: the plies' patches, which may touch their ply.
        mass: shape [vertex] [kg].
        x: positions [m], shape [vertex].
        v: velocities half a step ago [m/s], shape [vertex].
        kept: what vertices remember; updated.
        lost: (friction, contact damping, mass damping) [J], shape [vertex]; accumulated.
    """
    for i in range(sweep.first + wp.tid(), sweep.end, sweep.threads):
        above = ply.first_slot + i - ply.first_vertex
        below = above + ply.vertices
        asks = search.asks == 1 and (
            patches.folded[patches.of_vertex[i]] == 1 or kept.pressing[i] == 1
        )
        if search.asks == 1 and not asks:
            kept.seen[above] = 0
            kept.seen[below] = 0
        if not asks and kept.seen[above] == 0 and kept.seen[below] == 0:
            continue
        point = x[i]
        upper = no_facet()
        lower = no_facet()
        if kept.seen[above] > 0 and (not asks or kept.slots.contacts[above].near == 1):
            upper = walk_on_fold(flat, facets, i, kept.seen[above] - 1, x)
        if kept.seen[below] > 0 and (not asks or kept.slots.contacts[below].near == 1):
            lower = walk_on_fold(flat, facets, i, kept.seen[below] - 1, x)
        if asks:
            held_above = upper
            held_below = lower
            radius = radius_of(search)
            margin = wp.vec3d(radius, radius, radius)
            query = wp.mesh_query_aabb(
                ply.mesh, to_single(point - margin), to_single(point + margin)
            )
            for face in query:
                facet = ply.first_triangle + face
                if is_all_near(flat, facets, i, facet):
                    continue
                there = nearest_on_facet(facets, facet, x, point)
                square = wp.length_sq(there.offset)
                nearer = upper.facet < 0 or square < wp.length_sq(upper.offset)
                nearer = nearer or lower.facet < 0 or square < wp.length_sq(lower.offset)
                if square >= radius * radius or not nearer:
                    continue
                if is_another_fold(flat, facets, i, there):
                    over = is_same_place(flat, facets, i, held_above, there)
                    under = is_same_place(flat, facets, i, held_below, there)
                    if over == under:
                        over = wp.dot(there.offset, facing(facets, there, x)) >= wp.float64(0.0)
                    if over:
                        if upper.facet < 0 or square < wp.length_sq(upper.offset):
                            upper = there
                    else:
                        if lower.facet < 0 or square < wp.length_sq(lower.offset):
                            lower = there

        one = wp.float64(1.0)
        touch(law, laws, search, facets, flat, ply, i, above, one, upper, mass, x, v, kept, lost)
        touch(law, laws, search, facets, flat, ply, i, below, -one, lower, mass, x, v, kept, lost)
        # What is let go of still hands in its energy in the next step.
        stores = wp.max(kept.slots.stored[above], kept.slots.stored[below]) > wp.float64(0.0)
        near = kept.slots.contacts[above].near == 1 or kept.slots.contacts[below].near == 1
        kept.pressing[i] = wp.where(near or stores, 1, 0)


@wp.kernel(enable_backward=False)
def add_self_forces(
    law: ContactLaw,
    laws: CompactionLaws,
    ply: SearchedSelf,
    first: int,
    x: wp.array(dtype=wp.vec3d),
    v: wp.array(dtype=wp.vec3d),
    kept: SelfSlots,
    f: wp.array(dtype=wp.vec3d),
    lost: wp.array(dtype=wp.vec3d),
):
    """Add the forces between vertices and their own ply to ``f``; one thread a vertex.

    Args:
        law: contact law.
        laws: of compaction.
        ply: the ply.
        first: number of the first vertex.
        x: positions [m], shape [vertex].
        v: velocities half a step ago [m/s], shape [vertex].
        kept: what vertices remember; their contacts are updated.
        f: forces [N], shape [vertex]; accumulated.
        lost: (friction, contact damping, mass damping) [J], shape [vertex]; accumulated.
    """
    i = first + wp.tid()
    if kept.pressing[i] == 0:
        return
    for side in range(2):
        slot = ply.first_slot + side * ply.vertices + i - ply.first_vertex
        press_on_ply(law, laws, i, slot, x, v, kept.slots, f, lost)
