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
from warpdrape.distinct import distinct_rows
from warpdrape.interaction import Run, Span, Swept
from warpdrape.kernels.contact.face_depths import (
    Look,
    PlaceSeen,
    find_face_depths,
    find_vertex_planes,
)
from warpdrape.kernels.contact.tool_planes import ToolPlane
from warpdrape.setup import Setup
from warpdrape.state import State
from warpdrape.tools.pose import Pose

BETWEEN = np.array([[0.0, 0.5, 0.5], [0.5, 0.0, 0.5], [0.5, 0.5, 0.0], [1.0 / 3.0] * 3])
"""Places of a triangle that are looked at besides its corners: middles of sides, its centre."""
Depths = Sequence[tuple[float, float]] | np.ndarray
"""Deepest place at vertices, and between them, for each tool [m]."""


class FaceDepths:
    """Looks at how deep plies lie in tools, and remembers where it need not look again.

    Attributes:
        seen: places as they were when a tool was asked for them, shape [tool · place].
    """

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
        self._half: wp.array = wp.array(half, dtype=wp.float64, device=device)
        corners, weights = _places(scene, spans)
        self._corners: wp.array = wp.array(corners, dtype=wp.vec3i, device=device)
        self._weights: wp.array = wp.array(weights, dtype=wp.vec3d, device=device)
        slots = len(scene.tools) * self._vertices
        self._planes = wp.zeros(slots, dtype=ToolPlane, device=device)
        self._turns = wp.zeros(slots, dtype=wp.int32, device=device)
        self.seen = wp.zeros(len(scene.tools) * len(corners), dtype=PlaceSeen, device=device)

    def deepest(self, state: State, known: Depths = ()) -> np.ndarray:
        """Deepest place of all plies at vertices, and between them [m], shape [tool, 2].

        Args:
            state: the state now.
            known: the deepest at earlier frames, which are part of what is returned; places that
                cannot be deeper are not asked for. Empty for none.
        """
        before = np.array(known if len(known) else np.zeros((len(self._meshes), 2)))
        found = [
            self._depths(tool, pose, state, before[tool, 1])
            for tool, pose in enumerate(state.tools.poses())
        ]
        return np.maximum(np.array(found).reshape(-1, 2), before.reshape(-1, 2))

    def _depths(self, tool: int, pose: Pose, state: State, known: float) -> tuple[float, float]:
        places, device = len(self._corners), self._device
        at_vertices, between = (
            wp.empty(count, dtype=wp.float64, device=device) for count in (self._vertices, places)
        )
        look = Look()
        look.tool, look.radius, look.known = tool, self._radius, known
        look.turned, look.shift = wp.mat33d(*pose.turned.ravel()), wp.vec3d(*pose.shift)
        asked = [self._surfaces, look, self._half, state.plies.x]
        planes = [self._planes, self._turns]
        Swept(find_vertex_planes, Run(0, self._vertices), asked, [*planes, at_vertices])(device)
        inputs = [*asked, *planes, self._corners, self._weights]
        Swept(find_face_depths, Run(0, places), inputs, [self.seen, between])(device)
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
        first, _ = distinct_rows(np.round(points, 12))
        corners.append(every[first] + span.first_vertex)
        weights.append(share[first])
    return np.concatenate(corners), np.concatenate(weights)
