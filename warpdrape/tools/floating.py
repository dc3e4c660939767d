"""Tools that float under a force, and how far they go."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from warpdrape.errors import InputError, positive
from warpdrape.over_time import table_over_time, through
from warpdrape.tools.motion import Prescribed, smooth_ramp, vector
from warpdrape.wording import brief


@dataclass(frozen=True, kw_only=True)
class Float:
    """A tool that floats along an axis under a force, and shows how far it went.

    Attributes:
        force: pressing force [N], the tool's weight included; or pairs (time [s], force [N])
            through which it goes smoothly, the ends holding before and after.
        axis: direction in which it presses, shape [3].
        mass: moving mass [kg]; None takes that of the scene's plies, mass added by plain
            scaling included. A run is so much faster than a press that a real holder's inertia
            would press several times as hard as its force.
        ramp: time over which the force rises smoothly from zero [s].
        damping: of the motion along the axis [N·s/m]; None takes the largest ``force`` at 5 m/s.
    """

    force: float | Sequence[tuple[float, float]]
    axis: Sequence[float] = (0.0, 0.0, -1.0)
    mass: float | None = None
    ramp: float = 2e-3
    damping: float | None = None

    __repr__ = brief

    def __post_init__(self) -> None:
        if isinstance(self.force, list | tuple | np.ndarray):
            object.__setattr__(self, "force", table_over_time("tool force", self.force, "N"))
            largest = max(force for _, force in self.force)
            if min(force for _, force in self.force) < 0.0:
                raise InputError("tool force must be zero or more at all its times")
        else:
            largest = positive("tool force", self.force, unit="N", zero=True)
        if self.mass is not None:
            positive("tool mass", self.mass, unit="kg")
        positive("force ramp", self.ramp, unit="s", zero=True)
        axis = vector("tool axis", self.axis)
        if np.linalg.norm(axis) == 0.0:
            raise InputError("tool axis must not be the zero vector")
        object.__setattr__(self, "axis", axis / np.linalg.norm(axis))
        damping = largest / 5.0 if self.damping is None else self.damping
        object.__setattr__(self, "damping", positive("tool damping", damping, zero=True))

    def force_at(self, time: np.ndarray) -> np.ndarray:
        """Force [N] at times [s]."""
        if isinstance(self.force, tuple):
            return through(self.force, time)
        if self.ramp == 0.0:
            return np.full(np.shape(time), self.force)
        return self.force * smooth_ramp(np.asarray(time) / self.ramp, 0.5, 0.5)

    @property
    def peak_speed(self) -> float:
        """Zero: it follows the plies [m/s]."""
        return 0.0


Motion = Prescribed | Float
