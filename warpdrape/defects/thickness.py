"""Thickness and fibre volume fraction of a formed ply.

Shear and strain change a triangle's area from A0 to A; its fibres stay in it. At the thickness t,
V_f = m/(ρ t) · A0/A with the areal density m of the flat fabric and the density ρ of its fibres,
which is V_f0 · A0/A at constant thickness. The thickness is the fabric's own, or what its
compaction law gives at the pressure there: without a law none is computed, and the ply does not
thicken as it is sheared. Rubber keeps its volume, and t = t0 A0/A. What a closed cavity makes of a
stack is in `cavity.py`.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from warpdrape.materials.fabric import Fabric
from warpdrape.materials.laws import MooneyRivlin, Unwoven


def area_ratios(flat: np.ndarray, points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """A/A0 of triangles [-], shape [m].

    Args:
        flat: areas in the flat ply [m²], shape [m].
        points: formed positions [m], shape [n, 3].
        triangles: vertices, shape [m, 3].
    """
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1) / flat


def yarn_area_ratios(strain: np.ndarray, shear: np.ndarray, yarn_angle: float) -> np.ndarray:
    """A/A0 of a woven ply by its yarns, (1 + ε1)(1 + ε2) sin(θ0 − γ)/sin θ0 [-], shape [m].

    With the strains that a pair's triangles share: one triangle's own area strays about that, as
    one triangle's own strains do.

    Args:
        strain: of warp and weft [-], shape [m, 2].
        shear: signed shear angles γ [rad], shape [m].
        yarn_angle: θ0 from warp to weft in the flat ply [rad].
    """
    stretched = (1.0 + strain[:, 0]) * (1.0 + strain[:, 1])
    return stretched * np.sin(yarn_angle - shear) / np.sin(yarn_angle)


def formed_area_ratios(
    fabric: Fabric,
    flat: np.ndarray,
    points: np.ndarray,
    triangles: np.ndarray,
    strain: np.ndarray,
    shear: np.ndarray,
) -> np.ndarray:
    """A/A0 of a ply's triangles [-], shape [m]: by its yarns, and without yarns by its area.

    Args:
        fabric: of the ply.
        flat: areas in the flat ply [m²], shape [m].
        points: formed positions [m], shape [n, 3].
        triangles: vertices, shape [m, 3].
        strain: of warp and weft [-], shape [m, 2].
        shear: signed shear angles [rad], shape [m].
    """
    if isinstance(fabric.tension, Unwoven):
        return area_ratios(flat, points, triangles)
    return yarn_area_ratios(strain, shear, fabric.yarn_angle)


def thicknesses(
    fabric: Fabric,
    pressures: Sequence[np.ndarray],
    triangles: np.ndarray,
    ratios: np.ndarray | float = 1.0,
) -> np.ndarray:
    """Thickness of a ply in its triangles [m], shape [m].

    Args:
        fabric: of the ply.
        pressures: of plies and tools on its vertices [Pa], each of shape [n]; the largest counts.
        triangles: vertices, shape [m, 3].
        ratios: A/A0 [-], shape [m]; it matters to rubber alone.
    """
    if isinstance(fabric.tension, MooneyRivlin):
        return fabric.thickness / np.maximum(ratios, 1e-12)
    if fabric.compaction is None or not len(pressures):
        return np.full(len(triangles), fabric.thickness)
    pressure = np.max(pressures, axis=0)
    return fabric.compaction.thickness_at(np.maximum(pressure, 0.0))[triangles].mean(axis=1)


def fibre_volume_fractions(
    fabric: Fabric, ratios: np.ndarray, thickness: np.ndarray
) -> np.ndarray | None:
    """V_f of triangles [-], shape [m]; None for a fabric without the density of its fibres.

    Args:
        fabric: of the ply.
        ratios: A/A0 [-], shape [m].
        thickness: [m], shape [m].
    """
    if fabric.fibre_density is None:
        return None
    solid = fabric.areal_density / fabric.fibre_density
    return solid / (thickness * np.maximum(ratios, 1e-12))
