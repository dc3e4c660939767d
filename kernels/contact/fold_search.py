"""Other folds of a vertex's own ply: what counts as one, by the flat ply, and walks over it."""

import warp as wp

from .facets import MOST_MOVES, NearestFacet, PlyFacets, nearest_on_facet, no_facet
from .surface import weighted


@wp.struct
class FlatPly:
    """Where vertices lie on the flat plies."""

    places: wp.array(dtype=wp.vec3d)  # m, shape [vertex]
    apart: wp.array(dtype=wp.float64)  # from which distance on points may touch [m], shape [vertex]
    areas: wp.array(dtype=wp.float64)  # that contacts of vertices stand for [m²], shape [vertex]


@wp.func
def is_another_fold(flat: FlatPly, facets: PlyFacets, i: int, there: NearestFacet) -> bool:
    """Whether a place is so far from a vertex along the flat ply that they may touch."""
    at = facets.corners[there.facet]
    place = weighted(there.weights, flat.places[at[0]], flat.places[at[1]], flat.places[at[2]])
    return wp.length_sq(place - flat.places[i]) >= flat.apart[i] * flat.apart[i]


@wp.func
def is_all_near(flat: FlatPly, facets: PlyFacets, i: int, facet: int) -> bool:
    """Whether no place of a facet is another fold for a vertex: its corners are too near for it.

    They are by more than rounding, so that `is_another_fold` says the same of every place.
    """
    at = facets.corners[facet]
    most = wp.float64(0.0)
    for k in range(3):
        most = wp.max(most, wp.length_sq(flat.places[at[k]] - flat.places[i]))
    return most < wp.float64(1.0 - 1.0e-9) * flat.apart[i] * flat.apart[i]


@wp.func
def walk_on_fold(
    flat: FlatPly,
    facets: PlyFacets,
    i: int,
    start: int,
    x: wp.array(dtype=wp.vec3d),
) -> NearestFacet:
    """Nearest place for vertex i that a walk from facet ``start`` finds, none of its own fold."""
    here = start
    best = nearest_on_facet(facets, here, x, x[i])
    if not is_another_fold(flat, facets, i, best):
        best = no_facet()
    moves = wp.int32(0)
    while moves < MOST_MOVES:
        at = facets.corners[here]
        for corner in range(3):
            first = facets.first_of_fan[at[corner]]
            for k in range(first, facets.first_of_fan[at[corner] + 1]):
                there = nearest_on_facet(facets, facets.fans[k], x, x[i])
                if best.facet < 0 or wp.length_sq(there.offset) < wp.length_sq(best.offset):
                    if is_another_fold(flat, facets, i, there):
                        best = there
        stays = best.facet < 0 or best.facet == here
        moves = wp.where(stays, MOST_MOVES, moves + 1)
        here = wp.where(stays, here, best.facet)
    return best


@wp.func
def is_same_place(
    flat: FlatPly, facets: PlyFacets, i: int, one: NearestFacet, other: NearestFacet
) -> bool:
    """Whether two places are of one fold, nearer to each other than what vertex i may touch."""
    if one.facet < 0 or other.facet < 0:
        return False
    a = facets.corners[one.facet]
    b = facets.corners[other.facet]
    p = flat.places
    between = weighted(one.weights, p[a[0]], p[a[1]], p[a[2]])
    between -= weighted(other.weights, p[b[0]], p[b[1]], p[b[2]])
    return wp.length_sq(between) < flat.apart[i] * flat.apart[i]
