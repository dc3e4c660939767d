"""Wavelength of a stretched sheet that is squeezed far beyond its threshold, by its least energy.

A wave w = f(x) cos ky over the length L takes up the squeeze Δ where it can; what it leaves stays
as compression. Per area, in the mean over y:

    W = ∫ [¼ B (k² f − f″)² + ¼ T f′² + ½ Y (Δ − ¼ k² f²)²] dx / L

with the bending stiffness B, the tension T along x and the stiffness Y across. Near the threshold f
is half a sine and k that of Cerda and Mahadevan (2003). Beyond it f fills the length, its ends get
steep, and the wave that costs least is shorter. Derived here; that the compression collapses while
the wave fills the sheet is what Xin and Davidovitch (2020) call far from threshold.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize, minimize_scalar

SHAPES = 12
"""Odd half sines of which f is made."""
POINTS = 240
"""Places along the length at which the squeeze that is left is summed."""


@dataclass(frozen=True, kw_only=True)
class SqueezedSheet:
    """A sheet pulled along x between hinges, which are squeezed along y.

    Attributes:
        bending: B [N·m].
        tension: T [N/m].
        stiffness: Y, across the pull [N/m].
        length: L [m].
    """

    bending: float
    tension: float
    stiffness: float
    length: float

    @property
    def first_wave_number(self) -> float:
        """Of the wave that comes first [1/m]: B (k² + q²)² + T q² over k² is least, q = π/L."""
        q = math.pi / self.length
        return (q**4 + self.tension / self.bending * q**2) ** 0.25

    @property
    def threshold(self) -> float:
        """Squeeze at which it comes [-]."""
        k, q = self.first_wave_number, math.pi / self.length
        bent = self.bending * (k**2 + q**2) ** 2 + self.tension * q**2
        return bent / (self.stiffness * k**2)

    def energy(self, amplitudes: np.ndarray, k: float, squeeze: float) -> tuple[float, np.ndarray]:
        """W of a wave [J/m²], and its slopes.

        Args:
            amplitudes: of the odd half sines that make f [m], shape [`SHAPES`].
            k: wave number across [1/m].
            squeeze: Δ [-].
        """
        odd = np.arange(1, 2 * SHAPES, 2)
        q = math.pi * odd / self.length
        sines = np.sin(np.outer((np.arange(POINTS) + 0.5) * math.pi / POINTS, odd))
        stiff = 0.25 * (self.bending * (k**2 + q**2) ** 2 + self.tension * q**2)
        f = sines @ amplitudes
        left = squeeze - 0.25 * k**2 * f**2
        energy = 0.5 * stiff @ amplitudes**2 + 0.5 * self.stiffness * np.mean(left**2)
        slopes = stiff * amplitudes - 0.5 * self.stiffness * k**2 * (left * f) @ sines / POINTS
        return float(energy), slopes

    def least_energy(self, k: float, squeeze: float) -> float:
        """W of the best shape for a wave number [J/m²], over that of the flat sheet [-]."""
        size = 2.0 * math.sqrt(squeeze) / k
        flat = 0.5 * self.stiffness * squeeze**2

        def scaled(a: np.ndarray) -> tuple[float, np.ndarray]:
            energy, slopes = self.energy(size * a, k, squeeze)
            return energy / flat, size * slopes / flat

        start = np.zeros(SHAPES)
        start[0] = 1.0
        return float(minimize(scaled, start, jac=True, method="BFGS", options={"gtol": 1e-9}).fun)

    def wavelength(self, squeeze: float) -> float:
        """Of the wave that costs least at a squeeze [m]; that which comes first, below it."""
        if squeeze <= self.threshold:
            return 2.0 * math.pi / self.first_wave_number
        # waves grow where B (k² + q²)² + T q² < Y Δ k²
        q = math.pi / self.length
        half = 0.5 * self.stiffness * squeeze / self.bending - q**2
        root = math.sqrt(half**2 - q**4 - self.tension / self.bending * q**2)
        best = minimize_scalar(
            lambda k: self.least_energy(k, squeeze),
            bounds=(math.sqrt(half - root), math.sqrt(half + root)),
            method="bounded",
            options={"xatol": 1e-5 * self.first_wave_number},
        )
        return 2.0 * math.pi / float(best.x)
