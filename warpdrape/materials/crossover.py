"""How yarns slide through the crossovers of a weave: force at which they slip, stiffness before."""

from __future__ import annotations

from dataclasses import dataclass

from warpdrape.errors import InputError, positive
from warpdrape.wording import brief

MOST_FRICTION = 2.0
"""Slip force over what presses beyond which it must have another unit [-]."""
LONGEST_HOLD = 1e-3
"""Slide before a yarn slips beyond which a unit must be wrong [m]: a crossing is that wide."""


@dataclass(frozen=True, kw_only=True)
class Crossover:
    """Where one warp yarn crosses one weft yarn; for ``approach = 'sliding_yarns'``.

    A yarn is held there by a spring until its force reaches the slip force, then slips at it. Both
    follow from pulling a yarn out of a patch: the largest force over the number of yarns crossed,
    and the slope of the rise (docs/approaches.md).

    Attributes:
        slip_force_warp: at which a warp yarn slips through a crossing [N].
        slip_force_weft: likewise a weft yarn [N].
        stiffness_warp: force over slide of a warp yarn before it slips [N/m].
        stiffness_weft: likewise of a weft yarn [N/m].
        friction: slip force that is added per tension of the yarn that is crossed [-].
        yarn_friction: slip force that is added per force with which the yarns press on each other
            [-]: what goes through the ply from tools and other plies, and, where the tension law
            knows their crimp, 2 t h/L of a yarn of tension t that climbs h over a length L from
            crossing to crossing.
    """

    slip_force_warp: float
    slip_force_weft: float
    stiffness_warp: float
    stiffness_weft: float
    friction: float = 0.0
    yarn_friction: float = 0.0

    __repr__ = brief

    def __post_init__(self) -> None:
        for family in ("warp", "weft"):
            force = positive(f"crossover.slip_force_{family}", self.slip(family), zero=True)
            stiffness = positive(f"crossover.stiffness_{family}", self.stiffness(family))
            if force > LONGEST_HOLD * stiffness:
                raise InputError(
                    f"crossover.stiffness_{family} = {stiffness:g} N/m gives way by "
                    f"{1e3 * force / stiffness:.3g} mm before the yarn slips at {force:g} N, more "
                    f"than {1e3 * LONGEST_HOLD:g} mm: check the units of both"
                )
        for name, of in (
            ("friction", "tension of the crossed yarn"),
            ("yarn_friction", "force that presses the yarns together"),
        ):
            value = positive(f"crossover.{name}", getattr(self, name), zero=True)
            if value > MOST_FRICTION:
                raise InputError(
                    f"crossover.{name} = {value:g} is above {MOST_FRICTION:g}: give the slip force "
                    f"per {of}, 0.2 for 20 %"
                )

    def slip(self, family: str) -> float:
        """Slip force of "warp" or "weft" yarns [N]."""
        return self.slip_force_warp if family == "warp" else self.slip_force_weft

    def stiffness(self, family: str) -> float:
        """Stiffness for "warp" or "weft" yarns [N/m]."""
        return self.stiffness_warp if family == "warp" else self.stiffness_weft
