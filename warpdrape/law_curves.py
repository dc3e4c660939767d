"""A fabric's laws sampled on the host, through the very functions that the solver calls."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import warp as wp

from warpdrape.fabric import Fabric
from warpdrape.kernels.law_samples import make_law_samplers
from warpdrape.law_data import membrane_functions, shear_struct, tension_struct

_samplers = lru_cache(maxsize=None)(make_law_samplers)


def sample_tensions(
    fabric: Fabric, strains: np.ndarray, device: str = "cpu"
) -> tuple[np.ndarray, np.ndarray]:
    """Return line tensions [N/m], shape [n, 2], and energies [J/m²], shape [n].

    Args:
        fabric: a fabric with yarns.
        strains: (ε1, ε2), shape [n, 2].
        device: where to evaluate.
    """
    strains = np.asarray(strains, dtype=float)
    kernel, _ = _samplers(*membrane_functions(fabric))
    tension = wp.empty(len(strains), dtype=wp.vec2d, device=device)
    energy = wp.empty(len(strains), dtype=wp.float64, device=device)
    at = wp.array(strains, dtype=wp.vec2d, device=device)
    law = tension_struct(fabric, device)
    wp.launch(kernel, len(strains), inputs=[law, at], outputs=[tension, energy], device=device)
    return tension.numpy(), energy.numpy()


def sample_couples(
    fabric: Fabric, angles: np.ndarray, device: str = "cpu"
) -> tuple[np.ndarray, np.ndarray]:
    """Return couples per area C [N/m] and energies [J/m²] at shear angles [rad], shape [n]."""
    angles = np.asarray(angles, dtype=float)
    _, kernel = _samplers(*membrane_functions(fabric))
    couple = wp.empty(len(angles), dtype=wp.float64, device=device)
    energy = wp.empty(len(angles), dtype=wp.float64, device=device)
    at = wp.array(angles, dtype=wp.float64, device=device)
    law = shear_struct(fabric, device)
    wp.launch(kernel, len(angles), inputs=[law, at], outputs=[couple, energy], device=device)
    return couple.numpy(), energy.numpy()
