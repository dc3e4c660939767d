"""Where tools first meet the plies as they lie flat, and when: from the motions alone.

What a tool meets after the first touch depends on how the plies have given way: only a run tells.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from warpdrape.blanks.ply import Ply
from warpdrape.contact.rims import over_ply
from warpdrape.contact.tools_at_start import points_between
from warpdrape.setup import Setup
from warpdrape.tools.floating import Float
from warpdrape.tools.tool import Tool

TOUCHING = 0.02
"""Gap over the ply's thickness below which a tool counts as touching it at the start [-]."""
LOOKS = 48
"""Instants at which a moving tool is held against the flat plies, besides those where it turns."""
HALVINGS = 24
"""Halvings by which the instant of touch is narrowed down."""
INSIDE = 1e-3
"""Depth over the ply's thickness at which a tool has touched it [-]."""


@dataclass(frozen=True)
class Touch:
    """The first touch of a tool.

    Attributes:
        tool: its name.
        ply: name of the ply it touches first; "" if it touches none while they lie flat.
        time: when [s]; 0 for one that lies on it from the start.
        way: that it has come till then [m].
        gap: between tool and nearest ply at the start [m]; infinite if it never faces one.
        place: where [m], shape [3]; None without a touch.
    """

    tool: str
    ply: str
    time: float
    way: float
    gap: float
    place: np.ndarray | None


def first_touches(scene: Setup) -> list[Touch]:
    """The first touch of each tool with the flat plies, the earliest first; then those without.

    Args:
        scene: what is computed.
    """
    found = [_touch(scene, tool) for tool in scene.tools]
    return sorted(found, key=lambda touch: (not touch.ply, touch.time))


def _touch(scene: Setup, tool: Tool) -> Touch:
    start = tool.pose(0.0).place(tool.vertices)
    gaps = [_gap(tool, start, ply) for ply in scene.plies]
    nearest = int(np.argmin(gaps))
    ply, gap = scene.plies[nearest], gaps[nearest]
    if gap <= TOUCHING * ply.fabric.thickness:
        return Touch(tool.name, ply.name, 0.0, 0.0, gap, _place(tool, start, ply, gap))
    none = Touch(tool.name, "", 0.0, 0.0, gap, None)
    if isinstance(tool.motion, Float) or tool.peak_speed == 0.0:
        return none
    turns = [time for time in tool.turning_points if time <= scene.duration]
    times = np.unique([*np.linspace(0.0, scene.duration, LOOKS + 1), *turns])
    first: Touch = none
    for ply in scene.plies:
        time = _when(partial(_met, tool, ply), times)
        if time is None or (first.ply and time >= first.time):
            continue
        points = tool.pose(time).place(tool.vertices)
        way = float(np.linalg.norm(tool.pose(time).shift - tool.pose(0.0).shift))
        place = _place(tool, points, ply, 0.0)
        first = Touch(tool.name, ply.name, time, way, gap, place)
    return first


def _within(points: np.ndarray, tool: Tool, ply: Ply, half: float) -> np.ndarray:
    """Points of a tool over the ply's area less than ``half`` off its middle [m], shape [k, 3]."""
    inside = points_between(points[tool.triangles], ply.z - half, ply.z + half)
    return inside[over_ply(ply, inside)]


def _met(tool: Tool, ply: Ply, time: float) -> bool:
    half = 0.5 * ply.fabric.thickness * (1.0 - INSIDE)
    return len(_within(tool.pose(time).place(tool.vertices), tool, ply, half)) > 0


def _place(tool: Tool, points: np.ndarray, ply: Ply, gap: float) -> np.ndarray:
    """Where a tool touches a ply [m], of many places the one nearest to their middle, shape [3]."""
    half = 0.5 * ply.fabric.thickness * (1.0 + INSIDE + TOUCHING) + gap
    places = _within(points, tool, ply, half)
    return places[np.argmin(np.linalg.norm(places - places.mean(axis=0), axis=1))]


def _gap(tool: Tool, points: np.ndarray, ply: Ply) -> float:
    """Room between tool and ply along z at the start [m]; infinite if it is not over or under."""
    half = 0.5 * ply.fabric.thickness
    far = float(np.abs(points[:, 2] - ply.z).max())
    if not len(_within(points, tool, ply, far + half)):
        return np.inf
    low, high = 0.0, far + half
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if len(_within(points, tool, ply, middle)):
            high = middle
        else:
            low = middle
    return max(high - half, 0.0)


def _when(met: Callable[[float], bool], times: np.ndarray) -> float | None:
    """The first time at which ``met`` holds, narrowed down [s]; None if it never does."""
    before = times[0]
    for after in times:
        if met(after):
            low, high = before, after
            for _ in range(HALVINGS):
                middle = 0.5 * (low + high)
                low, high = (low, middle) if met(middle) else (middle, high)
            return float(high)
        before = after
    return None
