"""What all contacts share: the penalty law, what it takes of the step, how far to look."""

from __future__ import annotations

import math

from warpdrape.contact.features import has_features
from warpdrape.contact.friction import friction_laws
from warpdrape.errors import InputError
from warpdrape.kernels.contact.contact import ContactLaw
from warpdrape.setup import Setup

CONTACTS_AT_A_VERTEX = 8
"""Contacts that one vertex may feel at once: two sides, its own and those of opposite vertices,
each pair of masses counted at both ends; a side is touched by other plies or by the ply itself,
hardly by both at once. Edges that touch edges share their vertices' masses, features of tools those
of the triangles that they meet: each make one more."""


def contact_law(scene: Setup, time_step: float, device: str) -> ContactLaw:
    """Stiffness, damping and friction of contacts at a time step [s]."""
    law = ContactLaw()
    share = scene.numerics.contact_share
    law.stiffness = share / time_step**2
    law.lag = 2.0 * scene.numerics.contact_damping * time_step / math.sqrt(share)
    law.time_step = time_step
    law.friction = friction_laws(scene, device)
    return law


def step_share(scene: Setup) -> float:
    """What contacts take of the 4 in (Δt ω)² + Σ k_c Δt²/m + 2 Σ c Δt/m ≤ 4 [-].

    The dashpots, c = 2 ζ √(k m), act on the velocity half a step back, hence the last term; pressed
    from two sides, a vertex feels two.

    Raises:
        InputError: if nothing is left.
    """
    if not scene.tools and len(scene.plies) == 1 and not scene.touches_itself(scene.plies[0]):
        return 0.0
    share, damping = scene.numerics.contact_share, scene.numerics.contact_damping
    edges = len(scene.plies) > 1 or scene.touches_itself(scene.plies[0])
    contacts = CONTACTS_AT_A_VERTEX + int(edges) + int(has_features(scene))
    taken = contacts * share + 2.0 * 4.0 * damping * math.sqrt(share)
    if taken >= 3.5:
        raise InputError(
            f"contact_share = {share} with contact_damping = {damping} leaves no stable step: "
            "lower one of them"
        )
    return taken


def near_reach(scene: Setup) -> float:
    """Distance [m] within which a vertex counts as near: four slides, for those that go faster."""
    return 4.0 * scene.numerics.search_slide
