"""Methods by which places are chosen, by name."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from warpdrape.optimisation import descent, gaussian, parzen
from warpdrape.optimisation.descent import GRADIENT
from warpdrape.optimisation.known import Known
from warpdrape.optimisation.space import Axis, Place
from warpdrape.optional import needed

GP, TPE = "gp", "tpe"
METHODS: dict[str, Callable[[Sequence[Axis], Sequence[Known], int, int], list[Place]]] = {
    GP: gaussian.propose,
    TPE: parzen.propose,
    GRADIENT: descent.propose,
}
"""Name → what asks for places: Gaussian processes, the tree-structured Parzen estimator, slopes."""
_PACKAGES = {GP: "sklearn.gaussian_process", TPE: "optuna"}


def check_method(method: str) -> None:
    """Raise `InputError` where what a method needs is not installed."""
    if method in _PACKAGES:
        needed(_PACKAGES[method], "optimise")
