"""Which places of stacked plies lay on each other at the start, and how far they have slipped."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import warp as wp

from warpdrape.blanks.ply import Ply
from warpdrape.contact.ply_surfaces import PlySurfaces
from warpdrape.kernels.contact.ply_surfaces import find_places

ROUNDING = 1e-6
"""Added to the plies' distance when looking for what lies over a vertex [m]."""


@dataclass(frozen=True, eq=False)
class Partners:
    """For each vertex the place of the ply above it, of the topmost ply's that of the ply below.

    Attributes:
        corners: vertices of the triangle, shape [vertex, 3].
        weights: of them at the place; zero where the vertex lay alone, likewise.
    """

    corners: np.ndarray
    weights: np.ndarray

    def covers(self, vertices: slice) -> np.ndarray:
        """Which of some vertices did not lie alone."""
        return self.weights[vertices].sum(axis=1) > 0.0

    def slip(self, x: np.ndarray, normals: np.ndarray) -> np.ndarray:
        """How far vertices have slid along the ply from their places [m], shape [vertex, 3].

        Args:
            x: positions [m], shape [vertex, 3].
            normals: unit vertex normals, likewise.
        """
        way = x - np.einsum("ik,ikj->ij", self.weights, x[self.corners])
        way -= np.einsum("ij,ij->i", way, normals)[:, None] * normals
        way[self.weights.sum(axis=1) == 0.0] = 0.0
        return way


def find_partners(plies: Sequence[Ply], surfaces: PlySurfaces) -> Partners:
    """Find them among the plies as they lie flat.

    Args:
        plies: two or more.
        surfaces: theirs.
    """
    device, spans = surfaces.device, surfaces.spans
    rest = np.concatenate([ply.rest_points for ply in plies])
    x: wp.array = wp.array(rest, dtype=wp.vec3d, device=device)
    corners = wp.zeros(len(x), dtype=wp.vec3i, device=device)
    weights = wp.zeros(len(x), dtype=wp.vec3d, device=device)
    for number, (ply, span) in enumerate(zip(plies, spans, strict=True)):
        other = number + 1 if number + 1 < len(plies) else number - 1
        radius = 1.001 * abs(plies[other].z - ply.z) + ROUNDING
        wp.launch(
            find_places,
            span.vertex_count,
            inputs=[
                span.first_vertex,
                surfaces.facets,
                surfaces.meshes[other].id,
                spans[other].first_triangle,
                radius,
                x,
            ],
            outputs=[corners, weights],
            device=device,
        )
    return Partners(corners.numpy(), weights.numpy())
