"""Hypoelastic membranes in the frame of Green and Naghdi: the polar decomposition's rotation.

Moduli are along the flat yarns' directions turned by R, which the yarns leave in shear.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from warpdrape.blanks.ply import Ply
from warpdrape.blanks.triangles import flat_gradients, highest_frequency_squared
from warpdrape.forces.hypoelastic import StressedMembranes, build_stressed, refuse_rubber
from warpdrape.forces.membrane import yarn_viscosity
from warpdrape.forces.membrane_stiffness import stabiliser_range
from warpdrape.interaction import Span
from warpdrape.kernels.forces.objective_rates import polar_rows
from warpdrape.materials.law_data import shear_stiffness, tension_stiffness
from warpdrape.materials.laws import IsotropicMembrane
from warpdrape.materials.softening import soften
from warpdrape.numerics import Numerics
from warpdrape.setup import Setup

FRAME_RANGE = math.radians(60.0)
"""Shear angle of yarns that do not stretch up to which the stable step covers the frame [rad].

In this frame a sheet rather stretches its yarns than its frame's directions, and keeps its area:
its diagonals are as long then at a shear angle of 75°."""
ANGLES = 120
"""Steps of shear up to `FRAME_RANGE` by which the bound follows the frame."""
BOUNDS = 12
"""Of them, those at which the bound is taken."""


class Sheared(NamedTuple):
    """The frame of a sheet whose yarns turn and do not stretch.

    Attributes:
        directions: p, the frame's own in terms of k1 and k2, one a column, shape [2, 2].
        stretch: U⁻¹ times the flat yarns' directions, lengths [-], shape [2].
        shear: that it has seen between its directions [rad].
    """

    directions: np.ndarray
    stretch: np.ndarray
    shear: float


def build(
    scene: Setup, spans: tuple[Span, ...], time_step: float, device: str
) -> StressedMembranes:
    """Put the membranes of all plies on a device."""
    return build_stressed(scene, spans, device, polar_rows)


def frequencies(scene: Setup, number: int) -> np.ndarray:
    """Bound on ω² [1/s²] of each triangle of a ply, given its number.

    Where a sheet is sheared its short diagonal carries the stresses of both of the frame's
    directions: the bound is the largest over shear angles up to `FRAME_RANGE`.
    """
    ply = scene.plies[number]
    refuse_rubber(ply.fabric, "green_naghdi")
    gradients, _ = flat_gradients(ply)
    highest = np.zeros(len(gradients))
    for state in sheared_frames(ply.fabric.yarn_angle):
        seen = np.column_stack(
            [
                p[0] * gradients[:, 0:2] + p[1] * gradients[:, 2:4]
                for p in state.directions.T  # D along the frame's own directions
            ]
        )
        yarns, shear = _stiffness(ply, scene.numerics, state)
        found = highest_frequency_squared(seen, ply.fabric.areal_density, yarns, shear)
        highest = np.maximum(highest, found)
    return highest


def sheet_stiffness(ply: Ply, numerics: Numerics) -> tuple[tuple[float, float], float]:
    """Bounds on the stiffness of a ply along warp and weft [N/m], shear in them.

    |b_α·dF F⁻¹·b_α|² ≤ |U⁻¹ t_α|² |dF|², and |dF|² ≤ (|dk1|² + |dk2|²)/(1 − |cos θ0|).
    """
    largest = 0.0
    for state in sheared_frames(ply.fabric.yarn_angle):
        yarns, shear = _stiffness(ply, numerics, state)
        squares = state.stretch**2
        largest = max(largest, float(squares @ yarns + 2.0 * shear * squares.sum()))
    largest /= 1.0 - abs(math.cos(ply.fabric.yarn_angle))
    return (largest, largest), 0.0


def _stiffness(ply: Ply, numerics: Numerics, state: Sheared) -> tuple[tuple[float, float], float]:
    """Stiffness along the frame's directions and between them [N/m], with what viscosity takes."""
    fabric = ply.fabric
    if isinstance(fabric.tension, IsotropicMembrane):
        sheet = fabric.tension
        stiffness = sheet.stiffness / (1.0 - abs(sheet.poisson))
        return (stiffness, stiffness), 0.5 * sheet.stiffness / (1.0 + sheet.poisson)
    yarns = tension_stiffness(soften(fabric, numerics.yarn_softening))
    drag = yarn_viscosity(fabric, numerics)
    _, stabiliser = stabiliser_range(ply, numerics)
    warp, weft = (y + 2.0 * d + stabiliser for y, d in zip(yarns, drag, strict=True))
    return (warp, weft), shear_stiffness(fabric, abs(state.shear))


def sheared_frames(rest_angle: float) -> Iterator[Sheared]:
    """Frames of a sheet sheared either way, from none to `FRAME_RANGE`.

    Args:
        rest_angle: from warp to weft of the flat ply [rad].
    """
    flat = np.array([[1.0, math.cos(rest_angle)], [0.0, math.sin(rest_angle)]])
    for way in (1.0, -1.0):
        stretched, seen = np.eye(2), np.zeros((2, 2))
        for number in range(ANGLES + 1):
            angle = rest_angle - way * FRAME_RANGE * number / ANGLES
            if not 0.05 < angle < math.pi - 0.05:
                break
            yarns = np.array([[1.0, math.cos(angle)], [0.0, math.sin(angle)]])
            before, stretched = stretched, _stretch(yarns @ np.linalg.inv(flat))
            rate = (stretched - before) @ np.linalg.inv(0.5 * (stretched + before))
            seen += 0.5 * (rate + rate.T)
            if number % (ANGLES // BOUNDS):
                continue
            inverse = np.linalg.inv(stretched)
            along = np.einsum("ia,ij,ja->a", flat, seen, flat).sum()
            across = 2.0 * flat[:, 0] @ seen @ flat[:, 1] - math.cos(rest_angle) * along
            yield Sheared(
                np.linalg.inv(flat) @ inverse @ flat,
                np.linalg.norm(inverse @ flat, axis=0),
                float(across / math.sin(rest_angle)),
            )


def _stretch(gradient: np.ndarray) -> np.ndarray:
    """U of F = R U, shape [2, 2]."""
    values, vectors = np.linalg.eigh(gradient.T @ gradient)
    return vectors * np.sqrt(values) @ vectors.T
