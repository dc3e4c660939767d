"""Where a ply may have folded onto itself: patches of it, by their boxes and by how they bend.

Two patches that do not lie beside each other may touch where their boxes come near. Two that do, or
one in itself, where their triangles' normals turn by so much that the ply may come back on itself.
Elsewhere no vertex need be held against its own ply. At holes, notches and slots vertices always
are: their lips may lie on each other without a bend.
"""

import warp as wp

from .facets import PlyFacets
from .on_ply import PlySearch, radius_of

TURN = wp.constant(wp.float64(1.4))
"""Angle between any two normals of patches beside each other up to which they cannot touch [rad]:
up to 90° two points stay 0.7 of their distance along the ply apart."""


@wp.struct
class Patches:
    """Patches of all plies, one after the other: where they lie on the flat ply, and now."""

    first: wp.array(dtype=wp.int32)  # where a patch's triangles begin, shape [patch + 1]
    triangles: wp.array(dtype=wp.int32)  # numbers of the triangles, shape [triangle]
    column: wp.array(dtype=wp.int32)  # of the grid on the flat ply, shape [patch]
    row: wp.array(dtype=wp.int32)  # likewise
    gaping: wp.array(dtype=wp.int32)  # 1 at borders whose lips may lie on each other, [patch]
    of_vertex: wp.array(dtype=wp.int32)  # patch of each vertex, shape [vertex]
    low: wp.array(dtype=wp.vec3d)  # corner of the box now [m], shape [patch]
    high: wp.array(dtype=wp.vec3d)  # the opposite one [m], likewise
    normal: wp.array(dtype=wp.vec3d)  # mean, of unit length, likewise
    spread: wp.array(dtype=wp.float64)  # largest angle to the mean normal [rad], likewise
    folded: wp.array(dtype=wp.int32)  # 1 if it may touch its ply, as marked last, likewise


@wp.kernel(enable_backward=False)
def bound_patches(
    facets: PlyFacets, x: wp.array(dtype=wp.vec3d), first_patch: int, patches: Patches
):
    """Find each patch's box, mean normal and spread of normals; one thread a patch.

    Args:
        facets: of all plies.
        x: positions [m], shape [vertex].
        first_patch: of the ply.
        patches: what is found here is written into it.
    """
    p = first_patch + wp.tid()
    begin = patches.first[p]
    end = patches.first[p + 1]
    low = x[facets.corners[patches.triangles[begin]][0]]
    high = low
    normal = wp.vec3d()
    for k in range(begin, end):
        at = facets.corners[patches.triangles[k]]
        a = x[at[0]]
        b = x[at[1]]
        c = x[at[2]]
        low = wp.min(low, wp.min(a, wp.min(b, c)))
        high = wp.max(high, wp.max(a, wp.max(b, c)))
        normal += wp.cross(b - a, c - a)
    normal = wp.normalize(normal)
    least = wp.float64(1.0)
    for k in range(begin, end):
        at = facets.corners[patches.triangles[k]]
        n = wp.normalize(wp.cross(x[at[1]] - x[at[0]], x[at[2]] - x[at[0]]))
        least = wp.min(least, wp.dot(n, normal))
    patches.low[p] = low
    patches.high[p] = high
    patches.normal[p] = normal
    patches.spread[p] = wp.acos(wp.clamp(least, -wp.float64(1.0), wp.float64(1.0)))


@wp.func
def may_touch(patches: Patches, p: int, q: int, margin: wp.float64) -> bool:
    """Whether two patches may touch themselves, or each other, before the next search."""
    beside = (
        wp.abs(patches.column[p] - patches.column[q]) <= 1
        and wp.abs(patches.row[p] - patches.row[q]) <= 1
    )
    if beside:
        between = wp.dot(patches.normal[p], patches.normal[q])
        turn = wp.acos(wp.clamp(between, -wp.float64(1.0), wp.float64(1.0)))
        return turn + patches.spread[p] + patches.spread[q] > TURN
    apart = wp.max(patches.low[p] - patches.high[q], patches.low[q] - patches.high[p])
    return wp.max(apart) < margin


@wp.kernel(enable_backward=False)
def mark_folds(
    patches: Patches,
    first_patch: int,
    count: int,
    search: PlySearch,
):
    """Say of each patch of a ply whether it may touch the ply; one thread a patch.

    It must be known how far this search looks, and only where points ask in it is there anything to
    say: then nothing has closed since they asked.

    Args:
        patches: as bounded; whether they may is written into it.
        first_patch: of the ply.
        count: of its patches.
        search: how to look.
    """
    p = first_patch + wp.tid()
    if search.paces[search.part].closed > wp.float64(0.0):
        return
    found = patches.gaping[p]
    margin = radius_of(search)
    for q in range(first_patch, first_patch + count):
        if found == 0 and may_touch(patches, p, q, margin):
            found = 1
    patches.folded[p] = found
