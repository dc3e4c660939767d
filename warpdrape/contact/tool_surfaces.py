"""Rigid tools on a device: their facets, and how far these stand off the surface."""

from __future__ import annotations

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
    facets = [len(tool.triangles) for tool in scene.tools]
    corners = [tool.vertices[tool.triangles] for tool in scene.tools]
    normals = [contact_normals(tool) for tool in scene.tools]
    empty = [np.zeros((0, 3, 3))]
    surfaces = ToolSurfaces()
    surfaces.meshes = wp.array([mesh.id for mesh in meshes], dtype=wp.uint64, device=device)
    first = np.cumsum([0, *facets])[:-1]
    surfaces.first_facet = wp.array(first, dtype=wp.int32, device=device)
    surfaces.corners = wp.array(np.concatenate(corners or empty), dtype=wp.vec3d, device=device)
    surfaces.normals = wp.array(np.concatenate(normals or empty), dtype=wp.vec3d, device=device)
    borders = [border_bits(t.triangles, across_edges(t.triangles)) for t in scene.tools]
    borders = np.concatenate(borders or [np.zeros(0)])
    surfaces.borders = wp.array(borders, dtype=wp.int32, device=device)
    sag = [largest_sag(tool) for tool in scene.tools]
    surfaces.sag = wp.array(sag, dtype=wp.float64, device=device)
    hollow = [facet_hollows(tool.vertices, tool.triangles) for tool in scene.tools]
    hollow = np.concatenate(hollow or [np.zeros(0)])
    surfaces.hollow = wp.array(hollow, dtype=wp.float64, device=device)
    exact = [tool.surface.exact for tool in scene.tools]
    surfaces.exact = wp.array(exact, dtype=wp.int32, device=device)
    ridges = [ridge_bits(tool) for tool in scene.tools] or [np.zeros(0)]
    surfaces.ridges = wp.array(np.concatenate(ridges), dtype=wp.int32, device=device)
    is_open = [not tool.surface.mesh.is_watertight for tool in scene.tools]
    surfaces.open = wp.array(is_open, dtype=wp.int32, device=device)
    surfaces.rubs = rubs(scene, [scene.friction_of(tool) for tool in scene.tools], device)
    return meshes, surfaces


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
