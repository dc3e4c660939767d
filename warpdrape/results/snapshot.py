"""Plies and tools at a moment: read from the arrays of a run, for its result and its animation."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from warpdrape.approaches import SLIDING_YARNS
from warpdrape.blanks.ply import Ply
from warpdrape.blanks.triangles import dot, flat_gradients, two_sides
from warpdrape.contact.pressure import vertex_shapes
from warpdrape.dynamics.model import Model
from warpdrape.interaction import Measured
from warpdrape.results.frame_data import ToolShape
from warpdrape.results.result import FormedPly, PlacedTool
from warpdrape.setup import Setup
from warpdrape.state import State
from warpdrape.tools.pose import Pose
from warpdrape.tools.tool import Tool


def read_plies(model: Model, state: State, measured: Sequence[Measured]) -> tuple[FormedPly, ...]:
    """Copy the plies from the device.

    Args:
        model: the model.
        state: its state.
        measured: what forces and contacts show, from `energy.measure`.
    """
    x = state.plies.x.numpy()
    pressures = _pressures(model, x, measured)
    formed = []
    for number, (ply, span) in enumerate(zip(model.scene.plies, model.spans, strict=True)):
        points = x[span.vertices].copy()
        triangles = np.asarray(ply.mesh.triangles)
        gradients, _ = flat_gradients(ply)
        warp, weft, shear = yarn_state(points, triangles, gradients, ply.fabric.yarn_angle)
        fields: dict[str, Any] = {
            name: array.copy()
            for each in measured
            if each.fields
            for name, array in each.fields[number].items()
        }
        fields |= {name: pressure[span.vertices].copy() for name, pressure in pressures.items()}
        formed.append(
            FormedPly(ply.name, ply.rest_points, points, triangles, warp, weft, shear, **fields)
        )
    return tuple(formed)


def tool_shape(tool: Tool) -> ToolShape:
    """A tool for the animation, where it stands at the start."""
    axis, point = (None, None) if tool.turn is None else (tool.turn.axis, tool.turn.point)
    return ToolShape(tool.name, tool.vertices, tool.triangles, axis, point)


def place_tools(scene: Setup, poses: Sequence[Pose]) -> tuple[PlacedTool, ...]:
    """Tools where they have come to.

    Args:
        scene: the scene.
        poses: theirs.
    """
    return tuple(
        PlacedTool(tool.name, pose.place(tool.vertices), tool.triangles)
        for tool, pose in zip(scene.tools, poses, strict=True)
    )


def _pressures(model: Model, x: np.ndarray, measured: Sequence[Measured]) -> dict[str, np.ndarray]:
    """Largest pressure on any face, or of any tool, at each vertex [Pa], by name."""
    forces: dict[str, np.ndarray] = {}
    for each in measured:
        for name, pressing in each.pressing.items():
            forces[name] = forces[name] + pressing if name in forces else pressing
    if not forces:
        return {}
    corners = [
        np.asarray(ply.mesh.triangles) + span.first_vertex
        for ply, span in zip(model.scene.plies, model.spans, strict=True)
    ]
    _, areas = vertex_shapes(x, np.concatenate(corners))
    return {name: pressing.max(axis=0) / areas for name, pressing in forces.items()}


def shown_at_vertices(scene: Setup, ply: Ply) -> tuple[str, ...]:
    """Names of the quantities of `PlyFrame` at vertices that a ply's frames have in a scene."""
    names: tuple[str, ...] = ()
    if ply.fabric.bends:
        names = ("warp_curvature", "weft_curvature")
    several = len(scene.plies) > 1
    if several:
        names += ("slip",)
    if several or any(map(scene.touches_itself, scene.plies)):
        names += ("contact_pressure",)
    if scene.tools:
        names += ("tool_pressure",)
    if scene.cools(ply):
        names += ("temperature",)
    if scene.approach == SLIDING_YARNS:
        names += ("warp_slide", "weft_slide")
    return names


def shown_of_defects(ply: Ply) -> tuple[str, ...]:
    """Names of the quantities of `PlyFrame` in triangles that a ply's frames have by its fabric."""
    if ply.fabric.fibre_density is None:
        return ("thickness", "wrinkle")
    return ("thickness", "fibre_volume_fraction", "wrinkle")


def yarn_state(
    points: np.ndarray, triangles: np.ndarray, gradients: np.ndarray, yarn_angle: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Unit yarn directions and shear angle [rad] of a formed ply.

    Args:
        points: formed positions [m], shape [n, 3].
        triangles: vertices, shape [m, 3].
        gradients: of the yarn families, as in `Membrane` [1/m], shape [m, 4].
        yarn_angle: from warp to weft in the flat ply [rad].
    """
    ab, ac = two_sides(points, triangles)
    d = gradients.T
    k1, k2 = _unit(d[0] * ab + d[1] * ac), _unit(d[2] * ab + d[3] * ac)
    angle = np.arccos(np.clip(dot(k1, k2), -1.0, 1.0))
    return np.ascontiguousarray(k1.T), np.ascontiguousarray(k2.T), yarn_angle - angle


def _unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.sqrt(dot(vectors, vectors))
