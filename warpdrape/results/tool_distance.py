"""How far a formed ply is from the tools, worked out from a run's own meshes.

The distance is that of a vertex, which lies in the middle of the ply's thickness, from the nearest
facet of any tool as the run folder has it; facets of length h lie off a rounding of radius r by up
to h²/(8 r).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from warpdrape.tools.pose import pose_between

TOOL_DISTANCE = "toolDistance"
"""Name of the quantity among the primvars, of which it is none: it follows from the meshes."""


class ToolDistances:
    """Distances from tools.

    Args:
        surfaces: vertices [m], shape [n, 3], and triangles, shape [m, 3], of each tool as it
            stands at some moment.
    """

    def __init__(self, surfaces: Sequence[tuple[NDArray[np.float64], NDArray[np.integer]]]) -> None:
        from warpdrape.defects.gaps import SurfaceGaps
        from warpdrape.warp_start import start_warp

        start_warp()
        self._starts = [vertices.copy() for vertices, _ in surfaces]
        self._gaps = [SurfaceGaps(vertices, triangles) for vertices, triangles in surfaces]

    def of(
        self, points: NDArray[np.float64], tools: Sequence[NDArray[np.float64]]
    ) -> NDArray[np.float64]:
        """Distances of points from the nearest tool [m], shape [n].

        Args:
            points: [m], shape [n, 3].
            tools: vertices of each tool now [m].
        """
        nearest = np.full(len(points), np.inf)
        for gaps, start, now in zip(self._gaps, self._starts, tools, strict=True):
            ways = gaps.ways(pose_between(start, now).into(points))
            nearest = np.minimum(nearest, np.linalg.norm(ways, axis=1))
        return nearest
