"""The hemisphere under a blank holder in four segments, each pressed by a force of its own."""

import math
from dataclasses import replace

from warpdrape import Float, Scene, Tool
from warpdrape.scenes.hemisphere import build as hemisphere
from warpdrape.scenes.press import DIE_EDGE, DIE_RADIUS, FORCE_RAMP, RING_RADIUS
from warpdrape.units import deg

NAMES = ("right", "back", "left", "front")
"""Segments, counter-clockwise from x."""
GAP = 4 * deg
"""Between two segments."""


def build(
    *,
    right_force: float = 25.0,
    back_force: float = 25.0,
    left_force: float = 25.0,
    front_force: float = 25.0,
    turn_deg: float = 0.0,
    angle_deg: float = 0.0,
    cells: int = 20,
    blank_size: float = 0.3,
    travel: float = 0.075,
    duration: float = 0.08,
    brake: float = 0.3,
    friction: float = 0.2,
    fabric: str = "carbon_interlock",
    facet: float = 5e-3,
    accuracy: str = "standard",
) -> Scene:
    """Build the hemisphere with a holder of four segments.

    Args:
        right_force: on the segment about +x [N].
        back_force: on the segment about +y [N].
        left_force: on the segment about -x [N].
        front_force: on the segment about -y [N].
        turn_deg: by which the segments are turned on the die [deg].
        angle_deg: from the blank's side to the warp [deg].
        cells: squares of four triangles along a side.
        blank_size: side of the blank [m].
        travel: punch travel [m].
        duration: of the stroke [s].
        brake: share of the stroke in which the punch slows down, below 1 [-].
        friction: Coulomb coefficient of tools on the ply [-].
        fabric: name or file of a fabric.
        facet: size of the tools' facets [m].
        accuracy: "draft", "standard" or "reference": the summary says what it costs.
    """
    parameters = dict(locals())
    shared = ("angle_deg", "cells", "blank_size", "travel", "duration", "brake", "friction")
    whole = hemisphere(
        **{name: parameters[name] for name in shared},
        fabric=fabric,
        facet=facet,
        accuracy=accuracy,
    )
    punch, die, ring = whole.tools
    top = ring.vertices[:, 2].min()  # of the ply, on which the ring lies
    forces = (right_force, back_force, left_force, front_force)
    segments = []
    for k, (name, force) in enumerate(zip(NAMES, forces, strict=True)):
        middle = turn_deg * deg + 0.5 * math.pi * k
        half = 0.25 * math.pi - 0.5 * GAP
        segment = Tool.blank_holder(
            name,
            hole_radius=DIE_RADIUS + DIE_EDGE,
            outer_radius=RING_RADIUS,
            facet=facet,
            sector=(middle - half, middle + half),
            motion=Float(force=force, ramp=FORCE_RAMP * duration),
        )
        segments.append(segment.moved((0.0, 0.0, float(top))))
    return replace(
        whole,
        name="hemisphere_segments",
        tools=[punch, die, *segments],
        parameters=parameters,
    )


if __name__ == "__main__":
    from warpdrape.cli import run_script

    run_script(__file__)
