"""The reference press: a 75 mm hemisphere through a 78 mm die ring, under a ring held by a force.

The paper's Figure 4 prints no dimensions; these are this project's own.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from warpdrape import Float, Numerics, Ply, Scene, Stroke, Tool, lay_up, stack_top
from warpdrape.units import kg, mm

PUNCH_RADIUS = 75 * mm
DIE_RADIUS = 78 * mm
DIE_EDGE = 10 * mm
HOLDER_RADIUS = 88 * mm
RING_RADIUS = 230 * mm
HOLDER_MASS = 1.9 * kg
"""An aluminium ring of these radii, 5 mm thick."""
HOLD = 0.2
"""Time for which the punch stands at the end, as a share of the stroke [-]."""
RAMP = 0.3
"""Share of the stroke in which the punch's speed rises, where ``brake`` leaves that much [-]."""
FORCE_RAMP = 0.05
"""Share of the stroke in which the holder's force rises [-]."""
FAST = Numerics(yarn_softening=36.0, search_slide=1e-4, contact_share=0.1)
"""A fast run: steps five times as long, contacts sought 2.5 times less often.

Contacts soften as the step grows; the larger share, at 13 % of the step, makes up for some of it.
"""


def hemisphere_tools(
    name: str,
    plies: Sequence[Ply],
    parameters: Mapping[str, Any],
    friction: float,
    ply_friction: float = 0.3,
    die_radius: float = DIE_RADIUS,
) -> Scene:
    """Put plies on the die, from the bottom up, and the other tools on them.

    Args:
        name: of the scene.
        plies: from the die up.
        parameters: of the scene; travel, duration, holder_force, facet, contact_share, contact,
            brake, kinetic_limit, minimum_time_step, mass_scaling, fast and approach are
            used.
        friction: Coulomb coefficient of tools on plies [-].
        ply_friction: between plies [-].
        die_radius: of the die's hole [m].
    """
    plies = lay_up(plies)
    top = stack_top(plies)
    facet, duration = parameters["facet"], parameters["duration"]
    brake = parameters["brake"]
    stroke = Stroke(
        travel=(0.0, 0.0, -parameters["travel"]),
        duration=duration,
        ramp=min(RAMP, 1.0 - brake),
        brake=brake,
    )
    press = Float(force=parameters["holder_force"], mass=HOLDER_MASS, ramp=FORCE_RAMP * duration)
    ring = {"outer_radius": RING_RADIUS, "facet": facet}
    holder_radius = HOLDER_RADIUS + (die_radius - DIE_RADIUS)
    die = Tool.die(hole_radius=die_radius, edge_radius=DIE_EDGE, depth=60 * mm, **ring)
    punch = Tool.punch(radius=PUNCH_RADIUS, facet=facet, motion=stroke)
    holder = Tool.blank_holder(hole_radius=holder_radius, motion=press, **ring)
    share = parameters["contact_share"]
    numerics = Numerics(contact_share=share)
    if parameters["fast"]:
        numerics = replace(FAST, contact_share=max(share, FAST.contact_share))
    numerics = replace(
        numerics,
        contact=parameters["contact"],
        kinetic_limit=parameters["kinetic_limit"] or None,
        minimum_time_step=parameters["minimum_time_step"] or None,
        mass_scaling=parameters["mass_scaling"],
    )
    return Scene(
        name=name,
        plies=plies,
        tools=[punch.moved((0.0, 0.0, top)), die, holder.moved((0.0, 0.0, top))],
        duration=(1.0 + HOLD) * duration,
        friction=friction,
        ply_friction=ply_friction,
        numerics=numerics,
        approach=parameters["approach"],
        parameters=parameters,
    )
