"""The matrix of a prepreg while it is liquid: viscous in shear, and what it takes to cool it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from warpdrape.errors import InputError, finite, positive, said
from warpdrape.materials.viscosity import ShiftLaw, ViscosityLaw
from warpdrape.wording import brief


@dataclass(frozen=True, kw_only=True)
class Heat:
    """Heat that a ply holds, and that passes from its faces to tools, other plies and the air.

    Attributes:
        capacity: ρ c_p times the thickness: to warm a ply by a kelvin, per area [J/(m²·K)].
        conductance: of the contact between one face and a tool [W/(m²·K)].
        between: of the contact between two such plies [W/(m²·K)], of plies of two fabrics the
            harmonic mean; None where none passes.
        emissivity: of the faces, by which they radiate to the air's temperature [-].
    """

    capacity: float
    conductance: float
    between: float | None = None
    emissivity: float = 0.0

    __repr__ = brief

    def __post_init__(self) -> None:
        positive("capacity", self.capacity, unit="J/(m²·K)")
        positive("conductance", self.conductance, unit="W/(m²·K)")
        if self.between is not None:
            positive("between", self.between, unit="W/(m²·K)")
        if not 0.0 <= finite("emissivity", self.emissivity) <= 1.0:
            raise InputError(
                f"emissivity = {self.emissivity:g} must lie in 0 … 1: 1 is that of a black face"
            )

    @property
    def rate(self) -> float:
        """At which a ply goes to the temperature of one tool [1/s]."""
        return self.conductance / self.capacity


@dataclass(frozen=True, kw_only=True)
class Matrix:
    """What resists shear beside the fabric's own couple: C = h φ(γ) σ(a γ̇), per area of the ply.

    h is the fabric's thickness, σ = η γ̇ the viscous stress, a the temperature's shift of rates. It
    acts beside the fabric's shear law, which is elastic.

    Attributes:
        viscosity: apparent one of the ply in shear, fibres and all: couple per area over thickness
            and rate of the shear angle, at the shift's reference temperature.
        shift: with temperature; None for a viscosity that holds for the process's.
        rise: r1, r2 in φ(γ) = 1 + r1 γ² + r2 γ⁴, by which it rises with the shear angle [-].
        modulus: of a spring in series, G = modulus · h: couples relax with η/modulus [Pa]; None for
            a liquid without, whose spring is as stiff as the time step allows.
        heat: None for a ply that keeps its temperature.
    """

    viscosity: ViscosityLaw
    shift: ShiftLaw | None = None
    rise: tuple[float, float] = (0.0, 0.0)
    modulus: float | None = None
    heat: Heat | None = None

    __repr__ = brief

    def __post_init__(self) -> None:
        if not isinstance(self.viscosity, ViscosityLaw):
            raise InputError(
                f"matrix.viscosity = {said(self.viscosity)} is no laws.Newtonian, PowerLaw or Cross"
            )
        if not isinstance(self.shift, ShiftLaw | None):
            raise InputError(f"matrix.shift = {said(self.shift)} is no laws.Arrhenius or WLF")
        if not isinstance(self.heat, Heat | None):
            raise InputError(f"matrix.heat = {said(self.heat)} is no warpdrape.Heat")
        if not isinstance(self.rise, tuple | list) or len(self.rise) != 2:
            raise InputError(f"rise = {said(self.rise)} must be two numbers, of γ² and γ⁴")
        rise = tuple(positive("rise", each, zero=True) for each in self.rise)
        object.__setattr__(self, "rise", rise)
        if self.modulus is not None:
            positive("modulus", self.modulus, unit="Pa")
        if self.heat is not None and self.shift is None:
            raise InputError(
                "heat is of no use to a matrix whose viscosity does not depend on temperature: "
                "give shift too, or leave heat out"
            )

    @property
    def temperature(self) -> float | None:
        """That at which the viscosity is given [K]; None where it does not depend on one."""
        return None if self.shift is None else self.shift.reference_temperature

    def factor(self, temperature: float | None) -> float:
        """Shift factor of rates at a temperature [K], None for that of the viscosity."""
        if self.shift is None or temperature is None:
            return 1.0
        return self.shift.factor(temperature)

    def stress(
        self, angle: ArrayLike, rate: ArrayLike, temperature: float | None = None
    ) -> np.ndarray:
        """Couple per area and thickness [Pa], where nothing is stored in the spring.

        Args:
            angle: shear angles γ [rad].
            rate: of theirs in the process [1/s].
            temperature: [K]; None for that of the viscosity.
        """
        square = np.asarray(angle, dtype=float) ** 2
        rise = 1.0 + square * (self.rise[0] + square * self.rise[1])
        return rise * self.viscosity.stress(self.factor(temperature) * np.asarray(rate))
