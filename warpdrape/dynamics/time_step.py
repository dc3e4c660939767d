"""The stable time step: the bounds of all forces, the contacts' penalty; and mass scaling."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from warpdrape.blanks.triangles import flat_gradients
from warpdrape.dynamics.interactions import forces_of, step_share
from warpdrape.dynamics.selective_mass import Polynomial, choose_polynomial, laplacian_bound
from warpdrape.errors import InputError
from warpdrape.setup import Setup


@dataclass(frozen=True, eq=False)
class LumpedMass:
    """Vertex masses and the step they allow.

    Attributes:
        mass: mass of every vertex, plies one after the other [kg], shape [vertex].
        added: share of it that plain mass scaling added [kg], shape [vertex].
        scaling: polynomial of selective mass scaling, of order 1 without.
        stable_step: largest stable step [s], contact included.
        dictator: ply and triangle that bound the step most, by number, and how many times shorter
            it is than half of that ply's triangles need.
    """

    mass: np.ndarray
    added: np.ndarray
    scaling: Polynomial
    stable_step: float
    dictator: tuple[int, int, float]


def stable_step(highest: float, taken: float) -> float:
    """Largest stable step [s] of central differences.

    Args:
        highest: bound on ω² of the forces [1/s²].
        taken: of the 4 in (Δt ω)² ≤ 4, from `step_share` [-].
    """
    if not (math.isfinite(highest) and highest > 0.0):
        raise InputError(
            f"the plies' stiffness over mass, {highest:g} 1/s², gives no time step: look at the "
            "values of the fabric, and at yarn_softening and stabiliser"
        )
    return math.sqrt((4.0 - taken) / highest)


def frequencies(scene: Setup, number: int) -> np.ndarray:
    """Bound on ω² [1/s²] of each triangle of a ply, that of each force, shape [force, triangle]."""
    return np.stack([force.frequencies(scene, number) for force in forces_of(scene)])


def lump_masses(scene: Setup) -> LumpedMass:
    """Lump each triangle's mass on its vertices, a third each, scaled where asked.

    Raises:
        InputError: if selective mass scaling cannot do what is asked.
    """
    taken = step_share(scene)
    numerics, allowed = scene.numerics, np.inf
    shortest = numerics.minimum_time_step
    if shortest is not None:
        share = stable_step(1.0, taken) * numerics.safety / shortest
        allowed = share**2
    selective = numerics.mass_scaling == "selective"
    masses, added, highest, unscaled, dictator = [], [], 0.0, 0.0, (0, 0, 1.0)
    for number, ply in enumerate(scene.plies):
        by_force = frequencies(scene, number)
        frequency = by_force.sum(axis=0)
        scale = np.maximum(frequency / (np.inf if selective else allowed), 1.0)
        _, areas = flat_gradients(ply)
        third = ply.fabric.areal_density * areas / 3.0
        vertex = np.asarray(ply.mesh.triangles)
        count = len(ply.mesh.vertices)
        total = np.bincount(vertex.ravel(), np.repeat(third * scale, 3), count)
        masses.append(total)
        added.append(total - np.bincount(vertex.ravel(), np.repeat(third, 3), count))
        scaled = frequency / scale
        if scaled.max() > highest:
            highest = float(scaled.max())
            shorter = math.sqrt(highest / np.median(scaled))
            dictator = (number, int(np.argmax(scaled)), shorter)
        unscaled = max(unscaled, float(by_force[1:].sum(axis=0).max()))
    scaling = Polynomial(1)
    if selective and scene.clamps:
        raise InputError(
            "mass_scaling = 'selective' is for plies that nothing but tools and contact hold, and "
            f"clamp {scene.clamps[0].name!r} leads vertices: take 'plain'"
        )
    if selective and shortest is not None and highest > allowed:
        bound = laplacian_bound(scene)
        if unscaled > 0.5 * allowed:
            raise InputError(
                f"minimum_time_step = {shortest:g} s is too long for the plies' "
                "bending, which mass_scaling = 'selective' leaves as it is: lower it"
            )
        scaling = choose_polynomial(bound, allowed - unscaled, shortest)
        highest = scaling.peak * bound + unscaled  # what scales down the first force alone
    return LumpedMass(
        np.concatenate(masses),
        np.concatenate(added),
        scaling,
        stable_step(highest, taken),
        dictator,
    )
