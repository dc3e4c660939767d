"""Friction between plies by the angle between the warp yarns that touch, and their warmth."""

import warp as wp

from .facets import PlyFacets
from .friction import ANGLE, TABLES, FrictionLaws, Rub, shifts_with_heat, table_factor


@wp.func
def warp_of(
    laws: FrictionLaws, facets: PlyFacets, facet: int, x: wp.array(dtype=wp.vec3d)
) -> wp.vec3d:
    """Unit direction of the warp yarns of a triangle."""
    at = facets.corners[facet]
    d = laws.warps[facet]
    return wp.normalize(d[0] * (x[at[1]] - x[at[0]]) + d[1] * (x[at[2]] - x[at[0]]))


@wp.func
def warp_at(
    laws: FrictionLaws, facets: PlyFacets, vertex: int, x: wp.array(dtype=wp.vec3d)
) -> wp.vec3d:
    """Unit direction of the warp yarns at a vertex, the mean of its triangles'."""
    mean = wp.vec3d()
    for k in range(facets.first_of_fan[vertex], facets.first_of_fan[vertex + 1]):
        mean += warp_of(laws, facets, facets.fans[k], x)
    return wp.normalize(mean)


@wp.func
def at_angle(
    laws: FrictionLaws,
    rub: Rub,
    facets: PlyFacets,
    i: int,
    facet: int,
    x: wp.array(dtype=wp.vec3d),
) -> Rub:
    """Friction of vertex i on a triangle, by the angle between their yarns and their warmth now.

    Args:
        laws: all laws.
        rub: of the interface.
        facets: of all plies.
        i: the vertex.
        facet: the triangle.
        x: positions [m], shape [vertex].
    """
    turned = Rub()
    turned.coefficient = rub.coefficient
    turned.law = rub.law
    turned.viscosity = rub.viscosity
    if shifts_with_heat(laws, rub):
        at = facets.corners[facet]
        there = (laws.shifts[at[0]] + laws.shifts[at[1]] + laws.shifts[at[2]]) / wp.float64(3.0)
        turned.viscosity *= wp.float64(0.5) * (laws.shifts[i] + there)
    if rub.law > 0:
        first = (rub.law - 1) * TABLES + ANGLE
        if laws.first[first] < laws.first[first + 1]:
            cosine = wp.abs(wp.dot(warp_at(laws, facets, i, x), warp_of(laws, facets, facet, x)))
            angle = wp.degrees(wp.acos(wp.min(cosine, wp.float64(1.0))))
            turned.coefficient *= table_factor(laws, rub.law - 1, ANGLE, angle)
    return turned
