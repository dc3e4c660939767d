"""Friction of an interface: one coefficient, or tables by pressure, slip speed and yarn angle."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from warpdrape.errors import InputError, numbers, positive, true_or_false

Table = Sequence[tuple[float, float]]
"""Pairs of what the coefficient depends on and the coefficient there."""
TABLES = ("by_pressure", "by_speed", "by_hersey", "by_angle")


@dataclass(frozen=True, kw_only=True, eq=False)
class Friction:
    """Coulomb friction whose coefficient may depend on how and how fast the faces meet.

    Each table holds measured coefficients, linear between its points and constant beyond them;
    divided by ``coefficient``, taken under the conditions that the tables share, they are factors
    that multiply. Give pressure and speed apart, or together by the Hersey number η v / p, as
    Stribeck curves of molten or wet plies are measured (Harrison et al. 2010, ten Thije et al.
    2011). Dry plies rub with less under more pressure and depend on the angle between their yarns
    (Allaoui et al. 2012).

    Attributes:
        coefficient: μ, where the tables' conditions meet [-].
        by_pressure: pairs (pressure [Pa], μ), rising in pressure.
        by_speed: pairs (slip speed in the process [m/s], μ), rising in speed; the first one is
            what sticks.
        by_hersey: pairs (η v / p [m], μ), rising; needs ``viscosity``.
        viscosity: η, of the resin between the faces [Pa·s].
        shifted: whether that is η at the temperature at which the viscosity of the plies' matrix is
            given, and shifts with their temperature as that does; else it holds at any.
        by_angle: pairs (angle between the plies' warp yarns, 0 to 90 [deg], μ), rising in angle;
            for plies on each other.
        source: where the numbers are from.
    """

    coefficient: float
    by_pressure: Table = ()
    by_speed: Table = ()
    by_hersey: Table = ()
    viscosity: float = 0.0
    shifted: bool = False
    by_angle: Table = ()
    source: str = ""

    def __post_init__(self) -> None:
        for name in TABLES:
            object.__setattr__(self, name, _table(f"friction.{name}", getattr(self, name)))
        positive("friction.coefficient", self.coefficient, zero=not self.varies)
        positive("friction.viscosity", self.viscosity, unit="Pa·s", zero=True)
        if bool(self.by_hersey) != (self.viscosity > 0.0):
            raise InputError(
                "friction.by_hersey and friction.viscosity go together: the Hersey number is "
                "viscosity · speed / pressure"
            )
        true_or_false("friction.shifted", self.shifted)
        if self.shifted and not self.by_hersey:
            raise InputError(
                "friction.shifted shifts friction.viscosity with temperature: give by_hersey and "
                "viscosity, or leave it out"
            )
        if self.by_hersey and (self.by_pressure or self.by_speed):
            raise InputError(
                "friction.by_hersey holds pressure and speed already: leave out by_pressure and "
                "by_speed, or by_hersey"
            )
        if self.by_angle and self.by_angle[-1][0] > 90.0:
            raise InputError(
                f"friction.by_angle ends at {self.by_angle[-1][0]:g}°: angles between yarns go "
                "from 0 to 90 degrees"
            )

    @property
    def varies(self) -> bool:
        """Whether there is more to it than one coefficient."""
        return any(len(getattr(self, name)) for name in TABLES)

    @property
    def has_speed(self) -> bool:
        """Whether it depends on how fast the faces slip."""
        return bool(self.by_speed or self.by_hersey)

    def factors(self, name: str) -> np.ndarray:
        """A table as factors on ``coefficient``, shape [n, 2]; none for an empty one.

        Args:
            name: of the table.
        """
        return np.array(getattr(self, name), dtype=float).reshape(-1, 2) / (1.0, self.coefficient)

    def __call__(
        self,
        *,
        pressure: float = 0.0,
        speed: float = 0.0,
        angle_deg: float = 0.0,
        shift: float = 1.0,
    ) -> float:
        """μ under conditions [-].

        Args:
            pressure: between the faces [Pa].
            speed: of slip in the process [m/s].
            angle_deg: between the warp yarns [deg].
            shift: of the plies' matrix, factor on a viscosity that is `shifted` [-].
        """
        hersey = 0.0
        if self.by_hersey and speed > 0.0:
            viscosity = self.viscosity * (shift if self.shifted else 1.0)
            hersey = np.inf if pressure <= 0.0 else viscosity * speed / pressure
        at = dict(zip(TABLES, (pressure, speed, hersey, angle_deg), strict=True))
        value = self.coefficient
        for name, where in at.items():
            if getattr(self, name):
                value *= float(np.interp(where, *self.factors(name).T))
        return value


def friction_of(name: str, value: Any) -> Friction:
    """Friction from a coefficient [-], or as it is.

    Args:
        name: what errors call it.
        value: a number or a `Friction`.

    Raises:
        InputError: if it is neither.
    """
    if isinstance(value, Friction):
        return value
    return Friction(coefficient=positive(name, value, zero=True))


def _table(name: str, pairs: Any) -> tuple[tuple[float, float], ...]:
    """Pairs of finite numbers, rising in the first and not below zero; or `InputError`."""
    table = numbers(name, pairs)
    if table.size == 0:
        return ()
    if table.ndim != 2 or table.shape[1] != 2 or not np.isfinite(table).all():
        raise InputError(f"{name} must be pairs of finite numbers")
    if len(table) < 2:
        raise InputError(f"{name} has one point: give two or more, or coefficient alone")
    if (np.diff(table[:, 0]) <= 0.0).any() or table[0, 0] < 0.0:
        raise InputError(f"{name} must rise in its first numbers, from zero or more: sort it")
    if (table[:, 1] < 0.0).any():
        raise InputError(f"{name} holds a coefficient below zero")
    return tuple((float(at), float(value)) for at, value in table)
