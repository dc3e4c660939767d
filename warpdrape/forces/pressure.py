"""Pressures on plies: what they act on, launches, work, columns of the history."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp

from warpdrape.forces.load_work import work_done
from warpdrape.interaction import Bodies, Launch, Launches, Measured, Share, Span
from warpdrape.kernels.forces.pressure import add_pressure
from warpdrape.setup import Setup
from warpdrape.tools.pressure import UPWARDS


@dataclass(frozen=True, eq=False)
class PressureMemory:
    """What a pressure remembers.

    Attributes:
        acted: forces in the last step [N], shape [loaded].
        middle: where the triangles' centroids were then [m], shape [loaded].
        work: done so far [J], shape [loaded].
    """

    acted: wp.array
    middle: wp.array
    work: wp.array


@dataclass(frozen=True, eq=False)
class Pressures:
    """All pressures of a scene.

    Attributes:
        scene: what is computed.
        corners: vertices of the triangles of each, shape [loaded].
        rest: positions at the start [m], shape [vertex, 3].
        device: Warp device.
    """

    scene: Setup
    corners: tuple[wp.array, ...]
    rest: np.ndarray
    device: str
    name: str = "pressure"
    searches: str = ""

    def start(self) -> tuple[PressureMemory, ...]:
        """No force yet, no work."""
        return tuple(
            PressureMemory(
                wp.zeros(len(corners), dtype=wp.vec3d, device=self.device),
                wp.array(middle, dtype=wp.vec3d, device=self.device),
                wp.zeros(len(corners), dtype=wp.float64, device=self.device),
            )
            for corners in self.corners
            for middle in (self.rest[corners.numpy()].mean(axis=1),)
        )

    def launches(
        self, share: Share, bodies: Bodies, memory: tuple[PressureMemory, ...]
    ) -> Launches:
        """All of the triangles, by part 0: it alone counts the steps, as others scatter."""
        plies, scatter = bodies.plies, []
        if share.number > 0:
            return Launches()
        for load, (corners, mine) in enumerate(zip(self.corners, memory, strict=True)):
            inputs = [load, corners, bodies.loads.pressure, bodies.step, plies.x]
            outputs = [plies.f, mine.acted, mine.middle, mine.work]
            scatter.append(Launch(add_pressure, len(corners), inputs, outputs))
        return Launches(scatter=tuple(scatter))

    def measure(self, bodies: Bodies, memory: tuple[PressureMemory, ...]) -> Measured:
        """Works, and what each shows in the history."""
        x = bodies.plies.x.numpy()
        now = bodies.loads.pressure.numpy()[:, int(bodies.step.numpy()[0])]
        work, readings = 0.0, {}
        for load, (pressure, corners, mine) in enumerate(
            zip(self.scene.pressures, self.corners, memory, strict=True)
        ):
            at = corners.numpy()
            a, b, c = (x[at[:, corner]] for corner in range(3))
            force = 0.5 * now[load] * np.cross(b - a, c - a)
            moved = x[at].mean(axis=1) - mine.middle.numpy()
            done = work_done(mine.work, mine.acted, moved)
            work += done
            readings[f"{pressure.name}_pressure_pa"] = float(UPWARDS[pressure.side] * now[load])
            readings[f"{pressure.name}_force_z_n"] = float(force[:, 2].sum())
            readings[f"{pressure.name}_work_j"] = done
        nothing: tuple[dict[str, np.ndarray], ...] = tuple({} for _ in self.scene.plies)
        return Measured(fields=nothing, work=work, readings=readings)

    def ply_entries(self, fields: Mapping[str, np.ndarray]) -> dict[str, float]:
        """Nothing to say of a ply."""
        return {}

    def entries(
        self, history: Mapping[str, np.ndarray], fields: Sequence[Mapping[str, np.ndarray]]
    ) -> tuple[dict[str, Any], list[str]]:
        """What ``summary.json`` says of each pressure."""
        names = [pressure.name for pressure in self.scene.pressures]
        entries = [
            {
                "name": name,
                "pressure_pa": float(history[f"{name}_pressure_pa"][-1]),
                "force_z_n": float(history[f"{name}_force_z_n"][-1]),
                "work_j": float(history[f"{name}_work_j"][-1]),
            }
            for name in names
        ]
        return {"pressures": entries}, []


def frequencies(scene: Setup, number: int) -> np.ndarray:
    """Pressures stiffen no triangle: 0 [1/s²] for each of a ply."""
    return np.zeros(len(scene.plies[number].mesh.triangles))


def build(scene: Setup, spans: tuple[Span, ...], device: str) -> Pressures | None:
    """Put the triangles that pressures act on on a device; None where there are none."""
    if not scene.pressures:
        return None
    names = [ply.name for ply in scene.plies]
    corners: list[wp.array] = []
    for pressure in scene.pressures:
        ply, span = scene.plies[names.index(pressure.ply)], spans[names.index(pressure.ply)]
        triangles = np.asarray(ply.mesh.triangles)
        loaded = pressure.triangles(ply.rest_points, triangles)
        vertices = triangles[loaded] + span.first_vertex
        corners.append(wp.array(vertices, dtype=wp.vec3i, device=device))
    rest = np.concatenate([ply.rest_points for ply in scene.plies])
    return Pressures(scene, tuple(corners), rest, device)
