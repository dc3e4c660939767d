"""Heat between plies and the tools that press on them: what it needs on a device, its launches."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import warp as wp

from warpdrape.interaction import Bodies, Launch, Run
from warpdrape.kernels.contact.tool_heat import exchange_heat
from warpdrape.setup import Setup

PASSES_NONE = -1.0
"""In the place of the temperature of a tool that passes no heat."""


class ToolHeat(NamedTuple):
    """What decides how fast plies cool on tools."""

    rates: wp.array
    """Conductance over heat capacity [1/s], shape [vertex]; 0 of plies that do not cool."""
    tools: wp.array
    """Temperatures of the tools [K], shape [tool]; `PASSES_NONE` of those that pass no heat."""

    def launches(
        self, vertices: Sequence[Run], bodies: Bodies, touching: wp.array, holds: wp.array
    ) -> tuple[Launch, ...]:
        """For runs of vertices, after the contacts' forces.

        Args:
            vertices: the runs.
            bodies: plies, and the clock of the process.
            touching: bits of the tools that are near, shape [vertex].
            holds: memory of the contacts, shape [slot].
        """
        inputs = [self.rates, self.tools, touching, holds, bodies.loads.process, bodies.step]
        outputs = [bodies.heat.temperature]
        return tuple(
            Launch(exchange_heat, count, [first, *inputs], outputs) for first, count in vertices
        )


def tool_heat(scene: Setup, device: str) -> ToolHeat | None:
    """Put what cools plies on a device; None where none cools."""
    if not any(map(scene.cools, scene.plies)):
        return None
    rates = []
    for ply in scene.plies:
        matrix = ply.fabric.matrix
        holds = None if matrix is None else matrix.heat
        rates.append(np.full(len(ply.mesh.vertices), 0.0 if holds is None else holds.rate))
    tools = [PASSES_NONE if t.temperature is None else t.temperature for t in scene.tools]
    return ToolHeat(
        wp.array(np.concatenate(rates), dtype=wp.float64, device=device),
        wp.array(tools, dtype=wp.float64, device=device),
    )
