"""The discrete approach: yarns as chains of bars, pinned to each other where they cross.

W = Σ_quadrants A [Φ(ε1, ε2) + Ψ(γ)] + Σ_ties ½ k ‖x_v − Σ w x‖²

A quadrant (`warpdrape.blanks.yarn_net`) is where a warp bar and a weft bar meet. With a law of each
family alone, Φ = Φ1 + Φ2, the sum over a bar's quadrants is a bar of the width that it stands for;
crimp interchange and tables couple the two at their crossover. The couple is on the angle between
the bars themselves. That is the patch kernel's formula with k_α = (x_a − x_o)/l_α, one quadrant a
patch. Bending, in the plane and out of it, is that of the ply (`bending`, `bending_curve`).
"""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import warp as wp
from scipy import sparse

from warpdrape.blanks.ply import Ply
from warpdrape.blanks.yarn_net import YarnNet
from warpdrape.forces import membrane
from warpdrape.forces.curvature import gershgorin
from warpdrape.forces.membrane import (
    Load,
    YarnRates,
    rates_of,
    strain_entries,
    summary_of_softening,
)
from warpdrape.forces.ply_net import net_of, tie_stiffness, yarns_per_bar
from warpdrape.forces.recovery import (
    Recovered,
    measured,
    recovered_by,
    start_recovery,
)
from warpdrape.interaction import Bodies, Launch, Launches, Measured, Run, Share, Span
from warpdrape.kernels.forces.membrane import PatchMemory, make_yarn_membrane
from warpdrape.kernels.forces.ties import Ties, add_tie_forces, measure_ties
from warpdrape.materials.law_data import (
    membrane_functions,
    shear_struct,
    tension_struct,
)
from warpdrape.materials.softening import soften
from warpdrape.numerics import Numerics
from warpdrape.setup import Setup

OVER_TRIANGLES = 3.0
"""Bound on the energy of a net over that of triangles of the same stiffness [-]: a bar stands for
up to twice the area of the triangles along it; the rest is for ties."""


@dataclass(frozen=True, eq=False)
class PlyYarns:
    """One ply's net on a device.

    Attributes:
        ply: the ply.
        span: where its vertices and triangles are in the model's.
        net: the net.
        load: what adds the quadrants' forces.
        measurement: launch (kernel, inputs) of strain, line tension and energy of quadrants.
        ties: what carries the other vertices.
        rates: what of its bars' tensions goes with time.
    """

    ply: Ply
    span: Span
    net: YarnNet
    load: Load
    measurement: tuple
    ties: Ties
    rates: YarnRates

    @property
    def order(self) -> np.ndarray:
        """Its triangles in the order in which parts share out their quadrants."""
        home = self.net.home
        return np.argsort(home.indices[home.indptr[:-1]], kind="stable")

    def launches(
        self,
        quadrants: Run,
        ties: Run,
        x: wp.array,
        memory: wp.array,
        recovered: wp.array,
        f: wp.array,
    ) -> list[Launch]:
        """Launches of a run of its quadrants and one of its ties."""
        found = []
        if quadrants.count:
            found.append(self.load.launch(quadrants, x, self.rates, memory, recovered, f))
        if ties.count:
            found.append(Launch(add_tie_forces, ties.count, [ties.first, self.ties, x], [f]))
        return found

    def start(self) -> wp.array:
        """What its quadrants remember: no strain so far."""
        return wp.zeros(self.load.remembered, self.load.memory, device=self.ties.weight.device)

    def measure(self, x: wp.array) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Yarn strains [-], line tensions [N/m] of triangles; energy [J] of yarns, shear, ties.

        Returns:
            Shapes [triangle, 2], [triangle, 2] and [3].
        """
        n, device = len(self.net.quadrants), x.device
        shown = [wp.empty(n, dtype=d, device=device) for d in (wp.vec2d, wp.vec2d, wp.vec3d)]
        kernel, inputs = self.measurement
        wp.launch(kernel, n, inputs=[*inputs, x], outputs=shown, device=device)
        strain, tension, energy = (array.numpy() for array in shown)
        tied = wp.zeros(len(self.net.carried), dtype=wp.float64, device=device)
        wp.launch(measure_ties, len(tied), inputs=[self.ties, x], outputs=[tied], device=device)
        energies = np.einsum("ij->j", energy)
        energies[2] = tied.numpy().sum()
        return self.net.home @ strain, self.net.home @ tension, energies

    def recovered(self, numerics: Numerics, memory: wp.array) -> Recovered | None:
        """What its bars have recovered; None where they do not."""
        if not memory.shape[0]:
            return None
        tension, *energies = recovered_by(self.ply, numerics, memory.numpy(), self.net.areas)
        return Recovered(self.net.home @ tension, *energies)


@dataclass(frozen=True, eq=False)
class Yarns:
    """The nets of all plies.

    Attributes:
        plies: one for each ply.
        numerics: softening of their yarns, and recovery.
    """

    plies: tuple[PlyYarns, ...]
    numerics: Numerics
    name: str = "membrane"
    searches: str = ""

    @property
    def order(self) -> tuple[np.ndarray, ...]:
        """Each ply's triangles in the order in which parts share out their quadrants."""
        return tuple(of.order for of in self.plies)

    def start(self) -> tuple[wp.array, ...]:
        """For each ply what its quadrants remember, then what they have recovered."""
        return tuple(of.start() for of in self.plies) + tuple(
            start_recovery(of.ply, self.numerics, of.load.remembered, str(of.ties.weight.device))
            for of in self.plies
        )

    def _halves(self, memory: tuple[wp.array, ...]) -> tuple[tuple[wp.array, ...], ...]:
        """Of `start`, what is remembered and what has been recovered."""
        return memory[: len(self.plies)], memory[len(self.plies) :]

    def launches(self, share: Share, bodies: Bodies, memory: tuple[wp.array, ...]) -> Launches:
        """A part's share of every ply's quadrants and ties."""
        scatter = []
        for of, *kept in zip(self.plies, *self._halves(memory), strict=True):
            ours = share.of(len(of.net.quadrants)), share.of(len(of.net.carried))
            scatter += of.launches(*ours, bodies.plies.x, *kept, bodies.plies.f)
        return Launches(scatter=tuple(scatter))

    def measure(self, bodies: Bodies, memory: tuple[wp.array, ...]) -> Measured:
        """Energies, and per ply strain and line tension of its triangles."""
        shown = [of.measure(bodies.plies.x) for of in self.plies]
        energies = np.sum([energy for *_, energy in shown], axis=0)
        stored = dict(zip(("yarn", "shear", "stabiliser"), map(float, energies), strict=True))
        kept, recovered = self._halves(memory)
        lost = {"viscosity": sum(float(m.numpy()["lost"].sum()) for m in kept)}
        beside = [
            of.recovered(self.numerics, own) for of, own in zip(self.plies, recovered, strict=True)
        ]
        yarns = [(strain, tension) for strain, tension, _ in shown]
        return measured(stored, lost, yarns, beside, self.numerics.yarn_softening)

    def ply_entries(self, fields: Mapping[str, np.ndarray]) -> dict[str, float]:
        """What ``summary.json`` says of a ply's yarns."""
        return strain_entries(fields)

    def entries(
        self, history: Mapping[str, np.ndarray], fields: Sequence[Mapping[str, np.ndarray]]
    ) -> tuple[dict, list[str]]:
        """What ``summary.json`` says of all of them, and warnings."""
        found, warnings = summary_of_softening(self.numerics.yarn_softening, history, fields)
        per_bar = {of.ply.name: yarns_per_bar(of.ply, of.net) for of in self.plies}
        return found | {"yarns_per_bar": per_bar}, warnings


def build(scene: Setup, spans: tuple[Span, ...], time_step: float, device: str) -> Yarns:
    """Put the nets of all plies on a device."""
    plies, numerics = zip(scene.plies, spans, strict=True), scene.numerics
    return Yarns(
        tuple(
            build_ply_yarns(ply, numerics, span, rates_of(ply, numerics, time_step), device)
            for ply, span in plies
        ),
        scene.numerics,
    )


def build_ply_yarns(
    ply: Ply, numerics: Numerics, span: Span, rates: YarnRates, device: str
) -> PlyYarns:
    """Put a ply's net on a device."""
    net, fabric = net_of(ply), ply.fabric
    count = len(net.quadrants)

    def integers(values: np.ndarray) -> wp.array:
        return wp.array(values, dtype=wp.int32, device=device)

    add_forces, measure = _kernels(membrane_functions(fabric))
    inputs = [
        integers(np.arange(count + 1)),
        integers(np.arange(count)),
        integers(net.quadrants + span.first_vertex),
        wp.array(net.gradients, dtype=wp.vec4d, device=device),
        wp.array(net.areas, dtype=wp.float64, device=device),
        tension_struct(soften(fabric, numerics.yarn_softening), device),
        shear_struct(fabric, device),
        wp.zeros(count, dtype=wp.float64, device=device),  # a quadrant's strain is its bars'
        fabric.yarn_angle,
    ]
    ties = Ties()
    ties.first = integers(net.ties.indptr)
    ties.vertex = integers(net.ties.indices + span.first_vertex)
    ties.weight = wp.array(net.ties.data, dtype=wp.float64, device=device)
    ties.stiffness = wp.array(tie_stiffness(ply, numerics), dtype=wp.float64, device=device)
    load = Load(add_forces, count, [0, *inputs], PatchMemory, count)
    return PlyYarns(ply, span, net, load, (measure, inputs), ties, rates)


@functools.cache
def _kernels(functions: tuple) -> tuple:
    return make_yarn_membrane(*functions)


def sheet_stiffness(ply: Ply, numerics: Numerics) -> tuple[tuple[float, float], float]:
    """Bounds as `membrane.sheet_stiffness`, of triangles that store no less than the net [N/m]."""
    (warp, weft), shear = membrane.sheet_stiffness(ply, numerics)
    return (OVER_TRIANGLES * warp, OVER_TRIANGLES * weft), OVER_TRIANGLES * shear


def frequencies(scene: Setup, number: int) -> np.ndarray:
    """Bound on ω² [1/s²] of each triangle of a ply, given its number.

    By row sums of the sizes of the matrix's entries, whatever the directions of the bars:
    A n_α d_α d_αᵀ of every quadrant's bars, d = (−1, 1)/l; A s g gᵀ of its couple, ‖∂γ/∂x‖ ≤ g,
    1/l1 and 1/l2 at the ends and their sum at the crossover; k c cᵀ of the ties.
    """
    ply, numerics = scene.plies[number], scene.numerics
    net = net_of(ply)
    yarns, shear = membrane.sheet_stiffness(ply, numerics)
    one, two = 1.0 / np.abs(net.lengths.T)
    none = np.zeros_like(one)
    parts = (
        (yarns[0], np.column_stack([one, one, none])),
        (yarns[1], np.column_stack([two, none, two])),
    )
    local = sum(
        (k * net.areas)[:, None, None] * size[:, :, None] * size[:, None, :] for k, size in parts
    )
    n = len(ply.mesh.vertices)
    return bound_of(ply, numerics, assembled(net.quadrants, local + couple_rows(net, shear), n))


def couple_rows(net: YarnNet, shear: float) -> np.ndarray:
    """Sizes of the couples' entries [N/m] by quadrant, shape [quadrant, 3, 3].

    Args:
        net: the net.
        shear: bound on their stiffness [N/m].
    """
    one, two = 1.0 / np.abs(net.lengths.T)
    size = np.column_stack([one + two, one, two])
    return (shear * net.areas)[:, None, None] * size[:, :, None] * size[:, None, :]


def assembled(places: np.ndarray, local: np.ndarray, n: int) -> sparse.coo_matrix:
    """Matrix of n rows from those of elements, shape [element, k, k], at places [element, k]."""
    k = places.shape[1]
    rows, columns = np.repeat(places, k, axis=1), np.tile(places, (1, k))
    return sparse.coo_matrix((local.ravel(), (rows.ravel(), columns.ravel())), shape=(n, n))


def bound_of(ply: Ply, numerics: Numerics, matrix: sparse.spmatrix) -> np.ndarray:
    """Bound on ω² [1/s²] of each triangle by sizes of entries [N/m]; the ties' are added."""
    ties = abs(net_of(ply).ties)
    matrix = matrix + ties.T @ sparse.diags(tie_stiffness(ply, numerics)) @ ties
    masses = ply.fabric.areal_density * np.asarray(ply.mesh.areas)
    return gershgorin(matrix.tocsr(), np.asarray(ply.mesh.triangles), masses)
