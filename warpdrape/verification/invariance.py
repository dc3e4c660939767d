"""The same problem turned, mirrored or renumbered has the same result, turned, mirrored so."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from warpdrape import Clamp, Ply, Scene, Stroke
from warpdrape.blanks.flat_mesh import FlatMesh
from warpdrape.blanks.meshing import mesh_outline
from warpdrape.blanks.outlines import Rectangle
from warpdrape.materials.fabric_library import load_fabric
from warpdrape.verification.case import CaseResult, absolute

WIDTH, HEIGHT, EDGE = 0.06, 0.12, 0.012
WARP = math.radians(35.0)
TRAVEL = 0.012
TURN = math.radians(37.0)


def _pulled(matrix: np.ndarray, order: np.ndarray, flat: FlatMesh, warp_angle: float) -> np.ndarray:
    """Final x, y [m] of a pulled strip whose flat points went through ``matrix``, shape [2, 2].

    Triangles are renumbered with the vertices. Yarns as stiff in compression: a stiffness that
    switches with the sign of a strain turns rounding into differences that can be seen.
    """
    triangles = np.arange(len(flat.triangles))
    if (order[1:] < order[:-1]).any():
        triangles = np.random.default_rng(5).permutation(triangles)
    place = np.empty(len(order), int)
    place[order] = np.arange(len(order))
    mesh = FlatMesh(flat.vertices[order] @ matrix.T, place[flat.triangles[triangles]])
    fabric = replace(load_fabric("carbon_interlock"), compressive_factor=1.0)
    ply = Ply(name="ply_0", fabric=fabric, mesh=mesh, warp_angle=warp_angle)
    up = np.append(matrix @ (0.0, 1.0), 0.0)

    def end(side: float) -> Callable[[np.ndarray], np.ndarray]:
        return lambda p: side * (p @ up) > 0.5 * HEIGHT - 1e-9

    clamps = [
        Clamp(
            name=name,
            ply="ply_0",
            motion=Stroke(travel=(way * up).tolist(), duration=2e-3),
            follow=up.tolist(),
            where=end(side),
        )
        for name, side, way in (("lower", -1.0, 0.0), ("upper", 1.0, TRAVEL))
    ]
    scene = Scene(name="strip", plies=[ply], clamps=clamps, duration=2e-3, gravity=(0.0, 0.0, 0.0))
    return scene.run(frames=1).plies[0].points[:, :2]


def invariance(quick: bool) -> list[CaseResult]:
    """Largest difference of the final positions over the clamp's travel."""
    flat = mesh_outline(Rectangle(WIDTH, HEIGHT), edge=EDGE, pattern="random", seed=3)
    same = np.arange(len(flat.vertices))
    shuffled = np.random.default_rng(4).permutation(same)
    c, s = math.cos(TURN), math.sin(TURN)
    turn, mirror, eye = np.array([[c, -s], [s, c]]), np.diag([-1.0, 1.0]), np.eye(2)
    plain = _pulled(eye, same, flat, WARP)
    others = {
        "turned by 37°": _pulled(turn, same, flat, WARP + TURN) @ turn,
        "mirrored": _pulled(mirror, same, flat, math.pi - WARP) @ mirror,
        "renumbered": _pulled(eye, shuffled, flat, WARP)[np.argsort(shuffled)],
    }
    return [
        absolute(
            f"{name}: largest change of positions over the travel",
            np.abs(found - plain).max() / TRAVEL,
            0.0,
            1e-9,
        )
        for name, found in others.items()
    ]
