"""The viscous shear of prepregs: plies with a matrix on a device, launches, energies, bound."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import warp as wp

from warpdrape.blanks.ply import Ply
from warpdrape.blanks.triangles import flat_gradients, gradient_products
from warpdrape.interaction import Bodies, Launch, Launches, Measured, Share, Span
from warpdrape.kernels.forces.matrix import (
    MatrixLaw,
    MatrixMemory,
    add_matrix_forces,
    compute_passed,
)
from warpdrape.materials.fabric import Fabric
from warpdrape.materials.law_data import tension_stiffness
from warpdrape.materials.matrix import Matrix
from warpdrape.materials.softening import soften
from warpdrape.materials.viscosity_data import shift_struct, viscosity_struct
from warpdrape.numerics import Numerics
from warpdrape.setup import Setup
from warpdrape.state import MOST_PARTS

SERIES = 0.05
"""Stiffness of the spring in series with a liquid that has none of its own, over the yarns' [-]: it
takes less than a tenth of the step, and turns by a few hundredths of a degree."""
LAG_WARNING = 1.0
"""Turn of that spring above which a run warns [deg]."""
COLD_WARNING = 1e-3
"""Share of a ply colder than its law knows above which a run warns [-]."""


@dataclass(frozen=True, eq=False)
class PlyMatrix:
    """The matrix of one ply.

    Attributes:
        span: where the ply is in the model.
        law: for the kernel.
        triangles: vertices in the model's numbering, shape [triangle, 3].
        gradients: D [1/m], shape [triangle].
        areas: initial areas [m²], shape [triangle].
        rest_angle: from warp to weft in the flat ply [rad].
        lags: whether its spring is one of the computation, not of the card.
        lowest: temperature down to which its law holds [K]; None where it has none.
    """

    span: Span
    law: MatrixLaw
    triangles: wp.array
    gradients: wp.array
    areas: wp.array
    rest_angle: float
    lags: bool
    lowest: float | None

    def launch(
        self, share: Share, bodies: Bodies, passed: wp.array, memory: wp.array
    ) -> tuple[Launch, ...]:
        """A part's share of its triangles."""
        first, count = share.of(self.span.triangle_count)
        if not count:
            return ()
        warmth = bodies.cooling.temperature if self.law.cools else self.areas  # not read
        inputs = [first, self.triangles, self.gradients, self.areas, self.law, self.rest_angle]
        inputs += [bodies.plies.x, warmth, share.number, passed]
        return (Launch(add_matrix_forces, count, inputs, [memory, bodies.plies.f]),)


@dataclass(frozen=True, eq=False)
class MatrixState:
    """What matrices remember.

    Attributes:
        triangles: of each ply that has one, shape [triangle].
        passed: time of the process in the last step, for each part of the model [s], shape [part].
    """

    triangles: tuple[wp.array, ...]
    passed: wp.array


@dataclass(frozen=True, eq=False)
class Matrices:
    """The matrices of all plies that have one.

    Attributes:
        plies: by number of the ply.
        names: of all plies.
    """

    plies: Mapping[int, PlyMatrix]
    names: tuple[str, ...]
    name: str = "matrix"
    searches: str = ""

    def start(self) -> MatrixState:
        """At rest, and flat."""
        device = next(iter(self.plies.values())).areas.device
        triangles = tuple(
            wp.zeros(of.span.triangle_count, dtype=MatrixMemory, device=device)
            for of in self.plies.values()
        )
        return MatrixState(triangles, wp.zeros(MOST_PARTS, dtype=wp.float64, device=device))

    def launches(self, share: Share, bodies: Bodies, memory: MatrixState) -> Launches:
        """A part's share of every ply's triangles."""
        scatter: tuple[Launch, ...] = ()
        for of, kept in zip(self.plies.values(), memory.triangles, strict=True):
            scatter += of.launch(share, bodies, memory.passed, kept)
        clock = [share.number, bodies.loads.process, bodies.step]
        push = (Launch(compute_passed, 1, clock, [memory.passed]),)
        return Launches(scatter=scatter, push=push)

    def measure(self, bodies: Bodies, memory: MatrixState) -> Measured:
        """Energy in the springs, what the viscosity lost, and temperatures at vertices."""
        stored, lost, lag = 0.0, 0.0, 0.0
        fields: list[Mapping[str, np.ndarray]] = [{} for _ in self.names]
        readings: dict[str, float] = {}
        for (number, of), kept in zip(self.plies.items(), memory.triangles, strict=True):
            known = kept.numpy()
            turned = known["couple"] / of.law.stiffness
            stored += 0.5 * float(of.areas.numpy() @ (known["couple"] * turned))
            lost += float(known["lost"].sum())
            if of.lags:
                lag = max(lag, math.degrees(float(np.abs(turned).max())))
            if of.law.cools:
                warmth = bodies.cooling.temperature.numpy()[of.span.vertices]
                fields[number] = {"temperature": warmth}
                readings[f"{self.names[number]}_mean_temperature_k"] = float(warmth.mean())
        readings["matrix_lag_deg"] = lag
        return Measured(
            {"matrix": stored},
            {"matrix_viscosity": lost},
            tuple(fields),
            flowed=lost,
            readings=readings,
        )

    def ply_entries(self, fields: Mapping[str, np.ndarray]) -> dict[str, float]:
        """What ``summary.json`` says of a ply's temperature."""
        if "temperature" not in fields:
            return {}
        warmth = fields["temperature"]
        return {
            "min_temperature_k": float(warmth.min()),
            "mean_temperature_k": float(warmth.mean()),
            "max_temperature_k": float(warmth.max()),
        }

    def entries(
        self, history: Mapping[str, np.ndarray], fields: Sequence[Mapping[str, np.ndarray]]
    ) -> tuple[dict[str, float], list[str]]:
        """How far the springs in series turned, and warnings: of that, and of cold plies."""
        lag = float(history["matrix_lag_deg"].max())
        found = {"matrix_lag_deg": lag}
        warnings = []
        if lag > LAG_WARNING:
            warnings.append(
                f"shear lags {lag:.2g}° behind where the matrix alone would let it be: leave out "
                "yarn_softening (fast), or look whether the matrix is that viscous at these rates"
            )
        for number, of in self.plies.items():
            if of.lowest is None or "temperature" not in fields[number]:
                continue
            warmth = fields[number]["temperature"]
            cold = float((warmth < of.lowest).mean())
            if cold > COLD_WARNING:
                warnings.append(
                    f"ply {self.names[number]!r} cools to {warmth.min():.4g} K, below the lowest "
                    f"of its matrix's data, {of.lowest:.4g} K, on {100 * cold:.2g} % of the ply: "
                    "it counts as liquid there; form it hotter or faster"
                )
        return found, warnings


def build(scene: Setup, spans: tuple[Span, ...], device: str) -> Matrices | None:
    """Put the matrices of all plies on a device; None where there is none."""
    plies = {
        number: _build_ply(scene, ply, matrix, span, device)
        for number, (ply, span) in enumerate(zip(scene.plies, spans, strict=True))
        if (matrix := ply.fabric.matrix) is not None
    }
    return Matrices(plies, tuple(ply.name for ply in scene.plies)) if plies else None


def frequencies(scene: Setup, number: int) -> np.ndarray:
    """Bound on ω² [1/s²] of each triangle of a ply, 0 without a matrix.

    A step is as stiff as the spring in series at most, whatever the viscosity: with c = q G Δt and
    the couple before times q, 0 ≤ q < 1, the roots stay within one while (Δt ω)² ≤ 2 (1 + q)/q.
    """
    ply = scene.plies[number]
    gradients, areas = flat_gradients(ply)
    if ply.fabric.matrix is None:
        return np.zeros(len(areas))
    d1, d2, _ = gradient_products(gradients)
    stiffness = series_stiffness(ply.fabric, scene.numerics)
    return 3.0 / ply.fabric.areal_density * stiffness * (np.sqrt(d1) + np.sqrt(d2)) ** 2


def series_stiffness(fabric: Fabric, numerics: Numerics) -> float:
    """G of the spring in series with the viscosity [N/m]."""
    matrix = fabric.matrix
    if matrix is not None and matrix.modulus is not None:
        return matrix.modulus * fabric.thickness
    return SERIES * max(tension_stiffness(soften(fabric, numerics.yarn_softening)))


def _build_ply(scene: Setup, ply: Ply, matrix: Matrix, span: Span, device: str) -> PlyMatrix:
    gradients, areas = flat_gradients(ply)
    triangles = np.asarray(ply.mesh.triangles, dtype=np.int32) + span.first_vertex
    return PlyMatrix(
        span,
        _law(scene, ply, matrix),
        wp.array(triangles, dtype=wp.int32, device=device),
        wp.array(gradients, dtype=wp.vec4d, device=device),
        wp.array(areas, dtype=wp.float64, device=device),
        ply.fabric.yarn_angle,
        matrix.modulus is None,
        None if matrix.shift is None else matrix.shift.lowest_temperature,
    )


def _law(scene: Setup, ply: Ply, matrix: Matrix) -> MatrixLaw:
    law = MatrixLaw()
    law.viscosity = viscosity_struct(matrix.viscosity)
    law.shift = shift_struct(matrix.shift)
    law.thickness = ply.fabric.thickness
    law.rise = wp.vec2d(*matrix.rise)
    law.stiffness = series_stiffness(ply.fabric, scene.numerics)
    law.temperature = ply.warmth or 0.0
    law.cools = int(scene.cools(ply))
    return law
