"""Contact of edges with edges, between plies and within one: where two folds cross each other.

Vertices against triangles let two sharp folds pass each other between their vertices. What holds
them is the pair of edges that stick out towards each other, each *ridge* the nearest place of its
own sheet: the direction between them lies between the normals of the facets on either side of both.
Only such pairs are held. On smooth plies there are none: one of two that lie on each other is
hollow where the other bulges. A ply's border is a ridge too, on both sides: it is nearest from
beside the ply.

A slot is an edge: it holds the ridge that comes nearest to it on the side to which it sticks out.
An edge belongs to its end of the lower number.
"""

import warp as wp

from ..sweep import Sweep
from .contact import CompactionLaws, ContactLaw
from .crossing import Crossing
from .edge_search import Look, Seen, Sheets, look_everywhere, look_round
from .on_ply import PlyContact, PlySearch, Slots, press_slot, radius_of, reach_of
from .ridges import PlyEdges, Ridges
from .settling import hold, let_go
from .yarn_angle import at_angle

HOLDERS = wp.constant(wp.float64(2.0))
"""Contacts that an edge bears at a time: its own, and that of the edge which it meets."""


@wp.struct
class EdgeMemory:
    """What the search of an edge remembers; zero at first."""

    other: wp.int32  # number of the nearest edge plus one, 0 if none was in sight
    ply: wp.int32  # of that one
    share: wp.float64  # of its second end where they are nearest
    way: wp.float64  # that ridges may come closer before one is near [m]


@wp.struct
class EdgeSlots:
    """What edges remember from search to search, and how deep they have been in each other."""

    memory: wp.array(dtype=EdgeMemory)  # of the searches, shape [edge]
    slots: Slots  # of the contacts, shape [edge]
    pressing: wp.array(dtype=wp.int32)  # 1 if it may touch before the next search, shape [edge]
    deepest: wp.array(dtype=wp.float64)  # so far, but for what is allowed [m], shape [ply · ply]
    jump: wp.array(dtype=wp.float64)  # largest penetration allowed so far [m], likewise


@wp.func
def edge_mass(sheets: Sheets, now: Ridges, e: int, share: wp.float64) -> wp.float64:
    """1/m [1/kg] with which a place of an edge meets others.

    Ridges at a vertex share its mass, each with those that bear on it: together their contacts
    take no more of the step than one of the vertex.
    """
    edges = sheets.edges
    inverse = wp.float64(0.0)
    for end in range(2):
        vertex = edges.ends[e][end]
        at_vertex = wp.float64(0.0)
        for k in range(edges.first_of_star[vertex], edges.first_of_star[vertex + 1]):
            if now.ways[edges.stars[k]] != 0:
                at_vertex += wp.float64(1.0)
        w = wp.where(end == 0, wp.float64(1.0) - share, share)
        inverse += w * w * HOLDERS * wp.max(at_vertex, wp.float64(1.0)) / sheets.mass[vertex]
    return inverse


@wp.func
def contact_of(
    law: ContactLaw, sheets: Sheets, now: Ridges, e: int, own: int, best: Crossing
) -> PlyContact:
    """The contact of an edge of ply ``own`` with a ridge; a triangle without a third corner."""
    one = wp.float64(1.0)
    edges = sheets.edges
    stack = sheets.stack
    f = best.other - 1
    i = edges.ends[e][0]
    j = edges.ends[e][1]
    pair = own * stack.half.shape[0] + best.ply
    found = PlyContact()
    found.a = edges.ends[f][0]
    found.b = edges.ends[f][1]
    found.c = edges.ends[f][1]
    found.weights = wp.vec3d(one - best.other_share, best.other_share, wp.float64(0.0))
    found.normal = best.normal
    found.rise = best.rise
    inverse = edge_mass(sheets, now, e, best.share)
    inverse += edge_mass(sheets, now, f, best.other_share)
    found.mass = one / inverse
    found.thickness = stack.half[own] + stack.half[best.ply]
    beside = edges.sides[f][0]
    found.rub = at_angle(law.friction, stack.rubs[pair], sheets.facets, i, beside, now.x)
    found.pad.law = stack.pads[pair]
    found.pad.area = (one - best.share) * stack.areas[i] + best.share * stack.areas[j]
    return found


@wp.func
def place_on(edges: PlyEdges, e: int, share: wp.float64, x: wp.array(dtype=wp.vec3d)) -> wp.vec3d:
    """Place on an edge, by the share of its second end [m]."""
    ends = edges.ends[e]
    return (wp.float64(1.0) - share) * x[ends[0]] + share * x[ends[1]]


@wp.func
def nearest_ridge(
    sheets: Sheets, now: Ridges, search: PlySearch, e: int, own: int, held: int, kept: EdgeSlots
) -> Crossing:
    """The ridge that an edge of ply ``own`` may touch, and remember what the edge has seen."""
    seen = Seen()
    seen.nearest = radius_of(search)
    look = Look()
    look.edge = e
    look.ply = own
    look.held = held
    look.last = kept.memory[e].other
    look.last_ply = kept.memory[e].ply
    look.radius = seen.nearest
    look.reach = reach_of(search)
    if now.ways[e] != 0 and search.asks == 1:
        seen = look_everywhere(sheets, now, look, seen)
        kept.memory[e].way = seen.nearest
    elif now.ways[e] != 0 and look.last > 0:
        seen = look_round(sheets, now, look, seen)
    if seen.best.other > 0:
        seen.other = seen.best.other
        seen.other_ply = seen.best.ply
    kept.memory[e].other = seen.other
    kept.memory[e].ply = seen.other_ply
    return seen.best


@wp.func
def touch_nearest(
    law: ContactLaw,
    laws: CompactionLaws,
    search: PlySearch,
    sheets: Sheets,
    now: Ridges,
    e: int,
    own: int,
    kept: EdgeSlots,
    lost: wp.array(dtype=wp.vec3d),
):
    """Make an edge's contact that with the nearest ridge, or none; else as `find_edge_contacts`."""
    reach = reach_of(search)
    kept.memory[e].way -= reach
    waits = now.ways[e] == 0 or (kept.memory[e].way > reach and search.asks == 0)
    if kept.pressing[e] == 0 and waits:
        return
    held = wp.where(kept.slots.contacts[e].near == 1, kept.memory[e].other, 0)
    point = place_on(sheets.edges, e, kept.memory[e].share, now.x)
    earlier = let_go(law, laws, kept.slots, e, now.x, point)
    best = nearest_ridge(sheets, now, search, e, own, held, kept)
    near = best.other > 0 and best.gap <= reach
    kept.pressing[e] = wp.where(near or kept.slots.stored[e] > wp.float64(0.0), 1, 0)
    if not near:
        return
    kept.memory[e].share = best.share
    found = contact_of(law, sheets, now, e, own, best)
    point = place_on(sheets.edges, e, best.share, now.x)
    i = sheets.edges.ends[e][0]
    allowed = hold(
        law, laws, search, kept.slots, e, found, now.x, point, best.gap, earlier, i, lost
    )
    pair = own * sheets.stack.half.shape[0] + best.ply
    wp.atomic_max(kept.deepest, pair, -best.gap - allowed)
    wp.atomic_max(kept.jump, pair, allowed)


@wp.kernel(enable_backward=False)
def find_edge_contacts(
    sweep: Sweep,
    law: ContactLaw,
    laws: CompactionLaws,
    search: PlySearch,
    sheets: Sheets,
    now: Ridges,
    own: int,
    watched: wp.array(dtype=wp.int32),
    kept: EdgeSlots,
    touching: wp.array(dtype=wp.int32),
    lost: wp.array(dtype=wp.vec3d),
):
    """Find the ridge nearest to each ridge of a ply, on the side to which it sticks out.

    A sweep over vertices, for the edges that begin there. An edge looks at the next ply there, on
    a border on both sides, at those beyond where that is not in sight, and where its own has folded
    at that. Between searches
    in which all ask it looks at the ridge that was nearest and at those beside it, once that may
    have come near.

    Args:
        sweep: numbers of the vertices.
        law: contact law.
        laws: of compaction.
        search: how to look.
        sheets: the plies.
        now: where their ridges are.
        own: number of the ply.
        watched: whether edges of a vertex are ridges or touch, shape [vertex].
        kept: what edges remember; updated.
        touching: whether they may touch before the next search, shape [vertex]; overwritten.
        lost: (friction, contact damping, mass damping) [J], shape [vertex]; accumulated.
    """
    for i in range(sweep.first + wp.tid(), sweep.end, sweep.threads):
        if watched[i] == 0:
            continue
        touches = wp.int32(0)
        for e in range(sheets.edges.first_of_own[i], sheets.edges.first_of_own[i + 1]):
            touch_nearest(law, laws, search, sheets, now, e, own, kept, lost)
            touches = wp.max(touches, kept.pressing[e])
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
    kept: EdgeSlots,
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
        kept: what edges remember; its contacts are updated.
        f: forces [N], shape [vertex]; accumulated.
        lost: (friction, contact damping, mass damping) [J], shape [vertex]; accumulated.
    """
    i = first + wp.tid()
    if touching[i] == 0:
        return
    for e in range(edges.first_of_own[i], edges.first_of_own[i + 1]):
        if kept.pressing[e] == 1:
            second = kept.memory[e].share
            share = wp.float64(1.0) - second
            point = place_on(edges, e, second, x)
            velocity = place_on(edges, e, second, v)
            pressed, force = press_slot(law, laws, i, e, point, velocity, x, v, kept.slots, f, lost)
            if pressed:
                wp.atomic_add(f, i, share * force)
                wp.atomic_add(f, edges.ends[e][1], second * force)
