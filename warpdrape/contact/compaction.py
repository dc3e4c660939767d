"""Compaction laws of the plies as contacts read them: pressure and energy against depth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import warp as wp

from warpdrape.blanks.ply import Ply
from warpdrape.interaction import Span
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


def build_pads(
    scene: Setup, spans: Sequence[Span], timing: Timing, mass: wp.array, device: str
) -> Pads:
    """Put the laws of all faces that may touch on a device.

    Args:
        scene: what is computed.
        spans: where plies are.
        timing: the steps.
        mass: vertex masses [kg], shape [vertex].
        device: Warp device.
    """
    areas = np.concatenate([ply.mesh.vertex_areas for ply in scene.plies])
    stiffest = dict(
        zip(
            (ply.name for ply in scene.plies),
            penalty_slopes(scene, spans, timing, mass.numpy() / areas),
            strict=True,
        )
    )
    known: dict[tuple, int] = {}
    sampled: list[Sampled] = []

    def number(*plies: Ply) -> int:
        """Law of a ply's face against a tool, or of the faces of two on each other, plus one."""
        laws = [ply.fabric.compaction for ply in plies]
        if not any(laws):
            return 0
        limit = min(stiffest[ply.name] for ply in plies)
        key = (tuple(sorted(map(id, laws))), limit)
        if key not in known:
            sampled.append(sample([law for law in laws if law is not None], limit))
            known[key] = len(sampled)
        return known[key]

    of_tools = tuple(number(ply) for ply in scene.plies)
    of_plies = np.array([[number(one, other) for other in scene.plies] for one in scene.plies])

    def real(values: list[np.ndarray] | list[float]) -> wp.array:
        return wp.array(np.hstack(values or [[0.0]]), dtype=wp.float64, device=device)

    laws = CompactionLaws()
    laws.samples = SAMPLES
    laws.pressures = real([each.pressures for each in sampled])
    laws.energies = real([each.energies for each in sampled])
    laws.spacing = real([each.spacing for each in sampled])
    laws.beyond = real([each.beyond for each in sampled])
    laws.steepest = real([each.steepest for each in sampled])
    return Pads(laws, of_tools, of_plies, areas)


def penalty_slopes(
    scene: Setup, spans: Sequence[Span], timing: Timing, density: np.ndarray
) -> list[float]:
    """Slope of pressure over depth that the step allows contacts of each ply [Pa/m].

    Args:
        scene: what is computed.
        spans: where plies are.
        timing: the steps.
        density: mass of vertices over their area, that of mass scaling included [kg/m²].
    """
    share = scene.numerics.contact_share / timing.time_step**2
    return [share * float(density[span.vertices].max()) for span in spans]


def too_hard(scene: Setup, spans: Sequence[Span], timing: Timing, mass: np.ndarray) -> list[str]:
    """Plies whose laws rise more steeply than the step allows, in words.

    Args:
        scene: what is computed.
        spans: where plies are.
        timing: the steps.
        mass: vertex masses [kg], shape [vertex].
    """
    areas = np.concatenate([ply.mesh.vertex_areas for ply in scene.plies])
    found = []
    slopes = penalty_slopes(scene, spans, timing, mass / areas)
    for ply, slope in zip(scene.plies, slopes, strict=True):
        law = ply.fabric.compaction
        if law is not None and sample([law], np.inf).steepest > slope:
            found.append(
                f"ply {ply.name!r}: its compaction law rises more steeply than contacts may at "
                "this time step, so tools that close on it press too softly: leave out "
                "minimum_time_step and yarn_softening, or raise contact_share"
            )
    return found


class Sampled(NamedTuple):
    """A law, evenly sampled in the depth of a contact."""

    spacing: float  # m
    pressures: np.ndarray  # Pa, shape [SAMPLES]
    energies: np.ndarray  # J/m², likewise
    beyond: float  # slope after the last one [Pa/m]
    steepest: float  # the largest [Pa/m]


def sample(laws: Sequence[Compaction], stiffest: float) -> Sampled:
    """Pressure against the depth of a contact.

    A face gives way by half of what its ply does; of two faces the depths add up under one
    pressure.

    Args:
        laws: of the faces that can be compacted, one or two.
        stiffest: slope that pressure may have at most [Pa/m].
    """
    highest = max(law.pressures[-1] for law in laws)

    def depth(pressure: np.ndarray | float) -> np.ndarray:
        return np.asarray(sum(0.5 * (law.thickness - law.thickness_at(pressure)) for law in laws))

    fine = np.linspace(0.0, 1.0, 20 * SAMPLES) ** 3 * highest  # close where laws are soft
    even = np.linspace(0.0, float(depth(highest)), SAMPLES)
    pressure = np.interp(even, depth(fine), fine)
    spacing = float(even[1])
    steps = np.minimum(np.diff(pressure), stiffest * spacing)
    pressure = np.r_[0.0, np.cumsum(steps)]
    energy = np.r_[0.0, np.cumsum(0.5 * (pressure[1:] + pressure[:-1])) * spacing]
    beyond = min(1.0 / sum(0.5 / law.last_slope for law in laws), stiffest)
    steepest = max(float(steps.max()) / spacing, beyond)
    return Sampled(spacing, pressure, energy, beyond, steepest)
