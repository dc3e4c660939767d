"""Whether a run was slow enough: kinetic energy against what deforming the plies took.

That is the internal energy, and of prepregs what their matrix has lost besides: a melt stores next
to nothing of what it resists with.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

QUASI_STATIC_END = 0.05
"""Kinetic over internal energy at the end that still counts as quasi-static [-]."""
QUASI_STATIC_MEAN = 0.10
"""Its mean while the plies are loaded [-]."""
LOADED = 0.1
"""Share of the largest internal energy from which the plies count as loaded [-]."""
LEAST_LOADED = 1e-6
"""Largest internal energy, over what the plies store when hardly loaded, below which nothing was
loaded at all [-]: with energy as the square of the shear that is a thousandth of 5°."""


def taken(history: Mapping[str, np.ndarray]) -> np.ndarray:
    """Energy that deforming the plies took, stored or lost to a matrix [J], shape [frame]."""
    return history["internal_j"] + history.get("matrix_viscosity_j", 0.0)


def mean_while_loaded(history: Mapping[str, np.ndarray], name: str) -> float:
    """An energy over what was `taken`, on average over the frames in which plies are loaded [-]."""
    internal = taken(history)
    if internal.max() <= 0.0:
        return 0.0
    loaded = internal >= LOADED * internal.max()
    return float(history[name][loaded].sum() / internal[loaded].sum())


def was_loaded(history: Mapping[str, np.ndarray], reference: float) -> bool:
    """Whether deforming the plies ever took energy to speak of.

    Args:
        history: columns over the frames.
        reference: what they store when hardly loaded [J], from `loading.reference_energy`.
    """
    return bool(taken(history).max() > LEAST_LOADED * reference)


def quasi_static(history: Mapping[str, np.ndarray]) -> tuple[float, float, bool]:
    """Kinetic energy over what was `taken` at the end, its mean while loaded, and the verdict."""
    kinetic, internal = history["kinetic_j"], taken(history)
    if internal.max() <= 0.0:
        return 0.0, 0.0, False
    mean = mean_while_loaded(history, "kinetic_j")
    end = float(kinetic[-1] / internal[-1]) if internal[-1] > 0.0 else float("inf")
    end = min(end, 1e12)
    return end, mean, bool(end < QUASI_STATIC_END and mean < QUASI_STATIC_MEAN)


def calm_from(history: Mapping[str, np.ndarray]) -> int | None:
    """Frame from which on kinetic energy stays small beside what was `taken`; None if never.

    Args:
        history: columns over the frames.
    """
    hasty = history["kinetic_j"] >= QUASI_STATIC_END * taken(history)
    first = int(np.flatnonzero(hasty)[-1]) + 1 if hasty.any() else 0
    return first if first < len(hasty) else None
