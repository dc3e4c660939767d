"""Before a run: tools whose motions leave the plies between them less room than they are thick."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import permutations, product

import numpy as np
import trimesh
import warp as wp

from warpdrape.blanks.ply import Ply
from warpdrape.kernels.contact.passages import find_gaps
from warpdrape.setup import Setup
from warpdrape.tools.floating import Float
from warpdrape.tools.tool import Tool

LOOKS = 24
"""Instants at which tools are held against each other, besides those at which one turns."""
ACROSS, MOST = 40, 20_000
"""Points of a tool across the plies, about, and at most in all, corners of facets besides."""
NEAR = 3.0
"""Distance over the plies' thickness up to which tools count as near each other [-]."""
TOO_LITTLE = 0.95
"""Room over thickness below which it is said; facets of curved tools cut a little off it [-]."""


@dataclass(frozen=True)
class Closing:
    """The narrowest place between two tools where plies may lie.

    Attributes:
        tools: their names.
        gap: room between them, below zero where they overlap [m].
        thickness: of the plies there, compacted as far as their laws go [m].
        time: when [s].
        place: where [m], shape [3].
        lacks: whether the plies need more than that.
    """

    tools: tuple[str, str]
    gap: float
    thickness: float
    time: float
    place: np.ndarray
    lacks: bool

    def __str__(self) -> str:
        x, y, _ = 1e3 * self.place
        room = f"leave {1e3 * self.gap:.3g} mm" if self.gap > 0.0 else "leave no room"
        return (
            f"tools {self.tools[0]!r} and {self.tools[1]!r} {room} between them at "
            f"{1e3 * self.time:.4g} ms, ({x:.4g}, {y:.4g}) mm; plies that lie there are "
            f"{1e3 * self.thickness:.3g} mm thick"
        )


def closing_tools(scene: Setup) -> list[Closing]:
    """Pairs of tools with prescribed motions that close to less than the plies are thick.

    Arguments as of `narrowest_gaps`.
    """
    return [closing for closing in narrowest_gaps(scene) if closing.lacks]


def narrowest_gaps(scene: Setup) -> list[Closing]:
    """Pairs of tools with prescribed motions that come near each other, each where they lack most.

    Near means by little more than the plies' thickness. A floating tool gives way, and is not
    looked at. Whether a ply lies there then, only the run tells.

    Args:
        scene: what is computed.
    """
    led = [tool for tool in scene.tools if not isinstance(tool.motion, Float)]
    turns = [time for tool in led for time in tool.turning_points if time <= scene.duration]
    times = np.unique([*np.linspace(0.0, scene.duration, LOOKS + 1), *turns])
    narrowest: dict[frozenset[str], Closing] = {}
    for one, other in permutations(led, 2):
        found = _narrowest(one, other, scene.plies, times)
        pair = frozenset((one.name, other.name))
        if found and (pair not in narrowest or _before(found, narrowest[pair])):
            narrowest[pair] = found
    return list(narrowest.values())


def _before(one: Closing, other: Closing) -> bool:
    """Whether one place is to be named rather than another: what lacks room, then the narrower."""
    return (not one.lacks, one.gap) < (not other.lacks, other.gap)


def _narrowest(one: Tool, other: Tool, plies: Sequence[Ply], times: np.ndarray) -> Closing | None:
    """The narrowest place from points of one tool to the surface of another."""
    boxes = [(ply.rest_points.min(axis=0), ply.rest_points.max(axis=0)) for ply in plies]
    thickness = [_thinnest(ply) for ply in plies]
    way, base = ([tool.pose(time) for time in times] for tool in (one, other))
    # So far that tools which pass each other are seen at one instant at least.
    seen = np.array([b.into(w.place(_corners(one))) for w, b in zip(way, base, strict=True)])
    reach = NEAR * sum(thickness) + float(np.linalg.norm(np.diff(seen, axis=0), axis=2).max())
    shifts = [pose.shift for pose in way]
    low = np.min([low for low, _ in boxes], axis=0) - np.max(shifts, axis=0)
    high = np.max([high for _, high in boxes], axis=0) - np.min(shifts, axis=0)
    if one.turn is not None:  # any of it may come over the plies
        low, high = (
            np.minimum(low, one.vertices.min(axis=0)),
            np.maximum(high, one.vertices.max(axis=0)),
        )
    points, normals = _spread(one, low[:2], high[:2])
    if not len(points):
        return None
    mesh = wp.Mesh(
        wp.array(other.vertices, dtype=wp.vec3f, device="cpu"),
        wp.array(np.ravel(other.triangles), dtype=wp.int32, device="cpu"),
    )
    gaps = wp.zeros(len(points), dtype=wp.float32, device="cpu")
    inputs: list[wp.array] = [wp.array(a, dtype=wp.vec3f, device="cpu") for a in (points, normals)]
    worst = None
    for time, moved, ground in zip(times, way, base, strict=True):
        wp.launch(
            find_gaps,
            len(points),
            inputs=[
                *inputs,
                mesh.id,
                wp.mat33f(*(ground.turned.T @ moved.turned).ravel()),
                wp.vec3f(*ground.into(moved.shift)),
                reach,
            ],
            outputs=[gaps],
            device="cpu",
        )
        at = moved.place(points)
        room = np.zeros(len(points))
        for (low, high), thin in zip(boxes, thickness, strict=True):
            over = (at[:, :2] >= low[:2]) & (at[:, :2] <= high[:2])
            room += np.where(over.all(axis=1), thin, 0.0)
        near = (room > 0.0) & (gaps.numpy() < reach)
        lacking = np.where(near, TOO_LITTLE * room - gaps.numpy(), -np.inf)
        k = int(np.argmax(lacking))
        if not near[k]:
            continue
        names, gap = (one.name, other.name), float(gaps.numpy()[k])
        found = Closing(names, gap, float(room[k]), float(time), at[k], bool(lacking[k] > 0.0))
        if worst is None or _before(found, worst):
            worst = found
    return worst


def _corners(tool: Tool) -> np.ndarray:
    """Corners of a box that holds a tool [m], shape [8, 3]."""
    low, high = tool.vertices.min(axis=0), tool.vertices.max(axis=0)
    return np.array(list(product(*zip(low, high, strict=True))))


def _thinnest(ply: Ply) -> float:
    law = ply.fabric.compaction
    return ply.fabric.thickness if law is None else law.thinnest


def _spread(tool: Tool, low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points on what of a tool comes over the plies, and the outward normals there.

    Corners of its large facets, and more over the area of all, the same in every run.

    Args:
        tool: the tool.
        low: corner of the box of the plies, seen from above, as the tool moves over it [m].
        high: the opposite one.
    """
    corners = tool.vertices[tool.triangles]
    over = (corners.min(axis=1)[:, :2] <= high) & (corners.max(axis=1)[:, :2] >= low)
    corners = corners[over.all(axis=1)]
    normals, good = trimesh.triangles.normals(corners)
    corners = corners[good]
    if not len(corners):
        return np.zeros((0, 3)), np.zeros((0, 3))
    sheet = trimesh.Trimesh(corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3))
    spacing_sq = float((high - low).prod()) / ACROSS**2
    count = min(int(sheet.area / spacing_sq) + 1, MOST)
    spread, facet = trimesh.sample.sample_surface(sheet, count, seed=0)
    large = np.flatnonzero(sheet.area_faces > spacing_sq)  # whose corners lie far from others
    points = np.concatenate([corners[large].reshape(-1, 3), np.asarray(spread)])
    return points, np.concatenate([np.repeat(normals[large], 3, axis=0), normals[facet]])
