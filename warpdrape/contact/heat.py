"""Temperatures of plies in a run: the air round them, their step, and how they shift viscosities.

Contacts with tools and plies add to `HeatState` what they pass; this comes after them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import warp as wp

from warpdrape.interaction import Bodies, Interaction, Launch, Launches, Measured, Share
from warpdrape.kernels.contact.heat import HeldHeat, advance_temperatures, compute_shifts
from warpdrape.kernels.materials.viscosity import Shift
from warpdrape.materials.viscosity_data import shift_struct
from warpdrape.setup import Setup


@dataclass(frozen=True, eq=False)
class Temperatures:
    """The temperatures of all plies that cool.

    Attributes:
        plies: what decides how theirs change, by number of the ply.
        shifts: with temperature, of their matrices, likewise.
        areas: of vertices in the flat plies [m²], shape [vertex].
        melts: shift factors at vertices as contacts read them, shape [vertex] each; follow the
            temperatures at every search.
    """

    plies: Mapping[int, HeldHeat]
    shifts: Mapping[int, Shift]
    areas: wp.array
    melts: tuple[wp.array, ...]
    name: str = "heat"
    searches: str = ""

    def start(self) -> None:
        """Temperatures are kept in `HeatState`."""

    def launches(self, share: Share, bodies: Bodies, memory: None) -> Launches:
        """A part's own vertices."""
        heat, clock = bodies.cooling, [bodies.loads.process, bodies.step]
        advance, follow = [], []
        for number, held in self.plies.items():
            for first, count in share.by_ply[number]:
                outputs = [heat.power, heat.pull, heat.cover, heat.temperature]
                inputs = [first, held, self.areas, *clock]
                advance.append(Launch(advance_temperatures, count, inputs, outputs))
                inputs = [first, self.shifts[number], heat.temperature]
                follow += [Launch(compute_shifts, count, inputs, [melt]) for melt in self.melts]
        return Launches(prepare=tuple(follow), push=tuple(advance))

    def measure(self, bodies: Bodies, memory: None) -> Measured:
        """Nothing: matrices show their temperature."""
        return Measured()


def build(scene: Setup, contacts: Sequence[Interaction], device: str) -> Temperatures | None:
    """Put what changes temperatures on a device; None where none does.

    Args:
        scene: what is computed.
        contacts: that read shift factors of melts.
        device: Warp device.
    """
    cooling = scene.cooling
    if not cooling:
        return None
    areas = np.concatenate([ply.mesh.vertex_areas for ply in scene.plies])
    plies, shifts = {}, {}
    for number, heat in cooling.items():
        held = HeldHeat()
        held.capacity, held.emissivity = heat.capacity, heat.emissivity
        if scene.air is not None:
            held.air, held.convection = scene.air.temperature, scene.air.convection
        plies[number] = held
        matrix = scene.plies[number].fabric.matrix
        shifts[number] = shift_struct(None if matrix is None else matrix.shift)
    melts: tuple[wp.array, ...] = ()
    if any(law.shifted for law in scene.friction_laws):
        laws = [contact.law for contact in contacts if hasattr(contact, "law")]
        melts = tuple(law.friction.shifts for law in laws)
    return Temperatures(plies, shifts, wp.array(areas, dtype=wp.float64, device=device), melts)
