"""A stack of plies draped over closed tools: a net for each, on its own level between them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from warpdrape.blanks.ply import Ply
from warpdrape.blanks.triangles import longest_sides
from warpdrape.errors import InputError
from warpdrape.fishnet.drape import SHEAR_LIMIT, begin_at, counts_of
from warpdrape.fishnet.net import Net
from warpdrape.fishnet.onto import laid_on
from warpdrape.fishnet.press import mould_surface, pressed_surface, split_tools
from warpdrape.fishnet.solver import lay_out
from warpdrape.fishnet.surface import NetSurface
from warpdrape.materials.laws import Unwoven
from warpdrape.tools.pose import Pose
from warpdrape.tools.tool import Tool

SPACING = 0.25
"""Spacing of the net over the longest sides of a ply's triangles [-]."""
GRID = 0.6
"""Distance of the points of a surface between tools over the spacing [-]."""


@dataclass(frozen=True, eq=False)
class Draped:
    """A ply and its net.

    Attributes:
        net: the net.
        flat_points: vertices of the flat ply in place [m], shape [n, 3].
        points: of the draped one [m], shape [n, 3]; zero where the net covers none.
        covered: vertices that the net covers, shape [n].
        triangles: of the whole ply, shape [m, 3].
    """

    net: Net
    flat_points: np.ndarray
    points: np.ndarray
    covered: np.ndarray
    triangles: np.ndarray


def drape_stack(plies: Sequence[Ply], tools: Sequence[Tool], poses: Sequence[Pose]) -> list[Draped]:
    """Drape plies over tools that have moved.

    Args:
        plies: from the bottom up, flat.
        tools: at the start.
        poses: where they are now.

    Raises:
        InputError: if the tools give no surface to drape over, or a ply has no yarns.
    """
    for ply in plies:
        if isinstance(ply.fabric.tension, Unwoven):
            raise InputError(
                f"approach = 'fishnet' lays out yarns, and fabric {ply.fabric.name!r} of ply "
                f"{ply.name!r} has none: take approach = 'semi_discrete'"
            )
    low = min(ply.z - 0.5 * ply.fabric.thickness for ply in plies)
    high = max(ply.z + 0.5 * ply.fabric.thickness for ply in plies)
    middle = 0.5 * (low + high)
    spacing = [SPACING * float(_sides(ply).mean()) for ply in plies]
    corners = np.concatenate([np.asarray(ply.mesh.vertices) for ply in plies])
    box = np.stack([corners.min(axis=0), corners.max(axis=0)])
    surface = _surface(tools, poses, high - low, middle, box, GRID * min(spacing))
    return [
        _drape(ply, surface.offset(ply.z - middle), step)
        for ply, step in zip(plies, spacing, strict=True)
    ]


def _sides(ply: Ply) -> np.ndarray:
    return longest_sides(np.asarray(ply.mesh.vertices), np.asarray(ply.mesh.triangles))


def _surface(
    tools: Sequence[Tool],
    poses: Sequence[Pose],
    thickness: float,
    height: float,
    box: np.ndarray,
    grid: float,
) -> NetSurface:
    if not tools:
        raise InputError(
            "approach = 'fishnet' needs tools to drape over, and the scene has none: give it some, "
            "or take approach = 'semi_discrete'"
        )
    above, below = split_tools(tools, height)
    if not above and len(below) == 1:
        return mould_surface(tools[below[0]], poses[below[0]], thickness)
    return pressed_surface(tools, poses, thickness, height, box, grid)


def _drape(ply: Ply, surface: NetSurface, spacing: float) -> Draped:
    flat = np.asarray(ply.mesh.vertices)
    low, high = flat.min(axis=0), flat.max(axis=0)
    at = np.zeros(2) if ((low < 0.0) & (high > 0.0)).all() else 0.5 * (low + high)
    along = np.append(ply.yarn_directions[0], 0.0)
    begin = begin_at(surface, surface.top_at(at), along, ply.fabric.yarn_angle)
    warp = ply.yarn_directions[0]
    turned = (flat - at) @ np.stack([warp, [-warp[1], warp[0]]], axis=1)
    counts = counts_of(surface, begin, spacing, turned)
    net = lay_out(surface, begin, spacing, counts, limit=SHEAR_LIMIT)
    points, covered = laid_on(net, turned)
    return Draped(net, ply.rest_points, points, covered, np.asarray(ply.mesh.triangles))
