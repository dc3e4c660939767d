"""How softened yarns recover the tension that softening withholds: rates, and what it amounts to.

The rates follow from the lowest frequency at which a ply swings along its yarns, that of a bar as
long with free ends, so that all that swings is damped (docs/theory.md).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import warp as wp

from warpdrape.blanks.ply import Ply, longest_yarn
from warpdrape.blanks.triangles import flat_gradients, highest_frequency_squared
from warpdrape.interaction import Measured
from warpdrape.kernels.forces.recovery import Recovery, RecoveryRates
from warpdrape.materials.law_data import tension_stiffness
from warpdrape.materials.laws import Unwoven
from warpdrape.materials.softening import soften
from warpdrape.numerics import Numerics

SLOWER = 0.2
"""ω over that frequency [-]: what swings at ω itself is neither damped nor fed. Yarns that are
pushed askew, as early in a stroke, swing as much slower as they lie flat. No step up to the
stable one then lets anything faster grow (tests/test_recovery.py)."""
TINY = 1e-300


def recovers(ply: Ply, numerics: Numerics) -> bool:
    """Whether a ply's yarns are softened, and recover what that withholds."""
    woven = not isinstance(ply.fabric.tension, Unwoven)
    return woven and numerics.yarn_softening > 1.0 and numerics.yarn_recovery > 0.0


def guard_stiffness(ply: Ply, numerics: Numerics) -> tuple[float, float]:
    """Stiffness c of the guard along warp and weft [N/m]: 2 g k_s/ω, g a share of ω."""
    if not recovers(ply, numerics):
        return 0.0, 0.0
    warp, weft = tension_stiffness(soften(ply.fabric, numerics.yarn_softening))
    return 2.0 * numerics.yarn_recovery * warp, 2.0 * numerics.yarn_recovery * weft


def lowest_frequency(ply: Ply, numerics: Numerics, time_step: float) -> float:
    """Lowest ω at which a ply with softened yarns swings along them [1/s].

    Added mass makes it lower; it is taken to be as much everywhere as where it is most.

    Args:
        ply: the ply.
        numerics: softening, and added mass.
        time_step: Δt [s].
    """
    softened = tension_stiffness(soften(ply.fabric, numerics.yarn_softening))
    speed = math.sqrt(min(softened) / ply.fabric.areal_density)
    lowest = math.pi * speed / longest_yarn(ply)
    if numerics.minimum_time_step is None or numerics.mass_scaling != "plain":
        return lowest
    gradients, _ = flat_gradients(ply)
    warp, weft = (k + c for k, c in zip(softened, guard_stiffness(ply, numerics), strict=True))
    highest = highest_frequency_squared(gradients, ply.fabric.areal_density, (warp, weft), 0.0)
    stable = 2.0 * numerics.safety / math.sqrt(float(highest.max()))
    return lowest * min(1.0, stable / time_step)


def recovery_rates(ply: Ply, numerics: Numerics, time_step: float) -> RecoveryRates:
    """A ply's rates; all zero where its yarns do not recover.

    Args:
        ply: the ply.
        numerics: softening and recovery.
        time_step: Δt [s].
    """
    rates = RecoveryRates()
    if recovers(ply, numerics):
        slowest = lowest_frequency(ply, numerics, time_step) * time_step
        rates.followed = SLOWER * slowest
        rates.taken_up = numerics.yarn_recovery * rates.followed
        rates.let_go = rates.taken_up / (numerics.yarn_softening - 1.0)
        rates.guard = wp.vec2d(*guard_stiffness(ply, numerics))
    return rates


@dataclass(frozen=True, eq=False)
class Recovered:
    """What a ply's yarns have recovered.

    Attributes:
        tension: R of the patch of each triangle [N/m], shape [triangle, 2].
        stored: R²/(2 (s − 1) k_s), what linear yarns store beyond T_s once they have recovered [J].
        taken: the work of all that is beside T_s, less that [J]; negative where yarns were
            stretched before they recovered, and then pulled back.
    """

    tension: np.ndarray
    stored: float
    taken: float

    def owed_strain(self, strain: np.ndarray, softened: np.ndarray, softening: float) -> float:
        """Largest strain that is still owed to softening [-].

        Of the strain ε(1 − 1/s) that softening makes, the share that R lacks of (s − 1) T_s.

        Args:
            strain: ε of triangles [-], shape [triangle, 2].
            softened: T_s [N/m], shape [triangle, 2].
            softening: s [-].
        """
        taut = np.maximum(softened, TINY)
        lacking = np.clip(1.0 - self.tension / ((softening - 1.0) * taut), 0.0, 1.0)
        return float((np.maximum(strain, 0.0) * lacking).max() * (1.0 - 1.0 / softening))


def recovered_by(
    ply: Ply, numerics: Numerics, memory: np.ndarray, areas: np.ndarray
) -> tuple[np.ndarray, float, float]:
    """What a ply's patches have recovered.

    Args:
        ply: the ply.
        numerics: softening and recovery.
        memory: of its patches, as the kernels' `Recovery`, shape [patch].
        areas: theirs [m²], shape [patch].

    Returns:
        Tensions [N/m], shape [patch, 2]; what is stored, and taken besides [J]: as of `Recovered`.
    """
    withheld = (1.0 - 1.0 / numerics.yarn_softening) * np.array(tension_stiffness(ply.fabric))
    stored = float(areas @ (0.5 * memory["tension"] ** 2 / withheld).sum(axis=1))
    return memory["tension"], stored, float(memory["taken"].sum()) - stored


def measured(
    stored: dict[str, float],
    lost: dict[str, float],
    shown: Sequence[tuple[np.ndarray, np.ndarray]],
    recovered: Sequence[Recovered | None],
    softening: float,
) -> Measured:
    """What a membrane shows, with what its yarns have recovered.

    Args:
        stored: energies of softened yarns and all else, by name [J].
        lost: likewise.
        shown: by ply the strain ε [-] and T_s [N/m] of triangles, each shape [triangle, 2].
        recovered: by ply; None where nothing recovers.
        softening: s [-].
    """
    fields, owed = [], []
    for (strain, softened), beside in zip(shown, recovered, strict=True):
        tension = softened
        if beside is not None:
            tension = softened + beside.tension
            stored["yarn"] += beside.stored
            lost["recovery"] = lost.get("recovery", 0.0) + beside.taken
            owed.append(beside.owed_strain(strain, softened, softening))
        fields.append({"strain": strain, "line_tension": tension})
    readings = {"softening_strain": max(owed)} if owed else {}
    return Measured(stored, lost, fields=tuple(fields), readings=readings)


def start_recovery(ply: Ply, numerics: Numerics, patches: int, device: str) -> wp.array:
    """What a ply's patches remember at first; of none where nothing recovers."""
    return wp.zeros(patches if recovers(ply, numerics) else 0, dtype=Recovery, device=device)
