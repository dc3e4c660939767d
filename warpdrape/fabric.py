"""A fabric: areal density, thickness, unit cell and laws, each value with its source."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from warpdrape.errors import InputError, finite, positive
from warpdrape.laws import (
    IsotropicMembrane,
    LinearTension,
    NoShear,
    ShearLaw,
    ShearPolynomial,
    ShearTable,
    TabulatedTension,
    TensionLaw,
)


@dataclass(frozen=True)
class Source:
    """Where a value comes from.

    Attributes:
        status: "measured", "second-hand", "inferred" or "assumed".
        text: the source in words.
    """

    status: str
    text: str


@dataclass(frozen=True, kw_only=True)
class Fabric:
    """A woven reinforcement.

    Attributes:
        name: how scenes and files call it.
        areal_density: mass per area [kg/m²].
        thickness: ply thickness under forming pressure [m].
        cell_warp: unit-cell length L1 along the warp [m], the spacing of the weft yarns.
        cell_weft: unit-cell length L2 along the weft [m], the spacing of the warp yarns.
        tension: yarn tension law, or an isotropic membrane in its place.
        shear: shear couple law.
        compressive_factor: yarn stiffness in compression over that in tension [-].
        yarn_angle: angle from warp to weft in the flat ply [rad].
        sources: value name → where it comes from.
    """

    name: str
    areal_density: float
    thickness: float
    tension: TensionLaw
    shear: ShearLaw = NoShear()
    cell_warp: float = 1e-3
    cell_weft: float = 1e-3
    compressive_factor: float = 0.01
    yarn_angle: float = math.pi / 2
    sources: Mapping[str, Source] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not self.name:
            raise InputError(f"fabric name = {self.name!r} must be a text")
        positive("areal_density", self.areal_density, unit="kg/m²")
        positive("thickness", self.thickness, unit="m")
        positive("cell_warp", self.cell_warp, unit="m")
        positive("cell_weft", self.cell_weft, unit="m")
        if self.areal_density > 100.0:
            raise InputError(f"areal_density = {self.areal_density} kg/m²: give kg/m², not g/m²")
        if self.thickness > 0.1:
            raise InputError(f"thickness = {self.thickness} m: give metres, not millimetres")
        if not 0.0 <= finite("compressive_factor", self.compressive_factor) <= 1.0:
            raise InputError(f"compressive_factor = {self.compressive_factor} must lie in 0 … 1")
        if not math.radians(20) <= finite("yarn_angle", self.yarn_angle) <= math.radians(160):
            raise InputError(f"yarn_angle = {self.yarn_angle} rad must lie in 0.35 … 2.79 (20–160°)")
        if not isinstance(self.tension, LinearTension | TabulatedTension | IsotropicMembrane):
            raise InputError(f"tension = {self.tension!r} is not a tension law")
        if not isinstance(self.shear, ShearPolynomial | ShearTable | NoShear):
            raise InputError(f"shear = {self.shear!r} is not a shear law")
        if isinstance(self.tension, IsotropicMembrane) and (
            not isinstance(self.shear, NoShear) or abs(self.yarn_angle - math.pi / 2) > 1e-12
        ):
            raise InputError("an isotropic membrane shears by its own law: leave shear and yarn_angle out")

    @property
    def cell_area(self) -> float:
        """Area S of a unit cell [m²]: L1 L2 for orthogonal yarns."""
        return self.cell_warp * self.cell_weft * math.sin(self.yarn_angle)

    @property
    def yarn_width(self) -> tuple[float, float]:
        """Width of sheet that one warp, one weft yarn carries [m]."""
        return self.cell_area / self.cell_warp, self.cell_area / self.cell_weft

    def shear_per_area(self, angle: float) -> float:
        """C = C_s/S [N/m] at a shear angle [rad]."""
        return float(self.shear.couple(angle)) / self.cell_area
