"""Nodes of a net: where crossovers lie, and how their yarns leave and arrive.

Node (i, j) is the crossover i yarns along the warp from the middle of the grid and j along the
weft. A segment of yarn belongs to the one of its two nodes that is farther from the start.
"""

import warp as wp

from .facets import Place

OPEN = wp.constant(0)
PLACED = wp.constant(1)
BORDER = wp.constant(2)
SHEARED = wp.constant(3)
COARSE = wp.constant(4)
FINE = wp.constant(5)
BEHIND = wp.constant(6)
CUT_OFF = wp.constant(7)
"""What became of a node: not looked for; there; beyond the surface's border; nowhere at the spacing
from both neighbours, or sheared past the limit; not found, so that the spacing is too coarse for
the surface; more facets in a yarn segment than fit; without neighbours because of a border; without
neighbours for another reason."""


@wp.struct
class Net:
    """Arrays over the nodes, shape [node along warp, node along weft]."""

    status: wp.array2d(dtype=wp.int32)
    facets: wp.array2d(dtype=wp.int32)
    places: wp.array2d(dtype=wp.vec2d)  # in the facet [m]
    warp_leave: wp.array2d(dtype=wp.float64)  # direction of the warp segment at its near end [rad]
    warp_arrive: wp.array2d(dtype=wp.float64)  # … and at this node
    weft_leave: wp.array2d(dtype=wp.float64)
    weft_arrive: wp.array2d(dtype=wp.float64)
    seen: wp.array2d(dtype=wp.vec3d)  # where a search that failed had come to [m]


@wp.func
def place_of(net: Net, i: int, j: int) -> Place:
    """Place of a node."""
    place = Place()
    place.facet = net.facets[i, j]
    place.at = net.places[i, j]
    return place


@wp.func
def put(net: Net, i: int, j: int, place: Place):
    """Set a node."""
    net.facets[i, j] = place.facet
    net.places[i, j] = place.at
    net.status[i, j] = PLACED
