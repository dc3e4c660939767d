"""Rubber in a sheet: its constants, and how stiff it is at most, for the stable step."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warpdrape.errors import InputError, finite, positive
from warpdrape.wording import brief

SOFTEST_RUBBER = 10.0
"""Shear modulus that a constant in MPa would have in Pa [Pa]."""
LEAST_OF_FREE = 0.9
"""Least stretch over that of a strip pulled freely that the stable step allows for [-]."""


@dataclass(frozen=True)
class MooneyRivlin:
    """A sheet of incompressible rubber in place of yarns: W = C10 (I1 − 3) + C01 (I2 − 3).

    It becomes thinner as its area grows. Without C01 it is neo-Hookean; 2 (C10 + C01) is its shear
    modulus, three times that Young's modulus.

    Attributes:
        c10: C10 [Pa].
        c01: C01 [Pa].
        largest_stretch: up to which the time step is stable, and the constants hold [-].
    """

    c10: float
    c01: float = 0.0
    largest_stretch: float = 3.0

    __repr__ = brief

    def __post_init__(self) -> None:
        positive("rubber c10", self.c10, unit="Pa")
        if finite("rubber c01", self.c01, unit="Pa") < 0.0:
            raise InputError(
                f"rubber c01 = {self.c01:g} Pa is below zero, where a sheet may give way at large "
                "strains: fit the data with c01 = 0 or more"
            )
        if self.shear_modulus < SOFTEST_RUBBER:
            raise InputError(
                f"rubber c10 = {self.c10:g} and c01 = {self.c01:g} Pa are softer than any rubber: "
                "give Pa, 0.3 MPa as 0.3e6"
            )
        if not 1.0 < finite("rubber largest_stretch", self.largest_stretch) <= 10.0:
            raise InputError(
                f"rubber largest_stretch = {self.largest_stretch:g} must lie above 1 and not above "
                "10: twice as long is 2"
            )

    @property
    def shear_modulus(self) -> float:
        """At small strains [Pa]."""
        return 2.0 * (self.c10 + self.c01)

    def energy(self, one: np.ndarray, other: np.ndarray) -> np.ndarray:
        """Energy per volume [J/m³] at two principal stretches in the sheet [-]."""
        a, b = np.square(one), np.square(other)
        c = 1.0 / (a * b)
        return self.c10 * (a + b + c - 3.0) + self.c01 * (a * b + b * c + c * a - 3.0)

    @property
    def stiffest(self) -> float:
        """Largest eigenvalue of ∂²W/∂F∂F of a sheet, F its 3×2 gradient [Pa].

        Over stretches up to ``largest_stretch``, and down to a tenth below those of a strip that
        is pulled freely: a sheet that is pressed by more than that wrinkles. In the principal
        directions they are those of ∂²W/∂λ_i∂λ_j, (W1 ∓ W2)/(λ1 ∓ λ2) in the sheet, and W_i/λ_i
        out of it (Ogden 1984, 6.2).
        """
        one, other = np.meshgrid(*2 * [np.geomspace(0.5, self.largest_stretch, 301)])
        most = np.maximum(np.maximum(one, other), 1.0)
        used = np.minimum(one, other) >= LEAST_OF_FREE / np.sqrt(most)
        one, other = one[used], other[used]
        a, b, q = one**2, other**2, (one * other) ** -2
        c10, c01 = self.c10, self.c01
        first = 2.0 * (c10 * (one - q / one) + c01 * (one * b - one**-3))
        second = 2.0 * (c10 * (other - q / other) + c01 * (other * a - other**-3))
        w11 = 2.0 * (c10 * (1.0 + 3.0 * q / a) + c01 * (b + 3.0 * one**-4))
        w22 = 2.0 * (c10 * (1.0 + 3.0 * q / b) + c01 * (a + 3.0 * other**-4))
        w12 = 4.0 * (c10 * q / (one * other) + c01 * one * other)
        pulled = 0.5 * (w11 + w22) + np.hypot(0.5 * (w11 - w22), w12)
        spun = (first + second) / (one + other)
        alike = np.abs(one - other) < 1e-6
        sheared = (first - second) / np.where(alike, 1.0, one - other)
        sheared = np.where(alike, w11 - w12, sheared)
        out = np.maximum(first / one, second / other)
        return float(np.max([pulled, spun, sheared, out]))
