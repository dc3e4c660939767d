"""Tools at the start: none reaches into a flat ply, holds one inside, or would pass it unfelt."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from warpdrape.blanks.ply import Ply
from warpdrape.blanks.triangles import longest_sides
from warpdrape.contact.features import finer_points
from warpdrape.contact.rims import over_ply, rims_hold
from warpdrape.errors import InputError
from warpdrape.numerics import START_TOLERANCE
from warpdrape.setup import Setup
from warpdrape.tools.tool import Tool

MISSED = 0.5
"""Width of a surface over the sides of triangles below which their vertices miss it [-]."""
FACING = 0.5
"""Share of an open tool's area, seen from the plies, beyond which the side it shows tells [-]."""


def check_tools(scene: Setup) -> None:
    """Refuse tools that reach into a flat ply, or that hold one inside.

    Raises:
        InputError: naming tool and ply, and how far to move the tool.
    """
    for tool, finer in zip(scene.tools, finer_points(scene), strict=True):
        points = tool.pose(0.0).place(tool.vertices)
        for ply in scene.plies:
            _refuse_crossing(tool, points, ply)
            _refuse_enclosing(tool, points, ply)
        _refuse_facing_away(tool, points, scene.plies)
        unfelt = len(finer) == 0 and not rims_hold(tool, scene)
        for ply in scene.plies if unfelt else ():
            _refuse_finer(tool, points, ply)


def _refuse_finer(tool: Tool, points: np.ndarray, ply: Ply) -> None:
    """Raise `InputError` for a narrow surface that would pass between the vertices of a ply unfelt.

    Nothing of it sticks out, and rims that would be felt turn away; its second longest principal
    dimension is what the vertices must not miss.
    """
    middle = tool.vertices.mean(axis=0)
    axes = np.linalg.svd(tool.vertices - middle, full_matrices=False)[2]
    thick = float(np.sort(np.ptp(tool.vertices @ axes.T, axis=0))[1])
    sides = longest_sides(ply.rest_points, ply.mesh.triangles)
    side = float(np.median(sides))
    if 0.0 < thick < MISSED * side and over_ply(ply, points).any():
        raise InputError(
            f"tool {tool.name!r} is an open surface {1e3 * thick:.3g} mm wide and would pass "
            f"between the vertices of ply {ply.name!r}, {1e3 * side:.3g} mm apart: make it a "
            f"closed solid, or give triangles with sides of {1e3 * thick:.3g} mm or less"
        )


def _refuse_facing_away(tool: Tool, points: np.ndarray, plies: Sequence[Ply]) -> None:
    """Raise `InputError` where most of an open tool over or under the plies turns its back on them.

    Args:
        tool: the tool.
        points: its vertices at the start [m], shape [n, 3].
        plies: the plies.
    """
    if tool.surface.mesh.is_watertight:
        return
    a, b, c = np.moveaxis(points[tool.triangles], 1, 0)
    middle, upward = (a + b + c) / 3.0, 0.5 * np.cross(b - a, c - a)[:, 2]
    over = {mesh: over_ply(ply, middle) for mesh, ply in {ply.mesh: ply for ply in plies}.items()}
    for ply in plies:
        facing = np.where(over[ply.mesh], upward * np.sign(ply.z - middle[:, 2]), 0.0)
        if facing.sum() < -FACING * np.abs(facing).sum():
            raise InputError(
                f"tool {tool.name!r}: its facets face away from ply {ply.name!r}: take "
                "tool.flipped(), or turn them round in its file"
            )


def _refuse_crossing(tool: Tool, points: np.ndarray, ply: Ply) -> None:
    """Raise `InputError` where facets of a tool pass through the body of a flat ply.

    Args:
        tool: the tool.
        points: its vertices at the start [m], shape [n, 3].
        ply: the ply.
    """
    half = 0.5 * ply.fabric.thickness
    body = half * (1.0 - 2.0 * START_TOLERANCE)
    inside = points_between(points[tool.triangles], ply.z - body, ply.z + body)
    if not over_ply(ply, inside).any():
        return
    facing = points[over_ply(ply, points)]
    heights = np.concatenate([inside[:, 2], facing[:, 2]])
    up, down = ply.z + half - heights.min(), heights.max() - (ply.z - half)
    word, way = ("raise", up) if up <= down else ("lower", down)
    raise InputError(
        f"tool {tool.name!r} starts inside ply {ply.name!r}: {word} it by {1e3 * way:.4g} mm"
    )


def points_between(corners: np.ndarray, low: float, high: float) -> np.ndarray:
    """Corners and middles of the parts of triangles [m, 3, 3] between two heights, shape [k, 3]."""
    z = corners[..., 2]
    corners = corners[(z.min(axis=1) < high) & (z.max(axis=1) > low)]
    a, b = corners, np.roll(corners, -1, axis=1)
    rise = b[..., 2] - a[..., 2]
    level = rise == 0.0
    safe = np.where(level, 1.0, rise)
    ends = np.sort(np.stack([low - a[..., 2], high - a[..., 2]]) / safe, axis=0)
    first = np.where(level, 0.0, np.clip(ends[0], 0.0, 1.0))
    last = np.where(level, 1.0, np.clip(ends[1], 0.0, 1.0))
    part = (last > first) & (~level | ((a[..., 2] > low) & (a[..., 2] < high)))
    points = np.stack([a + s[..., None] * (b - a) for s in (first, last)], axis=2)
    count = 2 * part.sum(axis=1)
    used = np.where(part[:, :, None, None], points, 0.0)
    middles = used.sum(axis=(1, 2))[count > 0] / count[count > 0, None]
    return np.concatenate([points[part].reshape(-1, 3), middles])


def _refuse_enclosing(tool: Tool, points: np.ndarray, ply: Ply) -> None:
    """Raise `InputError` if the ply lies inside a closed tool: one of its points tells for all.

    The solid angle of a closed surface seen from inside is 4π (Van Oosterom & Strackee 1983).
    """
    if not tool.surface.mesh.is_watertight:
        return
    a, b, c = np.moveaxis(points[tool.triangles] - ply.rest_points[0], 1, 0)
    la, lb, lc = (np.linalg.norm(corner, axis=1) for corner in (a, b, c))
    volume = (a * np.cross(b, c)).sum(axis=1)
    base = la * lb * lc + (a * b).sum(1) * lc + (b * c).sum(1) * la + (c * a).sum(1) * lb
    if abs(np.arctan2(volume, base).sum()) > np.pi:  # half the angle, half of 4π
        raise InputError(
            f"ply {ply.name!r} starts inside tool {tool.name!r}: move the tool or the ply, or cut "
            "the tool's mesh down to the surface that meets the ply"
        )
