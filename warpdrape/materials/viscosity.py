"""Viscosity of a matrix: how stress rises with the rate of shear, and shifts with temperature."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from warpdrape.errors import InputError, finite, positive
from warpdrape.wording import brief

GAS_CONSTANT = 8.314462618
"""R [J/(mol·K)], exact since 2019."""
MOST_VISCOUS = 1e15
"""Viscosity beyond which nothing flows [Pa·s]."""
MOST_SHIFT = 1e12
"""Shift factor at the lowest temperature beyond which the matrix is no liquid there [-]."""


@dataclass(frozen=True)
class Newtonian:
    """σ = η r, the same viscosity at any rate.

    Attributes:
        viscosity: η [Pa·s].
    """

    viscosity: float

    __repr__ = brief

    def __post_init__(self) -> None:
        positive("viscosity", self.viscosity, unit="Pa·s")

    def stress(self, rate: ArrayLike) -> np.ndarray:
        """σ [Pa] at rates of shear r [1/s]."""
        return self.viscosity * np.asarray(rate, dtype=float)


@dataclass(frozen=True)
class PowerLaw:
    """σ = η r with η = η1 ((r² + r0²)/(r1² + r0²))^((n − 1)/2): a power law that has an end.

    Well above r0 a power law, |σ| ∝ |r|^n; well below it a Newtonian liquid, as any melt is.

    Attributes:
        viscosity: η1, at the reference rate [Pa·s].
        exponent: n, above 0 and not above 1 [-].
        reference_rate: r1 [1/s].
        lowest_rate: r0, at which the power law has its end; below the lowest rate measured [1/s].
    """

    viscosity: float
    exponent: float
    reference_rate: float
    lowest_rate: float

    __repr__ = brief

    def __post_init__(self) -> None:
        positive("viscosity", self.viscosity, unit="Pa·s")
        _check_exponent(self.exponent)
        positive("reference_rate", self.reference_rate, unit="1/s")
        positive("lowest_rate", self.lowest_rate, unit="1/s")
        if not self.at_rest <= MOST_VISCOUS:
            raise InputError(
                f"lowest_rate = {self.lowest_rate:g} 1/s makes the viscosity at rest "
                f"{self.at_rest:.3g} Pa·s, that of a solid: give the lowest rate measured"
            )

    @property
    def at_rest(self) -> float:
        """Viscosity far below the lowest rate [Pa·s]."""
        share = self.reference_rate / self.lowest_rate
        return self.viscosity * math.hypot(1.0, share) ** (1.0 - self.exponent)

    def stress(self, rate: ArrayLike) -> np.ndarray:
        """σ [Pa] at rates of shear r [1/s]."""
        r = np.asarray(rate, dtype=float)
        share = (r**2 + self.lowest_rate**2) / (self.reference_rate**2 + self.lowest_rate**2)
        return self.viscosity * share ** (0.5 * (self.exponent - 1.0)) * r


@dataclass(frozen=True)
class Cross:
    """σ = η r with η = η∞ + (η0 − η∞)/(1 + (λ |r|)^m). Source: Cross 1965.

    Attributes:
        at_rest: η0, at no rate [Pa·s].
        at_last: η∞, at any high rate, below η0 [Pa·s].
        time: λ, one over the rate at which viscosity has fallen half way [s].
        exponent: m, above 0 and not above 1 [-].
    """

    at_rest: float
    at_last: float
    time: float
    exponent: float

    __repr__ = brief

    def __post_init__(self) -> None:
        positive("at_rest", self.at_rest, unit="Pa·s")
        positive("at_last", self.at_last, unit="Pa·s", zero=True)
        positive("time", self.time, unit="s")
        _check_exponent(self.exponent)
        if self.at_last >= self.at_rest:
            raise InputError(
                f"at_last = {self.at_last:g} Pa·s must be below at_rest = {self.at_rest:g} Pa·s: "
                "a Cross liquid thins with rate; take the Newtonian law for one that does not"
            )

    def stress(self, rate: ArrayLike) -> np.ndarray:
        """σ [Pa] at rates of shear r [1/s]."""
        r = np.asarray(rate, dtype=float)
        fall = (self.at_rest - self.at_last) / (1.0 + (self.time * np.abs(r)) ** self.exponent)
        return (self.at_last + fall) * r


@dataclass(frozen=True, kw_only=True)
class Arrhenius:
    """Rates at T count as a r with ln a = (E/R)(1/T − 1/T0).

    Attributes:
        activation_energy: E [J/mol].
        reference_temperature: T0, at which the viscosity is given [K].
        lowest_temperature: below it a stays as it is there, and the run says so [K].
    """

    activation_energy: float
    reference_temperature: float
    lowest_temperature: float

    __repr__ = brief

    def __post_init__(self) -> None:
        energy = positive("activation_energy", self.activation_energy, unit="J/mol")
        if energy < 500.0:
            raise InputError(
                f"activation_energy = {energy:g} J/mol is below any melt's: give J/mol, 5e4 for "
                "50 kJ/mol"
            )
        _check_temperatures(self, self.factor)

    def factor(self, temperature: float) -> float:
        """Shift factor a at a temperature [K]."""
        t = max(temperature, self.lowest_temperature)
        return math.exp(
            self.activation_energy / GAS_CONSTANT * (1.0 / t - 1.0 / self.reference_temperature)
        )


@dataclass(frozen=True, kw_only=True)
class WLF:
    """Rates at T count as a r with lg a = −C1 (T − T0)/(C2 + T − T0).

    Source: Williams, Landel & Ferry 1955.

    Attributes:
        c1: C1 [-].
        c2: C2 [K].
        reference_temperature: T0, at which the viscosity is given [K].
        lowest_temperature: below it a stays as it is there, and the run says so [K].
    """

    c1: float
    c2: float
    reference_temperature: float
    lowest_temperature: float

    __repr__ = brief

    def __post_init__(self) -> None:
        positive("c1", self.c1)
        positive("c2", self.c2, unit="K")
        _check_temperatures(self, lambda t: 1.0)
        pole = self.reference_temperature - self.c2
        if self.lowest_temperature <= pole:
            raise InputError(
                f"lowest_temperature = {self.lowest_temperature:g} K must be above "
                f"reference_temperature − c2 = {pole:g} K, where the WLF law has no end"
            )
        _check_temperatures(self, self.factor)

    def factor(self, temperature: float) -> float:
        """Shift factor a at a temperature [K]."""
        above = max(temperature, self.lowest_temperature) - self.reference_temperature
        return 10.0 ** (-self.c1 * above / (self.c2 + above))


ViscosityLaw = Newtonian | PowerLaw | Cross
ShiftLaw = Arrhenius | WLF


def check_temperature(name: str, value: float) -> float:
    """Return a temperature [K]; raise `InputError` unless it is one that forming knows."""
    kelvin = finite(name, value, unit="K")
    if not 150.0 <= kelvin <= 1500.0:
        raise InputError(
            f"{name} = {kelvin:g} K must lie in 150 … 1500 K: give kelvin, as units.celsius(180)"
        )
    return kelvin


def _check_exponent(exponent: float) -> None:
    if not 0.0 < finite("exponent", exponent) <= 1.0:
        raise InputError(
            f"exponent = {exponent:g} must be above 0 and not above 1: stress rises with rate, "
            "and less than in proportion"
        )


def _check_temperatures(law: Arrhenius | WLF, factor: Callable[[float], float]) -> None:
    reference = check_temperature("reference_temperature", law.reference_temperature)
    lowest = check_temperature("lowest_temperature", law.lowest_temperature)
    if lowest > reference:
        raise InputError(
            f"lowest_temperature = {lowest:g} K must not exceed reference_temperature = "
            f"{reference:g} K, at which the viscosity is given"
        )
    try:
        most = factor(lowest)
    except OverflowError:
        most = math.inf
    if most > MOST_SHIFT:
        raise InputError(
            f"lowest_temperature = {lowest:g} K makes the matrix {most:.1g} times as viscous as at "
            "reference_temperature: give the one at which it becomes solid"
        )
