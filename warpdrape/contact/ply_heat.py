"""Heat between plies that press on each other: what it needs on a device, its launches.

Of two plies the vertices of the one with the finer mesh look for the other: a coarse mesh's would
pour all that they pass into the few vertices of a fine one that lie next to them.
"""

from __future__ import annotations

from itertools import combinations
from typing import NamedTuple

import numpy as np
import warp as wp

from warpdrape.interaction import Bodies, Launch, Run
from warpdrape.kernels.contact.on_ply import Slots
from warpdrape.kernels.contact.ply_heat import exchange_between_plies
from warpdrape.materials.matrix import Heat
from warpdrape.setup import Setup
from warpdrape.timing import Timing

MOST = 0.05
"""Share of what two places must pass to be alike that passes in a step at most, so that no
conductance is too much for it: such plies are alike within a hundred steps [-]."""


class PlyHeat(NamedTuple):
    """What decides how fast plies warm each other."""

    cools: frozenset[int]
    """Numbers of the plies whose temperatures change."""
    plies: int
    """How many there are in all."""
    conductances: wp.array
    """From each ply's vertices to each other ply [W/(m²·K)], shape [ply · ply]."""
    most: float
    """Share that may pass in a time of the process [1/s]."""
    areas: wp.array
    """Of vertices in the flat plies [m²], shape [vertex]."""
    capacities: wp.array
    """Heat per kelvin of vertices [J/K], shape [vertex]."""

    def launches(
        self,
        searching: int,
        run: Run,
        first_slot: int,
        bodies: Bodies,
        seen: wp.array,
        slots: Slots,
    ) -> tuple[Launch, ...]:
        """For a run of a searching ply's vertices, after the contacts' forces.

        Args:
            searching: number of the ply.
            run: its vertices.
            first_slot: of their contacts with the plies above or below.
            bodies: the plies.
            seen: of the searches, shape [slot].
            slots: memory of the contacts.
        """
        if searching not in self.cools:
            return ()
        inputs = [run.first, first_slot, searching * self.plies, self.conductances, self.most]
        heat = bodies.cooling
        inputs += [self.areas, self.capacities, seen, slots, heat.temperature]
        outputs = [heat.power, heat.cover]
        return (Launch(exchange_between_plies, run.count, inputs, outputs),)


def ply_heat(scene: Setup, timing: Timing, device: str) -> PlyHeat | None:
    """Put what passes heat between plies on a device; None where none cools.

    Args:
        scene: what is computed.
        timing: the steps.
        device: Warp device.
    """
    cooling, count = scene.cooling, len(scene.plies)
    if not cooling:
        return None
    areas = [ply.mesh.vertex_areas for ply in scene.plies]
    between = np.zeros((count, count))
    for one, other in combinations(cooling, 2):
        finer, coarser = sorted((one, other), key=lambda number: areas[number].mean())
        between[finer, coarser] = conductance(cooling[one], cooling[other])
    capacities = [
        area * (cooling[number].capacity if number in cooling else 0.0)
        for number, area in enumerate(areas)
    ]
    return PlyHeat(
        frozenset(cooling),
        count,
        wp.array(between.ravel(), dtype=wp.float64, device=device),
        MOST * scene.pace / timing.time_step,
        wp.array(np.concatenate(areas), dtype=wp.float64, device=device),
        wp.array(np.concatenate(capacities), dtype=wp.float64, device=device),
    )


def conductance(one: Heat, other: Heat) -> float:
    """Of the contact of two plies, each face half of the way [W/(m²·K)]; 0 where none passes."""
    if one.between is None or other.between is None:
        return 0.0
    return 2.0 / (1.0 / one.between + 1.0 / other.between)
