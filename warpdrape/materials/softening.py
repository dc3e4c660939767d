"""Softer yarns for a larger time step: what a run computes with, and what that costs in strain.

Yarns are about 10⁴ times stiffer than shear, so that they alone set the stable step, while their
strains in forming stay far below any that shows. Tensions divided by s make the step √s larger and
the strains s times larger. Nothing else becomes slower: it is mass scaling of the yarns' stretching
alone, without a matrix to solve. Resistance to compression is kept: it is small already, and a
flange under the blank holder leans on it.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from warpdrape.errors import InputError
from warpdrape.materials.fabric import Fabric
from warpdrape.materials.laws import CrimpInterchange, LinearTension, TabulatedTension, TensionLaw

STRAIN_WARNING = 2e-3
"""Strain owed to softening above which a run warns [-]."""
TINY = 1e-300
RECOVERY_WARNING = 0.2
"""Energy that recovery may give over the work from outside before a run warns [-]."""


def soften(fabric: Fabric, softening: float) -> Fabric:
    """Divide the tensions of a fabric's yarns, and keep what resists compression and shear.

    An isotropic membrane has no yarns and stays as it is.

    Args:
        fabric: as measured.
        softening: divisor s of the tensions, 1 or more [-].

    Raises:
        InputError: if the softened yarns would resist compression more than tension.
    """
    if softening == 1.0 or not isinstance(fabric.tension, _LAWS_OF_YARNS):
        return fabric
    factor = fabric.compressive_factor * softening
    if factor > 1.0 + 1e-12:
        raise InputError(
            f"yarn_softening = {softening:g} is above {1.0 / fabric.compressive_factor:g}, where "
            f"the yarns of {fabric.name!r} (compressive_factor = {fabric.compressive_factor:g}) "
            "would resist compression more than tension: lower it"
        )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # given when the fabric itself was made
        return replace(
            fabric,
            tension=_divide(fabric.tension, softening),
            compressive_factor=min(factor, 1.0),
        )


_LAWS_OF_YARNS = LinearTension | TabulatedTension | CrimpInterchange


def _divide(law: TensionLaw, softening: float) -> TensionLaw:
    names = {
        LinearTension: ("warp", "weft"),
        TabulatedTension: ("tension_warp", "tension_weft"),
        CrimpInterchange: ("stiffness_warp", "stiffness_weft"),
    }[type(law)]
    return replace(law, **{name: np.divide(getattr(law, name), softening) for name in names})


def softening_entries(
    softening: float, history: Mapping[str, np.ndarray], strain: float
) -> dict[str, float]:
    """Entries of ``summary.json``: the softening, and what it may have cost by the end.

    The strain owed to it, ε(1 − 1/s), is exact for linear yarns; yarns that stiffen as they stretch
    owe less. Where they recover the history has what is still owed, and its mean over the run tells
    what was owed on the way. What yarns store over what the plies do says how far they are from
    inextensible.

    Args:
        softening: divisor s of the tensions [-].
        history: columns over the frames.
        strain: the largest yarn strain at the end [-].
    """
    internal = float(history["internal_j"][-1])
    entries = {
        "yarn_softening": float(softening),
        "softening_strain": max(strain, 0.0) * (1.0 - 1.0 / softening),
        "yarn_energy_ratio": float(history["yarn_j"][-1]) / internal if internal > 0.0 else 0.0,
    }
    if "softening_strain" in history:
        owed = history["softening_strain"]
        entries["softening_strain"] = float(owed[-1])
        entries["mean_softening_strain"] = float(np.mean(owed))
    return entries


def recovery_warnings(history: Mapping[str, np.ndarray]) -> list[str]:
    """Warn where what softened yarns recovered moved the plies: they keep swinging then.

    Args:
        history: columns over the frames.
    """
    if "recovery_j" not in history:
        return []
    given, work = -float(history["recovery_j"][-1]), float(history["external_work_j"][-1])
    if given <= RECOVERY_WARNING * abs(work):
        return []
    return [
        f"softened yarns gave {100 * given / max(abs(work), TINY):.2g} % of the work done as they "
        "recovered their tension, and keep lightly loaded plies swinging by it: set "
        "yarn_recovery = 0 (in press scenes take accuracy = reference)"
    ]


def softening_warnings(entries: Mapping[str, float]) -> list[str]:
    """Warn where softened yarns stretch too far; see `softening_entries`."""
    if entries["softening_strain"] <= STRAIN_WARNING:
        return []
    return [
        f"softened yarns stretch by {100 * entries['softening_strain']:.2g} % more than the fabric "
        f"(limit {100 * STRAIN_WARNING:.2g} %): lower yarn_softening = "
        f"{entries['yarn_softening']:g} (in press scenes take accuracy = reference, or leave out "
        "fast)"
    ]
