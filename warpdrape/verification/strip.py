"""A narrow strip with its warp along x, which stands for a yarn, a chain or a rope in the cases."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from warpdrape import Clamp, Fabric, Ply, Scene
from warpdrape.materials.laws import LinearTension, NoShear, ShearPolynomial
from warpdrape.numerics import Numerics

CELL = 1e-3
"""Unit cell of the strip's fabric, both ways [m]."""


def yarn_fabric(line_stiffness: float, areal_density: float, shear: float | None = None) -> Fabric:
    """A fabric of one line stiffness both ways, as stiff in compression.

    Args:
        line_stiffness: N per metre of width and unit strain [N/m].
        areal_density: [kg/m²].
        shear: C'(0) [N/m]; 1/1000 of the line stiffness if None.
    """
    couple = (1e-3 * line_stiffness if shear is None else shear) * CELL**2
    return Fabric(
        name="strip",
        areal_density=areal_density,
        thickness=1e-3,
        cell_warp=CELL,
        cell_weft=CELL,
        tension=LinearTension(line_stiffness * CELL, line_stiffness * CELL),
        shear=ShearPolynomial((couple,)) if couple > 0.0 else NoShear(),
        compressive_factor=1.0,
    )


def strip_scene(
    fabric: Fabric,
    length: float,
    cells: int,
    *,
    duration: float,
    left=None,
    right=None,
    gravity: Sequence[float] = (0.0, 0.0, 0.0),
    numerics: Numerics | None = None,
    **options,
) -> Scene:
    """A strip one cell wide, held at the ends that are given a motion.

    Args:
        fabric: of the strip.
        length: along x, the strip centred at the origin [m].
        cells: squares along it.
        duration: [s].
        left: motion of the clamp at −length/2; free if None.
        right: motion of the clamp at length/2; free if None.
        gravity: [m/s²].
        numerics: as in a scene.
        options: of the scene.
    """
    ply = Ply.rectangle("strip", fabric, length, length / cells, cells=cells, mesh="grid")
    clamps = [
        Clamp(
            name=name,
            ply="strip",
            where=_end(0.5 * length, side),
            motion=motion,
            follow=(1.0, 0.0, 0.0),
        )
        for name, side, motion in (("left", -1.0, left), ("right", 1.0, right))
        if motion is not None
    ]
    return Scene(
        name="strip",
        plies=[ply],
        clamps=clamps,
        duration=duration,
        gravity=gravity,
        numerics=numerics or Numerics(),
        **options,
    )


def _end(half: float, side: float):
    return lambda points: side * points[:, 0] > half * (1.0 - 1e-6)


def middle_line(result) -> tuple[np.ndarray, np.ndarray]:
    """Rest x [m], shape [n], rising, and positions [m], shape [n, 3], of the strip's centres."""
    formed = result.plies[0]
    on_axis = np.flatnonzero(np.abs(formed.rest_points[:, 1]) < 1e-9)
    order = on_axis[np.argsort(formed.rest_points[on_axis, 0])]
    return formed.rest_points[order, 0], formed.points[order]
