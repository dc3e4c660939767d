"""How deep plies lie in tools at a frame: their vertices, and their faces between these.

Contact keeps vertices out of tools. Between them a ply's triangles are chords, and over a tool that
bulges out they cut into it by h²/8R, for sides h and a radius R: what a finer ply would not.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import warp as wp

from warpdrape.blanks.triangles import longest_sides
from warpdrape.contact.tool_surfaces import tool_surfaces
from warpdrape.interaction import Run, Span, Swept
from warpdrape.kernels.contact.face_depths import find_face_depths, find_vertex_planes
from warpdrape.kernels.contact.tool_planes import ToolPlane
from warpdrape.setup import Setup
from warpdrape.state import State
from warpdrape.tools.pose import Pose

BETWEEN = np.array([[0.0, 0.5, 0.5], [0.5, 0.0, 0.5], [0.5, 0.5, 0.0], [1.0 / 3.0] * 3])
"""Places of a triangle that are looked at besides its corners: middles of sides, its centre."""


class FaceDepths:
    """Looks at how deep plies lie in tools."""

    def __init__(self, scene: Setup, spans: Sequence[Span], device: str) -> None:
        """Put tools, and places of the plies, on a device.

        Args:
            scene: what is computed.
            spans: where plies are.
            device: Warp device.
        """
        self._device, self._vertices = device, spans[-1].vertices.stop
        self._meshes, self._surfaces = tool_surfaces(scene, device)
        sides = [longest_sides(p.rest_points, p.mesh.triangles).max() for p in scene.plies]
        thickness = [ply.fabric.thickness for ply in scene.plies]
        self._radius = 0.5 * float(max(sides)) + max(thickness)
        half = np.repeat(0.5 * np.array(thickness), [span.vertex_count for span in spans])
        self._half = wp.array(half, dtype=wp.float64, device=device)
        self._planes = wp.empty(self._vertices, dtype=ToolPlane, device=device)
        corners, weights = _places(scene, spans)
        self._corners = wp.array(corners, dtype=wp.vec3i, device=device)
        self._weights = wp.array(weights, dtype=wp.vec3d, device=device)

    def deepest(self, state: State) -> np.ndarray:
        """Deepest place of all plies at vertices, and between them [m], shape [tool, 2].

        Args:
            state: the state now.
        """
        found = [self._depths(*tool, state) for tool in enumerate(state.tools.poses())]
        return np.array(found).reshape(-1, 2)

    def _depths(self, tool: int, pose: Pose, state: State) -> tuple[float, float]:
        places, device = len(self._corners), self._device
        at_vertices, between = (
            wp.empty(count, dtype=wp.float64, device=device) for count in (self._vertices, places)
        )
        place = [wp.mat33d(*pose.turned.ravel()), wp.vec3d(*pose.shift)]
        known = [self._surfaces, tool, *place, self._half, self._radius, state.plies.x]
        outputs = [self._planes, at_vertices]
        Swept(find_vertex_planes, Run(0, self._vertices), known, outputs)(device)
        inputs = [*known, self._planes, self._corners, self._weights]
        Swept(find_face_depths, Run(0, places), inputs, [between])(device)
        return float(at_vertices.numpy().max()), float(between.numpy().max())


def _places(scene: Setup, spans: Sequence[Span]) -> tuple[np.ndarray, np.ndarray]:
    """Triangles' corners and weights of the places between vertices, each place once.

    A side's middle is of two triangles, of which either serves.
    """
    corners, weights = [], []
    for ply, span in zip(scene.plies, spans, strict=True):
        triangles = np.asarray(ply.mesh.triangles)
        every = np.repeat(triangles, len(BETWEEN), axis=0)
        share = np.tile(BETWEEN, (len(triangles), 1))
        points = np.einsum("nk,nkd->nd", share, np.asarray(ply.rest_points)[every])
        _, first = np.unique(np.round(points, 12), axis=0, return_index=True)
        corners.append(every[first] + span.first_vertex)
        weights.append(share[first])
    return np.concatenate(corners), np.concatenate(weights)
