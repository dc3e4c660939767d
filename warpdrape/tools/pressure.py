"""Pressure of air or a bag on a side of a ply, over time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from warpdrape.errors import InputError, finite, one_of, positive, said
from warpdrape.over_time import table_over_time, through
from warpdrape.tools.motion import smooth_ramp

UPWARDS = {"lower": 1.0, "upper": -1.0}
"""Sign along the normals of a ply's triangles, which point up where it lies flat."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Pressure:
    """A pressure that pushes on one side of a ply, along its normal wherever the ply goes.

    Vacuum under a ply is atmospheric pressure on its upper side.

    Attributes:
        name: how results call it.
        ply: name of the ply.
        pressure: on that side over the other one's [Pa]; or pairs (time [s], pressure [Pa]) through
            which it goes smoothly, the ends holding before and after.
        side: "upper", from which it pushes down on a flat ply, or "lower".
        ramp: time in which a constant pressure rises smoothly from zero [s].
        where: function of the flat points [m] (shape [n, 3]) to a mask: it acts on triangles with
            all corners in it; None on the whole ply.
    """

    name: str
    ply: str
    pressure: float | Sequence[tuple[float, float]]
    side: str = "upper"
    ramp: float = 5e-3
    where: Callable[[np.ndarray], np.ndarray] | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not self.name.isidentifier():
            raise InputError(f"pressure name = {said(self.name)} must be a plain identifier")
        one_of(f"side of pressure {self.name!r}", self.side, ("upper", "lower"))
        positive(f"ramp of pressure {self.name!r}", self.ramp, unit="s", zero=True)
        if isinstance(self.pressure, list | tuple | np.ndarray):
            table = table_over_time(f"pressure {self.name!r}", self.pressure, "Pa")
            object.__setattr__(self, "pressure", table)
        else:
            finite(f"pressure {self.name!r}", self.pressure, unit="Pa")
        if self.where is not None and not callable(self.where):
            raise InputError(
                f"pressure {self.name!r}: where must be a function of the flat points to a mask"
            )

    def at(self, time: np.ndarray) -> np.ndarray:
        """Pressure [Pa] at times [s], of their shape."""
        time = np.asarray(time, dtype=float)
        if isinstance(self.pressure, Sequence):
            return through(self.pressure, time)
        if self.ramp == 0.0:
            return np.full(time.shape, float(self.pressure))
        return self.pressure * smooth_ramp(time / self.ramp, 0.5, 0.5)

    def triangles(self, points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
        """Numbers of the triangles of a ply on which it acts.

        Args:
            points: flat [m], shape [n, 3].
            triangles: vertices, shape [m, 3].

        Raises:
            InputError: if there are none, or ``where`` gives no mask of the points.
        """
        if self.where is None:
            return np.arange(len(triangles))
        mask = np.asarray(self.where(points))
        if mask.dtype != bool or mask.shape != (len(points),):
            raise InputError(
                f"pressure {self.name!r}: where must give a mask of shape ({len(points)},), one "
                f"for each vertex of ply {self.ply!r}"
            )
        inside = np.flatnonzero(mask[triangles].all(axis=1))
        if inside.size == 0:
            raise InputError(f"pressure {self.name!r} acts on no triangle of ply {self.ply!r}")
        return inside


def along_normals(pressures: Sequence[Pressure], times: np.ndarray) -> np.ndarray:
    """Pressures along the normals of plies' triangles [Pa] at times [s], shape [load, time]."""
    rows = [UPWARDS[pressure.side] * pressure.at(times) for pressure in pressures]
    return np.array(rows).reshape(len(rows), len(times))
