"""Compaction of a ply through its thickness: pressure against thickness, table or power law."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from warpdrape.errors import InputError, numbers, positive
from warpdrape.wording import brief

if TYPE_CHECKING:
    from scipy.interpolate import PchipInterpolator

POINTS = 60
"""Points of the table that a power law becomes."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Compaction:
    """Pressure on a ply against its thickness, monotone between the points.

    Contact with the ply begins at the first thickness, where the pressure is zero. Beyond the last
    point the pressure goes on rising with the last slope: no fabric is pressed to nothing.

    Attributes:
        thicknesses: falling [m], shape [n]; the first one is the fabric's own.
        pressures: rising from 0 [Pa], shape [n].
    """

    thicknesses: Sequence[float]
    pressures: Sequence[float]

    __repr__ = brief

    def __post_init__(self) -> None:
        thicknesses = numbers("compaction.thicknesses", self.thicknesses)
        pressures = numbers("compaction.pressures", self.pressures)
        if thicknesses.ndim != 1 or thicknesses.size < 3 or not np.isfinite(thicknesses).all():
            raise InputError("compaction.thicknesses needs three or more finite numbers")
        if thicknesses[-1] <= 0.0 or (np.diff(thicknesses) >= 0.0).any():
            raise InputError("compaction.thicknesses must fall and stay above 0: sort them")
        if pressures.shape != thicknesses.shape or not np.isfinite(pressures).all():
            raise InputError("compaction.pressures needs a finite pressure for each thickness")
        if pressures[0] != 0.0 or (np.diff(pressures) <= 0.0).any():
            raise InputError(
                "compaction.pressures must rise from 0: take off the pressure at which the first "
                "thickness was measured"
            )
        object.__setattr__(self, "thicknesses", thicknesses)
        object.__setattr__(self, "pressures", pressures)

    @classmethod
    def power_law(
        cls,
        *,
        areal_density: float,
        fibre_density: float,
        thickness: float,
        coefficient: float,
        exponent: float,
        largest_pressure: float,
    ) -> Compaction:
        """V_f = a p^b, fibre volume fraction under a pressure p (Robitaille and Gauvin 1998).

        The pressure at the ply's own thickness, at which contact begins, is taken off.

        Args:
            areal_density: mass per area [kg/m²].
            fibre_density: of the fibres' material [kg/m³].
            thickness: of the ply before it is compacted [m].
            coefficient: a, V_f at 1 Pa [-].
            exponent: b [-].
            largest_pressure: up to which the law was measured [Pa].

        Raises:
            InputError: if the ply is thinner than at the largest pressure, or a value is odd.
        """
        for name, value in (
            ("fibre_density", fibre_density),
            ("coefficient", coefficient),
            ("exponent", exponent),
            ("largest_pressure", largest_pressure),
        ):
            positive(f"compaction.{name}", value)
        solid = areal_density / fibre_density  # thickness of the fibres alone
        if coefficient * largest_pressure**exponent > 0.95:
            raise InputError(
                f"compaction: V_f = {coefficient * largest_pressure**exponent:.3g} at the "
                "largest_pressure: check coefficient and exponent, which are for pressures in Pa"
            )
        thinnest = solid / (coefficient * largest_pressure**exponent)
        if thinnest >= thickness:
            raise InputError(
                f"compaction: {1e3 * thinnest:.3g} mm thick at the largest_pressure, no less than "
                f"the fabric's thickness of {1e3 * thickness:.3g} mm: check fibre_density, "
                "coefficient and exponent"
            )
        thicknesses = np.linspace(thickness, thinnest, POINTS)
        pressures = (solid / thicknesses / coefficient) ** (1.0 / exponent)
        pressures = pressures - pressures[0]
        return cls(thicknesses=thicknesses.tolist(), pressures=pressures.tolist())

    @property
    def thickness(self) -> float:
        """Before it is compacted [m]."""
        return float(self.thicknesses[0])

    @property
    def thinnest(self) -> float:
        """Least thickness that the points hold [m]."""
        return float(self.thicknesses[-1])

    @property
    def room(self) -> float:
        """By how much it can be compacted within the points [m]."""
        return self.thickness - self.thinnest

    @cached_property
    def _curve(self) -> PchipInterpolator:
        """Pressure over what the ply has been closed by."""
        from scipy.interpolate import PchipInterpolator  # when needed: a run starts sooner

        return PchipInterpolator(self.thickness - np.asarray(self.thicknesses), self.pressures)

    @cached_property
    def last_slope(self) -> float:
        """Slope with which the pressure goes on beyond the last point [Pa/m]."""
        last = float(self._curve.derivative()(self.room))
        secant = (self.pressures[-1] - self.pressures[-2]) / (
            self.thicknesses[-2] - self.thicknesses[-1]
        )
        return last if last > 0.0 else float(secant)

    def pressure(self, thickness: np.ndarray | float) -> np.ndarray:
        """Pressure at a thickness [Pa]; zero above the first one.

        Args:
            thickness: of the ply [m], any shape.
        """
        closed = self.thicknesses[0] - np.asarray(thickness, dtype=float)
        last = float(self.thicknesses[0] - self.thicknesses[-1])
        inside = self._curve(np.clip(closed, 0.0, last))
        return inside + self.last_slope * np.maximum(closed - last, 0.0)

    def thickness_at(self, pressure: np.ndarray | float) -> np.ndarray:
        """Thickness under a pressure [m]; the inverse of `pressure`.

        Args:
            pressure: from 0 on [Pa], any shape.
        """
        fine = np.linspace(self.thicknesses[0], self.thicknesses[-1], 50 * len(self.thicknesses))
        inside = np.interp(pressure, self.pressure(fine), fine)
        return inside - np.maximum(pressure - self.pressures[-1], 0.0) / self.last_slope
