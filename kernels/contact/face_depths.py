"""How deep places of the plies lie in tools, as contact sees these."""

import warp as wp

from ..sweep import Sweep
from .surface import weighted
from .tool_contact import (
    ToolPlane,
    ToolSurfaces,
    is_near,
    nearest_facet,
    no_plane,
    plane_gap,
    tangent_plane,
)


@wp.func
def plane_near(
    surfaces: ToolSurfaces,
    tool: int,
    at: wp.vec3d,
    half: wp.float64,
    radius: wp.float64,
    beside: ToolPlane,
) -> ToolPlane:
    """Plane of a tool near a place in its frame, on the side on which a place beside it lies."""
    plane = no_plane()
    facet = nearest_facet(surfaces, tool, at, radius, radius)
    if facet >= 0:
        zero = wp.float64(0.0)
        held = is_near(beside)
        plane, _distance = tangent_plane(
            surfaces, tool, facet, at, half, radius, zero, held, beside
        )
    return plane


@wp.kernel(enable_backward=False)
def find_vertex_planes(
    sweep: Sweep,
    surfaces: ToolSurfaces,
    tool: int,
    turned: wp.mat33d,
    shift: wp.vec3d,
    half: wp.array(dtype=wp.float64),
    radius: wp.float64,
    x: wp.array(dtype=wp.vec3d),
    planes: wp.array(dtype=ToolPlane),
    depths: wp.array(dtype=wp.float64),
):
    """How far vertices reach into a tool, and its planes there; a sweep over vertices.

    Args:
        sweep: numbers of the vertices.
        surfaces: the tools' facets.
        tool: number of the tool.
        turned: its rotation.
        shift: its translation [m].
        half: half the thickness of the ply [m], shape [vertex].
        radius: how far to look [m].
        x: positions [m], shape [vertex].
        planes: shape [vertex]; overwritten.
        depths: of the ply's side below the tool's surface, 0 where it is not in it [m],
            shape [vertex]; overwritten.
    """
    for i in range(sweep.first + wp.tid(), sweep.end, sweep.threads):
        at = wp.transpose(turned) * (x[i] - shift)
        plane = plane_near(surfaces, tool, at, half[i], radius, no_plane())
        if surfaces.open[tool] == 1 and is_near(plane) and plane_gap(plane, at) < -half[i]:
            plane.normal = (
                -plane.normal
            )  # it is on the sheet's other side, no deeper than half in it
            plane.level = wp.float64(2.0) * half[i] - plane.level
        planes[i] = plane
        depths[i] = wp.float64(0.0)
        if is_near(plane):
            depths[i] = wp.max(-plane_gap(plane, at), wp.float64(0.0))


@wp.kernel(enable_backward=False)
def find_face_depths(
    sweep: Sweep,
    surfaces: ToolSurfaces,
    tool: int,
    turned: wp.mat33d,
    shift: wp.vec3d,
    half: wp.array(dtype=wp.float64),
    radius: wp.float64,
    x: wp.array(dtype=wp.vec3d),
    planes: wp.array(dtype=ToolPlane),
    corners: wp.array(dtype=wp.vec3i),
    weights: wp.array(dtype=wp.vec3d),
    depths: wp.array(dtype=wp.float64),
):
    """How far places between vertices reach into a tool; a sweep over places.

    Args:
        sweep: numbers of the places.
        surfaces: the tools' facets.
        tool: number of the tool.
        turned: its rotation.
        shift: its translation [m].
        half: half the thickness of the ply [m], shape [vertex].
        radius: how far to look [m].
        x: positions [m], shape [vertex].
        planes: of the tool near the vertices, which say on which side of an open tool the place
            is, shape [vertex].
        corners: vertices of the triangle there, shape [place].
        weights: of these, shape [place].
        depths: of the ply's side below the tool's surface, 0 where it is not in it, or where no
            corner is near [m], shape [place]; overwritten.
    """
    for k in range(sweep.first + wp.tid(), sweep.end, sweep.threads):
        depths[k] = wp.float64(0.0)
        corner = corners[k]
        beside = no_plane()
        for c in range(3):
            if not is_near(beside):
                beside = planes[corner[c]]
        if not is_near(beside):
            continue
        place = weighted(weights[k], x[corner[0]], x[corner[1]], x[corner[2]])
        at = wp.transpose(turned) * (place - shift)
        plane = plane_near(surfaces, tool, at, half[corner[0]], radius, beside)
        if is_near(plane):
            depths[k] = wp.max(-plane_gap(plane, at), wp.float64(0.0))
