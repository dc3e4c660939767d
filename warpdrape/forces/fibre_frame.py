"""Hypoelastic membranes whose stress turns with the yarns: a frame along each family."""

from __future__ import annotations

import numpy as np

from warpdrape.errors import InputError
from warpdrape.forces import membrane
from warpdrape.forces.hypoelastic import StressedMembranes, build_stressed, refuse_rubber
from warpdrape.interaction import Span
from warpdrape.kernels.forces.objective_rates import fibre_rows
from warpdrape.materials.laws import IsotropicMembrane
from warpdrape.setup import Setup


def build(
    scene: Setup, spans: tuple[Span, ...], time_step: float, device: str
) -> StressedMembranes:
    """Put the membranes of all plies on a device."""
    return build_stressed(scene, spans, device, fibre_rows)


sheet_stiffness = membrane.sheet_stiffness
"""The tangents are those of the semi-discrete element, along the same directions."""


def frequencies(scene: Setup, number: int) -> np.ndarray:
    """Bound on ω² [1/s²] of each triangle of a ply, given its number.

    Raises:
        InputError: if the ply has no yarns that a frame could follow.
    """
    fabric = scene.plies[number].fabric
    refuse_rubber(fabric, "fibre_frame")
    if isinstance(fabric.tension, IsotropicMembrane):
        raise InputError(
            f"approach = 'fibre_frame' follows yarns, and fabric {fabric.name!r} is an isotropic "
            "membrane: take approach = 'green_naghdi' or 'semi_discrete'"
        )
    return membrane.frequencies(scene, number)
