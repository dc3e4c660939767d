"""Compaction laws of the plies as contacts read them: pressure and energy against depth."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import warp as wp

from warpdrape.blanks.ply import Ply
from warpdrape.kernels.contact.contact import CompactionLaws, Pad
from warpdrape.materials.compaction import Compaction
from warpdrape.setup import Setup
from warpdrape.timing import Timing

SAMPLES = 256
"""Of a law, evenly spaced in depth."""


@dataclass(frozen=True, eq=False)
class Pads:
    """What gives way in the contacts of a scene.

    Attributes:
        laws: for the kernels.
        of_tools: for each ply's contacts with tools the number of its law plus one, 0 for none.
        of_plies: for each pair of plies, a ply with itself included, shape [ply, ply].
        areas: of vertices, thirds of the flat triangles [m²], shape [vertex].
    """

    laws: CompactionLaws
    of_tools: tuple[int, ...]
    of_plies: np.ndarray
    areas: np.ndarray

    def at_vertices(self, scene: Setup, device: str) -> wp.array:
        """Pads of the vertices' contacts with tools, shape [vertex]."""
        pads = np.zeros(len(self.areas), dtype=Pad.numpy_dtype())
        counts = [len(ply.mesh.vertices) for ply in scene.plies]
        pads["law"] = np.repeat(self.of_tools, counts)
        pads["area"] = self.areas
        return wp.array(pads, dtype=Pad, device=device)


def build_pads(scene: Setup, timing: Timing, device: str) -> Pads:
    """Put the laws of all faces that may touch on a device.

    Args:
        scene: what is computed.
        timing: the steps.
        device: Warp device.
    """
    share = scene.numerics.contact_share / timing.time_step**2
    known: dict[tuple, int] = {}
    sampled: list[tuple[float, np.ndarray, float]] = []

    def number(*plies: Ply) -> int:
        """Law of a ply's face against a tool, or of the faces of two on each other, plus one."""
        laws = [ply.fabric.compaction for ply in plies]
        if not any(laws):
            return 0
        stiffest = share * min(ply.fabric.areal_density for ply in plies)
        key = (tuple(sorted(map(id, laws))), stiffest)
        if key not in known:
            sampled.append(sample([law for law in laws if law is not None], stiffest))
            known[key] = len(sampled)
        return known[key]

    of_tools = tuple(number(ply) for ply in scene.plies)
    of_plies = np.array([[number(one, other) for other in scene.plies] for one in scene.plies])
    laws = CompactionLaws()
    laws.samples = SAMPLES
    pressures = [pressures for _, pressures, _ in sampled] or [np.zeros(SAMPLES)]
    spacing = [spacing for spacing, _, _ in sampled] or [1.0]
    energies = [
        np.r_[0.0, np.cumsum(0.5 * (p[1:] + p[:-1])) * dx]
        for p, dx in zip(pressures, spacing, strict=True)
    ]

    def real(values: np.ndarray | list[float]) -> wp.array:
        return wp.array(values, dtype=wp.float64, device=device)

    laws.pressures, laws.energies = real(np.concatenate(pressures)), real(np.concatenate(energies))
    laws.spacing = real(spacing)
    laws.steepest = real([steepest for _, _, steepest in sampled] or [1.0])
    areas = np.concatenate([ply.mesh.vertex_areas for ply in scene.plies])
    return Pads(laws, of_tools, of_plies, areas)


def sample(laws: list[Compaction], stiffest: float) -> tuple[float, np.ndarray, float]:
    """Pressure against the depth of a contact, evenly sampled.

    A face gives way by half of what its ply does; of two faces the depths add up under one
    pressure.

    Args:
        laws: of the faces that can be compacted, one or two.
        stiffest: slope that pressure may have at most [Pa/m].

    Returns:
        Spacing of the samples [m], pressures [Pa], and the slope beyond the last one [Pa/m].
    """
    highest = min(law.pressures[-1] for law in laws)
    deepest = sum(0.5 * (law.thickness - float(law.thickness_at(highest))) for law in laws)
    fine = np.linspace(0.0, 1.0, 20 * SAMPLES) ** 3 * highest  # close where laws are soft
    depth = sum(0.5 * (law.thickness - law.thickness_at(fine)) for law in laws)
    even = np.linspace(0.0, deepest, SAMPLES)
    pressure = np.interp(even, depth, fine)
    spacing = float(even[1])
    steps = np.minimum(np.diff(pressure), stiffest * spacing)
    return spacing, np.r_[0.0, np.cumsum(steps)], stiffest
