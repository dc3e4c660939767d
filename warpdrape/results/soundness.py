"""How far a run can be trusted, by its energies: unbalanced ones, kinetic ones, stored ones."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from warpdrape.dynamics.loading import reference_energy
from warpdrape.dynamics.model import Model
from warpdrape.results.quasi_static import LEAST_LOADED, quasi_static, was_loaded

ENERGY_WARNING = 0.02
"""Unbalanced share of the largest energy above which a run warns [-]."""
ENERGY_FAILURE = 0.10
"""… and above which it fails [-]."""


@dataclass(frozen=True)
class Soundness:
    """What the energies of a run say of it.

    Attributes:
        failure: why the run failed, empty if it did not.
        energy_error: unbalanced energy over the largest energy [-].
        kinetic_end: kinetic over internal energy at the end [-].
        kinetic_loaded: its mean while the plies are loaded [-].
        calm: whether both are small.
        loaded: whether deforming the plies ever took energy to speak of.
        least: energy that counts as none [J].
    """

    failure: str
    energy_error: float
    kinetic_end: float
    kinetic_loaded: float
    calm: bool
    loaded: bool
    least: float


def soundness_of(
    model: Model, history: Mapping[str, np.ndarray], failure: str, grown: float
) -> Soundness:
    """Look at the energies of a run.

    Args:
        model: the model.
        history: columns over the frames.
        failure: why the run stopped early, empty if it did not.
        grown: share of energy that came from nowhere after the last good frame [-], if it did.
    """
    reference = reference_energy(tuple(model.scene.plies))
    least = LEAST_LOADED * reference
    error = max(energy_error(history, least), grown if np.isfinite(grown) else 0.0)
    if not failure and error > ENERGY_FAILURE:
        failure = (
            f"{100 * error:.1f} % of the energy is unbalanced "
            f"(limit {100 * ENERGY_FAILURE:.0f} %): refine the tool meshes or the plies, "
            "or lower contact_share"
        )
    end, mean, calm = quasi_static(history)
    return Soundness(failure, error, end, mean, calm, was_loaded(history, reference), least)


def energy_error(history: Mapping[str, np.ndarray], least: float = 0.0) -> float:
    """Largest unbalanced energy over the largest energy of the run [-].

    Args:
        history: columns over the frames.
        least: energy [J] below which the largest is nothing but rounding.
    """
    names = ("kinetic_j", "internal_j", "friction_j", "damping_j", "external_work_j")
    largest = max(least, *(np.abs(history[name]).max() for name in names))
    return float(np.abs(history["unbalanced_j"]).max() / largest) if largest > 0.0 else 0.0
