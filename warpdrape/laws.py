"""The laws of a fabric: yarn tension, shear couple, isotropic membrane. Values per yarn and cell.

Each is a frozen, validated record; `warpdrape.membrane` turns it into what the kernels read.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from warpdrape.errors import InputError, finite, positive


@dataclass(frozen=True)
class LinearTension:
    """T1 = warp · ε1, T2 = weft · ε2.

    Attributes:
        warp: stiffness of a warp yarn [N per unit strain].
        weft: stiffness of a weft yarn [N per unit strain].
    """

    warp: float
    weft: float

    def __post_init__(self) -> None:
        positive("warp yarn stiffness", self.warp, unit="N")
        positive("weft yarn stiffness", self.weft, unit="N")


@dataclass(frozen=True, eq=False)
class TabulatedTension:
    """Biaxial tension surface T1(ε1, ε2), T2(ε1, ε2), read off a regular grid.

    A cubic-spline *energy* is fitted, so that the tensions are smooth and come from a potential;
    `warpdrape.spline.fit_energy` says how far the table is from having one.

    Attributes:
        strain_warp: ε1 of the rows [-], evenly spaced, rising, shape [n].
        strain_weft: ε2 of the columns [-], evenly spaced, rising, shape [m].
        tension_warp: T1 [N per yarn], shape [n, m].
        tension_weft: T2 [N per yarn], shape [n, m].
    """

    strain_warp: Sequence[float]
    strain_weft: Sequence[float]
    tension_warp: Sequence[Sequence[float]]
    tension_weft: Sequence[Sequence[float]]

    def __post_init__(self) -> None:
        for name in ("strain_warp", "strain_weft"):
            axis = np.asarray(getattr(self, name), dtype=float)
            if axis.ndim != 1 or axis.size < 4 or not np.isfinite(axis).all():
                raise InputError(f"{name} needs at least four finite strains")
            steps = np.diff(axis)
            if (steps <= 0).any():
                at = int(np.argmax(steps <= 0))
                raise InputError(f"{name} must rise: {axis[at + 1]} follows {axis[at]}; sort the table")
            if np.ptp(steps) > 1e-6 * steps.max():
                raise InputError(f"{name} must be evenly spaced: resample the table")
            object.__setattr__(self, name, axis)
        shape = (len(self.strain_warp), len(self.strain_weft))
        for name in ("tension_warp", "tension_weft"):
            table = np.asarray(getattr(self, name), dtype=float)
            if table.shape != shape or not np.isfinite(table).all():
                raise InputError(f"{name} must hold finite tensions [N], shape {shape}")
            object.__setattr__(self, name, table)


@dataclass(frozen=True)
class ShearPolynomial:
    """C_s = c0 γ + c1 γ³ + c2 γ⁵ + c3 γ⁷.

    Attributes:
        coefficients: c0, c1, … [N·m per cell, γ in rad], at most four.
    """

    coefficients: tuple[float, ...]

    def __post_init__(self) -> None:
        values = tuple(finite("shear coefficient", c, unit="N·m") for c in self.coefficients)
        if not 1 <= len(values) <= 4:
            raise InputError(f"a shear polynomial has one to four odd terms, not {len(values)}")
        positive("first shear coefficient", values[0], unit="N·m")
        object.__setattr__(self, "coefficients", values)

    def couple(self, angle: np.ndarray) -> np.ndarray:
        """C_s [N·m] at shear angles [rad]."""
        angle = np.asarray(angle, dtype=float)
        return sum(c * angle ** (2 * i + 1) for i, c in enumerate(self.coefficients))

    def slope(self, angle: np.ndarray) -> np.ndarray:
        """dC_s/dγ [N·m/rad] at shear angles [rad]."""
        angle = np.asarray(angle, dtype=float)
        return sum((2 * i + 1) * c * angle ** (2 * i) for i, c in enumerate(self.coefficients))


@dataclass(frozen=True, eq=False)
class ShearTable:
    """C_s through measured points, odd in γ, monotone between them, linear past the last.

    Attributes:
        angles: shear angles [rad], rising from 0, shape [n].
        couples: C_s [N·m per cell], not falling, shape [n].
    """

    angles: Sequence[float]
    couples: Sequence[float]

    def __post_init__(self) -> None:
        angles = np.asarray(self.angles, dtype=float)
        couples = np.asarray(self.couples, dtype=float)
        if angles.ndim != 1 or angles.size < 3 or couples.shape != angles.shape:
            raise InputError("a shear table needs three or more angles and as many couples")
        if not (np.isfinite(angles).all() and np.isfinite(couples).all()):
            raise InputError("a shear table must hold finite numbers only")
        if angles[0] != 0.0 or couples[0] != 0.0:
            raise InputError(f"a shear table starts at (0, 0), not ({angles[0]}, {couples[0]})")
        if (np.diff(angles) <= 0).any():
            at = int(np.argmax(np.diff(angles) <= 0))
            raise InputError(
                f"shear table angles must rise: {angles[at + 1]} follows {angles[at]}; sort them"
            )
        if (np.diff(couples) < 0).any():
            at = int(np.argmax(np.diff(couples) < 0))
            raise InputError(
                f"shear table couples must not fall, but do after {np.degrees(angles[at]):.4g}°; "
                "smooth the curve"
            )
        object.__setattr__(self, "angles", angles)
        object.__setattr__(self, "couples", couples)

    @property
    def slopes(self) -> np.ndarray:
        """Monotone Hermite slopes [N·m/rad] at the knots (Fritsch–Carlson)."""
        from scipy.interpolate import PchipInterpolator

        return PchipInterpolator(self.angles, self.couples).derivative()(self.angles)

    def couple(self, angle: np.ndarray) -> np.ndarray:
        """C_s [N·m] at shear angles [rad]."""
        from scipy.interpolate import PchipInterpolator

        size = np.abs(np.asarray(angle, dtype=float))
        inside = PchipInterpolator(self.angles, self.couples)(np.minimum(size, self.angles[-1]))
        beyond = np.maximum(size - self.angles[-1], 0.0)
        return np.sign(angle) * (inside + beyond * self.slopes[-1])

    def slope(self, angle: np.ndarray) -> np.ndarray:
        """dC_s/dγ [N·m/rad] at shear angles [rad]."""
        step = 1e-6
        return (self.couple(angle + step) - self.couple(np.asarray(angle) - step)) / (2 * step)


@dataclass(frozen=True)
class NoShear:
    """A net of yarns that shears freely."""

    def couple(self, angle: np.ndarray) -> np.ndarray:
        """Zero [N·m] at any angle."""
        return np.zeros_like(np.asarray(angle, dtype=float))

    def slope(self, angle: np.ndarray) -> np.ndarray:
        """Zero [N·m/rad] at any angle."""
        return np.zeros_like(np.asarray(angle, dtype=float))


@dataclass(frozen=True)
class IsotropicMembrane:
    """An isotropic sheet in place of yarns (paper, Figure 3c).

    Attributes:
        stiffness: Young's modulus times thickness [N/m].
        poisson: Poisson's ratio [-].
    """

    stiffness: float
    poisson: float = 0.3

    def __post_init__(self) -> None:
        positive("membrane stiffness", self.stiffness, unit="N/m")
        if not -1.0 < finite("Poisson's ratio", self.poisson) < 0.5:
            raise InputError(f"Poisson's ratio = {self.poisson} must lie between -1 and 0.5")


TensionLaw = LinearTension | TabulatedTension | IsotropicMembrane
ShearLaw = ShearPolynomial | ShearTable | NoShear
