"""Geodesics between two places that a strip joins.

A strip is unfolded into the plane of its first facet. Where its end is in sight of its start the
way is straight; else it is pulled tight, and where it bends round a vertex that it had better pass
on the other side, the strip is turned there. What is left is locally shortest; it passes through
vertices only where more than a full turn meets in them.
"""

import warp as wp

from .facets import (
    Facets,
    Place,
    angle_of,
    before_corner,
    corner_of,
    cross2,
    next_corner,
    vertex_of,
)
from .funnel import ALONG_BORDER, TANGLED, Path, pull_tight
from .strips import AT_BORDER, OVERFULL, SPARE_STRIP, WALKED, Strips, push_one

GRAZED = wp.constant(wp.float64(1.0e-14))
ASLANT = wp.constant(wp.float64(1.0e-11))
"""By how much of its length, and of the distance to a vertex, a straight way may miss that vertex
on the wrong side [-]: rounding, where it runs along an edge or through a vertex."""
MOST_TURNED = wp.constant(1000)
"""Vertices round which a strip is turned; each makes the way shorter."""


@wp.struct
class Corners:
    """Corners of a facet in the unfolded strip [m]."""

    a: wp.vec2d
    b: wp.vec2d
    c: wp.vec2d


@wp.func
def pick(corners: Corners, k: int) -> wp.vec2d:
    """One of them."""
    if k == 0:
        return corners.a
    if k == 1:
        return corners.b
    return corners.c


@wp.func
def arranged(k: int, first: wp.vec2d, second: wp.vec2d, third: wp.vec2d) -> Corners:
    """Corners of a facet from those at k, after it and after that."""
    corners = Corners()
    if k == 0:
        corners.a = first
        corners.b = second
        corners.c = third
    elif k == 1:
        corners.a = third
        corners.b = first
        corners.c = second
    else:
        corners.a = second
        corners.b = third
        corners.c = first
    return corners


@wp.func
def unfold(facets: Facets, facet: int, strips: Strips, thread: int, which: int) -> Corners:
    """Unfold a strip into the plane of its first facet; return the corners of its last."""
    corners = Corners()
    corners.a = corner_of(facets, facet, 0)
    corners.b = corner_of(facets, facet, 1)
    corners.c = corner_of(facets, facet, 2)
    for i in range(strips.counts[thread, which]):
        half_edge = strips.edges[thread, which, i]
        k = half_edge % 3
        start = pick(corners, k)
        end = pick(corners, next_corner(k))
        strips.right[thread, i] = start
        strips.left[thread, i] = end
        twin = facets.twins[half_edge]
        side = start - end
        apex = facets.apexes[twin]
        third = end + apex[0] * side + apex[1] * wp.vec2d(-side[1], side[0])
        corners = arranged(twin % 3, end, start, third)
    return corners


@wp.func
def in_sight(start: wp.vec2d, goal: wp.vec2d, strips: Strips, thread: int, count: int) -> bool:
    """Whether a straight line passes between the ends of all half-edges, or through them."""
    way = goal - start
    far = wp.length(way)
    for i in range(count):
        left = strips.left[thread, i] - start
        right = strips.right[thread, i] - start
        if cross2(way, left) < -far * (GRAZED * far + ASLANT * wp.length(left)):
            return False
        if cross2(way, right) > far * (GRAZED * far + ASLANT * wp.length(right)):
            return False
    return True


@wp.func
def end_of(facets: Facets, half_edge: int, side: int) -> int:
    """Vertex at the left (1) or right (−1) end of a crossed half-edge."""
    k = half_edge % 3
    if side > 0:
        k = next_corner(k)
    return vertex_of(facets, half_edge // 3, k)


@wp.func
def turn_round(
    facets: Facets, strips: Strips, thread: int, which: int, crossing: int, side: int
) -> int:
    """Lead a strip round the other side of a vertex; return how that walk ended.

    Args:
        facets: of the surface.
        strips: to change.
        thread: whose.
        which: strip.
        crossing: one of its half-edges that ends at the vertex.
        side: on which the vertex lies, 1 for left.
    """
    count = strips.counts[thread, which]
    vertex = end_of(facets, strips.edges[thread, which, crossing], side)
    first = crossing
    for _ in range(count):
        if first == 0:
            break
        if end_of(facets, strips.edges[thread, which, first - 1], side) != vertex:
            break
        first = first - 1
    last = crossing
    for _ in range(count):
        if last + 1 == count:
            break
        if end_of(facets, strips.edges[thread, which, last + 1], side) != vertex:
            break
        last = last + 1
    strips.counts[thread, SPARE_STRIP] = 0
    fits = wp.int32(1)
    for i in range(first):
        fits = fits * push_one(facets, strips, thread, SPARE_STRIP, strips.edges[thread, which, i])
    half_edge = strips.edges[thread, which, first]
    goal = facets.twins[strips.edges[thread, which, last]] // 3
    facet = half_edge // 3
    k = half_edge % 3
    for _ in range(strips.edges.shape[2]):
        if facet == goal:
            break
        if side > 0:
            k = next_corner(k)
        else:
            k = before_corner(k)
        over = 3 * facet + k
        twin = facets.twins[over]
        if twin < 0:
            return AT_BORDER
        fits = fits * push_one(facets, strips, thread, SPARE_STRIP, over)
        facet = twin // 3
        k = twin % 3
    for i in range(last + 1, count):
        fits = fits * push_one(facets, strips, thread, SPARE_STRIP, strips.edges[thread, which, i])
    if fits == 0 or facet != goal:
        return OVERFULL
    for i in range(strips.counts[thread, SPARE_STRIP]):
        strips.edges[thread, which, i] = strips.edges[thread, SPARE_STRIP, i]
    strips.counts[thread, which] = strips.counts[thread, SPARE_STRIP]
    return WALKED


@wp.func
def straighten(
    facets: Facets, start: Place, goal: Place, strips: Strips, thread: int, which: int
) -> Path:
    """The geodesic between two places that a strip joins; the strip is led along it.

    Args:
        facets: of the surface.
        start: in the strip's first facet.
        goal: in its last one.
        strips: the strips.
        thread: whose.
        which: strip.
    """
    path = Path()
    for _ in range(MOST_TURNED):
        corners = unfold(facets, start.facet, strips, thread, which)
        along = wp.normalize(corners.b - corners.a)
        to = corners.a + goal.at[0] * along + goal.at[1] * wp.vec2d(-along[1], along[0])
        if in_sight(start.at, to, strips, thread, strips.counts[thread, which]):
            path = Path()
            path.bend = -1
            path.length = wp.length(to - start.at)
            path.leave = angle_of(to - start.at)
            path.arrive = path.leave
        else:
            path = pull_tight(facets, start.at, to, strips, thread, which)
        path.arrive = path.arrive - angle_of(along)
        if path.bend < 0:
            return path
        turned = turn_round(facets, strips, thread, which, path.bend, path.side)
        if turned != WALKED:
            path.ended = TANGLED
            if turned == AT_BORDER:
                path.ended = ALONG_BORDER
            return path
    path.ended = TANGLED
    return path
