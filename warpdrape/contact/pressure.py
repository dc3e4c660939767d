"""How hard contacts press at one instant, from what they remember: forces, and their areas."""

from __future__ import annotations

import numpy as np

from warpdrape.kernels.contact.contact import ContactLaw

LOWER, UPPER = 0, 1
"""Rows of forces on a ply's faces."""


def normal_forces(
    law: ContactLaw,
    mass: np.ndarray,
    stored: np.ndarray,
    springs: np.ndarray,
    dashpots: np.ndarray,
) -> np.ndarray:
    """Normal force of each contact, of penalty and dashpot [N], shape [slot].

    Args:
        law: the contact law.
        mass: of each contact [kg], shape [slot].
        stored: energy of its springs [J], shape [slot].
        springs: stick springs [m], shape [slot, 3].
        dashpots: their forces [N], shape [slot].
    """
    forces = np.zeros(len(stored))
    (at,) = np.nonzero(stored > 0.0)
    stiffness = law.stiffness * mass[at]
    square = 2.0 * stored[at] / stiffness - (springs[at] ** 2).sum(axis=1)
    depth = np.sqrt(np.maximum(square, 0.0))
    forces[at] = np.maximum(stiffness * depth + dashpots[at], 0.0)
    return forces


def on_corners(contacts: np.ndarray, forces: np.ndarray, vertices: int) -> np.ndarray:
    """What contacts with triangles bring to their corners [N], shape [vertices].

    Args:
        contacts: records of `PlyContact`, shape [slot].
        forces: of the contacts [N], shape [slot].
        vertices: so many in all.
    """
    (at,) = np.nonzero(forces)
    total = np.zeros(vertices)
    for corner, name in enumerate("abc"):
        share = contacts["weights"][at, corner] * forces[at]
        total += np.bincount(contacts[name][at], weights=share, minlength=vertices)
    return total


def vertex_shapes(x: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Unit normals [-], shape [n, 3], and areas of vertices, thirds of triangles [m²], shape [n].

    Args:
        x: positions [m], shape [n, 3].
        triangles: vertices, shape [m, 3].
    """
    a, b, c = (x[triangles[:, corner]] for corner in range(3))
    cross = np.cross(b - a, c - a)
    count, corners = len(x), triangles.T.ravel()
    areas = np.bincount(
        corners, weights=np.tile(np.linalg.norm(cross, axis=1) / 6.0, 3), minlength=count
    )
    normals = np.stack(
        [np.bincount(corners, weights=np.tile(part, 3), minlength=count) for part in cross.T], 1
    )
    return normals / np.linalg.norm(normals, axis=1, keepdims=True), areas
