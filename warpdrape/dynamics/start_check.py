"""What must hold before the first step: nothing overlaps, and the run has an end in sight."""

from __future__ import annotations

import numpy as np

from warpdrape.blanks.one_sheet import check_one_sheet
from warpdrape.dynamics.energy import measure
from warpdrape.dynamics.model import Model
from warpdrape.dynamics.stepping import Stepper, search_contacts
from warpdrape.errors import InputError
from warpdrape.interaction import met_in_contact
from warpdrape.numerics import START_TOLERANCE
from warpdrape.setup import Setup
from warpdrape.state import State
from warpdrape.tools.floating import Float

CLAMP_TOLERANCE = 1e-9
"""Displacement [m] or distortion [-] with which a clamp may begin."""
MOMENTS = 101
"""Moments of a run at which a clamp's functions of time are tried."""
LIGHTEST_TOOL = 0.1
"""Least mass of a floating tool over that of all plies [-]: the penalties of all their vertices act
on it, each a share of the vertex's own m/Δt²."""
MOST_COSTLY = 20.0
"""Times by which one triangle may shorten the step that half of a ply's triangles need [-]."""
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
