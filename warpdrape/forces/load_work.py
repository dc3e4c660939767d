"""Work of loads on plies, counted as the integrator counts kinetic energy."""

from __future__ import annotations

import numpy as np
import warp as wp


def work_done(work: wp.array, acted: wp.array, way: np.ndarray) -> float:
    """Work done by a load so far [J].

    Velocities are half a step on: so is the work, by half of the force that led there.

    Args:
        work: up to the last step [J], shape [loaded].
        acted: forces in the last step [N], shape [loaded].
        way: gone since [m], shape [loaded, 3].
    """
    return float(work.numpy().sum() + 0.5 * (acted.numpy() * way).sum())
