"""Friction of interfaces as contacts read it: coefficients, and tables where they vary."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import warp as wp

from warpdrape.blanks.triangles import yarn_gradients
from warpdrape.kernels.contact.friction import FrictionLaws, Rub
from warpdrape.materials.friction import TABLES, Friction
from warpdrape.setup import Setup


def friction_laws(scene: Setup, device: str) -> FrictionLaws:
    """Put the tables of all laws on a device."""
    laws = FrictionLaws()
    varying = scene.friction_laws
    tables = [law.factors(name) for law in varying for name in TABLES]
    points = np.concatenate([*tables, np.zeros((1, 2))])  # no array may be empty
    laws.points = wp.array(points, dtype=wp.vec2d, device=device)
    first = np.cumsum([0, *map(len, tables)])
    laws.first = wp.array(first, dtype=wp.int32, device=device)
    shifted = [int(law.shifted) for law in varying] or [0]
    laws.shifted = wp.array(shifted, dtype=wp.int32, device=device)
    laws.shifts = wp.array(first_shifts(scene), dtype=wp.float64, device=device)
    warps = np.zeros((1, 2))
    if any(law.by_angle for law in varying):
        warps = np.concatenate(
            [
                yarn_gradients(ply.mesh.vertices, np.asarray(ply.mesh.triangles), *directions)[0]
                for ply in scene.plies
                for directions in (ply.yarn_directions,)
            ]
        )[:, :2]
    laws.warps = wp.array(np.ascontiguousarray(warps), dtype=wp.vec2d, device=device)
    laws.pace = scene.pace
    return laws


def first_shifts(scene: Setup) -> np.ndarray:
    """Shift factors of the plies' matrices as they are laid in, 1 of dry ones, shape [vertex].

    Where none is asked for it has one entry: no array may be empty.
    """
    if not any(law.shifted for law in scene.friction_laws):
        return np.ones(1)
    matrices = [(ply, ply.fabric.matrix) for ply in scene.plies]
    factors = [1.0 if of is None else of.factor(ply.warmth) for ply, of in matrices]
    return np.repeat(factors, [len(ply.mesh.vertices) for ply in scene.plies])


def rubs(scene: Setup, frictions: Sequence[Friction], device: str) -> wp.array:
    """Frictions of interfaces for the kernels, in their order.

    Args:
        scene: what is computed.
        frictions: of its interfaces.
        device: Warp device.
    """
    array = np.zeros(len(frictions), dtype=Rub.numpy_dtype())
    array["coefficient"] = [friction.coefficient for friction in frictions]
    array["law"] = [_number(scene, friction) for friction in frictions]
    array["viscosity"] = [friction.viscosity for friction in frictions]
    return wp.array(array, dtype=Rub, device=device)


def rub(scene: Setup, friction: Friction) -> Rub:
    """Friction of one interface for the kernels."""
    one = Rub()
    one.coefficient = friction.coefficient
    one.law = _number(scene, friction)
    one.viscosity = friction.viscosity
    return one


def _number(scene: Setup, friction: Friction) -> int:
    """Number of its law plus one; 0 where a coefficient is all there is."""
    for number, law in enumerate(scene.friction_laws):
        if law is friction:
            return number + 1
    return 0
