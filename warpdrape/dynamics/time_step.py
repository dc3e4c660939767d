"""The stable time step: yarns, shear, triangle heights, contact penalty; and mass scaling."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from warpdrape.dynamics.selective_mass import Polynomial, choose_polynomial, laplacian_bound
from warpdrape.errors import InputError
from warpdrape.forces.membrane import flat_gradients, triangle_frequencies
from warpdrape.numerics import Numerics
from warpdrape.setup import Setup

CONTACTS_AT_A_VERTEX = 8
"""Contacts that one vertex may feel at once: two sides, its own and those of opposite vertices,
each pair of masses counted at both ends."""


@dataclass(frozen=True, eq=False)
class LumpedMass:
    """Vertex masses and the step they allow.

    Attributes:
        mass: mass of every vertex, plies one after the other [kg], shape [vertex].
        added: share of it that plain mass scaling added [kg], shape [vertex].
        scaling: polynomial of selective mass scaling, of order 1 without.
        stable_step: largest stable step [s], contact included.
    """

    mass: np.ndarray
    added: np.ndarray
    scaling: Polynomial
    stable_step: float


def stable_step(highest: float, numerics: Numerics, contacts: bool) -> float:
    """Largest stable step [s] of central differences, (Δt ω)² + Σ k_c Δt²/m + 2 Σ c Δt/m ≤ 4.

    The dashpots, c = 2 ζ √(k m), act on the velocity half a step back, hence the last term; pressed
    from two sides, a vertex feels two.

    Args:
        highest: bound on ω² of the membranes [1/s²].
        numerics: share of the penalty stiffness and damping of the contacts.
        contacts: whether there is anything to touch.

    Raises:
        InputError: if the contacts alone need more than there is.
    """
    left = 4.0
    if contacts:
        share, damping = numerics.contact_share, numerics.contact_damping
        left -= CONTACTS_AT_A_VERTEX * share + 2.0 * 4.0 * damping * math.sqrt(share)
    if left <= 0.5:
        raise InputError(
            f"contact_share = {numerics.contact_share} with contact_damping = "
            f"{numerics.contact_damping} leaves no stable step: lower one of them"
        )
    return math.sqrt(left / highest)


def lump_masses(scene: Setup) -> LumpedMass:
    """Lump each triangle's mass on its vertices, a third each, scaled where asked.

    Raises:
        InputError: if selective mass scaling cannot do what is asked.
    """
    contacts = bool(scene.tools) or len(scene.plies) > 1
    numerics, allowed = scene.numerics, np.inf
    if numerics.minimum_time_step is not None:
        share = stable_step(1.0, numerics, contacts) * numerics.safety / numerics.minimum_time_step
        allowed = share**2
    selective = numerics.mass_scaling == "selective"
    masses, added, highest = [], [], 0.0
    for ply in scene.plies:
        frequency = triangle_frequencies(ply, numerics)
        scale = np.maximum(frequency / (np.inf if selective else allowed), 1.0)
        _, areas = flat_gradients(ply)
        third = ply.fabric.areal_density * areas / 3.0
        vertex = np.asarray(ply.mesh.triangles)
        count = len(ply.mesh.vertices)
        total = np.bincount(vertex.ravel(), np.repeat(third * scale, 3), count)
        masses.append(total)
        added.append(total - np.bincount(vertex.ravel(), np.repeat(third, 3), count))
        highest = max(highest, float((frequency / scale).max()))
    scaling = Polynomial(1)
    if selective and scene.clamps:
        raise InputError(
            "mass_scaling = 'selective' is for plies that nothing but tools and contact hold, and "
            f"clamp {scene.clamps[0].name!r} leads vertices: take 'plain'"
        )
    if selective and highest > allowed:
        bound = laplacian_bound(scene)
        scaling = choose_polynomial(bound, allowed, numerics.minimum_time_step)
        highest = scaling.peak * bound
    return LumpedMass(
        np.concatenate(masses),
        np.concatenate(added),
        scaling,
        stable_step(highest, numerics, contacts),
    )


def choose_step(scene: Setup, stable: float) -> float:
    """Step to use [s].

    Raises:
        InputError: if the scene asks for more than the stable step.
    """
    asked = scene.numerics.time_step
    if asked is None:
        return scene.numerics.safety * stable
    if asked > stable:
        raise InputError(
            f"time_step = {asked:.4g} s is above the stable {stable:.4g} s: leave it out, "
            "or set minimum_time_step to add mass"
        )
    return asked
