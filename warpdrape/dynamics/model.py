"""What a run computes with: `Model`, everything that stays as it is, and its state at the start."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import accumulate

import numpy as np
import warp as wp

from warpdrape.dynamics.floating import floating_tools
from warpdrape.dynamics.interactions import FORCES, build_contacts, membrane_of
from warpdrape.dynamics.selective_mass import SelectiveMass, build_selective_mass, start_scaled
from warpdrape.dynamics.time_step import LumpedMass, lump_masses
from warpdrape.interaction import Force, Interaction, MembraneForce, Span
from warpdrape.kernels.dynamics.motion import FloatingTools, Medium
from warpdrape.kernels.tool_pose import TurningTools
from warpdrape.setup import Setup
from warpdrape.state import (
    State,
    start_clamps,
    start_heat,
    start_loads,
    start_plies,
    start_pressing,
    start_tools,
)
from warpdrape.timing import Timing, peak_speed, plan_steps
from warpdrape.tool_pose import turning_tools

RUNAWAY = 100.0
"""Vertex speed over the tools' that counts as blown up [-], but not below 500 m/s."""


@dataclass(frozen=True, eq=False)
class Model:
    """Everything that stays as it is during a run.

    Attributes:
        scene: what is computed.
        device: Warp device.
        timing: steps.
        spans: where each ply's vertices and triangles are.
        forces: of the plies, the membranes' first.
        contacts: between plies, and with tools, after the surfaces that they search.
        masses: vertex masses on the host.
        selective: selective mass scaling, None without.
        mass: vertex masses [kg], shape [vertex].
        added_mass: share of them that mass scaling added [kg], shape [vertex].
        rest: positions at the start [m], shape [vertex].
        clamp: clamp that holds a vertex, −1 if free, shape [vertex].
        floating: which tools float.
        turning: which tools turn.
        medium: gravity, and limits.
    """

    scene: Setup
    device: str
    timing: Timing
    spans: tuple[Span, ...]
    forces: tuple[MembraneForce, *tuple[Force, ...]]
    contacts: tuple[Interaction, ...]
    masses: LumpedMass
    selective: SelectiveMass | None
    mass: wp.array
    added_mass: wp.array
    rest: wp.array
    clamp: wp.array
    floating: FloatingTools
    turning: TurningTools
    medium: Medium

    @property
    def interactions(self) -> tuple[Interaction, ...]:
        """Forces and contacts, in the order in which they act."""
        return (*self.forces, *self.contacts)

    @property
    def triangles(self) -> int:
        """Number of triangles of all plies."""
        return sum(span.triangle_count for span in self.spans)


def build_model(scene: Setup, device: str, frames: int, timing: Timing | None = None) -> Model:
    """Turn a scene into arrays on a device.

    Args:
        scene: what to compute.
        device: Warp device.
        frames: frames after the first.
        timing: steps, of a run that is extended; None to plan them.

    Raises:
        InputError: if the scene asks for a step above the stable one.
    """
    masses = lump_masses(scene)
    timing = timing or plan_steps(scene, masses.stable_step, frames)
    rest = np.concatenate([ply.rest_points for ply in scene.plies])
    spans = ply_spans(scene)
    mass: wp.array = wp.array(masses.mass, dtype=wp.float64, device=device)
    forces = (force.build(scene, spans, device) for force in FORCES)
    contacts = build_contacts(scene, spans, timing, mass, device)
    return Model(
        scene=scene,
        device=device,
        timing=timing,
        spans=spans,
        forces=(
            membrane_of(scene).build(scene, spans, timing.time_step, device),
            *(force for force in forces if force is not None),
        ),
        contacts=contacts,
        masses=masses,
        selective=build_selective_mass(scene, masses.mass, masses.scaling, device),
        mass=mass,
        added_mass=wp.array(masses.added, dtype=wp.float64, device=device),
        rest=wp.array(rest, dtype=wp.vec3d, device=device),
        clamp=wp.array(_clamp_index(scene, spans), dtype=wp.int32, device=device),
        floating=floating_tools(scene, float(masses.mass.sum()), device),
        turning=turning_tools(scene, device),
        medium=_medium(scene, timing),
    )


def ply_spans(scene: Setup) -> tuple[Span, ...]:
    """Where each ply's vertices and triangles are, plies one after the other."""
    sizes = [(len(ply.mesh.vertices), len(ply.mesh.triangles)) for ply in scene.plies]
    first = accumulate(sizes, lambda a, b: (a[0] + b[0], a[1] + b[1]), initial=(0, 0))
    return tuple(Span(v, n, t, m) for (v, t), (n, m) in zip(first, sizes, strict=False))


def _clamp_index(scene: Setup, spans: tuple[Span, ...]) -> np.ndarray:
    index = np.full(spans[-1].vertices.stop, -1)
    names = [ply.name for ply in scene.plies]
    for number, clamp in enumerate(scene.clamps):
        at = names.index(clamp.ply)
        held = clamp.vertices(scene.plies[at].rest_points)
        index[spans[at].first_vertex + held] = number
    return index


def _medium(scene: Setup, timing: Timing) -> Medium:
    medium = Medium()
    medium.gravity = wp.vec3d(*np.asarray(scene.gravity, dtype=float))
    medium.time_step = timing.time_step
    medium.speed_limit = max(RUNAWAY * peak_speed(scene), 500.0)
    return medium


def initial_state(model: Model) -> State:
    """Plies flat and at rest, tools where they start."""
    scene, device, ahead = model.scene, model.device, model.timing.steps_ahead
    n = model.mass.shape[0]
    return State(
        plies=start_plies(model.rest.numpy(), device),
        tools=start_tools(scene, n, ahead, device),
        clamps=start_clamps(scene, n, ahead, device),
        loads=start_loads(scene, ahead, device),
        heat=start_heat(scene, device),
        pressing=start_pressing(n, device) if scene.yarns_rub else None,
        scaled=start_scaled(n, device) if model.selective else None,
        memory=tuple(thing.start() for thing in model.interactions),
        step=wp.zeros(1, dtype=wp.int32, device=device),
    )
