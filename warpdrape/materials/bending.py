"""Bending of a ply, per metre of width: moduli of an orthotropic plate, or curves of moment."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np
from numpy.typing import ArrayLike

from warpdrape.errors import InputError, finite, numbers, positive
from warpdrape.wording import brief

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

    __repr__ = brief

    def __post_init__(self) -> None:
        for name in ("warp", "weft"):
            positive(f"bending.{name}", getattr(self, name), unit="N·m", zero=True)
        if self.twist is None:
            object.__setattr__(
                self, "twist", TWIST_SHARE * math.sqrt(self.warp) * math.sqrt(self.weft)
            )
        positive("bending.twist", self.twist, unit="N·m", zero=True)
        coupling = abs(finite("bending.coupling", self.coupling))
        if coupling > math.sqrt(self.warp) * math.sqrt(self.weft):
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
        b1, b12, b2, b66 = self.warp, self.coupling, self.weft, cast(float, self.twist)
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


@dataclass(frozen=True, kw_only=True, eq=False)
class BendingCurve:
    """Resistance of a ply to bending by curves M(κ), softer the more it is bent, with friction.

    Attributes:
        curvatures: κ out of the plane, rising from 0 [1/m], shape [n].
        moments_warp: moment of the warp yarns per metre of width there [N], shape [n].
        moments_weft: likewise of the weft.
        in_plane: B_g of warp and weft [N·m]; the last point's M/κ if not given: within the ply
            yarns are taken to bend as when their fibres have slid.
        twist: B₆₆ [N·m]; a tenth of the geometric mean of ``in_plane`` if not given.
        friction: moment M_y that friction between fibres comes to, of warp and weft [N].
        friction_curvature: change of curvature over which it builds up, M_y/σ [1/m].
    """

    curvatures: Sequence[float]
    moments_warp: Sequence[float]
    moments_weft: Sequence[float]
    in_plane: tuple[float, float] | None = None
    twist: float | None = None
    friction: tuple[float, float] = (0.0, 0.0)
    friction_curvature: float = 1.0

    __repr__ = brief

    def __post_init__(self) -> None:
        curvatures = numbers("bending.curvatures", self.curvatures)
        if curvatures.ndim != 1 or curvatures.size < 3 or not np.isfinite(curvatures).all():
            raise InputError("bending.curvatures needs three or more finite numbers")
        if curvatures[0] != 0.0 or (np.diff(curvatures) <= 0.0).any():
            raise InputError("bending.curvatures must rise from 0: sort them")
        object.__setattr__(self, "curvatures", curvatures)
        for family in ("warp", "weft"):
            name = f"moments_{family}"
            moments = numbers(f"bending.{name}", getattr(self, name))
            if moments.shape != curvatures.shape or not np.isfinite(moments).all():
                raise InputError(f"bending.{name} needs a finite moment for each curvature")
            if moments[0] != 0.0 or (np.diff(moments) < 0.0).any() or moments[-1] <= 0.0:
                raise InputError(f"bending.{name} must start at 0 and not fall: check the signs")
            object.__setattr__(self, name, moments)
        if self.in_plane is None:
            last = (self.moments_warp[-1] / curvatures[-1], self.moments_weft[-1] / curvatures[-1])
            object.__setattr__(self, "in_plane", tuple(map(float, last)))
        for name in ("in_plane", "friction"):
            both = numbers(f"bending.{name}", getattr(self, name))
            if both.shape != (2,):
                raise InputError(f"bending.{name} needs two numbers, of warp and weft")
            for value in both:
                positive(f"bending.{name}", value, zero=True)
            object.__setattr__(self, name, tuple(map(float, both)))
        if self.twist is None:
            object.__setattr__(
                self,
                "twist",
                TWIST_SHARE * math.sqrt(math.prod(cast(tuple[float, float], self.in_plane))),
            )
        positive("bending.twist", self.twist, unit="N·m", zero=True)
        positive("bending.friction_curvature", self.friction_curvature, unit="1/m")

    @property
    def nothing(self) -> bool:
        """Whether it resists nothing; a curve always does."""
        return False

    @property
    def onset(self) -> tuple[float, float]:
        """Stiffness σ of the friction at its start, warp and weft [N·m]."""
        warp, weft = self.friction
        return warp / self.friction_curvature, weft / self.friction_curvature

    def slopes(self, moments: ArrayLike) -> np.ndarray:
        """dM/dκ at the points of a curve that is monotone between them [N·m]."""
        from scipy.interpolate import PchipInterpolator  # when needed: a run starts sooner

        return PchipInterpolator(self.curvatures, moments).derivative()(self.curvatures)

    @property
    def stiffest(self) -> np.ndarray:
        """Bound on the moduli of κ₁, κ₂, κ₁₂ [N·m], shape [3, 3]."""
        bound = []
        moments_of = (np.asarray(self.moments_warp), np.asarray(self.moments_weft))
        pairs = zip(moments_of, cast(tuple[float, float], self.in_plane), self.onset, strict=True)
        for moments, in_plane, onset in pairs:
            secants = np.diff(moments) / np.diff(self.curvatures)
            # a monotone cubic is nowhere steeper than 1.5 times its secant or an end's slope
            steepest = max(1.5 * secants.max(), self.slopes(moments).max())
            bound.append(max(steepest + onset, in_plane))
        return np.diag([*bound, 4.0 * cast(float, self.twist)])
