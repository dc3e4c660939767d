"""The forces and contacts there are: a new one is listed here, and nowhere else."""

from __future__ import annotations

from importlib import import_module
from types import ModuleType

import numpy as np
import warp as wp

from warpdrape.approaches import SLIDING_YARNS
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
from warpdrape.contact.compaction import build_pads, too_hard
from warpdrape.contact.features import has_features
from warpdrape.forces import bending, bending_curve, matrix, pressure, springs
from warpdrape.interaction import Interaction, Span
from warpdrape.setup import Setup
from warpdrape.timing import Timing

MEMBRANES = {
    "semi_discrete": "membrane",
    "green_naghdi": "green_naghdi",
    "fibre_frame": "fibre_frame",
    "yarns": "yarns",
    SLIDING_YARNS: "sliding_yarns",
}
"""Modules of `warpdrape.forces` with the plies' membranes by the scene's approach: ``build``,
``frequencies``, the bound on ω² of a ply's triangles, and ``sheet_stiffness``, for selective mass
scaling, which scales it alone. Its elements say how parts on several threads share out a ply.
Imported when needed: a run starts sooner."""
FORCES = (bending, bending_curve, matrix, pressure, springs)
"""Modules of the other forces: ``build`` and ``frequencies``."""
CONTACTS = (ply_contact, self_contact, edge_contact, tool_features, tool_contact)
"""Modules of contacts: ``build``. After them come `heat` and `press_through`, which take up what
they pass."""


def membrane_of(scene: Setup) -> ModuleType:
    """The module of the plies' membranes."""
    return import_module(f"warpdrape.forces.{MEMBRANES[scene.approach]}")


def forces_of(scene: Setup) -> tuple[ModuleType, ...]:
    """The modules of forces, the membranes' first."""
    return (membrane_of(scene), *FORCES)


def step_share(scene: Setup) -> float:
    """What takes of the 4 in (Δt ω)² ≤ 4 beside what `forces_of` bound by ω²: contacts, slides.

    Raises:
        InputError: if they leave no stable step.
    """
    contacts = law.step_share(scene)
    if scene.approach != SLIDING_YARNS:
        return contacts
    return contacts + membrane_of(scene).slides_share(scene, contacts)


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
    surfaces = None
    others = len(scene.plies) > 1 or has_features(scene)
    if others or any(map(scene.touches_itself, scene.plies)):
        surfaces = ply_surfaces.build(scene, spans, timing, device, shapes=others)
    pads = build_pads(scene, spans, timing, mass, device)
    needed = (scene, spans, timing, mass, surfaces, pads, device)
    built = [contact.build(*needed) for contact in CONTACTS]
    found = [thing for thing in (surfaces, *built) if thing is not None]
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
