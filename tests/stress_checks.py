"""One triangle, or a pair, led along a path of shapes: the stresses of a hypoelastic approach."""

import math
from dataclasses import dataclass

import numpy as np
import warp as wp
from element_checks import whole

from warpdrape.blanks.flat_mesh import FlatMesh
from warpdrape.blanks.ply import Ply
from warpdrape.forces.hypoelastic import build_stressed_ply
from warpdrape.kernels.forces.objective_rates import fibre_rows, polar_rows
from warpdrape.numerics import Numerics

ROWS = {"green_naghdi": polar_rows, "fibre_frame": fibre_rows}
CORNERS = 5e-3 * np.array([[0.0, 0.0], [1.0, 0.1], [0.3, 0.9], [0.9, -0.7]])


def square(cloth, warp_angle=0.0):
    """A pair of triangles."""
    mesh = FlatMesh(CORNERS, np.array([[0, 1, 2], [0, 3, 1]]))
    return Ply(name="pair", fabric=cloth, mesh=mesh, warp_angle=warp_angle)


@dataclass
class Path:
    """What a pair showed at the end of a path: of its first triangle, and of both."""

    tension: np.ndarray
    couple: float
    frame_tension: np.ndarray
    frame_couple: float
    work: np.ndarray
    done: float


class Led:
    """A ply led from shape to shape; counts the work of its nodal forces, step by step."""

    def __init__(self, ply, approach, device="cpu", **numerics):
        numerics = {"yarn_viscosity": 0.0} | numerics
        self.membrane = build_stressed_ply(
            ply, Numerics(**numerics), whole(ply), device, ROWS[approach]
        )
        self.ply, self.device, self.memory = ply, device, self.membrane.start()
        self.x, self.f = ply.rest_points, np.zeros_like(ply.rest_points)
        self.done = 0.0

    def to(self, x):
        """Go to positions [m]; return the forces [N]."""
        f = wp.zeros(len(x), dtype=wp.vec3d, device=self.device)
        at = wp.array(x, dtype=wp.vec3d, device=self.device)
        self.membrane.launch(0, self.membrane.patches, at, self.memory, f)(self.device)
        now = f.numpy()
        self.done -= 0.5 * float(((self.f + now) * (x - self.x)).sum())
        self.x, self.f = x, now
        return now

    def along(self, gradients):
        """Go along deformation gradients of the flat ply, shape [step, 3, 2]."""
        for gradient in gradients:
            self.to(self.ply.rest_points[:, :2] @ np.asarray(gradient).T)
        return self.shown()

    def shown(self):
        found = self.membrane.measure(
            wp.array(self.x, dtype=wp.vec3d, device=self.device), self.memory
        )
        patch = self.memory.patches.numpy()[0]
        return Path(
            tension=found["line_tension"][0],
            couple=float(found["couple"][0]),
            frame_tension=patch["tension"],
            frame_couple=float(self.memory.triangles.numpy()[0]["couple"]),
            work=found["work"].sum(axis=0),
            done=self.done,
        )


def in_space(flat):
    """Gradients of the plane, shape [step, 2, 2], as of space."""
    return np.concatenate([flat, np.zeros((len(flat), 1, 2))], axis=1)


def trellis(angles, warp=1.0, weft=1.0, rest_angle=math.pi / 2):
    """Yarns stretched and turned towards each other by shear angles, warp held; [step, 3, 2]."""
    angles, warp, weft = np.broadcast_arrays(angles, warp, weft)
    zero = np.zeros(len(angles))
    now = rest_angle - angles
    yarns = np.array([[warp, weft * np.cos(now)], [zero, weft * np.sin(now)]])
    flat = np.array([[1.0, math.cos(rest_angle)], [0.0, math.sin(rest_angle)]])
    return in_space(np.moveaxis(yarns, 2, 0) @ np.linalg.inv(flat))
