"""What a stack is at a place of it: its plies along the normal there, averaged by thickness."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from warpdrape.exports.permeability import Permeability, frames, principal
from warpdrape.exports.through_stack import PlyLines
from warpdrape.results.result import FormedPly

REACH = 5.0
"""How far along the normal plies are looked for, in thicknesses of the stack: gaps lie between."""


def met(plies: Sequence[FormedPly], base: FormedPly, farthest: float) -> np.ndarray:
    """Triangles of each ply on the normals of a ply's triangles, −1 where there is none.

    Args:
        plies: the stack.
        base: the ply from whose triangles' centres lines go out.
        farthest: [m].

    Returns:
        shape [ply, triangle of base].
    """
    centers = np.asarray(base.points)[base.triangles].mean(axis=1)
    normal = frames(base)[2]
    own = np.arange(len(base.triangles))
    return np.array(
        [
            own if ply is base else PlyLines(ply).nearest(centers, normal, farthest)[0]
            for ply in plies
        ]
    )


def averaged(
    permeabilities: Sequence[Permeability],
    thicknesses: Sequence[np.ndarray],
    base: FormedPly,
    triangles: np.ndarray,
) -> tuple[Permeability, np.ndarray]:
    """Permeability of a stack in the triangles of one of its plies.

    In the plane tensors add by thickness, Σ t K / Σ t; through it resistances do, Σ t / Σ (t / K).

    Args:
        permeabilities: of each ply.
        thicknesses: of each [m], shape [triangle].
        base: the ply.
        triangles: of each ply on its normals, from `met`.

    Returns:
        Of the stack, and its thickness [m], shape [triangle of base].
    """
    first, second, normal = frames(base)
    axes = np.stack([first, second], axis=1)
    tensor = np.zeros((len(first), 2, 2))
    thickness, resistance = np.zeros(len(first)), np.zeros(len(first))
    for own, thick, at in zip(permeabilities, thicknesses, triangles, strict=True):
        turned = _laid_into(own, at, axes)
        weight = np.where(at >= 0, thick[at], 0.0)
        values = own.principal[at]
        tensor += weight[:, None, None] * np.einsum(
            "tk,tki,tkj->tij", values[:, :2], turned, turned
        )
        thickness += weight
        resistance += weight / values[:, 2]
    in_plane = tensor / thickness[:, None, None]
    return principal(in_plane, thickness / resistance, first, second, normal), thickness


def _laid_into(own: Permeability, at: np.ndarray, axes: np.ndarray) -> np.ndarray:
    """Principal directions of triangles in the axes of another plane, shape [k, 2, 2]."""
    larger = own.directions[at, 0]
    x, y = (larger * axes[:, 0]).sum(axis=1), (larger * axes[:, 1]).sum(axis=1)
    length = np.maximum(np.hypot(x, y), 1e-300)
    x, y = x / length, y / length
    return np.stack([np.stack([x, y], axis=1), np.stack([-y, x], axis=1)], axis=1)
