"""Contact of edges with edges, between plies and within one: where two folds cross each other.

Vertices against triangles let two sharp folds pass each other between their vertices. What holds
them is the pair of edges that stick out towards each other, each *ridge* the nearest place of its
own sheet: the direction between them lies between the normals of the facets on either side of both.
Only such pairs are held. On smooth plies there are none: one of two that lie on each other is
hollow where the other bulges.

A slot is an edge: it holds the ridge that comes nearest to it on the side to which it sticks out.
An edge belongs to its end of the lower number.
"""

import warp as wp

from .contact import CompactionLaws, ContactLaw
from .facets import PlyFacets
from .folds import Patches
from .on_ply import PlySearch, Slots, before_search, press_slot, radius_of, reach_of, settled
from .ply_contact import PlyStack
from .ridges import Crossing, PlyEdges, apart, cross_at
from .self_contact import FlatPly
from .surface import to_single
from .yarn_angle import at_angle

HOLDERS = wp.constant(wp.float64(2.0))
"""Contacts that an edge bears at a time: its own, and that of the edge which it meets."""


@wp.struct
class Sheets:
    """All plies as their edges search them."""

    facets: PlyFacets
    edges: PlyEdges
    flat: FlatPly
    stack: PlyStack
    patches: Patches


@wp.struct
class EdgeMemory:
    """What the search of an edge remembers; zero at first."""

    other: wp.int32  # number of the nearest edge plus one, 0 if none was in sight
    ply: wp.int32  # of that one
    share: wp.float64  # of its second end where they are nearest
    way: wp.float64  # that ridges may come closer before one is near [m]


@wp.struct
class Seen:
    """What an edge sees."""

    ply: wp.int32  # 1 if the ply that it looked at last is in sight
    nearest: wp.float64  # least distance of a ridge, less the thickness [m]
    other: wp.int32  # number of that ridge plus one, 0 for none
    other_ply: wp.int32  # its ply
    best: Crossing  # the nearest of those that may touch


@wp.func
def are_another_fold(flat: FlatPly, edges: PlyEdges, e: int, f: int) -> bool:
    """Whether two edges of a ply lie so far apart on the flat sheet that they may touch."""
    a = edges.ends[e]
    b = edges.ends[f]
    apart = wp.max(flat.apart[a[0]], flat.apart[b[0]])
    least = wp.length_sq(flat.places[a[0]] - flat.places[b[0]])
    least = wp.min(least, wp.length_sq(flat.places[a[0]] - flat.places[b[1]]))
    least = wp.min(least, wp.length_sq(flat.places[a[1]] - flat.places[b[0]]))
    least = wp.min(least, wp.length_sq(flat.places[a[1]] - flat.places[b[1]]))
    return least >= apart * apart


@wp.func
def look_at_edge(
    sheets: Sheets,
    e: int,
    own: int,
    f: int,
    ply: int,
    held: int,
    reach: wp.float64,
    x: wp.array(dtype=wp.vec3d),
    hollows: wp.array(dtype=wp.vec2d),
    ridges: wp.array(dtype=wp.int32),
    seen: Seen,
) -> Seen:
    """What an edge sees, another edge besides what it has seen already.

    Args:
        sheets: the plies.
        e: the edge that looks.
        own: number of its ply.
        f: the other one.
        ply: number of that one's ply.
        held: number of the edge that it has held so far plus one, 0 for none.
        reach: gap up to which a ridge is near [m].
        x: positions [m], shape [vertex].
        hollows: room on the hollow sides, above and below [m], shape [vertex].
        ridges: to which side edges stick out, shape [edge].
        seen: so far.
    """
    if ridges[f] == 0:
        return seen
    edges = sheets.edges
    suits = bool(ridges[f] == -ridges[e])
    if own == ply:
        suits = are_another_fold(sheets.flat, edges, e, f)
    if not suits:
        return seen
    thickness = sheets.stack.half[own] + sheets.stack.half[ply]
    p = x[edges.ends[e][0]]
    q = x[edges.ends[f][0]]
    gap = apart(p, x[edges.ends[e][1]] - p, q, x[edges.ends[f][1]] - q) - thickness
    if gap < seen.nearest:
        seen.nearest = gap
        seen.other = f + 1
        seen.other_ply = ply
    if gap < reach:
        rooms = wp.where(own == ply, wp.float64(0.0), wp.float64(1.0))
        there = cross_at(
            sheets.facets, edges, e, f, held == f + 1, thickness, rooms, x, hollows, ridges
        )
        if there.other > 0 and (seen.best.other == 0 or there.gap < seen.best.gap):
            seen.best = there
            seen.best.ply = ply
    return seen


@wp.func
def look_at_ply(
    sheets: Sheets,
    e: int,
    own: int,
    ply: int,
    held: int,
    radius: wp.float64,
    reach: wp.float64,
    x: wp.array(dtype=wp.vec3d),
    hollows: wp.array(dtype=wp.vec2d),
    ridges: wp.array(dtype=wp.int32),
    seen: Seen,
) -> Seen:
    """What an edge sees of a ply within ``radius`` [m]; else as `look_at_edge`."""
    edges = sheets.edges
    p = x[edges.ends[e][0]]
    q = x[edges.ends[e][1]]
    margin = wp.vec3d(radius, radius, radius)
    low = to_single(wp.min(p, q) - margin)
    high = to_single(wp.max(p, q) + margin)
    query = wp.mesh_query_aabb(sheets.stack.meshes[ply], low, high)
    for face in query:
        facet = sheets.stack.first_triangle[ply] + face
        seen.ply = 1
        for corner in range(3):
            f = edges.of_triangle[facet][corner]
            if edges.sides[f][0] == facet:  # each edge once
                seen = look_at_edge(sheets, e, own, f, ply, held, reach, x, hollows, ridges, seen)
    return seen


@wp.func
def look_round(
    sheets: Sheets,
    e: int,
    own: int,
    last: int,
    ply: int,
    held: int,
    reach: wp.float64,
    x: wp.array(dtype=wp.vec3d),
    hollows: wp.array(dtype=wp.vec2d),
    ridges: wp.array(dtype=wp.int32),
    seen: Seen,
) -> Seen:
    """What an edge sees of another and of those that share an end with it; else likewise."""
    edges = sheets.edges
    for end in range(2):
        vertex = edges.ends[last][end]
        for k in range(edges.first_of_star[vertex], edges.first_of_star[vertex + 1]):
            f = edges.stars[k]
            if end == 0 or f != last:
                seen = look_at_edge(sheets, e, own, f, ply, held, reach, x, hollows, ridges, seen)
    return seen


@wp.func
def edge_mass(
    edges: PlyEdges,
    e: int,
    share: wp.float64,
    mass: wp.array(dtype=wp.float64),
    ridges: wp.array(dtype=wp.int32),
) -> wp.float64:
    """1/m [1/kg] with which a place of an edge meets others.

    Ridges at a vertex share its mass, each with those that bear on it: together their contacts
    take no more of the step than one of the vertex.
    """
    inverse = wp.float64(0.0)
    for end in range(2):
        vertex = edges.ends[e][end]
        at_vertex = wp.float64(0.0)
        for k in range(edges.first_of_star[vertex], edges.first_of_star[vertex + 1]):
            if ridges[edges.stars[k]] != 0:
                at_vertex += wp.float64(1.0)
        w = wp.where(end == 0, wp.float64(1.0) - share, share)
        inverse += w * w * HOLDERS * wp.max(at_vertex, wp.float64(1.0)) / mass[vertex]
    return inverse


@wp.func
def touch_nearest(
    law: ContactLaw,
    laws: CompactionLaws,
    search: PlySearch,
    sheets: Sheets,
    number: int,
    folds: int,
    e: int,
    mass: wp.array(dtype=wp.float64),
    x: wp.array(dtype=wp.vec3d),
    hollows: wp.array(dtype=wp.vec2d),
    ridges: wp.array(dtype=wp.int32),
    memory: wp.array(dtype=EdgeMemory),
    slots: Slots,
    pressing: wp.array(dtype=wp.int32),
    lost: wp.array(dtype=wp.vec3d),
    deepest: wp.array(dtype=wp.float64),
    largest_jump: wp.array(dtype=wp.float64),
):
    """Make an edge's contact that with the nearest ridge, or none; else as `find_edge_contacts`."""
    edges = sheets.edges
    stack = sheets.stack
    reach = reach_of(search)
    memory[e].way -= reach
    waits = ridges[e] == 0 or (memory[e].way > reach and search.asks == 0)
    if pressing[e] == 0 and waits:
        return
    i = edges.ends[e][0]
    j = edges.ends[e][1]
    zero = wp.float64(0.0)
    one = wp.float64(1.0)
    point = (one - memory[e].share) * x[i] + memory[e].share * x[j]
    before, had = before_search(
        law, laws, slots.contacts[e], x, point, slots.springs[e], slots.stored[e]
    )
    budget = wp.max(slots.spent[e], zero)
    slots.spent[e] = zero
    seen = Seen()
    seen.nearest = radius_of(search)
    held = wp.where(slots.contacts[e].near == 1, memory[e].other, 0)
    slots.contacts[e].near = 0
    if search.asks == 1 and ridges[e] != 0:
        radius = radius_of(search)
        count = stack.half.shape[0]
        ply = number + ridges[e]
        while ply >= 0 and ply < count:
            seen = look_at_ply(
                sheets,
                e,
                number,
                ply,
                held,
                radius,
                reach,
                x,
                hollows,
                ridges,
                seen,
            )
            ply = wp.where(seen.ply == 1, count, ply + ridges[e])
        if folds == 1 and sheets.patches.folded[sheets.patches.of_vertex[i]] == 1:
            ply = number
            seen = look_at_ply(
                sheets,
                e,
                number,
                ply,
                held,
                radius,
                reach,
                x,
                hollows,
                ridges,
                seen,
            )
        memory[e].way = seen.nearest
    elif ridges[e] != 0 and memory[e].other > 0:
        last = memory[e].other - 1
        ply = memory[e].ply
        seen = look_round(sheets, e, number, last, ply, held, reach, x, hollows, ridges, seen)
    best = seen.best
    if best.other > 0:
        seen.other = best.other
        seen.other_ply = best.ply
    memory[e].other = seen.other
    memory[e].ply = seen.other_ply
    near = best.other > 0 and best.gap <= reach
    pressing[e] = wp.where(near or slots.stored[e] > zero, 1, 0)
    if not near:
        return
    f = best.other - 1
    memory[e].share = best.share
    slots.contacts[e].near = 1
    slots.contacts[e].a = edges.ends[f][0]
    slots.contacts[e].b = edges.ends[f][1]
    slots.contacts[e].c = edges.ends[f][1]
    slots.contacts[e].weights = wp.vec3d(one - best.other_share, best.other_share, zero)
    slots.contacts[e].normal = best.normal
    slots.contacts[e].rise = best.rise
    inverse = edge_mass(edges, e, best.share, mass, ridges)
    inverse += edge_mass(edges, f, best.other_share, mass, ridges)
    slots.contacts[e].mass = one / inverse
    slots.contacts[e].thickness = stack.half[number] + stack.half[best.ply]
    pair = number * stack.half.shape[0] + best.ply
    beside = edges.sides[f][0]
    slots.contacts[e].rub = at_angle(law.friction, stack.rubs[pair], sheets.facets, i, beside, x)
    slots.contacts[e].pad.law = stack.pads[pair]
    slots.contacts[e].pad.area = (one - best.share) * stack.areas[i] + best.share * stack.areas[j]
    point = (one - best.share) * x[i] + best.share * x[j]
    jump = wp.max(before - best.gap, zero)
    allowance, taken = settled(
        law, laws, search, slots.contacts[e], x, point, slots.springs[e], jump, had, budget
    )
    slots.contacts[e].allowance = allowance
    slots.spent[e] = budget + taken
    lost[i] += wp.vec3d(zero, taken, zero)
    wp.atomic_max(deepest, pair, -best.gap - allowance)
    wp.atomic_max(largest_jump, pair, allowance)


@wp.kernel(enable_backward=False)
def find_edge_contacts(
    law: ContactLaw,
    laws: CompactionLaws,
    search: PlySearch,
    sheets: Sheets,
    number: int,
    folds: int,
    first: int,
    mass: wp.array(dtype=wp.float64),
    x: wp.array(dtype=wp.vec3d),
    hollows: wp.array(dtype=wp.vec2d),
    ridges: wp.array(dtype=wp.int32),
    memory: wp.array(dtype=EdgeMemory),
    slots: Slots,
    pressing: wp.array(dtype=wp.int32),
    watched: wp.array(dtype=wp.int32),
    touching: wp.array(dtype=wp.int32),
    lost: wp.array(dtype=wp.vec3d),
    deepest: wp.array(dtype=wp.float64),
    largest_jump: wp.array(dtype=wp.float64),
):
    """Find the ridge nearest to each ridge of a ply, on the side to which it sticks out.

    One thread a vertex, for the edges that begin there. An edge looks at the next ply there, at
    those beyond where that is not in sight, and where its own has folded at that. Between searches
    in which all ask it looks at the ridge that was nearest and at those beside it, once that may
    have come near.

    Args:
        law: contact law.
        laws: of compaction.
        search: how to look.
        sheets: the plies.
        number: of the ply.
        folds: 1 if it may touch itself.
        first: number of the first vertex.
        mass: shape [vertex] [kg].
        x: positions [m], shape [vertex].
        hollows: room on the hollow sides, above and below [m], shape [vertex].
        ridges: to which side edges stick out, shape [edge].
        memory: of the searches, shape [edge]; updated.
        slots: memory of the contacts, shape [edge]; these are overwritten.
        pressing: whether an edge may touch before the next search, shape [edge]; overwritten.
        watched: whether edges of a vertex are ridges or touch, shape [vertex].
        touching: whether they may touch before the next search, shape [vertex]; overwritten.
        lost: (friction, contact damping, mass damping) [J], shape [vertex]; accumulated.
        deepest: largest penetration so far [m], but for what is allowed, shape [ply · ply]; raised.
        largest_jump: largest penetration allowed so far [m], shape [ply · ply]; raised.
    """
    i = first + wp.tid()
    if watched[i] == 0:
        return
    touches = wp.int32(0)
    for e in range(sheets.edges.first_of_own[i], sheets.edges.first_of_own[i + 1]):
        touch_nearest(
            law,
            laws,
            search,
            sheets,
            number,
            folds,
            e,
            mass,
            x,
            hollows,
            ridges,
            memory,
            slots,
            pressing,
            lost,
            deepest,
            largest_jump,
        )
        touches = wp.max(touches, pressing[e])
    touching[i] = touches


@wp.kernel(enable_backward=False)
def add_edge_forces(
    law: ContactLaw,
    laws: CompactionLaws,
    edges: PlyEdges,
    first: int,
    x: wp.array(dtype=wp.vec3d),
    v: wp.array(dtype=wp.vec3d),
    touching: wp.array(dtype=wp.int32),
    pressing: wp.array(dtype=wp.int32),
    memory: wp.array(dtype=EdgeMemory),
    slots: Slots,
    f: wp.array(dtype=wp.vec3d),
    lost: wp.array(dtype=wp.vec3d),
):
    """Add the forces between edges and those that they touch to ``f``.

    One thread a vertex, for the edges that begin there.

    Args:
        law: contact law.
        laws: of compaction.
        edges: of all plies.
        first: number of the first vertex.
        x: positions [m], shape [vertex].
        v: velocities half a step ago [m/s], shape [vertex].
        touching: whether edges of a vertex may touch before the next search, shape [vertex].
        pressing: whether an edge may touch before the next search, shape [edge].
        memory: of the searches, shape [edge].
        slots: memory of the contacts, shape [edge]; updated.
        f: forces [N], shape [vertex]; accumulated.
        lost: (friction, contact damping, mass damping) [J], shape [vertex]; accumulated.
    """
    i = first + wp.tid()
    if touching[i] == 0:
        return
    for e in range(edges.first_of_own[i], edges.first_of_own[i + 1]):
        if pressing[e] == 1:
            j = edges.ends[e][1]
            second = memory[e].share
            share = wp.float64(1.0) - second
            point = share * x[i] + second * x[j]
            velocity = share * v[i] + second * v[j]
            pressed, force = press_slot(law, laws, i, e, point, velocity, x, v, slots, f, lost)
            if pressed:
                wp.atomic_add(f, i, share * force)
                wp.atomic_add(f, j, second * force)
