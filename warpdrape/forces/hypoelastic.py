"""The plies' membranes with stress as a state: arrays, launches, work done on them.

What `green_naghdi` and `fibre_frame` share; they differ by the frame in which the stress grows.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp

from warpdrape.blanks.ply import Ply
from warpdrape.blanks.triangles import flat_gradients
from warpdrape.errors import InputError
from warpdrape.forces.membrane import strain_entries, summary_of_softening, yarn_viscosity
from warpdrape.forces.membrane_stiffness import patch_stabilisers
from warpdrape.forces.pairs import patches_of
from warpdrape.interaction import Bodies, Launch, Launches, Measured, Share, Span
from warpdrape.kernels.forces.hypoelastic import (
    PatchState,
    Sheets,
    SheetState,
    make_hypoelastic,
)
from warpdrape.kernels.materials.isotropic import IsotropicMembrane as IsotropicStruct
from warpdrape.kernels.materials.isotropic import sheet_couple, sheet_tension
from warpdrape.materials.fabric import Fabric
from warpdrape.materials.law_curves import sample_tensions
from warpdrape.materials.law_data import (
    membrane_functions,
    shear_struct,
    taut_stiffness,
    tension_struct,
)
from warpdrape.materials.laws import IsotropicMembrane, MooneyRivlin
from warpdrape.materials.softening import soften
from warpdrape.numerics import Numerics
from warpdrape.setup import Setup

OFF_THE_CARD = 0.1
"""Tension off the card's for the yarns' strains, over the card's largest, that is warned of [-]."""


@dataclass(frozen=True, eq=False)
class StressState:
    """What a ply's membrane remembers.

    Attributes:
        triangles: shape [triangle].
        patches: shape [patch].
    """

    triangles: wp.array
    patches: wp.array


@dataclass(frozen=True, eq=False)
class StressedPly:
    """One ply's triangles on a device.

    Attributes:
        ply: the ply.
        span: where its vertices and triangles are in the model's.
        kernels: that add forces, and that measure.
        inputs: of both: triangles and laws.
        yarns: warp and weft of the flat ply, unit vectors, shape [2, 3].
        order: its triangles by patch, shape [triangle].
        patches: number of patches.
    """

    ply: Ply
    span: Span
    kernels: tuple[Any, Any]
    inputs: tuple[Any, ...]
    yarns: np.ndarray
    order: np.ndarray
    patches: int

    def start(self) -> StressState:
        """Flat, without stress."""
        device = self.inputs[0].areas.device
        flat = np.zeros(self.span.triangle_count, dtype=SheetState.numpy_dtype())
        flat["warp"], flat["weft"] = self.yarns
        return StressState(
            wp.array(flat, dtype=SheetState, device=device),
            wp.zeros(self.patches, dtype=PatchState, device=device),
        )

    def launch(
        self, first: int, count: int, x: wp.array, memory: StressState, f: wp.array
    ) -> Launch:
        """Launch of a run of its patches."""
        inputs = [first, *self.inputs, x]
        return Launch(self.kernels[0], count, inputs, [memory.triangles, memory.patches, f])

    def measure(self, x: wp.array, memory: StressState) -> dict[str, np.ndarray]:
        """What it shows at positions, by name: see `kernels.forces.hypoelastic`."""
        m = self.span.triangle_count
        shapes = {
            "strain": (m, wp.vec2d),
            "line_tension": (m, wp.vec2d),
            "couple": (m, wp.float64),
            "work": (self.patches, wp.vec3d),
            "lost": (self.patches, wp.float64),
        }
        moved = wp.empty_like(memory.triangles)
        shown = {n: wp.empty(k, dtype=d, device=x.device) for n, (k, d) in shapes.items()}
        inputs = [*self.inputs, memory.triangles, memory.patches, x]
        outputs = [moved, *shown.values()]
        wp.launch(self.kernels[1], self.patches, inputs, outputs=outputs, device=x.device)
        return {name: array.numpy() for name, array in shown.items()}

    def off_the_card(self, fields: Mapping[str, np.ndarray], softening: float) -> list[str]:
        """A warning where tensions are not those that the card gives the yarns' strains."""
        fabric, strain = self.ply.fabric, fields["strain"]
        if isinstance(fabric.tension, IsotropicMembrane):
            return []
        card = sample_tensions(soften(fabric, softening), strain)[0]
        apart = np.abs(fields["line_tension"] - card)
        triangle, family = np.unravel_index(np.argmax(apart), apart.shape)
        if apart.max() <= OFF_THE_CARD * np.abs(card).max():
            return []
        return [
            f"{('warp', 'weft')[family]} of ply {self.ply.name!r} carries "
            f"{fields['line_tension'][triangle, family]:.3g} N/m at a strain of "
            f"{100.0 * strain[triangle, family]:.2g} %, where its card gives "
            f"{card[triangle, family]:.3g} N/m: the stress did not turn with the yarns; "
            "compare approach = 'semi_discrete'"
        ]


@dataclass(frozen=True, eq=False)
class StressedMembranes:
    """The membranes of all plies.

    Attributes:
        plies: one for each ply.
        softening: divisor of the yarns' tensions [-].
    """

    plies: tuple[StressedPly, ...]
    softening: float
    name: str = "membrane"
    searches: str = ""

    def carrying(self, fields: Mapping[str, np.ndarray], number: int) -> np.ndarray:
        """Yarn strains of a ply [-], no larger than those that its stress would give a taut yarn.

        Where stress did not turn with the yarns these are longer without a tension.
        """
        fabric = self.plies[number].ply.fabric
        if isinstance(fabric.tension, IsotropicMembrane):
            return fields["strain"]
        taut = np.maximum(fields["line_tension"], 0.0)
        return np.minimum(fields["strain"], taut / taut_stiffness(soften(fabric, self.softening)))

    @property
    def order(self) -> tuple[np.ndarray, ...]:
        """Each ply's triangles in the order in which parts share them out."""
        return tuple(ply.order for ply in self.plies)

    def start(self) -> tuple[StressState, ...]:
        """No stress in any ply."""
        return tuple(ply.start() for ply in self.plies)

    def launches(self, share: Share, bodies: Bodies, memory: tuple[StressState, ...]) -> Launches:
        """A part's share of every ply's patches."""
        scatter = [
            ply.launch(ours.first, ours.count, bodies.plies.x, kept, bodies.plies.f)
            for ply, kept in zip(self.plies, memory, strict=True)
            if (ours := share.of(ply.patches)).count
        ]
        return Launches(scatter=tuple(scatter))

    def measure(self, bodies: Bodies, memory: tuple[StressState, ...]) -> Measured:
        """Work done on the stresses, and per ply strain and line tension."""
        x = bodies.plies.x
        shown = [ply.measure(x, kept) for ply, kept in zip(self.plies, memory, strict=True)]
        work = np.einsum("ij->j", np.concatenate([of_ply["work"] for of_ply in shown]))
        names = ("yarn", "shear", "stabiliser")
        return Measured(
            dict(zip(names, map(float, work), strict=True)),
            {"viscosity": sum(float(of_ply["lost"].sum()) for of_ply in shown)},
            fields=tuple({n: of_ply[n] for n in ("strain", "line_tension")} for of_ply in shown),
        )

    def ply_entries(self, fields: Mapping[str, np.ndarray]) -> dict[str, float]:
        """What ``summary.json`` says of a ply's membrane."""
        return strain_entries(fields)

    def entries(
        self, history: Mapping[str, np.ndarray], fields: Sequence[Mapping[str, np.ndarray]]
    ) -> tuple[dict[str, float], list[str]]:
        """What ``summary.json`` says of all of them, and warnings."""
        carrying = [{"strain": self.carrying(of, k)} for k, of in enumerate(fields)]
        found, warnings = summary_of_softening(self.softening, history, carrying)
        for ply, shown in zip(self.plies, fields, strict=True):
            warnings += ply.off_the_card(shown, self.softening)
        return found, warnings


def refuse_rubber(fabric: Fabric, approach: str) -> None:
    """Raise `InputError` for a sheet of rubber: its tangents are not those of a card."""
    if isinstance(fabric.tension, MooneyRivlin):
        raise InputError(
            f"approach = {approach!r} has the stress of fabrics as a state, and {fabric.name!r} is "
            "rubber: take approach = 'semi_discrete'"
        )


def build_stressed(
    scene: Setup, spans: tuple[Span, ...], device: str, rows: Callable
) -> StressedMembranes:
    """Put the membranes of all plies on a device.

    Args:
        scene: what is computed.
        spans: where plies are.
        device: Warp device.
        rows: wp.func of the frame in which stress grows; see `kernels.forces.objective_rates`.
    """
    plies = zip(scene.plies, spans, strict=True)
    return StressedMembranes(
        tuple(build_stressed_ply(ply, scene.numerics, span, device, rows) for ply, span in plies),
        scene.numerics.yarn_softening,
    )


def build_stressed_ply(
    ply: Ply, numerics: Numerics, span: Span, device: str, rows: Callable
) -> StressedPly:
    """Put a ply's triangles on a device; see `build_stressed`."""
    fabric = ply.fabric
    flat = np.asarray(ply.mesh.triangles, dtype=np.int32)
    gradients, areas = flat_gradients(ply)
    isotropic = isinstance(fabric.tension, IsotropicMembrane)
    averaging = "plain" if isotropic else numerics.averaging
    offsets, members, _ = patches_of(ply.mesh, averaging)
    sheets = Sheets()
    sheets.offsets = wp.array(offsets, dtype=wp.int32, device=device)
    sheets.members = wp.array(members, dtype=wp.int32, device=device)
    sheets.triangles = wp.array(flat + span.first_vertex, dtype=wp.int32, device=device)
    sheets.gradients = wp.array(gradients, dtype=wp.vec4d, device=device)
    sheets.areas = wp.array(areas, dtype=wp.float64, device=device)
    stabiliser = (
        np.zeros(len(flat)) if isotropic else patch_stabilisers(ply, numerics, offsets, members)
    )
    sheets.stabiliser = wp.array(stabiliser, dtype=wp.float64, device=device)
    sheets.rest = wp.vec2d(np.cos(fabric.yarn_angle), np.sin(fabric.yarn_angle))
    sheets.viscosity = wp.vec2d(*yarn_viscosity(fabric, numerics))
    yarns = np.column_stack([np.stack(ply.yarn_directions), np.zeros(2)])
    laws = _laws(fabric, numerics, device)
    kernels = _kernels(rows, *_functions(fabric))
    return StressedPly(
        ply, span, kernels, (sheets, *laws), yarns, np.asarray(members), len(offsets) - 1
    )


_kernels = functools.cache(make_hypoelastic)


def _functions(fabric: Fabric) -> tuple:
    """Laws of tension and shear for `make_hypoelastic`, and whether the sheet has yarns."""
    if isinstance(fabric.tension, IsotropicMembrane):
        return sheet_tension, sheet_couple, IsotropicStruct, IsotropicStruct, False
    tension, _, shear, _, *structs = membrane_functions(fabric)
    return tension, shear, *structs, True


def _laws(fabric: Fabric, numerics: Numerics, device: str) -> tuple[Any, Any]:
    if isinstance(fabric.tension, IsotropicMembrane):
        law = tension_struct(fabric, device)
        return law, law
    softer = soften(fabric, numerics.yarn_softening)
    return tension_struct(softer, device), shear_struct(fabric, device)
