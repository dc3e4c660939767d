"""Tools that have passed through a ply all the same, faster than contact could hold them.

A triangle over a right-angled edge or corner of a tool may cut up to half its side off it. Whatever
reaches deeper has passed: then the run is not the forming that was asked for.
Only closed solids are looked at: a ply may swing into the mouth of an open surface.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import warp as wp

from warpdrape.blanks.triangles import longest_sides
from warpdrape.contact.features import along
from warpdrape.distinct import distinct_rows
from warpdrape.interaction import Span
from warpdrape.kernels.contact.passages import find_depths
from warpdrape.setup import Setup
from warpdrape.state import State
from warpdrape.tools.pose import Pose
from warpdrape.tools.tool import Tool

PASSED = 0.6
"""Depth over the longest side of the ply's triangle beyond which a tool has passed it [-]."""


@dataclass(frozen=True)
class Passage:
    """A tool has passed through a ply.

    Attributes:
        tool: number of the tool.
        ply: number of the ply.
        triangle: of the ply.
        depth: how far beyond it the tool reaches [m].
        side: longest side of the triangle in the flat ply [m].
    """

    tool: int
    ply: int
    triangle: int
    depth: float
    side: float


class Passages:
    """Looks for passages; holds meshes of the plies as they move, and points of the tools."""

    def __init__(self, scene: Setup, spans: Sequence[Span], device: str) -> None:
        """Put plies and tools on a device.

        Args:
            scene: what is computed.
            spans: where plies are.
            device: Warp device.
        """
        self._spans = spans
        self._sides = [longest_sides(p.rest_points, p.mesh.triangles) for p in scene.plies]
        finest = min(float(sides.min()) for sides in self._sides)
        self._tools = [
            (number, _Sought(tool, finest, device))
            for number, tool in enumerate(scene.tools)
            if tool.surface.mesh.is_watertight
        ]
        moving = scene.plies if self._tools else ()
        self._plies = [_mesh(p.rest_points, p.mesh.triangles, device) for p in moving]

    def deepest(self, state: State) -> Passage | None:
        """The deepest passage, by the ply's triangles; None where there is none.

        Args:
            state: the state now.
        """
        if not self._tools:
            return None
        x, poses = state.plies.x.numpy(), state.tools.poses()
        worst, found = PASSED, None
        for number, (span, mesh, sides) in enumerate(
            zip(self._spans, self._plies, self._sides, strict=True)
        ):
            now = x[span.vertices]
            mesh.points.assign(now.astype(np.float32))
            mesh.refit()
            for tool, sought in self._tools:
                if not sought.may_meet(poses[tool].into(now)):
                    continue
                depth, facet = sought.depths(mesh, poses[tool], float(sides.max()))
                share = np.where(depth > 0.0, depth / sides[facet], 0.0)
                at = int(np.argmax(share))
                if share[at] > worst:
                    triangle = int(facet[at])
                    worst = float(share[at])
                    found = Passage(tool, number, triangle, float(depth[at]), sides[triangle])
        return found


class _Sought:
    """A tool, and the points of it that are looked for: its vertices, and more along its edges."""

    def __init__(self, tool: Tool, spacing: float, device: str) -> None:
        points = along(tool.vertices[tool.surface.mesh.edges_unique], spacing)
        points = points[distinct_rows(points)[0]]
        self._low, self._high = points.min(axis=0), points.max(axis=0)
        self._mesh = _mesh(tool.vertices, tool.triangles, device, solid=True)
        self._points: wp.array = wp.array(points, dtype=wp.vec3f, device=device)
        self._depth = wp.zeros(len(points), dtype=wp.float32, device=device)
        self._facet = wp.zeros(len(points), dtype=wp.int32, device=device)

    def may_meet(self, points: np.ndarray) -> bool:
        """Whether the tool's box meets that of points [n, 3] in its frame."""
        low, high = self._low, self._high
        return bool((points.min(axis=0) <= high).all() and (points.max(axis=0) >= low).all())

    def depths(self, ply: wp.Mesh, pose: Pose, reach: float) -> tuple[np.ndarray, np.ndarray]:
        """How deep each point reaches [m], and through which of the ply's triangles."""
        wp.launch(
            find_depths,
            len(self._points),
            inputs=[
                self._points,
                self._mesh.id,
                wp.mat33f(*pose.turned.ravel()),
                wp.vec3f(*pose.shift),
                ply.id,
                reach,
            ],
            outputs=[self._depth, self._facet],
            device=self._points.device,
        )
        return self._depth.numpy(), self._facet.numpy()


def _mesh(
    points: np.ndarray, triangles: np.ndarray, device: str, *, solid: bool = False
) -> wp.Mesh:
    return wp.Mesh(
        wp.array(points, dtype=wp.vec3f, device=device),
        wp.array(np.ravel(triangles), dtype=wp.int32, device=device),
        support_winding_number=solid,
    )
