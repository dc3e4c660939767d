"""How tools and clamps move: strokes, stages, sampled paths."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import ClassVar

import numpy as np

from warpdrape.errors import InputError, finite, numbers, positive, said
from warpdrape.wording import brief

SAMPLES = 2001
"""Times at which a path is asked for its largest speed."""


def vector(name: str, value: Sequence[float]) -> np.ndarray:
    """Return three finite floats; raise `InputError` otherwise."""
    try:
        array = numbers(name, value)
    except InputError:
        array = np.empty(0)
    if array.shape != (3,) or not np.isfinite(array).all():
        raise InputError(f"{name} = {said(value)} must be three finite numbers")
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

    peak_speed: ClassVar[float] = 0.0
    largest_way: ClassVar[float] = 0.0
    end: ClassVar[float] = 0.0
    heading: ClassVar[tuple[float, ...]] = (0.0, 0.0, 0.0)
    turns: ClassVar[tuple[float, ...]] = ()


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

    def and_back(self, *, after: float = 0.0, duration: float | None = None) -> Stages:
        """Return this stroke and the way back, which lets go of what it has formed.

        Args:
            after: time for which it stays where it has come to [s].
            duration: time that the way back takes [s]; None takes as long as the way there.
        """
        positive("and_back after", after, unit="s", zero=True)
        back = replace(
            self,
            travel=tuple(-way for way in self.travel),
            start=self.end + after,
            duration=self.duration if duration is None else duration,
        )
        return Stages(strokes=[self, back])

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

    @property
    def largest_way(self) -> float:
        """Farthest that it goes from the start [m]."""
        return float(np.linalg.norm(self.travel))

    @property
    def end(self) -> float:
        """When it comes to rest [s]."""
        return self.start + self.duration

    @property
    def heading(self) -> np.ndarray:
        """Where it goes [m], shape [3]."""
        return np.asarray(self.travel, dtype=float)

    @property
    def turns(self) -> tuple[float, ...]:
        """Times at which it begins, ends, or turns round [s]."""
        return (self.start, self.end)


@dataclass(frozen=True, kw_only=True, eq=False)
class Stages:
    """Strokes one after the other, such as down, and up again; those at one time add up.

    Attributes:
        strokes: each with its own start and duration.
    """

    strokes: Sequence[Stroke]

    def __post_init__(self) -> None:
        strokes = tuple(self.strokes) if isinstance(self.strokes, list | tuple) else ()
        if not strokes or not all(isinstance(stroke, Stroke) for stroke in strokes):
            raise InputError(f"strokes = {said(self.strokes)} must be a list of Stroke")
        object.__setattr__(self, "strokes", strokes)

    def displacement(self, time: np.ndarray) -> np.ndarray:
        """Displacement [m] at times [s], shape [..., 3]."""
        first, *others = (stroke.displacement(time) for stroke in self.strokes)
        return sum(others, first)

    @property
    def start(self) -> float:
        """When it begins [s]."""
        return min(stroke.start for stroke in self.strokes)

    @property
    def end(self) -> float:
        """When it comes to rest [s]."""
        return max(stroke.end for stroke in self.strokes)

    @property
    def peak_speed(self) -> float:
        """Largest speed [m/s]: at most that of all strokes that are on at a time."""
        return max(
            sum(stroke.peak_speed for stroke in self.strokes if stroke.start <= time < stroke.end)
            for time in {stroke.start for stroke in self.strokes}
        )

    @property
    def largest_way(self) -> float:
        """Farthest that it goes from the start [m], sampled between turns."""
        turns = self.turns
        fine = np.concatenate([np.linspace(*ends, 101) for ends in pairwise(turns)])
        return float(np.linalg.norm(self.displacement(fine), axis=1).max())

    @property
    def turns(self) -> tuple[float, ...]:
        """Times at which a stroke begins or ends [s]."""
        return tuple(sorted({time for stroke in self.strokes for time in stroke.turns}))

    @property
    def heading(self) -> np.ndarray:
        """Where its first stroke goes [m], shape [3]."""
        return min(self.strokes, key=lambda stroke: stroke.start).heading


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
        times = numbers("path times", self.times)
        positions = numbers("path positions", self.positions)
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
        fine = np.linspace(self.start, self.end, SAMPLES)
        steps = np.diff(self.displacement(fine), axis=0)
        return float(np.linalg.norm(steps, axis=1).max() / (fine[1] - fine[0]))

    @property
    def largest_way(self) -> float:
        """Farthest that it goes from the start [m]."""
        return float(np.linalg.norm(self.positions, axis=1).max())

    @property
    def start(self) -> float:
        """When it begins [s]."""
        return float(self.times[0])

    @property
    def end(self) -> float:
        """When it comes to rest [s]."""
        return float(self.times[-1])

    @property
    def turns(self) -> tuple[float, ...]:
        """Times of its samples [s]."""
        return tuple(np.asarray(self.times, dtype=float).tolist())

    @property
    def heading(self) -> np.ndarray:
        """Where it ends [m], shape [3]."""
        return np.subtract(self.positions[-1], self.positions[0])


Prescribed = Still | Stroke | Stages | Path
