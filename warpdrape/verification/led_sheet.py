"""A pair of triangles led from shape to shape: what a hypoelastic membrane makes of the path."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

import numpy as np
import warp as wp

from warpdrape.blanks.flat_mesh import FlatMesh
from warpdrape.blanks.ply import Ply
from warpdrape.forces.hypoelastic import build_stressed_ply
from warpdrape.interaction import Span
from warpdrape.kernels.forces.objective_rates import fibre_rows, polar_rows
from warpdrape.materials.fabric import Fabric
from warpdrape.numerics import Numerics

ROWS: dict[str, Callable] = {"green_naghdi": polar_rows, "fibre_frame": fibre_rows}
"""B of each hypoelastic approach."""
CORNERS = 5e-3 * np.array([[0.0, 0.0], [1.0, 0.1], [0.3, 0.9], [0.9, -0.7]])
"""Of a pair whose edges follow no yarn [m]."""


def pair_of(cloth: Fabric, warp_angle: float = 0.0) -> Ply:
    """A pair of triangles."""
    mesh = FlatMesh(CORNERS, np.array([[0, 1, 2], [0, 3, 1]]))
    return Ply(name="pair", fabric=cloth, mesh=mesh, warp_angle=warp_angle)


class Shown(NamedTuple):
    """What the first triangle shows, and the work done on all.

    Attributes:
        tension: along the yarns [N/m], shape [2].
        couple: on the yarns' angle [N/m].
        frame_tension: in the frame [N/m], shape [2].
        frame_couple: in the frame [N/m].
    """

    tension: np.ndarray
    couple: float
    frame_tension: np.ndarray
    frame_couple: float


class LedSheet:
    """A ply whose positions are given, step after step.

    Attributes:
        ply: the ply.
        membrane: its triangles on the device.
        memory: their states.
        x: positions [m], shape [vertex, 3].
        f: forces there [N], shape [vertex, 3].
        done: work of the nodal forces so far, by the trapezoidal rule [J].
    """

    def __init__(self, ply: Ply, approach: str, device: str = "cpu", **numerics: Any) -> None:
        """Lay it flat; without viscosity of the yarns unless it is asked for."""
        span = Span(0, len(ply.mesh.vertices), 0, len(ply.mesh.triangles))
        numerics = {"yarn_viscosity": 0.0} | numerics
        self.ply, self._device = ply, device
        self.membrane = build_stressed_ply(ply, Numerics(**numerics), span, device, ROWS[approach])
        self.memory = self.membrane.start()
        self.x, self.f, self.done = ply.rest_points, np.zeros_like(ply.rest_points), 0.0

    def to(self, x: np.ndarray) -> np.ndarray:
        """Go to positions [m], shape [vertex, 3]; return the forces there [N]."""
        f = wp.zeros(len(x), dtype=wp.vec3d, device=self._device)
        membrane = self.membrane
        membrane.launch(0, membrane.patches, self._at(x), self.memory, f)(self._device)
        now = f.numpy()
        self.done -= 0.5 * float(((self.f + now) * (x - self.x)).sum())
        self.x, self.f = x, now
        return now

    def along(self, gradients: Iterable[np.ndarray]) -> Shown:
        """Go along deformation gradients of the flat ply, shape [step, 3, 2]."""
        for gradient in gradients:
            self.to(self.ply.rest_points[:, :2] @ np.asarray(gradient).T)
        return self.shown()

    def measured(self, x: np.ndarray | None = None) -> dict[str, np.ndarray]:
        """All that it shows at its positions, or a step ahead at others."""
        return self.membrane.measure(self._at(self.x if x is None else x), self.memory)

    def shown(self) -> Shown:
        """Stresses of the first triangle."""
        found = self.measured()
        return Shown(
            found["line_tension"][0],
            float(found["couple"][0]),
            self.memory.patches.numpy()[0]["tension"],
            float(self.memory.triangles.numpy()[0]["couple"]),
        )

    def _at(self, x: np.ndarray) -> wp.array:
        return wp.array(x, dtype=wp.vec3d, device=self._device)


def trellis(
    angles: np.ndarray,
    warp: np.ndarray | float = 1.0,
    weft: np.ndarray | float = 1.0,
    rest_angle: float = math.pi / 2,
) -> np.ndarray:
    """Gradients of yarns stretched and turned towards each other, the warp's direction held.

    Args:
        angles: shear angles [rad], shape [step].
        warp: stretch of the warp [-], shape [step] or one for all.
        weft: likewise.
        rest_angle: from warp to weft of the flat ply, whose warp is along x [rad].

    Returns:
        Shape [step, 3, 2].
    """
    angles, warp, weft = np.broadcast_arrays(np.atleast_1d(angles), warp, weft)
    zero = np.zeros(len(angles))
    now = rest_angle - angles
    yarns = np.array([[warp, weft * np.cos(now)], [zero, weft * np.sin(now)], [zero, zero]])
    flat = np.array([[1.0, math.cos(rest_angle)], [0.0, math.sin(rest_angle)]])
    return np.moveaxis(yarns, 2, 0) @ np.linalg.inv(flat)


def loop(steps: int, stretch: float, angle: float) -> np.ndarray:
    """Warp stretched, sheared, let back, sheared back: gradients, shape [4 steps, 3, 2].

    Args:
        steps: of each of the four.
        stretch: largest strain of the warp [-].
        angle: largest shear angle [rad].
    """
    s = np.arange(1, steps + 1) / steps
    one, none = np.ones(steps), np.zeros(steps)
    angles = angle * np.r_[none, s, one, 1.0 - s]
    return trellis(angles, 1.0 + stretch * np.r_[s, one, 1.0 - s, none])
