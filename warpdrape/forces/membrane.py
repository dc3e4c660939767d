"""The plies' membranes: their yarns and shear on a device, launches, energies, bound on ω²."""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import warp as wp

from warpdrape.blanks.ply import Ply
from warpdrape.blanks.triangles import flat_gradients, highest_frequency_squared
from warpdrape.forces.membrane_stiffness import (
    patch_stabilisers,
    sheet_stiffness,
    yarn_viscosity,
)
from warpdrape.forces.pairs import arrange_pairs, patches_of
from warpdrape.forces.recovery import (
    Recovered,
    measured,
    recovered_by,
    recovery_rates,
    start_recovery,
)
from warpdrape.interaction import Bodies, Launch, Launches, Measured, Run, Share, Span
from warpdrape.kernels.forces import membrane as kernels
from warpdrape.kernels.forces import sheet
from warpdrape.kernels.forces.pairs import PairMemory, TwoPairs, make_pair_forces
from warpdrape.kernels.forces.recovery import Recovery, RecoveryRates
from warpdrape.materials.law_data import (
    membrane_functions,
    shear_struct,
    tension_struct,
)
from warpdrape.materials.laws import IsotropicMembrane, MooneyRivlin, Unwoven
from warpdrape.materials.softening import (
    recovery_warnings,
    soften,
    softening_entries,
    softening_warnings,
)
from warpdrape.numerics import Numerics
from warpdrape.setup import Setup

_SHEETS = {
    IsotropicMembrane: (sheet.add_isotropic_forces, sheet.measure_isotropic),
    MooneyRivlin: (sheet.add_rubber_forces, sheet.measure_rubber),
}
"""Kernels of the forces, and of what is shown, of sheets without yarns."""


class YarnRates(NamedTuple):
    """What of a ply's yarn tensions goes with time."""

    viscosity: tuple[float, float]
    """Of warp and weft, line tension per change of strain in a step [N/m]."""
    recovery: RecoveryRates
    """At which they recover what softening withholds."""


def without_rates() -> YarnRates:
    """Those of yarns whose tensions time has no part in."""
    return YarnRates((0.0, 0.0), RecoveryRates())


def rates_of(ply: Ply, numerics: Numerics, time_step: float) -> YarnRates:
    """Those of a ply, for steps of Δt [s]."""
    return YarnRates(yarn_viscosity(ply.fabric, numerics), recovery_rates(ply, numerics, time_step))


class Load(NamedTuple):
    """Elements whose forces one kernel adds."""

    kernel: Any
    count: int  # type: ignore[assignment]  # in place of tuple.count, which nobody asks for
    inputs: list
    """The number of the first element counted, then what the kernel reads."""
    memory: Any = None
    """Struct of what an element remembers, None for nothing."""
    remembered: int = 0
    """Elements from number 0 on that remember."""

    def launch(
        self,
        run: Run,
        x: wp.array,
        rates: YarnRates,
        memory: wp.array | None,
        recovered: wp.array,
        f: wp.array,
    ) -> Launch:
        """Launch of a run of them."""
        inputs = [self.inputs[0] + run.first, *self.inputs[1:]]
        if self.memory is None:
            return Launch(self.kernel, run.count, [*inputs, x], [f])
        inputs += [wp.vec2d(*rates.viscosity), rates.recovery, x]
        return Launch(self.kernel, run.count, inputs, [memory, recovered, f])


@dataclass(frozen=True, eq=False)
class Membrane:
    """One ply's triangles on the device.

    Attributes:
        ply: the ply.
        span: where its vertices and triangles are in the model's.
        triangles: vertices in the model's numbering, shape [triangle, 3].
        gradients: D [1/m], shape [triangle].
        areas: initial areas [m²], shape [triangle].
        loads: what adds its forces.
        rates: what of its yarns' tensions goes with time.
        patches: first member of each patch, and their number, shape [patch + 1].
        order: its triangles as the loads take them, by patch, shape [triangle].
        measurement: launch (kernel, count, inputs) of strain, line tension and energy.
    """

    ply: Ply
    span: Span
    triangles: wp.array
    gradients: wp.array
    areas: wp.array
    loads: tuple[Load, ...]
    rates: YarnRates
    patches: np.ndarray
    order: np.ndarray
    measurement: tuple[Any, int, list]

    def add_forces(self, x: wp.array, f: wp.array) -> None:
        """Add the membrane's forces [N] at positions x [m] to f, those that time has no part in."""
        recovered = wp.empty(0, Recovery, device=x.device)
        for load in self.loads:
            memory = None if load.memory is None else wp.empty(0, load.memory, device=x.device)
            load.launch(Run(0, load.count), x, without_rates(), memory, recovered, f)(x.device)

    def measure(self, x: wp.array) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Yarn strains [-], line tensions [N/m] and (yarn, shear, stabiliser) energy [J].

        Returns:
            Shapes [triangle, 2], [triangle, 2] and [triangle, 3].
        """
        n, device = self.span.triangle_count, x.device
        shown = [wp.empty(n, dtype=d, device=device) for d in (wp.vec2d, wp.vec2d, wp.vec3d)]
        kernel, count, inputs = self.measurement
        wp.launch(kernel, count, inputs=[*inputs, x], outputs=shown, device=device)
        return tuple(array.numpy() for array in shown)

    def recovered(self, numerics: Numerics, memory: wp.array) -> Recovered | None:
        """What its yarns have recovered; None where they do not."""
        if not memory.shape[0]:
            return None
        areas = np.add.reduceat(self.areas.numpy()[self.order], self.patches[:-1])
        tension, *energies = recovered_by(self.ply, numerics, memory.numpy(), areas)
        of_triangle = np.empty((len(self.order), 2))
        of_triangle[self.order] = np.repeat(tension, np.diff(self.patches), axis=0)
        return Recovered(of_triangle, *energies)


@dataclass(frozen=True, eq=False)
class Membranes:
    """The membranes of all plies.

    Attributes:
        plies: one for each ply.
        numerics: softening of their yarns, and recovery.
        woven: which plies have yarns.
    """

    plies: tuple[Membrane, ...]
    numerics: Numerics
    woven: tuple[bool, ...]
    name: str = "membrane"
    searches: str = ""

    @property
    def order(self) -> tuple[np.ndarray, ...]:
        """Each ply's triangles in the order in which parts share them out."""
        return tuple(membrane.order for membrane in self.plies)

    def start(self) -> tuple[wp.array | None, ...]:
        """What each load's elements remember, no strain so far; then what each ply recovered."""
        loads = tuple(
            load.memory and wp.zeros(load.remembered, load.memory, device=membrane.areas.device)
            for membrane in self.plies
            for load in membrane.loads
        )
        return loads + tuple(
            start_recovery(of.ply, self.numerics, len(of.patches) - 1, str(of.areas.device))
            for of in self.plies
        )

    def launches(self, share: Share, bodies: Bodies, memory: tuple) -> Launches:
        """A part's share of every ply's elements."""
        by_load, recovered = memory[: -len(self.plies)], memory[-len(self.plies) :]
        loads = [
            (load, of.rates, own)
            for of, own in zip(self.plies, recovered, strict=True)
            for load in of.loads
        ]
        scatter = [
            load.launch(ours, bodies.plies.x, rates, kept, own, bodies.plies.f)
            for (load, rates, own), kept in zip(loads, by_load, strict=True)
            if (ours := share.of(load.count)).count
        ]
        return Launches(scatter=tuple(scatter))

    def measure(self, bodies: Bodies, memory: tuple) -> Measured:
        """Energies, and per ply strain and line tension."""
        by_load, recovered = memory[: -len(self.plies)], memory[-len(self.plies) :]
        shown = [membrane.measure(bodies.plies.x) for membrane in self.plies]
        energies = np.einsum("ij->j", np.concatenate([energy for *_, energy in shown]))
        stored = dict(zip(("yarn", "shear", "stabiliser"), map(float, energies), strict=True))
        lost = {"viscosity": sum(float(m.numpy()["lost"].sum()) for m in by_load if m is not None)}
        beside = [
            of.recovered(self.numerics, own) for of, own in zip(self.plies, recovered, strict=True)
        ]
        yarns = [(strain, tension) for strain, tension, _ in shown]
        return measured(stored, lost, yarns, beside, self.numerics.yarn_softening)

    def ply_entries(self, fields: Mapping[str, np.ndarray]) -> dict[str, float]:
        """What ``summary.json`` says of a ply's membrane."""
        return strain_entries(fields)

    def entries(
        self, history: Mapping[str, np.ndarray], fields: Sequence[Mapping[str, np.ndarray]]
    ) -> tuple[dict[str, float], list[str]]:
        """What ``summary.json`` says of all of them, and warnings."""
        woven = [of_ply for of_ply, yes in zip(fields, self.woven, strict=True) if yes]
        return summary_of_softening(self.numerics.yarn_softening, history, woven)


def strain_entries(fields: Mapping[str, np.ndarray]) -> dict[str, float]:
    """Entries of ``summary.json`` on the yarn strains of a ply."""
    strain = fields["strain"]
    return {
        "max_strain_warp": float(strain[:, 0].max()),
        "max_strain_weft": float(strain[:, 1].max()),
    }


def summary_of_softening(
    softening: float,
    history: Mapping[str, np.ndarray],
    fields: Sequence[Mapping[str, np.ndarray]],
) -> tuple[dict[str, float], list[str]]:
    """Entries of ``summary.json`` on softer yarns, and warnings.

    Args:
        softening: by which yarns are softer.
        history: columns over the frames.
        fields: of the woven plies.
    """
    strain = max((float(of_ply["strain"].max()) for of_ply in fields), default=0.0)
    found = softening_entries(softening, history, strain)
    return found, softening_warnings(found) + recovery_warnings(history)


def build(scene: Setup, spans: tuple[Span, ...], time_step: float, device: str) -> Membranes:
    """Put the membranes of all plies on a device."""
    plies = zip(scene.plies, spans, strict=True)
    return Membranes(
        tuple(build_membrane(ply, scene.numerics, span, time_step, device) for ply, span in plies),
        scene.numerics,
        tuple(not isinstance(ply.fabric.tension, Unwoven) for ply in scene.plies),
    )


def frequencies(scene: Setup, number: int) -> np.ndarray:
    """Bound on ω² [1/s²] of each triangle of a ply, given its number."""
    ply, numerics = scene.plies[number], scene.numerics
    gradients, _ = flat_gradients(ply)
    return highest_frequency_squared(
        gradients, ply.fabric.areal_density, *sheet_stiffness(ply, numerics)
    )


def build_membrane(
    ply: Ply, numerics: Numerics, span: Span, time_step: float, device: str
) -> Membrane:
    """Put a ply's triangles on a device.

    Args:
        ply: the ply.
        numerics: averaging, stabiliser, softening and recovery of yarns.
        span: where the ply is in the model.
        time_step: Δt [s].
        device: Warp device.
    """
    fabric = ply.fabric
    flat = np.asarray(ply.mesh.triangles, dtype=np.int32)
    gradients, areas = flat_gradients(ply)
    common: tuple[wp.array, wp.array, wp.array] = (
        wp.array(flat + span.first_vertex, dtype=wp.int32, device=device),
        wp.array(gradients, dtype=wp.vec4d, device=device),
        wp.array(areas, dtype=wp.float64, device=device),
    )
    if isinstance(fabric.tension, Unwoven):
        law = tension_struct(fabric, device)
        add_forces, measure = _SHEETS[type(fabric.tension)]
        loads: tuple[Load, ...] = (Load(add_forces, len(flat), [0, *common, law]),)
        offsets, order = np.zeros(1, dtype=int), np.arange(len(flat))
        measurement = (measure, len(flat), [*common, law])
    else:
        loads, offsets, order, measurement = _yarn_launches(
            ply, numerics, span.first_vertex, common, gradients, areas, device
        )
    rates = rates_of(ply, numerics, time_step)
    return Membrane(ply, span, *common, loads, rates, offsets, order, measurement)


@functools.cache
def _yarn_kernels(functions: tuple) -> tuple:
    tension, _, shear, _, *structs = functions
    return make_pair_forces(tension, shear, *structs), *kernels.make_yarn_membrane(*functions)


def _yarn_launches(
    ply: Ply,
    numerics: Numerics,
    vertex: int,
    common: Sequence[wp.array],
    gradients: np.ndarray,
    areas: np.ndarray,
    device: str,
) -> tuple[tuple[Load, ...], np.ndarray, np.ndarray, tuple[Any, int, list]]:
    """A woven ply's loads, its patches, triangles by patch, and its measurement.

    Pairs come first, two at a time; an odd one is left to the kernel of patches of any size.
    """
    fabric = ply.fabric
    add_pair_forces, add_patch_forces, measure = _yarn_kernels(membrane_functions(fabric))
    laws = [
        tension_struct(soften(fabric, numerics.yarn_softening), device),
        shear_struct(fabric, device),
    ]
    offsets, members, pairs = patches_of(ply.mesh, numerics.averaging)
    patches, paired = len(offsets) - 1, pairs - pairs % 2
    stabiliser = patch_stabilisers(ply, numerics, offsets, members)
    of_patches = [*laws, wp.array(stabiliser, dtype=wp.float64, device=device), fabric.yarn_angle]
    in_order: list[wp.array] = [
        wp.array(array, dtype=wp.int32, device=device) for array in (offsets, members)
    ]
    loads = []
    if paired:
        halves = members[: 2 * paired].reshape(-1, 2)
        two_pairs = arrange_pairs(
            np.asarray(ply.mesh.triangles), gradients, areas, halves, stabiliser[:paired], vertex
        )
        pair_array: wp.array = wp.array(two_pairs, dtype=TwoPairs, device=device)
        inputs, twos = [0, pair_array, *laws, fabric.yarn_angle], paired // 2
        loads.append(Load(add_pair_forces, twos, inputs, PairMemory, twos))
    if patches > paired:
        inputs = [paired, *in_order, *common, *of_patches]
        memory = kernels.PatchMemory
        loads.append(Load(add_patch_forces, patches - paired, inputs, memory, patches))
    return tuple(loads), offsets, members, (measure, patches, [*in_order, *common, *of_patches])
