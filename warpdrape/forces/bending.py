"""Bending of the plies: matrices on a device, launches, energy, bound on ω², curvatures.

The energy is quadratic in positions with constant coefficients, so the forces are f = −K x − R M:
K from `curvature`, M the matrices of clamps, which hold the ply's slope where they hold it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
import warp as wp
from scipy import sparse

from warpdrape.forces.curvature import (
    CurvatureOperator,
    curvatures_of,
    gershgorin,
    largest_curvatures,
    out_of_plane,
)
from warpdrape.interaction import Bodies, Launch, Launches, Measured, Share, Span
from warpdrape.kernels.forces.bending import (
    Rows,
    Slopes,
    add_bending_forces,
    add_slope_forces,
    add_slope_work,
)
from warpdrape.materials.bending import Bending
from warpdrape.setup import Setup

NEGLIGIBLE = 1e-13
"""Entries of K below this share of the largest are rounding [-]."""


class PlyMatrices(NamedTuple):
    """What resists bending in one ply.

    Attributes:
        operator: its curvatures.
        matrix: K between vertices [N/m], shape [vertex, vertex].
        slopes: between vertices and clamps' slopes [N], shape [vertex, 2 · clamp].
        between: between slopes [N·m], shape [2 · clamp, 2 · clamp].
        moduli: of the curvatures [N·m], shape [3, 3].
    """

    operator: CurvatureOperator
    matrix: sparse.csr_matrix
    slopes: sparse.csr_matrix
    between: np.ndarray
    moduli: np.ndarray


@dataclass(frozen=True, eq=False)
class PlyBending:
    """Bending of one ply.

    Attributes:
        span: where the ply is in the model.
        operator: its curvatures.
        moduli: of them [N·m], shape [3, 3].
        rows: K for the kernel.
        slopes: what clamps' slopes do, None where none is held.
        turning: whether any of these clamps turns or distorts.
    """

    span: Span
    operator: CurvatureOperator
    moduli: np.ndarray
    rows: Rows
    slopes: Slopes | None
    turning: bool


@dataclass(frozen=True, eq=False)
class Bendings:
    """Bending of all plies that have it.

    Attributes:
        plies: by number of the ply.
        ply_count: how many plies there are.
        scene: what is computed.
        spans: where plies are.
    """

    plies: Mapping[int, PlyBending]
    scene: Setup
    spans: tuple[Span, ...]
    name: str = "bending"
    searches: str = ""

    def start(self) -> tuple[wp.array, ...]:
        """For each ply by what its clamps' slopes turned in the step before, shape [2 · clamp]."""
        return tuple(
            wp.zeros(2 * len(self.scene.clamps), dtype=wp.vec3d, device=bending.rows.first.device)
            for bending in self.plies.values()
        )

    def launches(self, share: Share, bodies: Bodies, memory: tuple[wp.array, ...]) -> Launches:
        """Rows of a part's own vertices."""
        scatter, push = [], []
        x, f = bodies.plies.x, bodies.plies.f
        clamps = len(self.scene.clamps)
        for (number, bending), turned in zip(self.plies.items(), memory, strict=True):
            offset = bending.span.first_vertex
            if bending.slopes is not None:
                bending.slopes.steps = bodies.clamps.matrix.shape[0] // clamps
            for first, count in share.by_ply[number]:
                scatter.append(
                    Launch(add_bending_forces, count, [first, offset, bending.rows, x], [f])
                )
                if bending.slopes is not None:
                    inputs = [first, offset, bending.slopes, bodies.step, bodies.clamps.matrix]
                    push.append(Launch(add_slope_forces, count, inputs, [f]))
            if bending.turning and share.number == 0:  # it alone counts the steps
                inputs = [bending.slopes, bodies.step, bodies.clamps.matrix, x]
                outputs = [turned, bodies.clamps.work]
                scatter.append(Launch(add_slope_work, clamps, inputs, outputs))
        return Launches(scatter=tuple(scatter), push=tuple(push))

    def measure(self, bodies: Bodies, memory: tuple[wp.array, ...]) -> Measured:
        """Energy, and per ply the curvatures of its yarns at vertices."""
        x = bodies.plies.x.numpy()
        stored, columns = 0.0, self._columns(bodies)
        fields: list[Mapping[str, np.ndarray]] = [{} for _ in self.spans]
        for number, bending in self.plies.items():
            points, operator = x[bending.span.vertices], bending.operator
            curvature = operator.rows @ points
            curvature += operator.slopes @ columns[: operator.slopes.shape[1]]
            curvature = curvature.reshape(-1, 3, 3)  # triangle, (κ1, κ2, κ12), component
            moments = np.einsum("ij,tjc->tic", bending.moduli, curvature)
            stored += 0.5 * operator.areas @ np.einsum("tic,tic->t", curvature, moments)
            bent = out_of_plane(self.scene.plies[number], points, curvature[:, :2])
            fields[number] = {"curvature": bent}
        return Measured({"bending": float(stored)}, fields=tuple(fields))

    def _columns(self, bodies: Bodies) -> np.ndarray:
        """First two columns of the clamps' matrices now, shape [2 · clamp, 3]."""
        clamps = len(self.scene.clamps)
        if not clamps:
            return np.zeros((0, 3))
        step = int(bodies.step.numpy()[0])
        now = bodies.clamps.matrix.numpy().reshape(clamps, -1, 3, 3)[:, step]
        return np.swapaxes(now, 1, 2)[:, :2].reshape(-1, 3)

    def ply_entries(self, fields: Mapping[str, np.ndarray]) -> dict[str, float]:
        """What ``summary.json`` says of a ply's bending."""
        return largest_curvatures(fields)

    def entries(
        self, history: Mapping[str, np.ndarray], fields: Sequence[Mapping[str, np.ndarray]]
    ) -> tuple[dict[str, float], list[str]]:
        """Nothing to say of all plies together."""
        return {}, []


def frequencies(scene: Setup, number: int) -> np.ndarray:
    """Bound on ω² [1/s²] of each triangle of a ply, 0 where it has no such bending."""
    ply = scene.plies[number]
    triangles = np.asarray(ply.mesh.triangles)
    found = _matrices(scene)[number]
    if found is None:
        return np.zeros(len(triangles))
    return gershgorin(found.matrix, triangles, ply.fabric.areal_density * found.operator.areas)


@lru_cache(maxsize=2)
def _matrices(scene: Setup) -> tuple[PlyMatrices | None, ...]:
    """What each ply resists bending with, None where nothing does.

    Kept for the scene that was asked for last: the step's bound and the forces both need them.
    """
    found: dict[Any, PlyMatrices | None] = {}
    alike = [_alike(scene, number) for number in range(len(scene.plies))]
    for number, kind in enumerate(alike):
        if kind not in found:
            found[kind] = _of_ply(scene, number)
    return tuple(found[kind] for kind in alike)


def _alike(scene: Setup, number: int) -> Any:
    """What is equal for plies that bend alike: most of a stack."""
    ply = scene.plies[number]
    held = any(clamp.ply == ply.name and clamp.slope == "held" for clamp in scene.clamps)
    return (
        number
        if held
        else (
            ply.mesh,
            ply.warp_angle,
            ply.fabric.yarn_angle,
            ply.fabric.bending,
        )
    )


def _of_ply(scene: Setup, number: int) -> PlyMatrices | None:
    ply = scene.plies[number]
    law = ply.fabric.bending
    if not ply.fabric.bends or not isinstance(law, Bending):
        return None
    operator = curvatures_of(scene, number)
    matrix, slopes, between = operator.stiffness(law.moduli)
    matrix.data[np.abs(matrix.data) < NEGLIGIBLE * np.abs(matrix.data).max()] = 0.0
    matrix.eliminate_zeros()
    matrix.sort_indices()
    return PlyMatrices(operator, matrix, slopes, between.toarray(), law.moduli)


def build(scene: Setup, spans: tuple[Span, ...], device: str) -> Bendings | None:
    """Put the bending of all plies on a device; None where no ply has any."""
    found = zip(_matrices(scene), spans, strict=True)
    plies = {
        number: _build_ply(scene, number, span, matrices, device)
        for number, (matrices, span) in enumerate(found)
        if matrices is not None
    }
    return Bendings(plies, scene, spans) if plies else None


def _build_ply(
    scene: Setup,
    number: int,
    span: Span,
    matrices: PlyMatrices,
    device: str,
) -> PlyBending:
    ply, matrix = scene.plies[number], matrices.matrix
    rows = Rows()
    rows.first = wp.array(matrix.indptr, dtype=wp.int32, device=device)
    rows.vertex = wp.array(matrix.indices + span.first_vertex, dtype=wp.int32, device=device)
    rows.value = wp.array(matrix.data, dtype=wp.float64, device=device)
    holding = [clamp.ply == ply.name and clamp.slope == "held" for clamp in scene.clamps]
    return PlyBending(
        span,
        matrices.operator,
        matrices.moduli,
        rows,
        _slopes(scene, number, span, matrices, device) if any(holding) else None,
        any(h and clamp.matrix is not None for h, clamp in zip(holding, scene.clamps, strict=True)),
    )


def _slopes(
    scene: Setup,
    number: int,
    span: Span,
    matrices: PlyMatrices,
    device: str,
) -> Slopes:
    """Entries of vertices and clamps, both columns of a clamp's matrix together."""
    ply, clamps = scene.plies[number], len(scene.clamps)
    full = np.zeros((2 * clamps, 2 * clamps))
    full[: len(matrices.between), : len(matrices.between)] = matrices.between
    pairs = matrices.slopes.tocoo()
    key, place = np.unique(
        pairs.row.astype(np.int64) * clamps + pairs.col // 2, return_inverse=True
    )
    values = np.zeros((len(key), 2))
    np.add.at(values, (place, pairs.col % 2), pairs.data)
    vertex, clamp = key // clamps, key % clamps
    by_clamp = np.argsort(clamp, kind="stable")
    anchors = [
        span.first_vertex + c.vertices(ply.rest_points)[0] if c.ply == ply.name else -1
        for c in scene.clamps
    ]

    def integers(array: np.ndarray) -> wp.array:
        return wp.array(array, dtype=wp.int32, device=device)

    slopes = Slopes()
    slopes.first_of_vertex = integers(_starts(vertex, span.vertex_count))
    slopes.clamp = integers(clamp)
    slopes.on_vertex = wp.array(values, dtype=wp.vec2d, device=device)
    slopes.first_of_clamp = integers(_starts(clamp, clamps))
    slopes.vertex = integers(vertex[by_clamp] + span.first_vertex)
    slopes.on_clamp = wp.array(values[by_clamp], dtype=wp.vec2d, device=device)
    slopes.between = wp.array(full, dtype=wp.float64, device=device)
    slopes.anchor = integers(np.array(anchors))
    return slopes


def _starts(owners: np.ndarray, count: int) -> np.ndarray:
    """Where the entries of each of ``count`` owners begin in a sorted list, and their end."""
    return np.r_[0, np.cumsum(np.bincount(owners, minlength=count))]
