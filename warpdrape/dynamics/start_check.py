"""What must hold before the first step: nothing overlaps, and the run has an end in sight."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from warpdrape.blanks.one_sheet import check_one_sheet
from warpdrape.blanks.ply import Ply
from warpdrape.blanks.triangles import longest_sides
from warpdrape.contact.features import finer_points
from warpdrape.contact.rims import over_ply, rims_hold
from warpdrape.dynamics.energy import measure
from warpdrape.dynamics.model import Model
from warpdrape.dynamics.stepping import Stepper, search_contacts
from warpdrape.errors import InputError
from warpdrape.interaction import met_in_contact
from warpdrape.setup import Setup
from warpdrape.state import State
from warpdrape.tools.floating import Float
from warpdrape.tools.tool import Tool

START_TOLERANCE = 0.01
"""Share of the ply thickness by which things may overlap at the start [-]."""
MOST_STEPS = 1_000_000_000
"""Steps beyond which a run is a mistake in a unit: more than a day for a single ply."""


def check_sheets(scene: Setup) -> None:
    """Refuse plies whose meshes are torn or lie on themselves.

    Raises:
        InputError: naming the ply and the place.
    """
    for ply in scene.plies:
        try:
            check_one_sheet(np.asarray(ply.mesh.vertices), ply.mesh.boundary_edges)
        except InputError as fault:
            raise InputError(f"ply {ply.name!r}: {fault}") from None


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
    for ply in plies:
        facing = np.where(over_ply(ply, middle), upward * np.sign(ply.z - middle[:, 2]), 0.0)
        if facing.sum() < -FACING * np.abs(facing).sum():
            raise InputError(
                f"tool {tool.name!r}: its facets face away from ply {ply.name!r}: take "
                "tool.flipped(), or turn them round in its file"
            )


MISSED = 0.5
"""Width of a surface over the sides of triangles below which their vertices miss it [-]."""
FACING = 0.5
"""Share of an open tool's area, seen from the plies, beyond which the side it shows tells [-]."""
CLAMP_TOLERANCE = 1e-9
"""Displacement [m] or distortion [-] with which a clamp may begin."""
MOMENTS = 101
"""Moments of a run at which a clamp's functions of time are tried."""
LIGHTEST_TOOL = 0.1
"""Least mass of a floating tool over that of all plies [-]: the penalties of all their vertices act
on it, each a share of the vertex's own m/Δt²."""


MOST_COSTLY = 20.0
"""Times by which one triangle may shorten the step that half of a ply's triangles need [-]."""


def check_clamps(scene: Setup) -> None:
    """Refuse clamps that would tear at their vertices in the first step, or lead them nowhere.

    Raises:
        InputError: naming the clamp that does not begin where its vertices lie, or whose matrix or
            travel is no finite number at some moment.
    """
    times = np.linspace(0.0, scene.duration, MOMENTS)
    for clamp in scene.clamps:
        jump = np.abs(clamp.motion.displacement(np.array(0.0))).max()
        turn = 0.0
        if clamp.matrix is not None:
            turn = np.abs(clamp.matrix(np.array([0.0])) - np.eye(3)).max()
        if jump > CLAMP_TOLERANCE or turn > CLAMP_TOLERANCE:
            raise InputError(
                f"clamp {clamp.name!r} does not begin where its vertices lie: let its motion start "
                "from zero, and its matrix from the identity"
            )
        for what in ("matrix", "travel"):
            function = getattr(clamp, what)
            values = np.zeros(len(times)) if function is None else np.asarray(function(times))
            lost = ~np.isfinite(values.reshape(len(times), -1)).all(axis=1)
            if lost.any():
                raise InputError(
                    f"clamp {clamp.name!r}: its {what} is not finite at "
                    f"{1e3 * times[lost][0]:.4g} ms: shorten the run, or let it end before"
                )


def check_loading(scene: Setup) -> None:
    """Refuse to hold motions back where there are none: the run would only get longer.

    Raises:
        InputError: if nothing moves but the plies.
    """
    led = any(tool.peak_speed > 0.0 for tool in scene.tools)
    led |= any(clamp.motion.peak_speed > 0.0 for clamp in scene.clamps)
    turned = any(clamp.matrix is not None for clamp in scene.clamps)
    pressed = any(isinstance(tool.motion, Float) for tool in scene.tools)
    pressed = pressed or bool(scene.pressures)
    if scene.numerics.kinetic_limit is not None and not (led or turned or pressed):
        raise InputError(
            f"kinetic_limit = {scene.numerics.kinetic_limit:g} holds tools and clamps back, and "
            "none of them moves: leave it out"
        )


def check_steps(model: Model) -> None:
    """Refuse a run that one triangle makes many times longer, or that would never end.

    Likewise one whose floating tools its contacts would shake apart.

    Raises:
        InputError: with the number of steps, or the least mass of the tool.
    """
    timing, scene = model.timing, model.scene
    least = LIGHTEST_TOOL * float(model.masses.mass.sum())
    for tool in scene.tools:
        mass = tool.motion.mass if isinstance(tool.motion, Float) else None
        if mass is not None and mass < least:
            raise InputError(
                f"tool {tool.name!r}: mass = {mass:.4g} kg is too light to float on "
                f"these plies: give it {least:.4g} kg or more"
            )
    number, triangle, shorter = model.masses.dictator
    if shorter > MOST_COSTLY:
        ply = scene.plies[number]
        x, y = 1e3 * np.asarray(ply.mesh.vertices)[ply.mesh.triangles[triangle]].mean(axis=0)
        raise InputError(
            f"ply {ply.name!r}: triangle {triangle} at ({x:.4g}, {y:.4g}) mm, "
            f"{1e3 * ply.mesh.heights[triangle]:.2g} mm high, makes the step {shorter:.3g} times "
            f"shorter than half of the triangles need, {timing.steps:.2g} steps in all: mesh it "
            "anew, or add mass to such triangles with minimum_time_step = "
            f"{shorter * timing.time_step:.2g} s"
        )
    if timing.steps > MOST_STEPS:
        raise InputError(
            f"duration = {scene.duration:.4g} s takes {timing.steps:.2g} steps of "
            f"{timing.time_step:.2g} s: give seconds (80 ms is 0.08), a coarser ply, or "
            "minimum_time_step to add mass"
        )


def check_contacts(model: Model, state: State) -> None:
    """Refuse overlaps that the contact search itself sees before anything moves.

    Raises:
        InputError: naming the tool, and by how much it reaches into a ply.
    """
    scene = model.scene
    limit = START_TOLERANCE * min(ply.fabric.thickness for ply in scene.plies)
    Stepper(model, state).begin(np.zeros(1))
    if scene.tools:  # a path may start away from zero, and a turn
        poses = [tool.pose(0.0) for tool in scene.tools]
        state.tools.shift.assign(np.array([pose.shift for pose in poses]))
        state.tools.turned.assign(np.array([pose.turned for pose in poses]))
    search_contacts(model, state)
    met = met_in_contact(measure(model, state))
    for tool, entry in zip(scene.tools, met.get("tools", ()), strict=True):
        depth = entry["max_penetration_m"]
        if depth > limit:
            raise InputError(
                f"tool {tool.name!r} starts {1e3 * depth:.4g} mm inside a ply: move it away by that"
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
