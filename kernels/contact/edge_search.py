"""Which ridge is nearest to an edge: by queries of the plies' meshes, or round the last one."""

import warp as wp

from .crossing import Crossing, apart, cross_at
from .facets import PlyFacets
from .fold_search import FlatPly
from .folds import Patches
from .ply_contact import PlyStack
from .ridges import BOTH, PlyEdges, Ridges, sticks_out
from .surface import to_single


@wp.struct
class Sheets:
    """All plies as their edges search them."""

    facets: PlyFacets
    edges: PlyEdges
    flat: FlatPly
    stack: PlyStack
    patches: Patches
    folds: wp.array(dtype=wp.int32)  # 1 if it may touch itself, shape [ply]
    mass: wp.array(dtype=wp.float64)  # kg, shape [vertex]


@wp.struct
class Look:
    """An edge that looks for others."""

    edge: wp.int32
    ply: wp.int32  # its own
    held: wp.int32  # number of the edge that it has held so far plus one, 0 for none
    last: wp.int32  # of the one that was nearest last plus one, 0 for none
    last_ply: wp.int32  # the ply of that
    radius: wp.float64  # how far queries look [m]
    reach: wp.float64  # gap up to which a ridge is near [m]


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
def way_to(now: Ridges, look: Look, ply: int) -> int:
    """To which side of its own ply an edge looks for another ply, or for its own."""
    if look.ply == ply:
        return now.ways[look.edge]
    return wp.where(ply > look.ply, 1, -1)


@wp.func
def may_meet(sheets: Sheets, now: Ridges, look: Look, f: int, ply: int) -> bool:
    """Whether another edge is a ridge that may touch the one that looks.

    Plies meet in their order: the upper one's edges those that stick out upwards from the lower
    one. In one ply borders are left to its vertices.
    """
    e = look.edge
    if look.ply == ply:
        if now.ways[f] == 0 or now.ways[f] == BOTH or now.ways[e] == BOTH:
            return False
        return are_another_fold(sheets.flat, sheets.edges, e, f)
    way = way_to(now, look, ply)
    return sticks_out(now, e, way) and sticks_out(now, f, -way)


@wp.func
def look_at_edge(sheets: Sheets, now: Ridges, look: Look, f: int, ply: int, seen: Seen) -> Seen:
    """What an edge sees, another edge besides what it has seen already.

    Args:
        sheets: the plies.
        now: where the ridges are.
        look: who looks.
        f: the other edge.
        ply: number of that one's ply.
        seen: so far.
    """
    if not may_meet(sheets, now, look, f, ply):
        return seen
    e = look.edge
    edges = sheets.edges
    thickness = sheets.stack.half[look.ply] + sheets.stack.half[ply]
    p = now.x[edges.ends[e][0]]
    q = now.x[edges.ends[f][0]]
    gap = apart(p, now.x[edges.ends[e][1]] - p, q, now.x[edges.ends[f][1]] - q) - thickness
    if gap < seen.nearest:
        seen.nearest = gap
        seen.other = f + 1
        seen.other_ply = ply
    if gap < look.reach:
        rooms = wp.where(look.ply == ply, wp.float64(0.0), wp.float64(1.0))
        held = look.held == f + 1
        way = way_to(now, look, ply)
        back = wp.where(look.ply == ply, now.ways[f], -way)
        there = cross_at(sheets.facets, edges, now, e, way, f, back, held, thickness, rooms)
        if there.other > 0 and (seen.best.other == 0 or there.gap < seen.best.gap):
            seen.best = there
            seen.best.ply = ply
    return seen


@wp.func
def look_at_ply(sheets: Sheets, now: Ridges, look: Look, ply: int, seen: Seen) -> Seen:
    """What an edge sees of a ply within its radius; else as `look_at_edge`."""
    edges = sheets.edges
    p = now.x[edges.ends[look.edge][0]]
    q = now.x[edges.ends[look.edge][1]]
    margin = wp.vec3d(look.radius, look.radius, look.radius)
    low = to_single(wp.min(p, q) - margin)
    high = to_single(wp.max(p, q) + margin)
    query = wp.mesh_query_aabb(sheets.stack.meshes[ply], low, high)
    for face in query:
        facet = sheets.stack.first_triangle[ply] + face
        seen.ply = 1
        for corner in range(3):
            f = edges.of_triangle[facet][corner]
            if edges.sides[f][0] == facet:  # each edge once
                seen = look_at_edge(sheets, now, look, f, ply, seen)
    return seen


@wp.func
def look_one_way(sheets: Sheets, now: Ridges, look: Look, way: int, seen: Seen) -> Seen:
    """What a ridge sees of the next ply in sight on a side, +1 above it, −1 below."""
    count = sheets.stack.half.shape[0]
    ply = look.ply + way
    seen.ply = 0
    while ply >= 0 and ply < count:
        seen = look_at_ply(sheets, now, look, ply, seen)
        ply = wp.where(seen.ply == 1, count, ply + way)
    return seen


@wp.func
def look_everywhere(sheets: Sheets, now: Ridges, look: Look, seen: Seen) -> Seen:
    """What a ridge sees of the next ply in sight on its side, and of its own where that folded."""
    e = look.edge
    for way in range(-1, 2, 2):
        if sticks_out(now, e, way):
            seen = look_one_way(sheets, now, look, way, seen)
    patch = sheets.patches.of_vertex[sheets.edges.ends[e][0]]
    folded = sheets.folds[look.ply] == 1 and sheets.patches.folded[patch] == 1
    if folded and now.ways[e] != BOTH:  # borders may not meet their own ply
        seen = look_at_ply(sheets, now, look, look.ply, seen)
    return seen


@wp.func
def look_round(sheets: Sheets, now: Ridges, look: Look, seen: Seen) -> Seen:
    """What a ridge sees of the last nearest one, and of those that share an end with it."""
    edges = sheets.edges
    last = look.last - 1
    for end in range(2):
        vertex = edges.ends[last][end]
        for k in range(edges.first_of_star[vertex], edges.first_of_star[vertex + 1]):
            f = edges.stars[k]
            if end == 0 or f != last:
                seen = look_at_edge(sheets, now, look, f, look.last_ply, seen)
    return seen
