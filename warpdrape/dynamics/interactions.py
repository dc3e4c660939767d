"""The forces and contacts there are: a new one is listed here, and nowhere else."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

import numpy as np
import warp as wp

from warpdrape.approaches import SLIDING_YARNS
from warpdrape.blanks.ply import Ply
from warpdrape.contact import (
    edge_contact,
    heat,
    law,
    ply_contact,
    ply_surfaces,
    press_through,
    self_contact,
    tool_contact,
    tool_features,
)
from warpdrape.contact.compaction import Pads, build_pads, too_hard
from warpdrape.contact.features import has_features
from warpdrape.contact.ply_surfaces import PlySurfaces
from warpdrape.forces import (
    bending,
    bending_curve,
    fibre_frame,
    green_naghdi,
    matrix,
    membrane,
    pressure,
    sliding_yarns,
    springs,
    yarns,
)
from warpdrape.interaction import Force, Interaction, MembraneForce, Span
from warpdrape.numerics import Numerics
from warpdrape.setup import Setup
from warpdrape.timing import Timing


class ForceModule(Protocol):
    """A module of a force."""

    def build(self, scene: Setup, spans: tuple[Span, ...], device: str, /) -> Force | None:
        """The force, ready on a device; None where nothing in the scene has it."""

    def frequencies(self, scene: Setup, number: int, /) -> np.ndarray:
        """Bound on ω² [1/s²] of each triangle of a ply, given its number, shape [triangle]."""


class MembraneModule(Protocol):
    """A module of the plies' membranes."""

    def build(
        self, scene: Setup, spans: tuple[Span, ...], time_step: float, device: str, /
    ) -> MembraneForce:
        """The force, ready on a device, for steps of Δt [s]."""

    def frequencies(self, scene: Setup, number: int, /) -> np.ndarray:
        """As of `ForceModule`."""

    def sheet_stiffness(self, ply: Ply, numerics: Numerics, /) -> tuple[tuple[float, float], float]:
        """Stiffness along the yarns and of shear [N/m], for selective mass scaling."""


class ContactModule(Protocol):
    """A module of a contact that searches the plies' surfaces."""

    def build(
        self,
        scene: Setup,
        spans: tuple[Span, ...],
        timing: Timing,
        mass: wp.array,
        surfaces: PlySurfaces,
        pads: Pads,
        device: str,
        /,
    ) -> Interaction | None:
        """The contact, ready on a device; None where nothing in the scene meets so."""


MEMBRANES: Mapping[str, MembraneModule] = {
    "semi_discrete": membrane,
    "green_naghdi": green_naghdi,
    "fibre_frame": fibre_frame,
    "yarns": yarns,
    SLIDING_YARNS: sliding_yarns,
}
"""The force of the plies' membranes by the scene's approach. Selective mass scaling scales it
alone. Its elements say how parts on several threads share out a ply."""
FORCES: tuple[ForceModule, ...] = (bending, bending_curve, matrix, pressure, springs)
"""Modules of the other forces."""
CONTACTS: tuple[ContactModule, ...] = (ply_contact, self_contact, edge_contact, tool_features)
"""Modules of contacts that search the plies' surfaces. After them comes `tool_contact`, which
searches the tools', then `heat` and `press_through`, which take up what they pass."""


def membrane_of(scene: Setup) -> MembraneModule:
    """The module of the plies' membranes."""
    return MEMBRANES[scene.approach]


def forces_of(scene: Setup) -> tuple[MembraneModule | ForceModule, ...]:
    """The modules of forces, the membranes' first."""
    return (membrane_of(scene), *FORCES)


def step_share(scene: Setup) -> float:
    """What takes of the 4 in (Δt ω)² ≤ 4 beside what `forces_of` bound by ω²: contacts, slides.

    Raises:
        InputError: if they leave no stable step.
    """
    contacts = law.step_share(scene)
    return contacts + sliding_yarns.slides_share(scene, contacts)


def build_contacts(
    scene: Setup, spans: tuple[Span, ...], timing: Timing, mass: wp.array, device: str
) -> tuple[Interaction, ...]:
    """The contacts that a scene needs, after the surfaces that they search.

    Args:
        scene: what is computed.
        spans: where plies are.
        timing: the steps.
        mass: vertex masses [kg], shape [vertex].
        device: Warp device.
    """
    pads = build_pads(scene, spans, timing, mass, device)
    built: list[Interaction | None] = []
    others = len(scene.plies) > 1 or has_features(scene)
    if others or any(map(scene.touches_itself, scene.plies)):
        surfaces = ply_surfaces.build(scene, spans, timing, device, shapes=others)
        needed = (scene, spans, timing, mass, surfaces, pads, device)
        built += [surfaces, *(contact.build(*needed) for contact in CONTACTS)]
    built.append(tool_contact.build(scene, timing, mass, pads, device))
    found = [thing for thing in built if thing is not None]
    after = (heat.build(scene, found, device), press_through.build(scene))
    return (*found, *(thing for thing in after if thing is not None))


def doubts(scene: Setup, spans: tuple[Span, ...], timing: Timing, masses: np.ndarray) -> list[str]:
    """Warnings of what forces and contacts cannot do at the step of a run, in words.

    Args:
        scene: what is computed.
        spans: where plies are.
        timing: the steps.
        masses: of vertices [kg], shape [vertex].
    """
    return too_hard(scene, spans, timing, masses)
