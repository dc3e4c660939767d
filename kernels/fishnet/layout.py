"""The kernels that lay a net out: generators first, then the crossovers between them.

They share the ways over facets, and so stand in one file, which is compiled at once.
"""

import warp as wp

from .crossovers import place_node
from .facets import Facets, Place
from .generators import lay_half, lay_half_in_plane
from .nodes import Net
from .strips import Strips


@wp.kernel(enable_backward=False)
def compute_generators(
    facets: Facets,
    net: Net,
    middle: wp.vec2i,
    start: Place,
    angles: wp.array(dtype=wp.float64),
    counts: wp.array(dtype=wp.int32),
    turns: wp.array2d(dtype=wp.float64),
    spacing: wp.float64,
    strips: Strips,
):
    """Lay the generators out from the start, straight but for given turns; one thread a half.

    Args:
        facets: of the surface.
        net: changed.
        middle: node of the start.
        start: its place.
        angles: directions in which the halves leave it [rad], shape [4].
        counts: nodes of the halves after the start, shape [4].
        turns: of the yarn at each node, to its left [rad], shape [4, node].
        spacing: of the net [m].
        strips: room for each thread.
    """
    half = wp.tid()
    thread = wp.min(half, strips.counts.shape[0] - 1)
    lay_half(facets, net, middle, start, angles, counts, turns, spacing, strips, half, thread)


@wp.kernel(enable_backward=False)
def compute_plane_generators(
    facets: Facets,
    net: Net,
    middle: wp.vec2i,
    start: Place,
    normals: wp.array(dtype=wp.vec3d),
    counts: wp.array(dtype=wp.int32),
    spacing: wp.float64,
    strips: Strips,
):
    """Lay the generators out along sections by planes through the start; one thread a half.

    Args:
        facets: of the surface.
        net: changed.
        middle: node of the start.
        start: its place.
        normals: of the planes, to the left of each half, shape [4].
        counts: nodes of the halves after the start, shape [4].
        spacing: of the net [m].
        strips: room for each thread.
    """
    half = wp.tid()
    thread = wp.min(half, strips.counts.shape[0] - 1)
    lay_half_in_plane(facets, net, middle, start, normals, counts, spacing, strips, half, thread)


@wp.kernel(enable_backward=False)
def compute_crossovers(
    facets: Facets,
    net: Net,
    middle: wp.vec2i,
    spacing: wp.float64,
    yarn_angle: wp.float64,
    limit: wp.float64,
    strips: Strips,
):
    """Place all nodes between the generators, row by row; one thread a quadrant.

    Args:
        facets: of the surface.
        net: whose generators are placed; changed.
        middle: node of the start.
        spacing: of the net [m].
        yarn_angle: from warp to weft in the flat ply [rad].
        limit: largest shear angle [rad].
        strips: room for each thread; for one, where threads take turns as on the processor.
    """
    quadrant = wp.tid()
    thread = wp.min(quadrant, strips.counts.shape[0] - 1)
    d = wp.vec2i(1 - 2 * (quadrant % 2), 1 - 2 * (quadrant // 2))
    along = middle[0]
    across = middle[1]
    if d[0] > 0:
        along = net.status.shape[0] - 1 - middle[0]
    if d[1] > 0:
        across = net.status.shape[1] - 1 - middle[1]
    for m in range(1, across + 1):
        for k in range(1, along + 1):
            i = middle[0] + d[0] * k
            j = middle[1] + d[1] * m
            place_node(facets, net, i, j, d, middle, spacing, yarn_angle, limit, strips, thread)
