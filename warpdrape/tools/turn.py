"""How tools turn: an angle about an axis over time, which goes along with the tool's motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import cast

import numpy as np

from warpdrape.errors import InputError, finite, said
from warpdrape.over_time import table_over_time
from warpdrape.tools.motion import Path, Stroke, vector
from warpdrape.wording import brief


@dataclass(frozen=True, kw_only=True, eq=False)
class Turn:
    """A rotation about an axis that the tool's motion carries along; smooth in speed.

    Attributes:
        axis: its direction; the tool turns as the fingers of a right hand whose thumb points so,
            shape [3].
        angle: turned in all [rad], any number of times round; or pairs (time [s], angle [rad])
            through which it goes, monotone between them and at rest at both ends, which hold.
        point: a point of the axis, where the tool stands at the start [m], shape [3].
        duration: time that it takes [s]; None with pairs.
        start: when it begins [s].
        ramp: share of the duration in which the speed rises [-].
        brake: share in which it falls [-]; None takes ``ramp``.
    """

    axis: Sequence[float]
    angle: float | Sequence[tuple[float, float]]
    point: Sequence[float] = (0.0, 0.0, 0.0)
    duration: float | None = None
    start: float = 0.0
    ramp: float = 0.3
    brake: float | None = None

    __repr__ = brief

    def __post_init__(self) -> None:
        axis = vector("turn axis", self.axis)
        largest = float(np.abs(axis).max())
        if largest == 0.0:
            raise InputError("turn axis must not be the zero vector: give the axis's direction")
        axis = axis / largest
        object.__setattr__(self, "axis", axis / np.linalg.norm(axis))
        object.__setattr__(self, "point", vector("turn point", self.point))
        if isinstance(self.angle, list | tuple | np.ndarray):
            object.__setattr__(self, "angle", table_over_time("turn angle", self.angle, "rad"))
            if self.duration is not None:
                raise InputError(
                    f"turn duration = {said(self.duration)} and pairs of time and angle say the "
                    "same twice: leave out duration"
                )
        else:
            finite("turn angle", self.angle, unit="rad")
            if self.duration is None:
                raise InputError(
                    "a turn by one angle needs duration = …, the time [s] that it takes; or give "
                    "angle as pairs (time, angle)"
                )
        try:
            self.at(np.zeros(()))
        except InputError as fault:
            raise InputError(str(fault).replace("stroke ", "turn ")) from None

    @cached_property
    def _course(self) -> Stroke | Path:
        """The angle as the first component of a motion."""
        if isinstance(self.angle, Sequence):
            times, angles = np.array(self.angle).T
            return Path(times=times, positions=angles[:, None] * (1.0, 0.0, 0.0))
        return Stroke(
            travel=(self.angle, 0.0, 0.0),
            duration=cast(float, self.duration),  # refused without
            start=self.start,
            ramp=self.ramp,
            brake=self.brake,
        )

    def at(self, time: np.ndarray) -> np.ndarray:
        """Angle [rad] at times [s], of their shape."""
        return self._course.displacement(time)[..., 0]

    @property
    def peak_rate(self) -> float:
        """Largest speed of turning [rad/s]."""
        return self._course.peak_speed

    @property
    def end(self) -> float:
        """When it comes to rest [s]."""
        return self._course.end

    @property
    def turns(self) -> tuple[float, ...]:
        """Times at which it begins, ends, or turns back [s]."""
        return self._course.turns

    def moved(self, way: np.ndarray) -> Turn:
        """The turn about an axis elsewhere, by a translation [m], shape [3]."""
        return replace(self, point=np.add(self.point, way).tolist())

    def turned(self, rotation: np.ndarray) -> Turn:
        """The turn with its axis turned about the origin by a matrix, shape [3, 3]."""
        axis, point = (rotation @ each for each in (self.axis, self.point))
        return replace(self, axis=axis.tolist(), point=point.tolist())

    def reach(self, points: np.ndarray) -> float:
        """Largest distance from the axis of points [m], shape [n, 3]."""
        arm = np.asarray(points) - self.point
        return float(np.linalg.norm(np.cross(arm, self.axis), axis=1).max())
