"""How far the vertices of plies are from each tool's true surface."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np
import warp as wp

from warpdrape.kernels.defects.gaps import compute_tool_gaps
from warpdrape.tools.tool import Tool

DEVICE = "cpu"
"""Where distances are asked: results are on the host, and few."""


class ToolGaps:
    """Distances from tools, on the host.

    Args:
        tools: where they stand at the start.
    """

    def __init__(self, tools: Sequence[Tool]) -> None:
        self.tools = tuple(tools)

    @cached_property
    def _surfaces(self) -> list[tuple[wp.Mesh, wp.array, wp.array, float]]:
        return [_surface(tool) for tool in self.tools]

    def ways(self, points: np.ndarray, shifts: np.ndarray) -> np.ndarray:
        """Ways from the nearest point of each tool to each point [m], shape [tool, n, 3].

        Args:
            points: [m], shape [n, 3].
            shifts: translation of each tool since the start [m], shape [tool, 3].
        """
        found = np.zeros((len(self.tools), len(points), 3))
        for number, (mesh, corners, normals, size) in enumerate(self._surfaces):
            at = points - shifts[number]
            ways = wp.empty(len(points), dtype=wp.vec3d, device=DEVICE)
            asked = wp.array(at, dtype=wp.vec3d, device=DEVICE)
            farthest = size + float(np.linalg.norm(at, axis=1).max())
            inputs = [mesh.id, corners, normals, asked, farthest]
            wp.launch(compute_tool_gaps, len(points), inputs, outputs=[ways], device=DEVICE)
            found[number] = ways.numpy()
        return found


def _surface(tool: Tool) -> tuple[wp.Mesh, wp.array, wp.array, float]:
    """Query mesh, corners and normals of a tool, and its farthest vertex from the origin [m]."""
    mesh = wp.Mesh(
        wp.array(tool.vertices, dtype=wp.vec3f, device=DEVICE),
        wp.array(np.ravel(tool.triangles), dtype=wp.int32, device=DEVICE),
    )
    corners = wp.array(tool.vertices[tool.triangles], dtype=wp.vec3d, device=DEVICE)
    normals = wp.array(tool.surface.normals, dtype=wp.vec3d, device=DEVICE)
    return mesh, corners, normals, float(np.linalg.norm(tool.vertices, axis=1).max())
