"""How a yarn resists being squeezed across its fibres: p = k [(1 − e)^−n − 1].

e is by how much a section has become thinner, or narrower. Were it to lose as much of its area, the
fibres would fill V = V₀/(1 − e) of it, so that this is the power law p = k [(V/V₀)^n − 1], with
n = 3 that of van Wyk (1946).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warpdrape.errors import InputError, positive


@dataclass(frozen=True)
class YarnCompaction:
    """The law; one for both families.

    Attributes:
        pressure: k [Pa].
        exponent: n [-].
    """

    pressure: float
    exponent: float

    def __post_init__(self) -> None:
        positive("compaction_pressure", self.pressure, unit="Pa")
        if not 1.5 <= positive("compaction_exponent", self.exponent) <= 30.0:
            raise InputError(f"compaction_exponent = {self.exponent:g} must lie in 1.5 … 30")

    def energy(self, squeeze: np.ndarray) -> np.ndarray:
        """∫p de [J/m³], none below e = 0, infinite from e = 1 on; complex e are taken, too."""
        e, n = np.asarray(squeeze), self.exponent
        left = np.where((e.real > 0.0) & (e.real < 1.0), 1.0 - e, 1.0)
        with np.errstate(over="ignore"):  # so near to e = 1 it is as good as infinite
            inside = (left ** (1.0 - n) - 1.0) / (n - 1.0) - (1.0 - left)
        return np.where(e.real < 1.0, self.pressure * inside, np.inf)

    def stress(self, squeeze: np.ndarray) -> np.ndarray:
        """The pressure p [Pa]; e below 1."""
        left = 1.0 - np.maximum(squeeze, 0.0)
        return self.pressure * (left**-self.exponent - 1.0)

    def stiffness(self, squeeze: np.ndarray) -> np.ndarray:
        """dp/de [Pa]; none below e = 0."""
        e = np.asarray(squeeze)
        left = 1.0 - np.maximum(e, 0.0)
        rise = self.pressure * self.exponent * left ** (-self.exponent - 1.0)
        return np.where(e > 0.0, rise, 0.0)
