"""Rigid tools on a device: their facets, and how far these stand off the surface."""

from __future__ import annotations

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
import warp as wp

from warpdrape.contact.adjacency import across_edges, border_bits, edge_bits, facet_hollows
from warpdrape.contact.friction import rubs
from warpdrape.kernels.contact.tool_facets import ToolSurfaces
from warpdrape.setup import Setup
from warpdrape.tools.tool import Tool

SMOOTH = 0.9999
"""Cosine between two facets' normals from which they count as one plane [-]."""


def tool_surfaces(scene: Setup, device: str) -> tuple[tuple[wp.Mesh, ...], ToolSurfaces]:
    """Query meshes of the tools, each in its own frame, and their facets for the kernels."""
    meshes = tuple(
        wp.Mesh(
            wp.array(tool.vertices, dtype=wp.vec3f, device=device),
            wp.array(np.ravel(tool.triangles), dtype=wp.int32, device=device),
        )
        for tool in scene.tools
    )
    facets = [facets_of(tool) for tool in scene.tools]
    surfaces = ToolSurfaces()
    surfaces.meshes = wp.array([mesh.id for mesh in meshes], dtype=wp.uint64, device=device)
    first = np.cumsum([0, *(len(tool.triangles) for tool in scene.tools)])[:-1]
    surfaces.first_facet = wp.array(first, dtype=wp.int32, device=device)

    def put(name: str, dtype: Any, empty: tuple[int, ...] = (0,)) -> wp.array:
        values = [getattr(own, name) for own in facets] or [np.zeros(empty)]
        return wp.array(np.concatenate(values), dtype=dtype, device=device)

    surfaces.corners = put("corners", wp.vec3d, (0, 3, 3))
    surfaces.normals = put("normals", wp.vec3d, (0, 3, 3))
    surfaces.borders = put("borders", wp.int32)
    surfaces.hollow = put("hollow", wp.float64)
    surfaces.ridges = put("ridges", wp.int32)
    sag = [own.sag for own in facets]
    surfaces.sag = wp.array(sag, dtype=wp.float64, device=device)
    exact = [tool.surface.exact for tool in scene.tools]
    surfaces.exact = wp.array(exact, dtype=wp.int32, device=device)
    is_open = [not tool.surface.mesh.is_watertight for tool in scene.tools]
    surfaces.open = wp.array(is_open, dtype=wp.int32, device=device)
    surfaces.rubs = rubs(scene, [scene.friction_of(tool) for tool in scene.tools], device)
    return meshes, surfaces


class Facets(NamedTuple):
    """What contact knows of a tool's facets: see `ToolSurfaces`, whose part these are."""

    corners: np.ndarray
    normals: np.ndarray
    borders: np.ndarray
    hollow: np.ndarray
    ridges: np.ndarray
    sag: float


@lru_cache(maxsize=32)
def facets_of(tool: Tool) -> Facets:
    """Find what contact knows of a tool's facets; kept, as depths between vertices need it too."""
    triangles = tool.triangles
    return Facets(
        corners=tool.vertices[triangles],
        normals=contact_normals(tool),
        borders=border_bits(triangles, across_edges(triangles)),
        hollow=facet_hollows(tool.vertices, triangles),
        ridges=ridge_bits(tool),
        sag=largest_sag(tool),
    )


def contact_normals(tool: Tool) -> np.ndarray:
    """Normals at the facets' corners that contact pushes along, shape [facet, 3, 3].

    Those of the true surface where it is known. Elsewhere the distance is that from the facets, and
    the push must be along their own normals: along any others, such as means over the facets round
    a vertex, it is not the slope of that distance, and sliding makes energy.
    """
    if tool.surface.exact:
        return np.asarray(tool.surface.normals)
    corners = np.asarray(tool.vertices)[tool.triangles]
    area = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(area, axis=1, keepdims=True)
    return np.repeat((area / np.where(length > 0.0, length, 1.0))[:, None], 3, axis=1)


def ridge_bits(tool: Tool) -> np.ndarray:
    """`edge_bits` of the edges at which a tool's surface bends sharply, shape [facet].

    Where such an edge is nearest, on the side to which it sticks out, the distance from the tool is
    that from the edge. Of a known true surface these are the edges at whose ends the normals of the
    two facets differ; where none is known facets are flat, and all edges between them bend.
    """
    triangles = np.asarray(tool.triangles)
    normals = contact_normals(tool)
    marked = np.zeros(triangles.shape, dtype=bool)
    for corner, other in enumerate(across_edges(triangles).T):
        alike = np.full(len(triangles), np.inf)
        for end in (corner - 2, corner - 1):
            same = triangles[other] == triangles[:, [end]]
            beyond = np.where(same[..., None], normals[other], 0.0).sum(axis=1)
            alike = np.minimum(alike, (beyond * normals[:, end]).sum(axis=1))
        marked[:, corner] = (other >= 0) & (alike < SMOOTH)
    return edge_bits(triangles, marked)


def largest_sag(tool: Tool) -> float:
    """Bound on the height of a tool's curved surface over its facets [m].

    Over a facet it is Σ w_i w_j c_ij, with c = ½ (x_i − x_j)·(n_i − n_j) along each edge, and the
    products of the weights add up to a third at most.
    """
    if not tool.surface.exact:
        return 0.0
    corners, normals = tool.vertices[tool.triangles], tool.surface.normals
    turned = np.roll(corners, 1, axis=1) - corners, np.roll(normals, 1, axis=1) - normals
    return float(np.abs((turned[0] * turned[1]).sum(axis=2)).max() / 6.0)
