"""How stiff a woven ply's membrane is at most, and what its pairs have beside yarns and shear."""

from __future__ import annotations

import math

import numpy as np

from warpdrape.blanks.flat_mesh import FlatMesh
from warpdrape.blanks.ply import Ply
from warpdrape.forces.pairs import patches_of
from warpdrape.forces.recovery import guard_stiffness
from warpdrape.materials.fabric import Fabric
from warpdrape.materials.law_data import (
    initial_shear_stiffness,
    shear_stiffness,
    tension_stiffness,
)
from warpdrape.materials.laws import IsotropicMembrane, MooneyRivlin, Unwoven
from warpdrape.materials.softening import soften
from warpdrape.numerics import Numerics

FREE = 160.0
"""Pairs in a square ply up to which the stabiliser is the fabric's own shear stiffness."""
STIFFEST = 1e-3
"""Most that a stabiliser grown with the mesh has of the yarns' stiffness [-]: far below what locks
yarns, and of the stable step hardly anything."""
SHEAR_RANGE = math.radians(75.0)
"""Shear angle up to which the stable step covers the shear law [rad], past any locking."""


def sheet_stiffness(ply: Ply, numerics: Numerics) -> tuple[tuple[float, float], float]:
    """Bounds on the stiffness of a ply along warp and weft, and in shear [N/m].

    With what the yarns' viscosity takes of the step: c = ν Δt k acts on the velocity half a step
    back, so that (Δt ω)² + 2 c Δt/m = (1 + 2 ν)(Δt ω)² ≤ 4; and with the guard of their recovery.
    """
    fabric = ply.fabric
    if isinstance(fabric.tension, MooneyRivlin):
        stiffness = fabric.tension.stiffest * fabric.thickness
        return (stiffness, stiffness), 0.0
    if isinstance(fabric.tension, IsotropicMembrane):
        sheet = fabric.tension
        stiffness = sheet.stiffness / (1.0 - sheet.poisson**2)
        return (stiffness, stiffness), stiffness
    shear = shear_stiffness(fabric, SHEAR_RANGE) / math.cos(SHEAR_RANGE) ** 2
    yarns = tension_stiffness(soften(fabric, numerics.yarn_softening))
    _, stabiliser = stabiliser_range(ply, numerics)
    drag = yarn_viscosity(fabric, numerics)
    guard = guard_stiffness(ply, numerics)
    warp, weft = (y + g + 2.0 * d + stabiliser for y, g, d in zip(yarns, guard, drag, strict=True))
    return (warp, weft), shear


def patch_stabilisers(
    ply: Ply, numerics: Numerics, offsets: np.ndarray, members: np.ndarray
) -> np.ndarray:
    """κ C'(0) of a ply's patches [N/m], shape [patch].

    A patch of three is as stiff as the pairs that its triangles might have made.

    Args:
        ply: the ply.
        numerics: κ and its floor.
        offsets: first member of each patch, and their number, shape [patch + 1].
        members: triangles by patch, shape [triangle].
    """
    of_triangle = np.add.reduceat(ply.mesh.areas[members], offsets[:-1]) / np.diff(offsets)
    pairs = ply_width(ply.mesh) ** 2 / (2.0 * of_triangle)
    return stabiliser_stiffness(ply.fabric, numerics, pairs)


def stabiliser_range(ply: Ply, numerics: Numerics) -> tuple[float, float]:
    """Smallest and largest κ C'(0) of a ply's patches [N/m]."""
    offsets, members, _ = patches_of(ply.mesh, numerics.averaging)
    found = patch_stabilisers(ply, numerics, offsets, members)
    return float(found.min()), float(found.max())


def ply_width(mesh: FlatMesh) -> float:
    """Four times area over border [m].

    That is the side of a square, the diameter of a disc, and twice what a long strip is across.
    """
    ends = mesh.vertices[mesh.boundary_edges]
    border = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum()
    return float(4.0 * mesh.areas.sum() / border)


def stabiliser_stiffness(
    fabric: Fabric, numerics: Numerics, pairs: np.ndarray | float = 0.0
) -> np.ndarray:
    """κ C'(0) [N/m], with its floor for fabrics that hardly shear-stiffen.

    It alone holds a pair's free mode, which compression along a flange's side drives: a zigzag of
    the rim that runs into the ply over some h √κ. So where no κ is given it grows as 1/h², patch by
    patch: then that zone is as wide on any mesh, and a share of the ply, as the flange is.

    Args:
        fabric: the fabric.
        numerics: κ and its floor.
        pairs: that would fill a square as wide as the ply, by patch [-], shape [patch].
    """
    shear, yarns = initial_shear_stiffness(fabric), max(tension_stiffness(fabric))
    if numerics.stabiliser is None:
        grown = np.minimum(shear * np.asarray(pairs) / FREE, STIFFEST * yarns)
        wanted = np.maximum(shear, grown)
    else:
        wanted = np.full(np.shape(pairs), numerics.stabiliser * shear)
    return np.maximum(wanted, numerics.stabiliser_floor * yarns)


def yarn_viscosity(fabric: Fabric, numerics: Numerics) -> tuple[float, float]:
    """Line tension of warp and weft per change of their strain in a step [N/m].

    A share of their stiffness in tension; none where tension and compression are alike, since it is
    the corner between them that makes central differences unstable.
    """
    if isinstance(fabric.tension, Unwoven):
        return 0.0, 0.0
    yarns = soften(fabric, numerics.yarn_softening)
    if yarns.compressive_factor >= 1.0:
        return 0.0, 0.0
    warp, weft = tension_stiffness(yarns)
    return numerics.yarn_viscosity * warp, numerics.yarn_viscosity * weft
