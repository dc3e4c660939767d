"""Bending by curves M(κ) with friction between fibres: rows by triangle, launches, energies.

Curvatures are those of `curvature`; the law acts on their part out of the plane in every triangle.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import cast

import numpy as np
import warp as wp
from scipy import sparse

from warpdrape.errors import InputError
from warpdrape.forces.curvature import (
    CurvatureOperator,
    curvatures_of,
    gershgorin,
    largest_curvatures,
    out_of_plane,
)
from warpdrape.interaction import Bodies, Launch, Launches, Measured, Share, Span
from warpdrape.kernels.forces.bending_curve import (
    BendingLaw,
    CurvatureRows,
    FrictionMemory,
    add_curve_forces,
    measure_curve,
)
from warpdrape.kernels.materials.shear import ShearCurve
from warpdrape.materials.bending import BendingCurve
from warpdrape.setup import Setup


@dataclass(frozen=True, eq=False)
class PlyBendingCurve:
    """Bending of one ply.

    Attributes:
        span: where the ply is in the model.
        operator: its curvatures.
        start: what held slopes add to them [1/m], shape [triangle, 3, 3].
        rows: the same for the kernel.
        law: moments for the kernel.
        onset: stiffness of the friction at its start, warp and weft [N·m].
    """

    span: Span
    operator: CurvatureOperator
    start: np.ndarray
    rows: CurvatureRows
    law: BendingLaw
    onset: tuple[float, float]


@dataclass(frozen=True, eq=False)
class BendingCurves:
    """Bending of all plies whose card has curves.

    Attributes:
        plies: by number of the ply.
        scene: what is computed.
    """

    plies: Mapping[int, PlyBendingCurve]
    scene: Setup
    name: str = "bending curves"
    searches: str = ""

    def start(self) -> tuple[wp.array, ...]:
        """Friction of each ply's triangles: none so far."""
        return tuple(
            wp.zeros(of.span.triangle_count, dtype=FrictionMemory, device=of.rows.areas.device)
            for of in self.plies.values()
        )

    def launches(self, share: Share, bodies: Bodies, memory: tuple[wp.array, ...]) -> Launches:
        """A part's share of every ply's triangles."""
        scatter = []
        for bending, kept in zip(self.plies.values(), memory, strict=True):
            first, count = share.of(bending.span.triangle_count)
            if count:
                inputs = [first, bending.rows, bending.law, bodies.plies.x]
                scatter.append(Launch(add_curve_forces, count, inputs, [kept, bodies.plies.f]))
        return Launches(scatter=tuple(scatter))

    def measure(self, bodies: Bodies, memory: tuple[wp.array, ...]) -> Measured:
        """Energies, what friction lost, and per ply the curvatures of its yarns at vertices."""
        x, stored, lost = bodies.plies.x, 0.0, 0.0
        positions = x.numpy()
        fields: list[Mapping[str, np.ndarray]] = [{} for _ in self.scene.plies]
        for (number, bending), kept in zip(self.plies.items(), memory, strict=True):
            count = bending.span.triangle_count
            bent = wp.empty(count, dtype=wp.vec2d, device=x.device)
            energy = wp.empty(count, dtype=wp.float64, device=x.device)
            inputs = [bending.rows, bending.law, x]
            wp.launch(measure_curve, count, inputs, outputs=[bent, energy], device=x.device)
            friction, areas = kept.numpy(), bending.operator.areas
            onset = np.maximum(bending.onset, 1e-300)
            spring = (0.5 * friction["moment"] ** 2 / onset).sum(axis=1)
            stored += float(energy.numpy().sum() + areas @ spring)
            lost += float(areas @ (friction["work"] - spring))
            points = positions[bending.span.vertices]
            curvature = (bending.operator.rows @ points).reshape(-1, 3, 3) + bending.start
            shown = out_of_plane(self.scene.plies[number], points, curvature[:, :2])
            fields[number] = {"curvature": shown}
        lost_by = {"fibre_friction": lost}
        return Measured({"bending_curves": stored}, lost_by, tuple(fields))

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
    found = _operators(scene)[number]
    if found is None:
        return np.zeros(len(triangles))
    operator, law = found
    matrix, _, _ = operator.stiffness(law.stiffest)
    return gershgorin(matrix, triangles, ply.fabric.areal_density * operator.areas)


@lru_cache(maxsize=2)
def _operators(scene: Setup) -> tuple[tuple[CurvatureOperator, BendingCurve] | None, ...]:
    """Per ply its operator and law, None where no curve is given; kept for the last scene."""
    laws = [ply.fabric.bending for ply in scene.plies]
    return tuple(
        (curvatures_of(scene, number), law) if isinstance(law, BendingCurve) else None
        for number, law in enumerate(laws)
    )


def build(scene: Setup, spans: tuple[Span, ...], device: str) -> BendingCurves | None:
    """Put the bending of all plies on a device; None where no card has a curve.

    Raises:
        InputError: if a clamp that turns holds the slope of such a ply.
    """
    plies = {
        number: _build_ply(scene, number, span, *found, device)
        for number, (found, span) in enumerate(zip(_operators(scene), spans, strict=True))
        if found is not None
    }
    return BendingCurves(plies, scene) if plies else None


def _build_ply(
    scene: Setup,
    number: int,
    span: Span,
    operator: CurvatureOperator,
    law: BendingCurve,
    device: str,
) -> PlyBendingCurve:
    ply = scene.plies[number]
    for clamp in scene.clamps:
        if clamp.ply == ply.name and clamp.slope == "held" and clamp.matrix is not None:
            raise InputError(
                f"clamp {clamp.name!r} turns the slope of ply {ply.name!r}, whose bending is a "
                "curve: give the clamp slope='free', or the fabric a linear bending"
            )
    flat = np.tile(np.eye(3)[:2], (operator.slopes.shape[1] // 2, 1)).reshape(-1, 3)
    start = (operator.slopes @ flat).reshape(-1, 3, 3)
    return PlyBendingCurve(
        span,
        operator,
        start,
        _rows(operator, start, np.asarray(ply.mesh.triangles), span, device),
        _law(law, device),
        law.onset,
    )


def _rows(
    operator: CurvatureOperator, start: np.ndarray, triangles: np.ndarray, span: Span, device: str
) -> CurvatureRows:
    """Rows of κ1, κ2 and κ12 together, by triangle."""
    entries: sparse.coo_matrix = operator.rows.tocoo()
    n = operator.rows.shape[1]
    key, place = np.unique(
        (entries.row // 3).astype(np.int64) * n + entries.col, return_inverse=True
    )
    weights = np.zeros((len(key), 3))
    np.add.at(weights, (place, entries.row % 3), entries.data)
    counts = np.bincount(key // n, minlength=len(triangles))
    rows = CurvatureRows()
    rows.first = wp.array(np.r_[0, np.cumsum(counts)], dtype=wp.int32, device=device)
    rows.vertex = wp.array(key % n + span.first_vertex, dtype=wp.int32, device=device)
    rows.weights = wp.array(weights, dtype=wp.vec3d, device=device)
    rows.start = wp.array(start, dtype=wp.vec3d, device=device)
    rows.corners = wp.array(triangles + span.first_vertex, dtype=wp.int32, device=device)
    rows.areas = wp.array(operator.areas, dtype=wp.float64, device=device)
    return rows


def _law(bending: BendingCurve, device: str) -> BendingLaw:
    law = BendingLaw()
    law.warp = _curve(bending, np.asarray(bending.moments_warp), device)
    law.weft = _curve(bending, np.asarray(bending.moments_weft), device)
    law.in_plane = wp.vec2d(*cast(tuple[float, float], bending.in_plane))
    law.twist = bending.twist
    law.yield_moment = wp.vec2d(*bending.friction)
    law.onset = wp.vec2d(*bending.onset)
    return law


def _curve(bending: BendingCurve, moments: np.ndarray, device: str) -> ShearCurve:
    """A monotone curve through points, odd, linear past the last; its energies at the points."""
    at, slopes = np.asarray(bending.curvatures), bending.slopes(moments)
    steps = np.diff(at)
    mean = 0.5 * (moments[:-1] + moments[1:]) + steps * (slopes[:-1] - slopes[1:]) / 12.0
    curve = ShearCurve()
    for name, values in (
        ("angles", at),
        ("couples", moments),
        ("slopes", slopes),
        ("energies", np.r_[0.0, np.cumsum(steps * mean)]),
    ):
        setattr(curve, name, wp.array(values, dtype=wp.float64, device=device))
    return curve
