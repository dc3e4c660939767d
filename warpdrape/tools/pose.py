"""Where a tool is: how far it has turned and gone from where it stood at the start."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class Pose:
    """A point X of the tool, where it stood at the start, is at R X + s now.

    Attributes:
        turned: the rotation R, shape [3, 3].
        shift: s [m], shape [3].
    """

    turned: np.ndarray
    shift: np.ndarray

    def place(self, points: np.ndarray) -> np.ndarray:
        """Points of the tool [m], shape [n, 3], where they are now."""
        return points @ self.turned.T + self.shift

    def into(self, points: np.ndarray) -> np.ndarray:
        """Points [m], shape [n, 3], as the tool sees them from where it stood at the start."""
        return (points - self.shift) @ self.turned

    def direct(self, directions: np.ndarray) -> np.ndarray:
        """Directions in the tool's frame, shape [..., 3], as they are now."""
        return directions @ self.turned.T

    def into_directions(self, directions: np.ndarray) -> np.ndarray:
        """Directions, shape [..., 3], in the tool's frame."""
        return directions @ self.turned


def shifted(shift: Sequence[float] = (0.0, 0.0, 0.0)) -> Pose:
    """The pose of a tool that has gone by a translation [m] and not turned."""
    return Pose(np.eye(3), np.asarray(shift, dtype=float))


def rotation(axis: Sequence[float], angle: float) -> np.ndarray:
    """Matrix of a right-handed rotation about a unit axis by an angle [rad] (Rodrigues)."""
    x, y, z = np.asarray(axis, dtype=float)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    cosine = np.cos(angle)
    return (
        cosine * np.eye(3) + np.sin(angle) * cross + (1.0 - cosine) * np.outer((x, y, z), (x, y, z))
    )
