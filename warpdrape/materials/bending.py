"""Bending of a ply: moduli of an orthotropic plate along its yarns, per metre of width."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from warpdrape.errors import InputError, finite, positive

TWIST_SHARE = 0.1
"""Twisting modulus over √(B₁ B₂) where none is given [-]: fibres that slide hardly resist twisting.
Bent at 45° to its yarns a balanced fabric then has 0.6 of its stiffness along them."""
GRAVITY = 9.81
"""m/s², with which flexural lengths are turned into stiffness."""


@dataclass(frozen=True, kw_only=True)
class Bending:
    """Resistance of a ply to bending, linear in the yarns' curvatures.

    Energy per area ½ [B₁ κ₁·κ₁ + 2 B₁₂ κ₁·κ₂ + B₂ κ₂·κ₂ + 4 B₆₆ κ₁₂·κ₁₂] of the curvature vectors
    κ₁ = ∂²x/∂y₁², κ₂ = ∂²x/∂y₂², κ₁₂ = ∂²x/∂y₁∂y₂: yarns bend within the ply as they do out of it,
    since their fibres slide either way. That is the least that they can have in the plane; held
    together, a wide yarn would have (width/thickness)² times more there.

    Attributes:
        warp: B₁, moment of the warp yarns over their curvature, per metre of width [N·m].
        weft: B₂, likewise [N·m].
        twist: B₆₆ [N·m]; a tenth of √(B₁ B₂) if not given.
        coupling: B₁₂ [N·m], none between yarns that slide on each other.
    """

    warp: float
    weft: float
    twist: float | None = None
    coupling: float = 0.0

    def __post_init__(self) -> None:
        for name in ("warp", "weft"):
            positive(f"bending.{name}", getattr(self, name), unit="N·m", zero=True)
        if self.twist is None:
            object.__setattr__(self, "twist", TWIST_SHARE * math.sqrt(self.warp * self.weft))
        positive("bending.twist", self.twist, unit="N·m", zero=True)
        if finite("bending.coupling", self.coupling) ** 2 > self.warp * self.weft:
            raise InputError(
                f"bending.coupling = {self.coupling:g} N·m is above √(warp · weft): some bending "
                "would give energy away"
            )

    @classmethod
    def isotropic(cls, stiffness: float, poisson: float = 0.0) -> Bending:
        """Bending of an isotropic sheet of flexural stiffness D [N·m]."""
        positive("bending", stiffness, unit="N·m", zero=True)
        return cls(
            warp=stiffness,
            weft=stiffness,
            coupling=poisson * stiffness,
            twist=0.5 * (1.0 - poisson) * stiffness,
        )

    @classmethod
    def of_sheet(cls, stiffness: float, poisson: float, thickness: float) -> Bending:
        """Bending of a solid sheet: D = E h · h²/12(1 − ν²).

        Args:
            stiffness: Young's modulus times thickness E h [N/m].
            poisson: ν [-].
            thickness: h [m].
        """
        return cls.isotropic(stiffness * thickness**2 / (12.0 * (1.0 - poisson**2)), poisson)

    @property
    def moduli(self) -> np.ndarray:
        """Of κ₁, κ₂, κ₁₂ [N·m], shape [3, 3]."""
        b1, b12, b2, b66 = self.warp, self.coupling, self.weft, self.twist
        return np.array([[b1, b12, 0.0], [b12, b2, 0.0], [0.0, 0.0, 4.0 * b66]])

    @property
    def nothing(self) -> bool:
        """Whether it resists nothing."""
        return not self.moduli.any()


def from_flexural_length(length: float, areal_density: float) -> float:
    """Bending stiffness B = w c³ [N·m] of a flexural length c [m] (Peirce 1930; ASTM D1388).

    Args:
        length: c, half the overhang at which a strip's tip lies 41.5° below its edge [m].
        areal_density: mass per area [kg/m²], w its weight.
    """
    return GRAVITY * areal_density * length**3
