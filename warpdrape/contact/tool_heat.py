"""Heat between plies and the tools that press on them: what it needs on a device, its launches."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import warp as wp

from warpdrape.interaction import Bodies, Launch, Share
from warpdrape.kernels.contact.tool_heat import draw_to_tools
from warpdrape.setup import Setup

PASSES_NONE = -1.0
"""In the place of the temperature of a tool that passes no heat."""


class ToolHeat(NamedTuple):
    """What decides how fast plies cool on tools."""

    rates: Mapping[int, float]
    """Conductance over heat capacity [1/s] of plies that cool, by number."""
    tools: wp.array
    """Temperatures of the tools [K], shape [tool]; `PASSES_NONE` of those that pass no heat."""

    def launches(
        self, share: Share, bodies: Bodies, touching: wp.array, planes: wp.array, holds: wp.array
    ) -> tuple[Launch, ...]:
        """For a part's vertices, after the contacts' forces.

        Args:
            share: the part's.
            bodies: plies and tools.
            touching: bits of the tools that are near, shape [vertex].
            planes: tangent planes, shape [slot].
            holds: memory of the contacts, shape [slot].
        """
        inputs = [self.tools, bodies.tools.turned, touching, planes, holds]
        heat = bodies.cooling
        outputs = [heat.pull, heat.cover]
        return tuple(
            Launch(draw_to_tools, run.count, [run.first, rate, *inputs], outputs)
            for number, rate in self.rates.items()
            for run in share.by_ply[number]
        )


def tool_heat(scene: Setup, device: str) -> ToolHeat | None:
    """Put what cools plies on a device; None where none cools."""
    rates = {number: heat.rate for number, heat in scene.cooling.items()}
    if not rates:
        return None
    tools = [PASSES_NONE if t.temperature is None else t.temperature for t in scene.tools]
    return ToolHeat(rates, wp.array(tools, dtype=wp.float64, device=device))
