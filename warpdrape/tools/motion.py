"""How tools and clamps move: smooth strokes, sampled paths, and forces that let a tool float."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from warpdrape.errors import InputError, finite, positive
from warpdrape.wording import brief


def vector(name: str, value: Sequence[float]) -> np.ndarray:
    """Return three finite floats; raise `InputError` otherwise."""
    try:
        array = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        array = np.empty(0)
    if array.shape != (3,) or not np.isfinite(array).all():
        raise InputError(f"{name} = {value!r} must be three finite numbers")
    return array


def smooth_ramp(u: np.ndarray, ramp: float, brake: float) -> np.ndarray:
    """Rise from 0 to 1 over u in 0…1, the speed growing over the first share of it, falling last.

    The speed follows 3r² − 2r³ within a ramp, so velocity has no jump and no corner; its peak is
    1/(1 − ½ ramp − ½ brake) of the mean.

    Args:
        u: time over the duration [-].
        ramp: share in which the speed rises [-].
        brake: share in which it falls [-].
    """
    u = np.clip(np.asarray(u, dtype=float), 0.0, 1.0)

    def gone(w: np.ndarray, share: float) -> np.ndarray:
        r = np.minimum(w / share, 1.0)
        return share * (r**3 - 0.5 * r**4) + np.maximum(w - share, 0.0)

    total = 1.0 - 0.5 * (ramp + brake)
    early = u <= 0.5 * (1.0 + ramp - brake)
    return np.where(early, gone(u, ramp), total - gone(1.0 - u, brake)) / total


@dataclass(frozen=True)
class Still:
    """No motion."""

    __repr__ = brief

    def displacement(self, time: np.ndarray) -> np.ndarray:
        """Zero [m] at any time, shape [..., 3]."""
        return np.zeros((*np.shape(time), 3))

    @property
    def peak_speed(self) -> float:
        """Largest speed [m/s]."""
        return 0.0


@dataclass(frozen=True, kw_only=True)
class Stroke:
    """A straight travel, smooth in velocity.

    Attributes:
        travel: displacement from start to end [m], shape [3].
        duration: time it takes [s].
        start: when it begins [s].
        ramp: share of the duration in which the speed rises [-].
        brake: share in which it falls, with ``ramp`` at most 1 [-]; None takes ``ramp``.
    """

    travel: Sequence[float]
    duration: float
    start: float = 0.0
    ramp: float = 0.3
    brake: float | None = None

    __repr__ = brief

    def __post_init__(self) -> None:
        object.__setattr__(self, "travel", vector("travel", self.travel))
        positive("stroke duration", self.duration, unit="s")
        positive("stroke start", self.start, unit="s", zero=True)
        if self.brake is None and not 0.0 < finite("stroke ramp", self.ramp) <= 0.5:
            raise InputError(f"stroke ramp = {self.ramp} must lie above 0 and not above 0.5")
        falling = positive("stroke brake", self.falling)
        if positive("stroke ramp", self.ramp) + falling > 1.0 + 1e-12:
            raise InputError(
                f"stroke ramp = {self.ramp} and brake = {self.brake} must not exceed 1 together: "
                "they are shares of the duration"
            )

    @property
    def falling(self) -> float:
        """Share of the duration in which the speed falls [-]."""
        return self.ramp if self.brake is None else self.brake

    def displacement(self, time: np.ndarray) -> np.ndarray:
        """Displacement [m] at times [s], shape [..., 3]."""
        u = (np.asarray(time, dtype=float) - self.start) / self.duration
        return smooth_ramp(u, self.ramp, self.falling)[..., None] * self.travel

    @property
    def peak_speed(self) -> float:
        """Largest speed [m/s]."""
        share = 1.0 - 0.5 * (self.ramp + self.falling)
        return float(np.linalg.norm(self.travel)) / (self.duration * share)


@dataclass(frozen=True, kw_only=True, eq=False)
class Path:
    """A path through samples, monotone between them and smooth in velocity, at rest at both ends.

    Attributes:
        times: rising times [s], shape [n]; the ends hold before and after.
        positions: displacements [m], shape [n, 3].
    """

    times: Sequence[float]
    positions: Sequence[Sequence[float]]

    __repr__ = brief

    def __post_init__(self) -> None:
        times = np.asarray(self.times, dtype=float)
        positions = np.asarray(self.positions, dtype=float)
        if times.ndim != 1 or times.size < 2 or positions.shape != (times.size, 3):
            raise InputError("a path needs n ≥ 2 times and n displacements of three numbers")
        if not (np.isfinite(times).all() and np.isfinite(positions).all()):
            raise InputError("a path must hold finite numbers only")
        if (np.diff(times) <= 0).any():
            raise InputError("path times must rise")
        object.__setattr__(self, "times", times)
        object.__setattr__(self, "positions", positions)

    def displacement(self, time: np.ndarray) -> np.ndarray:
        """Displacement [m] at times [s], shape [..., 3]."""
        from scipy.interpolate import CubicHermiteSpline, PchipInterpolator

        speeds = PchipInterpolator(self.times, self.positions).derivative()(self.times)
        speeds[[0, -1]] = 0.0
        inside = np.clip(np.asarray(time, dtype=float), self.times[0], self.times[-1])
        return CubicHermiteSpline(self.times, self.positions, speeds)(inside)

    @property
    def peak_speed(self) -> float:
        """Largest speed [m/s], sampled."""
        fine = np.linspace(self.times[0], self.times[-1], 2001)
        steps = np.diff(self.displacement(fine), axis=0)
        return float(np.linalg.norm(steps, axis=1).max() / (fine[1] - fine[0]))


@dataclass(frozen=True, kw_only=True)
class Float:
    """A tool that floats along an axis under a force, and shows how far it went.

    Attributes:
        force: pressing force [N], the tool's weight included.
        axis: direction in which it presses, shape [3].
        mass: moving mass [kg].
        ramp: time over which the force rises smoothly from zero [s].
        damping: of the motion along the axis [N·s/m]; None takes ``force`` at 5 m/s.
    """

    force: float
    axis: Sequence[float] = (0.0, 0.0, -1.0)
    mass: float = 0.5
    ramp: float = 2e-3
    damping: float | None = None

    __repr__ = brief

    def __post_init__(self) -> None:
        positive("tool force", self.force, unit="N", zero=True)
        positive("tool mass", self.mass, unit="kg")
        positive("force ramp", self.ramp, unit="s", zero=True)
        axis = vector("tool axis", self.axis)
        if np.linalg.norm(axis) == 0.0:
            raise InputError("tool axis must not be the zero vector")
        object.__setattr__(self, "axis", axis / np.linalg.norm(axis))
        damping = self.force / 5.0 if self.damping is None else self.damping
        object.__setattr__(self, "damping", positive("tool damping", damping, zero=True))

    def force_at(self, time: np.ndarray) -> np.ndarray:
        """Force [N] at times [s]."""
        if self.ramp == 0.0:
            return np.full(np.shape(time), self.force)
        return self.force * smooth_ramp(np.asarray(time) / self.ramp, 0.5, 0.5)

    @property
    def peak_speed(self) -> float:
        """Zero: it follows the plies [m/s]."""
        return 0.0


Motion = Still | Stroke | Path | Float
