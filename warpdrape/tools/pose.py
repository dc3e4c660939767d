"""Where a tool is: how far it has turned and gone from where it stood at the start."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

UNTURNED = 1e-6
"""Difference of vertices over the tool's size below which it has only gone: single precision."""


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


def shifted(shift: ArrayLike = (0.0, 0.0, 0.0)) -> Pose:
    """The pose of a tool that has gone by a translation [m] and not turned."""
    return Pose(np.eye(3), np.asarray(shift, dtype=float))


def pose_between(start: np.ndarray, now: np.ndarray) -> Pose:
    """The pose that takes vertices of a tool from one place to another, in the least squares.

    Source: Kabsch (1976), by the singular values of the moments of both.

    Args:
        start: where they were [m], shape [n, 3].
        now: where they are [m], shape [n, 3].
    """
    before, after = start - start.mean(axis=0), now - now.mean(axis=0)
    size = np.abs(before).max(initial=0.0)
    turned = np.eye(3)
    if np.abs(after - before).max(initial=0.0) > UNTURNED * size:
        u, _, v = np.linalg.svd(after.T @ before)
        turned = u @ np.diag([1.0, 1.0, np.linalg.det(u @ v)]) @ v
    return Pose(turned, now.mean(axis=0) - turned @ start.mean(axis=0))


def rotation(axis: Sequence[float], angle: float) -> np.ndarray:
    """Matrix of a right-handed rotation about a unit axis by an angle [rad] (Rodrigues)."""
    x, y, z = np.asarray(axis, dtype=float)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    cosine = np.cos(angle)
    return (
        cosine * np.eye(3) + np.sin(angle) * cross + (1.0 - cosine) * np.outer((x, y, z), (x, y, z))
    )
