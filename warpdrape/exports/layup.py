"""What a shell model says of a formed ply: its layers, their angles, an example material."""

from __future__ import annotations

import numpy as np

from warpdrape.results.result import FormedPly

LAYERS = (("WARP", 0.25), ("WEFT", 0.5), ("WARP", 0.25))
"""Yarn family and share of the thickness of a ply's layers, from the bottom up."""
MATERIAL = (135e9, 9e9, 9e9, 0.3, 0.3, 0.45, 5e9, 5e9, 3.1e9)
"""E1, E2, E3 [Pa], ν12, ν13, ν23, G12, G13, G23 [Pa]: carbon and epoxy, to be replaced."""
DENSITY = 1550.0
"""… and its density [kg/m³]."""


def angles_deg(ply: FormedPly) -> dict[str, np.ndarray]:
    """Angles of the yarns from an element's side 1-2, about its normal by the right hand [deg].

    Args:
        ply: the formed ply.

    Returns:
        by family, each within ±180°, shape [triangle].
    """
    a, b, c = (np.asarray(ply.points)[np.asarray(ply.triangles)[:, k]] for k in range(3))
    side = (b - a) / np.linalg.norm(b - a, axis=1, keepdims=True)
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    across = np.cross(normal, side)
    return {
        family: np.degrees(np.arctan2((along * across).sum(axis=1), (along * side).sum(axis=1)))
        for family, along in (("WARP", ply.warp), ("WEFT", ply.weft))
    }


def edge_vertices(ply: FormedPly) -> np.ndarray:
    """Vertices on the ply's border, counted from 0."""
    ends = np.sort(np.asarray(ply.triangles)[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    edges, count = np.unique(ends, axis=0, return_counts=True)
    return np.unique(edges[count == 1])


def thickness_of(ply: FormedPly, flat: float) -> np.ndarray:
    """Thickness of triangles [m]; that of the flat ply where the run has none."""
    if ply.thickness is None:
        return np.full(len(ply.triangles), flat)
    return np.asarray(ply.thickness, float)
