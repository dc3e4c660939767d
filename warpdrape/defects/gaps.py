"""How far points are from the true surface of tools, and from formed plies."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np
import warp as wp

from warpdrape.kernels.defects.gaps import compute_hits, compute_surface_ways
from warpdrape.tools.pose import Pose
from warpdrape.tools.tool import Tool

DEVICE = "cpu"
"""Where distances are asked: results are on the host, and few."""


class SurfaceGaps:
    """Ways from a triangulated surface, on the host.

    Args:
        vertices: [m], shape [n, 3].
        triangles: shape [m, 3].
        normals: at the corners, of the curved surface over the triangles, shape [m, 3, 3]; None for
            the flat triangles themselves.
    """

    def __init__(
        self, vertices: np.ndarray, triangles: np.ndarray, normals: np.ndarray | None = None
    ) -> None:
        corners = vertices[triangles]
        self._mesh = wp.Mesh(
            wp.array(vertices, dtype=wp.vec3f, device=DEVICE),
            wp.array(np.ravel(triangles), dtype=wp.int32, device=DEVICE),
        )
        self._corners: wp.array = wp.array(corners, dtype=wp.vec3d, device=DEVICE)
        normals = np.zeros_like(corners) if normals is None else normals
        self._normals: wp.array = wp.array(normals, dtype=wp.vec3d, device=DEVICE)
        self._size = float(np.linalg.norm(vertices, axis=1).max())

    def ways(self, points: np.ndarray, farthest: float | None = None) -> np.ndarray:
        """Ways from the nearest point of the surface to each point [m], shape [n, 3].

        Args:
            points: [m], shape [n, 3].
            farthest: how far to look [m]; what is not found so far counts as there, upwards.
        """
        if not len(points):
            return np.zeros((0, 3))
        if farthest is None:
            farthest = self._size + float(np.linalg.norm(points, axis=1).max())
        ways = wp.empty(len(points), dtype=wp.vec3d, device=DEVICE)
        asked: wp.array = wp.array(points, dtype=wp.vec3d, device=DEVICE)
        inputs = [self._mesh.id, self._corners, self._normals, asked, farthest]
        wp.launch(compute_surface_ways, len(points), inputs, outputs=[ways], device=DEVICE)
        return ways.numpy()

    def is_met(self, points: np.ndarray, directions: np.ndarray) -> np.ndarray:
        """Whether rays from points along unit directions meet the surface, shape [n].

        Args:
            points: [m], shape [n, 3].
            directions: of the rays, shape [n, 3].
        """
        farthest = self._size + float(np.linalg.norm(points, axis=1).max())
        hits = wp.zeros(len(points), dtype=wp.int32, device=DEVICE)
        rays: list[wp.array] = [
            wp.array(each, dtype=wp.vec3d, device=DEVICE) for each in (points, directions)
        ]
        inputs = [self._mesh.id, *rays, farthest]
        wp.launch(compute_hits, len(points), inputs, outputs=[hits], device=DEVICE)
        return hits.numpy() > 0


class ToolGaps:
    """Distances from tools, on the host.

    Args:
        tools: where they stand at the start.
    """

    def __init__(self, tools: Sequence[Tool]) -> None:
        self.tools = tuple(tools)

    @cached_property
    def _surfaces(self) -> list[SurfaceGaps]:
        return [_surface(tool) for tool in self.tools]

    def ways(self, points: np.ndarray, poses: Sequence[Pose]) -> np.ndarray:
        """Ways from the nearest point of each tool to each point [m], shape [tool, n, 3].

        Args:
            points: [m], shape [n, 3].
            poses: where each tool is.
        """
        found = np.zeros((len(self.tools), len(points), 3))
        for number, surface in enumerate(self._surfaces):
            pose = poses[number]
            found[number] = pose.direct(surface.ways(pose.into(points)))
        return found

    def beneath(self, points: np.ndarray, normals: np.ndarray, poses: Sequence[Pose]) -> np.ndarray:
        """Which tools lie straight under or over points, shape [tool, n].

        Args:
            points: [m], shape [n, 3].
            normals: of the ply there, shape [n, 3].
            poses: where each tool is.
        """
        found = np.zeros((len(self.tools), len(points)), dtype=bool)
        for number, surface in enumerate(self._surfaces):
            pose = poses[number]
            at, along = pose.into(points), pose.into_directions(normals)
            found[number] = surface.is_met(at, along) | surface.is_met(at, -along)
        return found


def _surface(tool: Tool) -> SurfaceGaps:
    """What contact sees of a tool: the curved surface where its normals are known, else facets."""
    normals = tool.surface.normals if tool.surface.exact else None
    return SurfaceGaps(tool.vertices, tool.triangles, normals)
