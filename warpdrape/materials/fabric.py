"""A fabric: areal density, thickness, unit cell and laws, each value with its source."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from warpdrape.errors import InputError, finite, nearest, positive, said, true_or_false
from warpdrape.materials.bending import Bending, BendingCurve
from warpdrape.materials.compaction import Compaction
from warpdrape.materials.crossover import Crossover
from warpdrape.materials.laws import (
    CrimpInterchange,
    MooneyRivlin,
    NoShear,
    ShearLaw,
    ShearTable,
    TensionLaw,
    Unwoven,
    falling_angle,
)
from warpdrape.materials.matrix import Matrix
from warpdrape.wording import value

MOST_FIBRES = 0.907
"""Share of a ply that round fibres can fill at most [-]: π/√12, side by side."""
THICKEST = 0.1
"""Thickness beyond which a ply's must have been given in millimetres [m]."""
MOST_STRAIN = 0.5
"""Strain beyond which a yarn cannot have failed only then [-]."""
STATUSES = ("measured", "simulated", "second-hand", "inferred", "assumed")


@dataclass(frozen=True)
class Source:
    """Where a value comes from.

    Attributes:
        status: "measured", "simulated", "second-hand", "inferred" or "assumed".
        text: the source in words.
        doubt: what is to be verified, and why.
        given: the value as the source gives it, with its unit.
    """

    status: str
    text: str
    doubt: str = ""
    given: str = ""

    def __post_init__(self) -> None:
        if self.status not in STATUSES:
            raise InputError(f"status = {said(self.status)}{nearest(self.status, STATUSES)}")


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
        bending: resistance to bending; None for a ply that bends freely.
        compaction: pressure against thickness; None for a ply that keeps its thickness.
        matrix: what is viscous between the yarns of a prepreg; None for a dry fabric.
        crossover: how yarns slide through crossovers; None where it is not known.
        fibre_density: of the fibres' material [kg/m³]; None where it is not known.
        locking_angle: shear angle from which on the fabric locks [rad]; None where not known.
        failure_strain_warp: strain at which warp yarns fail [-]; None where it is not known.
        failure_strain_weft: the same of weft yarns.
        sources: value name → where it comes from.
        description: what it is, in a line.
        doubts: what is uncertain about the fabric as a whole.
    """

    name: str
    areal_density: float
    thickness: float
    tension: TensionLaw
    shear: ShearLaw = field(default_factory=NoShear)
    cell_warp: float = 1e-3
    cell_weft: float = 1e-3
    compressive_factor: float = 0.01
    yarn_angle: float = math.pi / 2
    bending: Bending | BendingCurve | None = None
    compaction: Compaction | None = None
    matrix: Matrix | None = None
    crossover: Crossover | None = None
    fibre_density: float | None = None
    locking_angle: float | None = None
    failure_strain_warp: float | None = None
    failure_strain_weft: float | None = None
    sources: Mapping[str, Source] = field(default_factory=dict)
    description: str = ""
    doubts: tuple[str, ...] = ()

    def __repr__(self) -> str:
        laws = {name: getattr(self, name) for name in ("tension", "shear", "bending", "compaction")}
        words = [f"{name} {value(law) if law else 'none'}" for name, law in laws.items()]
        if self.matrix is not None:
            words.append(f"matrix {value(self.matrix.viscosity)}")
        cell = f"{1e3 * self.cell_warp:.3g} × {1e3 * self.cell_weft:.3g} mm"
        return (
            f"Fabric {self.name!r}: {1e3 * self.areal_density:.4g} g/m², "
            f"{1e3 * self.thickness:.3g} mm thick, unit cell {cell}, {', '.join(words)}"
        )

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not self.name:
            raise InputError(f"fabric name = {said(self.name)} must be a text")
        positive("areal_density", self.areal_density, unit="kg/m²")
        positive("thickness", self.thickness, unit="m")
        positive("cell_warp", self.cell_warp, unit="m")
        positive("cell_weft", self.cell_weft, unit="m")
        if self.areal_density > 100.0:
            raise InputError(f"areal_density = {self.areal_density} kg/m²: give kg/m², not g/m²")
        if self.thickness > THICKEST:
            raise InputError(f"thickness = {self.thickness} m: give metres, not millimetres")
        if not 0.0 <= finite("compressive_factor", self.compressive_factor) <= 1.0:
            raise InputError(f"compressive_factor = {self.compressive_factor} must lie in 0 … 1")
        if not math.radians(20) <= finite("yarn_angle", self.yarn_angle) <= math.radians(160):
            raise InputError(
                f"yarn_angle = {self.yarn_angle} rad must lie in 0.35 … 2.79 (20–160°)"
            )
        if not isinstance(self.tension, TensionLaw):
            raise InputError(f"tension = {said(self.tension)} is not a tension law")
        if not isinstance(self.shear, ShearLaw):
            raise InputError(f"shear = {said(self.shear)} is not a shear law")
        if isinstance(self.tension, Unwoven) and (
            not isinstance(self.shear, NoShear) or abs(self.yarn_angle - math.pi / 2) > 1e-12
        ):
            raise InputError(
                "a sheet without yarns shears by its own law: leave shear and yarn_angle out"
            )
        if not isinstance(self.bending, Bending | BendingCurve | None):
            raise InputError(
                f"bending = {said(self.bending)} is no warpdrape.Bending or BendingCurve"
            )
        if not isinstance(self.compaction, Compaction | None):
            raise InputError(f"compaction = {said(self.compaction)} is no warpdrape.Compaction")
        if not isinstance(self.crossover, Crossover | None):
            raise InputError(f"crossover = {said(self.crossover)} is no warpdrape.Crossover")
        if self.compaction is not None and not math.isclose(
            self.compaction.thickness, self.thickness, rel_tol=1e-6
        ):
            raise InputError(
                f"compaction.thicknesses start at {self.compaction.thickness:.6g} m, the fabric's "
                f"thickness is {self.thickness:.6g} m: give both the same"
            )
        if not isinstance(self.matrix, Matrix | None):
            raise InputError(f"matrix = {said(self.matrix)} is no warpdrape.Matrix")
        if self.matrix is not None and isinstance(self.tension, Unwoven):
            raise InputError(
                "a sheet without yarns has no shear angle for a matrix to resist: leave matrix out"
            )
        self._check_crimp()
        self._check_limits()
        self._warn_of_a_fall()

    def _warn_of_a_fall(self) -> None:
        """Warn of a couple that falls, with what may be wrong with its kind of law."""
        falling = falling_angle(self.shear)
        if falling is None:
            return
        words = f"falls beyond {math.degrees(falling):.1f}°; check the signs of its coefficients"
        if isinstance(self.shear, ShearTable):
            first, second = map(math.degrees, self.shear.first_fall())
            words = (
                f"falls from {first:.4g}° to {second:.4g}° of its table; leave out which of the "
                "two points is wrong, or let warpdrape calibrate fit a curve that never falls"
            )
        warnings.warn(f"fabric {self.name!r}: the shear couple {words}", stacklevel=4)

    def _check_crimp(self) -> None:
        if not isinstance(self.tension, CrimpInterchange):
            return
        for family in ("warp", "weft"):
            spacing = getattr(self.tension, f"spacing_{family}")
            cell = getattr(self, f"cell_{family}")
            if not math.isclose(spacing, cell, rel_tol=1e-6):
                raise InputError(
                    f"the crimp law's spacing_{family} = {spacing} m must equal "
                    f"cell_{family} = {cell} m"
                )

    def _check_limits(self) -> None:
        """Refuse densities and limits that have another unit."""
        if self.fibre_density is not None:
            positive("fibre_density", self.fibre_density, unit="kg/m³")
            packed = self.areal_density / (self.fibre_density * self.thickness)
            if packed > MOST_FIBRES:
                raise InputError(
                    f"fibre_density = {self.fibre_density:.4g} kg/m³ fills {100 * packed:.3g} % of "
                    f"the ply with fibres, more than {100 * MOST_FIBRES:.3g} %: check it, the "
                    "areal_density and the thickness"
                )
        if self.locking_angle is not None and not (
            0.0 < finite("locking_angle", self.locking_angle) < 0.5 * math.pi
        ):
            raise InputError(
                f"locking_angle = {self.locking_angle} rad must lie between 0 and 1.57 (90°)"
            )
        for name in ("failure_strain_warp", "failure_strain_weft"):
            value = getattr(self, name)
            if value is not None and positive(name, value) > MOST_STRAIN:
                raise InputError(f"{name} = {value} is above {MOST_STRAIN:g}: give 0.015 for 1.5 %")

    @classmethod
    def rubber(
        cls,
        name: str,
        *,
        thickness: float,
        density: float,
        c10: float,
        c01: float = 0.0,
        largest_stretch: float = 3.0,
        bends: bool = True,
        **options: Any,
    ) -> Fabric:
        """A sheet of incompressible rubber, such as a diaphragm: see `laws.MooneyRivlin`.

        Args:
            name: how scenes and files call it.
            thickness: of the flat sheet [m].
            density: of the rubber [kg/m³].
            c10: Mooney–Rivlin constant C10 [Pa]; alone, half the shear modulus.
            c01: Mooney–Rivlin constant C01 [Pa].
            largest_stretch: up to which the time step is stable, and the constants hold [-].
            bends: whether it resists bending as a solid sheet of its flat thickness does, which a
                ply must to touch itself.
            options: of the fabric.
        """
        law = MooneyRivlin(c10, c01, largest_stretch)
        if positive("thickness", thickness, unit="m") > THICKEST:
            raise InputError(f"thickness = {thickness} m: give metres, not millimetres")
        if positive("density", density, unit="kg/m³") < 50.0:
            raise InputError(f"density = {density:g} kg/m³: give kg/m³, 1100 and not 1.1")
        young = 3.0 * law.shear_modulus * thickness
        bends = true_or_false("bends", bends)
        bending = Bending.of_sheet(young, 0.5, thickness) if bends else None
        return cls(
            name=name,
            areal_density=density * thickness,
            thickness=thickness,
            tension=law,
            bending=bending,
            **options,
        )

    @property
    def bends(self) -> bool:
        """Whether it resists bending."""
        return self.bending is not None and not self.bending.nothing

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
