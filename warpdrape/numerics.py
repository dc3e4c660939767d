"""How a run is computed: what a user may tune, and its limits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from warpdrape.errors import InputError, finite, one_of, positive
from warpdrape.over_time import never_negative
from warpdrape.wording import brief

_SOFTENED = {"yarn_softening": 100.0, "yarn_recovery": 0.4, "search_slide": 1e-4}
ACCURACIES: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        "draft": {**_SOFTENED, "contact_share": 0.1},
        "standard": {**_SOFTENED, "contact_share": 0.15},
        "reference": {},
    }
)
"""Accuracies by name: what each changes of a `Numerics`, chosen by errors measured against a
converged run (docs/performance.md). Softer yarns make steps longer; contacts soften with the
square of the step, and the larger share, at 15 % of the step, makes up for some of it."""
START_TOLERANCE = 0.01
"""Share of the ply thickness by which things may overlap at the start [-]."""


@dataclass(frozen=True, kw_only=True)
class Numerics:
    """How a run is computed; the defaults suit forming.

    Attributes:
        averaging: "pairs" shares yarn strains between two triangles; "plain" does not.
        stabiliser: κ of what keeps the strains of a pair's triangles alike, in units of the initial
            shear stiffness [-]; None for one that grows as 1/h², patch by patch.
        stabiliser_floor: least stabiliser, as a share of the yarn stiffness [-].
        damping: mass-proportional damping rate [1/s]; or pairs (time [s], rate [1/s]) through which
            it goes smoothly, the ends holding before and after: none while a ply is formed, some
            while it comes to rest.
        contact_share: penalty stiffness over m/Δt² [-].
        contact_damping: damping of the contacts over their critical one [-].
        search_slide: sliding at tool speed between two contact searches [m].
        contact: "fast" searches every few steps and only where things have moved; "exact" asks for
            every vertex at every step, many times slower, to check the other against.
        time_step: Δt [s]; None takes ``safety`` times the stable one.
        safety: Δt over the stable step [-].
        minimum_time_step: mass is added until the stable step reaches it [s]; None adds none.
        mass_scaling: "plain" adds it to vertices; "selective" to the stretching of triangles alone,
            none to the motion of larger pieces.
        kinetic_limit: kinetic over internal energy [-], below 1, above which tools and clamps go
            slower than their motions say, at most ten times; None lets them go as they are given.
        yarn_viscosity: tension per change of strain in a step, over the yarns' stiffness [-]; holds
            yarns still that rest where tension turns into compression.
        yarn_softening: divides the yarns' tensions, for a larger step; strains grow by it [-].
        yarn_recovery: rate at which softened yarns recover the tension that this withholds, over
            the lowest frequency at which a ply swings along its yarns [-]: loads that last stretch
            them no more than the fabric's. 0 for never.
        graph: replay captured launches (the same results, faster).
    """

    averaging: str = "pairs"
    stabiliser: float | None = None
    stabiliser_floor: float = 2e-6
    damping: float | Sequence[tuple[float, float]] = 0.0
    contact_share: float = 0.04
    contact_damping: float = 0.3
    search_slide: float = 4e-5
    contact: str = "fast"
    time_step: float | None = None
    safety: float = 0.9
    minimum_time_step: float | None = None
    mass_scaling: str = "plain"
    kinetic_limit: float | None = None
    yarn_viscosity: float = 0.067
    yarn_softening: float = 1.0
    yarn_recovery: float = 0.0
    graph: bool = True

    __repr__ = brief

    @classmethod
    def for_accuracy(cls, accuracy: str, **changes: Any) -> Numerics:
        """Numerics of an accuracy, for a press with dry plies that yarns do not carry.

        Args:
            accuracy: "draft", "standard" or "reference", which is ``Numerics()``.
            changes: further fields, which count more than the accuracy's own.

        Raises:
            InputError: if there is no such accuracy.
        """
        return cls(**{**ACCURACIES[one_of("accuracy", accuracy, ACCURACIES)], **changes})

    def __post_init__(self) -> None:
        one_of("averaging", self.averaging, ("pairs", "plain"))
        one_of("contact", self.contact, ("fast", "exact"))
        one_of("mass_scaling", self.mass_scaling, ("plain", "selective"))
        if self.mass_scaling == "selective" and self.minimum_time_step is None:
            raise InputError(
                "mass_scaling = 'selective' adds mass until a step is reached: give "
                "minimum_time_step, in seconds"
            )
        if self.stabiliser is not None:
            positive("stabiliser", self.stabiliser, zero=True)
        positive("stabiliser_floor", self.stabiliser_floor, zero=True)
        if positive("yarn_viscosity", self.yarn_viscosity, zero=True) > 0.5:
            raise InputError(
                f"yarn_viscosity = {self.yarn_viscosity} must not exceed 0.5: it takes that much "
                "of the stable step"
            )
        object.__setattr__(self, "damping", never_negative("damping", self.damping, "1/s"))
        if positive("contact_damping", self.contact_damping, zero=True) > 1.0:
            raise InputError(
                f"contact_damping = {self.contact_damping} must not exceed 1, critical"
            )
        positive("search_slide", self.search_slide, unit="m")
        if not 0.0 < positive("contact_share", self.contact_share) <= 0.2:
            raise InputError(
                f"contact_share = {self.contact_share} must not exceed 0.2: it is the "
                "penalty stiffness over m/Δt², and contacts of one vertex add up"
            )
        if not 0.0 < positive("safety", self.safety) <= 1.0:
            raise InputError(f"safety = {self.safety} must lie in 0 … 1")
        if not 1.0 <= finite("yarn_softening", self.yarn_softening):
            raise InputError(
                f"yarn_softening = {self.yarn_softening} must be 1 or more: it divides tensions"
            )
        if positive("yarn_recovery", self.yarn_recovery, zero=True) > 0.5:
            raise InputError(
                f"yarn_recovery = {self.yarn_recovery} must not exceed 0.5: what damps it is twice "
                "that share of the softened yarns' stiffness, and takes of the step"
            )
        if self.kinetic_limit is not None and positive("kinetic_limit", self.kinetic_limit) >= 1.0:
            raise InputError(
                f"kinetic_limit = {self.kinetic_limit:g} must stay below 1: it is kinetic over "
                "internal energy, 5 % is 0.05"
            )
        for name in ("time_step", "minimum_time_step"):
            if getattr(self, name) is not None:
                positive(name, getattr(self, name), unit="s")
