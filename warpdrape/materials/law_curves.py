"""A fabric's laws sampled on the host, through the very functions that the solver calls."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
import warp as wp

from warpdrape.kernels.materials.law_samples import make_law_samplers
from warpdrape.materials.fabric import Fabric
from warpdrape.materials.law_data import membrane_functions, shear_struct, tension_struct

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
    kernel, _ = _samplers(*membrane_functions(fabric))
    return _sample(kernel, tension_struct(fabric, device), strains, wp.vec2d, device)


def sample_couples(
    fabric: Fabric, angles: np.ndarray, device: str = "cpu"
) -> tuple[np.ndarray, np.ndarray]:
    """Return couples per area C [N/m] and energies [J/m²] at shear angles [rad], shape [n]."""
    _, kernel = _samplers(*membrane_functions(fabric))
    return _sample(kernel, shear_struct(fabric, device), angles, wp.float64, device)


def _sample(
    kernel: Any, law: Any, at: np.ndarray, dtype: type, device: str
) -> tuple[np.ndarray, np.ndarray]:
    """Values, of the type of the arguments, and energies of a law at n arguments."""
    arguments: wp.array[Any] = wp.array(np.asarray(at, dtype=float), dtype=dtype, device=device)
    values = wp.empty(len(at), dtype=dtype, device=device)
    energies = wp.empty(len(at), dtype=wp.float64, device=device)
    wp.launch(kernel, len(at), inputs=[law, arguments], outputs=[values, energies], device=device)
    return values.numpy(), energies.numpy()
