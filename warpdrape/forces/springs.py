"""Springs and grippers on plies: their vertices, launches, work, columns of the history."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp

from warpdrape.forces.load_work import work_done
from warpdrape.interaction import Bodies, Launch, Launches, Measured, Share, Span
from warpdrape.kernels.forces.springs import BROKEN, SpringLaw, add_spring_forces
from warpdrape.setup import Setup
from warpdrape.tools.spring import Spring


@dataclass(frozen=True, eq=False)
class SpringMemory:
    """What the springs of a device remember.

    Attributes:
        slipped: way that the ply has slipped through the grip [m], shape [pulled].
        state: whether springs hold, shape [pulled].
        acted: forces in the last step [N], shape [pulled].
        before: positions then [m], shape [pulled].
        work: done so far [J], shape [pulled].
    """

    slipped: wp.array
    state: wp.array
    acted: wp.array
    before: wp.array
    work: wp.array


@dataclass(frozen=True, eq=False)
class Device:
    """One device on a device of Warp's.

    Attributes:
        law: of each of its springs.
        vertices: that they pull at, shape [pulled].
        start: where these started [m], shape [pulled].
    """

    law: SpringLaw
    vertices: wp.array
    start: wp.array


@dataclass(frozen=True, eq=False)
class Springs:
    """All springs of a scene.

    Attributes:
        scene: what is computed.
        devices: in the scene's order.
    """

    scene: Setup
    devices: tuple[Device, ...]
    name: str = "springs"
    searches: str = ""

    def start(self) -> tuple[SpringMemory, ...]:
        """All hold, none has pulled yet."""
        return tuple(
            SpringMemory(
                slipped=wp.zeros(each.vertices.shape[0], dtype=wp.float64, device=place),
                state=wp.zeros(each.vertices.shape[0], dtype=wp.int32, device=place),
                acted=wp.full(each.vertices.shape[0], _preload(each.law), wp.vec3d, device=place),
                before=wp.clone(each.start),
                work=wp.zeros(each.vertices.shape[0], dtype=wp.float64, device=place),
            )
            for each in self.devices
            for place in (each.vertices.device,)
        )

    def launches(self, share: Share, bodies: Bodies, memory: tuple[SpringMemory, ...]) -> Launches:
        """A part's own share of the springs."""
        scatter = []
        for each, mine in zip(self.devices, memory, strict=True):
            first, count = share.of(each.vertices.shape[0])
            inputs = [first, each.law, each.vertices, each.start, bodies.plies.x]
            outputs = [bodies.plies.f, mine.slipped, mine.state, mine.acted, mine.before, mine.work]
            scatter.append(Launch(add_spring_forces, count, inputs, outputs))
        return Launches(scatter=tuple(scatter))

    def measure(self, bodies: Bodies, memory: tuple[SpringMemory, ...]) -> Measured:
        """Works, and what each device shows in the history."""
        x = bodies.plies.x.numpy()
        work, readings = 0.0, {}
        for spring, each, mine in zip(self.scene.springs, self.devices, memory, strict=True):
            acted, at = mine.acted.numpy(), x[each.vertices.numpy()]
            done = work_done(mine.work, mine.acted, at - mine.before.numpy())
            work += done
            readings[f"{spring.name}_force_n"] = float(np.linalg.norm(acted, axis=1).sum())
            readings[f"{spring.name}_work_j"] = done
            readings[f"{spring.name}_slip_m"] = float(mine.slipped.numpy().max())
            readings[f"{spring.name}_broken"] = float((mine.state.numpy() == BROKEN).mean())
        nothing: tuple[dict[str, np.ndarray], ...] = tuple({} for _ in self.scene.plies)
        return Measured(fields=nothing, work=work, readings=readings)

    def ply_entries(self, fields: Mapping[str, np.ndarray]) -> dict[str, float]:
        """Nothing to say of a ply."""
        return {}

    def entries(
        self, history: Mapping[str, np.ndarray], fields: Sequence[Mapping[str, np.ndarray]]
    ) -> tuple[dict[str, Any], list[str]]:
        """What ``summary.json`` says of each device; a warning of those that let go."""
        entries, warnings = [], []
        for spring in self.scene.springs:
            name = spring.name
            force, broken = history[f"{name}_force_n"], float(history[f"{name}_broken"][-1])
            entries.append(
                {
                    "name": name,
                    "force_n": float(force[-1]),
                    "max_force_n": float(force.max()),
                    "work_j": float(history[f"{name}_work_j"][-1]),
                    "max_slip_m": float(history[f"{name}_slip_m"][-1]),
                    "broken_share": broken,
                }
            )
            if broken > 0.0:
                warnings.append(
                    f"{100.0 * broken:.0f} % of spring {name!r} let go, at break_force = "
                    f"{spring.break_force:g} N for the whole of it"
                )
        return {"springs": entries}, warnings


def frequencies(scene: Setup, number: int) -> np.ndarray:
    """Bound on ω² [1/s²] that springs add to each triangle of a ply.

    A spring of stiffness k at a vertex of mass m adds k/m, which its triangles share as they share
    the mass; across its line it is as stiff as its force over its length.
    """
    ply = scene.plies[number]
    triangles = np.asarray(ply.mesh.triangles)
    stiffness = np.zeros(len(ply.mesh.vertices))
    for spring in scene.springs:
        if spring.ply == ply.name:
            pulled = spring.vertices(ply.rest_points)
            across = spring.preload / float(np.linalg.norm(spring.to))
            stiffness[pulled] += (spring.stiffness + across) / len(pulled)
    mass = ply.fabric.areal_density * np.asarray(ply.mesh.vertex_areas)
    return (stiffness / mass)[triangles].max(axis=1)


def build(scene: Setup, spans: tuple[Span, ...], device: str) -> Springs | None:
    """Put the springs of a scene on a device; None where there are none."""
    if not scene.springs:
        return None
    names = [ply.name for ply in scene.plies]
    devices = []
    for spring in scene.springs:
        number = names.index(spring.ply)
        points = scene.plies[number].rest_points
        pulled = spring.vertices(points)
        vertices = pulled + spans[number].first_vertex
        devices.append(
            Device(
                _law(spring, len(pulled)),
                wp.array(vertices, dtype=wp.int32, device=device),
                wp.array(points[pulled], dtype=wp.vec3d, device=device),
            )
        )
    return Springs(scene, tuple(devices))


def _preload(law: SpringLaw) -> wp.vec3d:
    """Pull of a spring at the start [N]."""
    to = np.array(law.to)
    return wp.vec3d(*(float(law.preload) * to / np.linalg.norm(to)))


def _law(spring: Spring, count: int) -> SpringLaw:
    """That of each of so many springs of a device."""
    law = SpringLaw()
    law.stiffness = spring.stiffness / count
    law.preload = spring.preload / count
    limits = (
        math.inf if limit is None else limit for limit in (spring.slip_force, spring.break_force)
    )
    law.slips_at, law.breaks_at = (limit / count for limit in limits)
    law.to = wp.vec3d(*np.asarray(spring.to, dtype=float))
    law.follows = int(spring.direction == "following")
    return law
