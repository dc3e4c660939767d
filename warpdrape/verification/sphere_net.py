"""An inextensible net that its weight draws onto a frictionless sphere, pinned at the pole."""

from __future__ import annotations

import math

import numpy as np

from warpdrape import Clamp, Fabric, Numerics, Ply, Scene, Tool
from warpdrape.closed_forms import bias_diagonal_of_net, net_shear_on_sphere
from warpdrape.laws import LinearTension
from warpdrape.verification.case import CaseResult, absolute

RADIUS = 0.1
THICKNESS = 1e-4
CELL = 1e-3
HALF_SIDE = 0.072
"""Half the ply's side [m]: its corners come to about 63° from the pole."""
FARTHEST = math.radians(60.0)


def net_scene(cells: int, *, duration: float = 0.8, stiffness: float = 2e4) -> Scene:
    """A square net over the pole of a sphere, yarns along its sides, that falls onto it.

    Args:
        cells: squares along a side, an even number.
        duration: [s].
        stiffness: line stiffness of the yarns [N/m]; the weight strains them by some 1e-5.
    """
    net = Fabric(
        name="net", areal_density=0.6, thickness=THICKNESS, cell_warp=CELL, cell_weft=CELL,
        tension=LinearTension(stiffness * CELL, stiffness * CELL), compressive_factor=1.0,
    )
    ply = Ply.rectangle("net", net, 2.0 * HALF_SIDE, cells=cells, mesh="grid", z=0.5 * THICKNESS)
    pole = Clamp(name="pole", ply="net", where=lambda p: np.hypot(p[:, 0], p[:, 1]) < 1e-9)
    return Scene(
        name="sphere_net", plies=[ply], tools=[Tool.sphere(radius=RADIUS, facet=2.5e-3)],
        clamps=[pole], duration=duration, friction=0.0, numerics=Numerics(damping=12.0),
    )


def diagonal_shear(result) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Polar angle [rad], measured and exact shear angle [rad] of the cells along the bias diagonal.

    A cell's value is the mean over its four triangles; the exact one is taken at its middle.
    """
    formed = result.plies[0]
    radius = RADIUS + 0.5 * THICKNESS
    count = round(math.sqrt(len(formed.triangles) / 4))
    side = 2.0 * HALF_SIDE / count
    cell = np.floor(formed.rest_points[formed.triangles].mean(axis=1)[:, :2] / side).astype(int)
    shear = np.abs(formed.shear_angle)
    measured = np.array([
        shear[(np.abs(cell[:, 0] + 0.5) == k + 0.5) & (np.abs(cell[:, 1] + 0.5) == k + 0.5)].mean()
        for k in range(count // 2)
    ])
    u = (np.arange(count // 2) + 0.5) * side / radius
    return bias_diagonal_of_net(u), measured, net_shear_on_sphere(u**2)


def sphere_net(quick: bool) -> list[CaseResult]:
    """Largest error of the shear angle along the bias diagonal, on two meshes or three."""
    cases, errors = [], []
    meshes = (12, 24) if quick else (12, 24, 48)
    for cells in meshes:
        polar, measured, exact = diagonal_shear(net_scene(cells).run(frames=10))
        near = polar <= FARTHEST
        worst = np.argmax(np.abs(measured - exact) * near)
        errors.append(float(np.abs(measured - exact)[near].max()))
        cases.append(absolute(
            f"net on a sphere, {cells} cells, worst at {math.degrees(polar[worst]):.0f}° from the pole",
            math.degrees(measured[worst]), math.degrees(exact[worst]), 1.0, "°",
        ))
    rate = math.log(errors[0] / errors[-1]) / math.log(meshes[-1] / meshes[0])
    cases.append(absolute("net on a sphere, rate of convergence", rate, 2.0, 1.0))
    return cases
