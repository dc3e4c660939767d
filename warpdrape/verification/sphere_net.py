"""An inextensible net that its weight draws onto a frictionless sphere, pinned at the pole."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from warpdrape import Clamp, Fabric, Numerics, Ply, Scene, Tool
from warpdrape.coupons.closed_forms import bias_diagonal_of_net, net_shear_on_sphere
from warpdrape.materials.laws import LinearTension
from warpdrape.verification.case import CaseResult, absolute

RADIUS = 0.1
THICKNESS = 1e-4
CELL = 1e-3
HALF_SIDE = 0.08
"""Half the ply's side [m]: its corners come to about 72° from the pole."""
FARTHEST = math.radians(60.0)
RATE_AT = np.radians([25.0, 30.0, 35.0, 40.0])
"""Polar angles inside every mesh's inner cells, over which the error is averaged for its rate: at a
single one the finest mesh's is as small as what the search of contacts leaves, 0.001°."""

WORST = 0.1
"""Limit of a cell's error [deg]: three times what the coarsest mesh leaves, of cells of 11°."""


def net_scene(cells: int, *, duration: float = 0.7, stiffness: float = 2e4) -> Scene:
    """A square net over the pole of a sphere, yarns along its sides, that falls onto it.

    Args:
        cells: squares along a side, an even number.
        duration: [s].
        stiffness: line stiffness of the yarns [N/m]; the weight strains them by some 1e-5.
    """
    net = Fabric(
        name="net",
        areal_density=0.6,
        thickness=THICKNESS,
        cell_warp=CELL,
        cell_weft=CELL,
        tension=LinearTension(stiffness * CELL, stiffness * CELL),
        compressive_factor=1.0,
    )
    ply = Ply.rectangle("net", net, 2.0 * HALF_SIDE, cells=cells, mesh="grid", z=0.5 * THICKNESS)
    pole = Clamp(name="pole", ply="net", where=lambda p: np.hypot(p[:, 0], p[:, 1]) < 1e-9)
    return Scene(
        name="sphere_net",
        plies=[ply],
        tools=[Tool.sphere(radius=RADIUS, facet=2.5e-3)],
        clamps=[pole],
        duration=duration,
        friction=0.0,
        numerics=Numerics(damping=12.0, search_slide=5e-4),
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
    measured = np.array(
        [
            shear[
                (np.abs(cell[:, 0] + 0.5) == k + 0.5) & (np.abs(cell[:, 1] + 0.5) == k + 0.5)
            ].mean()
            for k in range(count // 2)
        ]
    )
    u = (np.arange(count // 2) + 0.5) * side / radius
    return bias_diagonal_of_net(u), measured, net_shear_on_sphere(u**2)


def sphere_net(quick: bool) -> Iterator[CaseResult]:
    """Largest error of the shear angle along the bias diagonal, and how it falls.

    The cell at the ply's corner is left out: it has no neighbour to hold its triangles' own mode.
    """
    errors = []
    meshes = (8, 16) if quick else (8, 16, 32)
    for cells in meshes:
        polar, measured, exact = diagonal_shear(net_scene(cells).run(frames=10))
        inside = (polar <= FARTHEST) & (np.arange(len(polar)) < len(polar) - 1)
        worst = int(np.argmax(np.abs(measured - exact) * inside))
        errors.append(float(np.interp(RATE_AT, polar, measured - exact).mean()))
        yield absolute(
            f"net on a sphere, {cells} cells: shear up to 60° from the pole, at its worst",
            math.degrees(measured[worst]),
            math.degrees(exact[worst]),
            WORST,
            "°",
        )
    rate = math.log(errors[0] / errors[-1]) / math.log(meshes[-1] / meshes[0])
    yield absolute("net on a sphere: rate of convergence", rate, 2.0, 0.5)
