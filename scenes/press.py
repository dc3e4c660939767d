"""The reference press: a 75 mm hemisphere through a 78 mm die ring, under a ring held by a force.

The paper's Figure 4 prints no dimensions; these are this project's own.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from warpdrape import (
    Float,
    Friction,
    InputError,
    Numerics,
    Ply,
    Scene,
    Stroke,
    Tool,
    lay_up,
    stack_top,
)
from warpdrape.approaches import RECOVERING, SLIDING_YARNS
from warpdrape.errors import one_of
from warpdrape.materials.law_data import taut_stiffness
from warpdrape.materials.laws import Unwoven
from warpdrape.numerics import ACCURACIES
from warpdrape.units import mm

PUNCH_RADIUS = 75 * mm
DIE_RADIUS = 78 * mm
DIE_EDGE = 10 * mm
RING_RADIUS = 230 * mm
ROOM = 1.5
"""Room between punch and die over the stack's thickness, at least [-]."""
HOLD = 0.2
"""Time for which the punch stands at the end, as a share of the stroke [-]."""
RAMP = 0.3
"""Share of the stroke in which the punch's speed rises, where ``brake`` leaves that much [-]."""
FORCE_RAMP = 0.05
"""Share of the stroke in which the holder's force rises [-]."""
REFERENCE, STANDARD = "reference", "standard"
"""Names of accuracies; the second is what ``fast`` stands for."""
ACCURACY = STANDARD
"""The accuracy where none is asked for: shapes of one ply are within 0.3° of a converged run with
it, and within 0.11 mm but for a double dome's 0.49 (docs/performance.md)."""
DURATIONS = {"draft": 0.04, "standard": 0.08, "reference": 0.16}
"""Time of a stroke by accuracy, where none is given [s]."""
BRAKE = 0.85
"""Share of a stroke in which the punch slows down, where none is given [-]: what inertia spoils is
the end of it."""
SOFTEST = 3.4e5
"""Stiffness that yarns keep, however an accuracy softens them [N/m]: those of `carbon_interlock`
over 100 keep more. Beyond that they would stretch by some tenths of a per cent."""
UNRECOVERED = {"draft": 100.0, "standard": 36.0, "reference": 1.0}
"""How far an accuracy softens yarns at most where these do not recover their tension [-]."""
SLIDING_SOFTENING = 9.0
"""How far an accuracy softens yarns that slide at most [-]: what they stretch they do not slide."""


def hemisphere_tools(
    name: str,
    plies: Sequence[Ply],
    parameters: Mapping[str, Any],
    friction: float | Friction,
    ply_friction: float = 0.3,
    die_radius: float = DIE_RADIUS,
    die_edge: float = DIE_EDGE,
    closing_time: float | None = None,
) -> Scene:
    """Put plies on the die, from the bottom up, and the other tools on them.

    Args:
        name: of the scene.
        plies: from the die up.
        parameters: of the scene, those that `press_scene` uses, and facet.
        friction: of tools on plies, a Coulomb coefficient [-] or a law.
        ply_friction: between plies [-].
        die_radius: of the die's hole [m].
        die_edge: radius of its rounded edge, beyond which the holder begins [m].
        closing_time: that the press takes for the stroke [s]; None where nothing depends on it.
    """
    ring = {"outer_radius": RING_RADIUS, "facet": parameters["facet"]}
    tools = (
        Tool.punch(radius=PUNCH_RADIUS, facet=parameters["facet"]),
        Tool.die(hole_radius=die_radius, edge_radius=die_edge, depth=60 * mm, **ring),
        Tool.blank_holder(hole_radius=die_radius + die_edge, **ring),
    )
    return press_scene(
        name, plies, tools, parameters, friction, ply_friction, closing_time=closing_time
    )


def press_scene(
    name: str,
    plies: Sequence[Ply],
    tools: Sequence[Tool],
    parameters: Mapping[str, Any],
    friction: float | Friction,
    ply_friction: float = 0.3,
    closing_time: float | None = None,
) -> Scene:
    """Lay plies on a die, and let a punch come down on them within a floating blank holder.

    Args:
        name: of the scene.
        plies: from the die up.
        tools: punch and die and holder, the punch's lowest point and the flats at z = 0.
        parameters: of the scene; travel, duration, holder_force, contact_share, contact, brake,
            kinetic_limit, minimum_time_step, mass_scaling, accuracy, fast and approach are used.
        friction: of tools on plies, a Coulomb coefficient [-] or a law.
        ply_friction: between plies [-].
        closing_time: that the press takes for the stroke [s]; None where nothing depends on it.
    """
    plies = lay_up(plies)
    top = (0.0, 0.0, stack_top(plies))
    duration, brake = stroke_duration(parameters), parameters["brake"]
    stroke = Stroke(
        travel=(0.0, 0.0, -parameters["travel"]),
        duration=duration,
        ramp=min(RAMP, 1.0 - brake),
        brake=brake,
    )
    press = Float(force=parameters["holder_force"], ramp=FORCE_RAMP * duration)
    punch, die, holder = tools
    return Scene(
        name=name,
        plies=plies,
        tools=[
            replace(punch.moved(top), motion=stroke),
            die,
            replace(holder.moved(top), motion=press),
        ],
        duration=(1.0 + HOLD) * duration,
        friction=friction,
        ply_friction=ply_friction,
        process_duration=None if closing_time is None else (1.0 + HOLD) * closing_time,
        numerics=press_numerics(parameters, plies),
        approach=parameters["approach"],
        parameters=parameters,
    )


def accuracy_of(parameters: Mapping[str, Any]) -> str:
    """The accuracy that a press scene's parameters ask for.

    Raises:
        InputError: if there is none of that name, or ``fast`` says another one.
    """
    accuracy = one_of("accuracy", parameters["accuracy"], ACCURACIES)
    if parameters["fast"] and accuracy not in (ACCURACY, STANDARD):
        raise InputError(
            f"fast = true is accuracy = {STANDARD}, and accuracy = {accuracy}: leave one out"
        )
    return STANDARD if parameters["fast"] else accuracy


def stroke_duration(parameters: Mapping[str, Any]) -> float:
    """Duration of a press scene's stroke [s], as given or the accuracy's."""
    if parameters["duration"] is None:
        return DURATIONS[accuracy_of(parameters)]
    return parameters["duration"]


def press_numerics(parameters: Mapping[str, Any], plies: Sequence[Ply]) -> Numerics:
    """How a press scene is computed, from its parameters.

    Contacts soften with the step: an accuracy of longer steps keeps its own share of the stiffness,
    unless a larger one is asked for.
    """
    numerics = Numerics.for_accuracy(accuracy_of(parameters))
    share, softening = parameters["contact_share"], numerics.yarn_softening
    if softening > 1.0:
        share = max(share, numerics.contact_share)
        softening = min(softening, *map(most_softening, plies))
    recovery = numerics.yarn_recovery if softening > 1.0 else 0.0
    if parameters["approach"] not in RECOVERING:
        recovery = 0.0
        softening = min(softening, UNRECOVERED[accuracy_of(parameters)])
    if parameters["approach"] == SLIDING_YARNS:
        softening = min(softening, SLIDING_SOFTENING)
    return replace(
        numerics,
        yarn_recovery=recovery,
        yarn_softening=softening,
        contact_share=share,
        contact=parameters["contact"],
        kinetic_limit=parameters["kinetic_limit"] or None,
        minimum_time_step=parameters["minimum_time_step"] or None,
        mass_scaling=parameters["mass_scaling"],
    )


def most_softening(ply: Ply) -> float:
    """How far an accuracy softens a ply's yarns at most [-]: what is weak already, hardly."""
    fabric = ply.fabric
    if isinstance(fabric.tension, Unwoven):
        return math.inf
    stiff_enough = min(taut_stiffness(fabric)) / SOFTEST
    factor = fabric.compressive_factor
    return max(min(stiff_enough, 1.0 / factor if factor > 0.0 else math.inf), 1.0)


def read_layup(text: str) -> list[float]:
    """Angles of a lay-up [deg].

    Args:
        text: as "0/45/-45/0".

    Raises:
        InputError: if it is none.
    """
    try:
        return [float(angle) for angle in text.split("/")]
    except ValueError:
        raise InputError(
            f"layup = {text!r} must be angles in degrees with strokes between, such as 0/45/0"
        ) from None
