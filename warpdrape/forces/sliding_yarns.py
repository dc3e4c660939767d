"""The discrete approach with crossovers that slide: yarns as chains of bars that carry on through.

A vertex stays the place where a warp bundle and a weft bundle cross; what slides is the yarn in it
(`kernels.forces.sliding_yarns`). Couples, ties and bending are those of `yarns`. The tensions of
both families must be their own: the card's law is linear.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import warp as wp

from warpdrape.approaches import SLIDING_YARNS
from warpdrape.blanks.ply import Ply
from warpdrape.blanks.yarn_chains import YarnChains, chain_yarns
from warpdrape.errors import InputError
from warpdrape.forces import membrane, yarns
from warpdrape.forces.membrane import strain_entries, summary_of_softening, yarn_viscosity
from warpdrape.forces.yarns import PlyYarns, net_of, yarns_per_bar
from warpdrape.interaction import Bodies, Launch, Launches, Measured, Share, Span
from warpdrape.kernels.forces.membrane import make_yarn_membrane
from warpdrape.kernels.forces.sliding_yarns import (
    LEAST_SPACING,
    SLIDES_SHARE,
    BarMemory,
    Bars,
    Crossovers,
    Slide,
    add_bar_forces,
    measure_bars,
    measure_slides,
    no_energy,
    no_tension,
    slide_yarns,
    take_bars,
    take_slides,
)
from warpdrape.materials.law_data import membrane_functions, tension_struct
from warpdrape.materials.laws import LinearTension
from warpdrape.materials.softening import soften
from warpdrape.numerics import Numerics
from warpdrape.setup import Setup

CLOSEST = float(LEAST_SPACING)
"""The same for the host [-]."""
MOST_TAKEN = 3.5
"""Of the 4 in (Δt ω)² ≤ 4 that contacts and slides may take together [-]."""
CROWDED = 1.01
"""Length over `CLOSEST` from which on a bar counts as crowded [-]."""


@dataclass(frozen=True, eq=False)
class SlidingMemory:
    """What a ply's yarns remember.

    Attributes:
        slides: of its crossovers, shape [crossover].
        moved: the same after the step that is going on.
        bars: of its bars, for their viscosity, shape [bar].
        kept: the same after the step.
    """

    slides: wp.array
    moved: wp.array
    bars: wp.array
    kept: wp.array


@dataclass(frozen=True, eq=False)
class PlySliding:
    """One ply's yarns on a device.

    Attributes:
        pinned: its couples and ties, without tension.
        chains: its bars and crossovers.
        bars: the bars for the kernels.
        crossovers: the crossovers for them.
    """

    pinned: PlyYarns
    chains: YarnChains
    bars: Bars
    crossovers: Crossovers

    def start(self) -> SlidingMemory:
        """Nothing has slid."""
        sizes = [(len(self.chains.vertices), Slide), (len(self.chains.ends), BarMemory)]
        device = self.bars.lengths.device
        arrays = (wp.zeros(n, dtype=of, device=device) for n, of in sizes for _ in range(2))
        return SlidingMemory(*arrays)

    def launches(self, share: Share, bodies: Bodies, memory: SlidingMemory) -> Launches:
        """A part's share of bars, couples, ties and slides."""
        x, f = bodies.plies.x, bodies.plies.f
        bars, crossovers = (share.of(len(of)) for of in (self.chains.ends, self.chains.vertices))
        net = self.pinned.net
        nothing = wp.empty(0, self.pinned.load.memory, device=x.device)
        ours = share.of(len(net.quadrants)), share.of(len(net.carried))
        scatter = self.pinned.launches(*ours, x, nothing, f)
        known, push = [self.bars, self.crossovers, memory.slides], []
        if bars.count:
            first, count = bars
            inputs = [first, *known, x, memory.bars]
            scatter.append(Launch(add_bar_forces, count, inputs, [memory.kept, f]))
            push.append(Launch(take_bars, count, [first, memory.kept], [memory.bars]))
        if crossovers.count:
            first, count = crossovers
            inputs = [first, *known, memory.bars, x]
            scatter.append(Launch(slide_yarns, count, inputs, [memory.moved]))
            push.append(Launch(take_slides, count, [first, memory.moved], [memory.slides]))
        return Launches(scatter=tuple(scatter), push=tuple(push))

    def measure(self, x: wp.array, memory: SlidingMemory) -> tuple[dict, dict, dict]:
        """Energies stored and lost [J], and fields, by name."""
        known, device = [self.bars, self.crossovers, memory.slides], x.device
        count = len(self.chains.ends)
        shown = [wp.empty(count, dtype=wp.float64, device=device) for _ in range(3)]
        wp.launch(measure_bars, count, inputs=[*known, x], outputs=shown, device=device)
        strain, tension, energy = (array.numpy() for array in shown)
        count = len(self.chains.vertices)
        energies = wp.empty(count, dtype=wp.vec3d, device=device)
        inputs = [*known, memory.bars, x]
        wp.launch(measure_slides, count, inputs=inputs, outputs=[energies], device=device)
        springs, moving, slip = np.einsum("ij->j", energies.numpy())
        _, _, (_, shear, stabiliser) = self.pinned.measure(x)
        stored = {
            "yarn": energy.sum(),
            "shear": shear,
            "stabiliser": stabiliser,
            "crossover": springs,
            "yarn_motion": moving,
        }
        viscous = memory.bars.numpy()["lost"].sum()
        lost = {"viscosity": viscous, "yarn_slip": slip}
        home, places = self.pinned.net.home, self.chains.quadrants
        slide = np.zeros((self.pinned.span.vertex_count, 2))
        slide[self.chains.vertices] = memory.slides.numpy()["s"]
        fields = {
            "strain": home @ strain[places],
            "line_tension": home @ tension[places],
            "yarn_slide": slide,
        }
        return stored, lost, fields

    def warnings(self, slide: np.ndarray) -> list[str]:
        """A warning where crossovers lie so close that no more yarn slides out between them."""
        chains = self.chains
        slides = slide[chains.vertices]
        at = slides[chains.numbers, chains.family[:, None]]
        there = chains.left(slides)[chains.numbers, chains.family[:, None]].min(axis=1) > 0.0
        length = 1.0 + (at[:, 1] - at[:, 0]) / chains.lengths
        crowded = int((length[there] < CROWDED * CLOSEST).sum())
        if not crowded:
            return []
        return [
            f"{crowded} of {len(length)} bars of ply {self.pinned.ply.name!r} have let so much "
            f"yarn out, {100 * (1 - CLOSEST):.0f} %, that their crossing yarns lie on each other; "
            "no more slides out of them: the fabric's [crossover] may hold its yarns too loosely"
        ]


@dataclass(frozen=True, eq=False)
class SlidingYarns:
    """The yarns of all plies.

    Attributes:
        plies: one for each ply.
        softening: divisor of the yarns' tensions [-].
    """

    plies: tuple[PlySliding, ...]
    softening: float
    name: str = "membrane"
    searches: str = ""

    @property
    def order(self) -> tuple[np.ndarray, ...]:
        """Each ply's triangles in the order in which parts share out their quadrants."""
        return tuple(of.pinned.order for of in self.plies)

    def start(self) -> tuple[SlidingMemory, ...]:
        """Nothing has slid in any ply."""
        return tuple(of.start() for of in self.plies)

    def launches(self, share: Share, bodies: Bodies, memory: tuple[SlidingMemory, ...]) -> Launches:
        """A part's share of every ply."""
        every = zip(self.plies, memory, strict=True)
        return sum((of.launches(share, bodies, kept) for of, kept in every), Launches())

    def measure(self, bodies: Bodies, memory: tuple[SlidingMemory, ...]) -> Measured:
        """Energies, and per ply strain and line tension of triangles, slides at vertices."""
        every = zip(self.plies, memory, strict=True)
        shown = [of.measure(bodies.plies.x, kept) for of, kept in every]
        stored, lost = (
            {name: float(sum(of_ply[k][name] for of_ply in shown)) for name in shown[0][k]}
            for k in (0, 1)
        )
        return Measured(stored, lost, fields=tuple(fields for *_, fields in shown))

    def ply_entries(self, fields: Mapping[str, np.ndarray]) -> dict[str, float]:
        """What ``summary.json`` says of a ply's yarns."""
        largest = np.abs(fields["yarn_slide"]).max(axis=0)
        slides = {"max_slide_warp_m": float(largest[0]), "max_slide_weft_m": float(largest[1])}
        return strain_entries(fields) | slides

    def entries(
        self, history: Mapping[str, np.ndarray], fields: Sequence[Mapping[str, np.ndarray]]
    ) -> tuple[dict, list[str]]:
        """What ``summary.json`` says of all of them, and warnings."""
        found, warnings = summary_of_softening(self.softening, history, fields)
        per_bar = {}
        for of, shown in zip(self.plies, fields, strict=True):
            ply = of.pinned.ply
            per_bar[ply.name] = yarns_per_bar(ply, of.pinned.net)
            warnings = [*warnings, *of.warnings(shown["yarn_slide"])]
        return found | {"yarns_per_bar": per_bar}, warnings


def build(scene: Setup, spans: tuple[Span, ...], device: str) -> SlidingYarns:
    """Put the yarns of all plies on a device."""
    plies = zip(scene.plies, spans, strict=True)
    return SlidingYarns(
        tuple(build_ply_sliding(scene, ply, span, device) for ply, span in plies),
        scene.numerics.yarn_softening,
    )


def build_ply_sliding(scene: Setup, ply: Ply, span: Span, device: str) -> PlySliding:
    """Put a ply's yarns on a device."""
    check_card(ply)
    chains = chain_yarns(net_of(ply))
    pinned = yarns.build_ply_yarns(ply, scene.numerics, span, device)
    _, _, shear, shear_energy, _, Shear = membrane_functions(ply.fabric)
    add_couples, measure = _couples(shear, shear_energy, Shear)
    load = pinned.load._replace(kernel=add_couples)
    pinned = replace(
        pinned,
        load=load,
        measurement=(measure, pinned.measurement[1]),
        viscosity=(0.0, 0.0),
    )
    bars = _bars(ply, chains, scene.numerics, span, device)
    dragged = np.array(bars.stiffness) + 2.0 * np.array(bars.viscosity)
    stiffness = along_bars(chains, dragged)
    return PlySliding(pinned, chains, bars, _crossovers(scene, ply, chains, stiffness, device))


@functools.cache
def _couples(shear, shear_energy, Shear) -> tuple:
    """Kernels of quadrants that have couples alone."""
    from warpdrape.kernels.materials.tension import LinearTension as Struct

    return make_yarn_membrane(no_tension, no_energy, shear, shear_energy, Struct, Shear)


def check_card(ply: Ply) -> None:
    """Raise `InputError` where a ply's fabric does not say how its yarns slide, or cannot."""
    fabric = ply.fabric
    net_of(ply)
    if fabric.crossover is None:
        raise InputError(
            f"approach = 'sliding_yarns' needs the [crossover] of fabric {fabric.name!r} of ply "
            f"{ply.name!r}, slip force and stiffness: give them in its file, or take "
            "approach = 'yarns', whose crossovers are pinned"
        )
    if not isinstance(fabric.tension, LinearTension):
        raise InputError(
            f"approach = 'sliding_yarns' is for yarns whose tension depends on their own strain, "
            f"and fabric {fabric.name!r} of ply {ply.name!r} couples warp and weft: give it "
            "tension law 'linear', or take approach = 'yarns'"
        )


def _bars(ply: Ply, chains: YarnChains, numerics: Numerics, span: Span, device: str) -> Bars:
    law = tension_struct(soften(ply.fabric, numerics.yarn_softening), device)
    bars = Bars()
    bars.ends = wp.array(chains.ends + span.first_vertex, dtype=wp.vec2i, device=device)
    bars.numbers = wp.array(chains.numbers, dtype=wp.vec2i, device=device)
    bars.family = wp.array(chains.family, dtype=wp.int32, device=device)
    bars.lengths = wp.array(chains.lengths, dtype=wp.float64, device=device)
    bars.widths = wp.array(chains.widths, dtype=wp.float64, device=device)
    bars.stiffness = law.stiffness
    bars.compressive_factor = law.compressive_factor
    bars.viscosity = wp.vec2d(*yarn_viscosity(ply.fabric, numerics))
    return bars


def _crossovers(
    scene: Setup, ply: Ply, chains: YarnChains, stiffness: np.ndarray, device: str
) -> Crossovers:
    """Springs of bundles: as many as there are crossings of single yarns in their area.

    Args:
        scene: whose clamps may grip yarns.
        ply: the ply.
        chains: its yarns.
        stiffness: from `along_bars` [N/m], shape [bar].
        device: Warp device.
    """
    law, fabric = ply.fabric.crossover, ply.fabric
    crossings = (chains.areas / fabric.cell_area)[:, None]
    held = np.zeros(len(ply.mesh.vertices), np.int32)
    for clamp in scene.clamps:
        if clamp.ply == ply.name and clamp.yarns == "held":
            held[clamp.vertices(ply.rest_points)] = 1
    below, above = chains.passed

    def pairs(values: np.ndarray) -> wp.array:
        return wp.array(values, dtype=wp.vec2d, device=device)

    out = Crossovers()
    out.bars = wp.array(chains.bars, dtype=wp.vec4i, device=device)
    out.slip = pairs(crossings * (law.slip_force_warp, law.slip_force_weft))
    out.stiffness = pairs(crossings * (law.stiffness_warp, law.stiffness_weft))
    crossed = fabric.yarn_width[::-1]  # of the yarn that is crossed, whose tension presses
    out.friction = pairs(crossings * law.friction * np.array(crossed))
    beside = np.where(chains.bars < 0, 0.0, stiffness[chains.bars]).reshape(-1, 2, 2).sum(axis=2)
    out.inertia = pairs(np.where(beside > 0.0, 2.0 / SLIDES_SHARE * beside, 1.0))
    out.below, out.above, out.span = pairs(below), pairs(above), pairs(chains.span)
    out.held = wp.array(held[chains.vertices], dtype=wp.int32, device=device)
    return out


def sheet_stiffness(ply: Ply, numerics: Numerics) -> tuple[tuple[float, float], float]:
    """Bounds as `yarns.sheet_stiffness`, of bars that have slid together [N/m]."""
    (warp, weft), shear = yarns.sheet_stiffness(ply, numerics)
    return (warp / CLOSEST, weft / CLOSEST), shear


def slides_share(scene: Setup, others: float) -> float:
    """What slides take of the 4 in (Δt ω)² ≤ 4 [-], 0 where crossovers are pinned.

    Vertices and slides share the bars: (Δt ω)² is at most the sum of what either has alone.

    Args:
        scene: what is computed.
        others: what others take of it.

    Raises:
        InputError: if too little is left.
    """
    if scene.approach != SLIDING_YARNS:
        return 0.0
    if others + SLIDES_SHARE > MOST_TAKEN:
        raise InputError(
            f"contact_share = {scene.numerics.contact_share:g} with contact_damping = "
            f"{scene.numerics.contact_damping:g} leaves no stable step beside yarns that slide: "
            "lower one of them"
        )
    return SLIDES_SHARE


def frequencies(scene: Setup, number: int) -> np.ndarray:
    """Bound on ω² [1/s²] of each triangle of a ply, given its number.

    As `yarns.frequencies`, of bars as short as they may get; without slides, see `slides_share`.
    """
    ply, numerics = scene.plies[number], scene.numerics
    check_card(ply)
    chains, net = chain_yarns(net_of(ply)), net_of(ply)
    stiffness, shear = membrane.sheet_stiffness(ply, numerics)
    k = along_bars(chains, np.array(stiffness))[:, None, None] * np.ones((2, 2))
    n = len(ply.mesh.vertices)
    matrix = yarns.assembled(chains.ends, k, n)
    matrix = matrix + yarns.assembled(net.quadrants, yarns.couple_rows(net, shear), n)
    return yarns.bound_of(ply, numerics, matrix)


def along_bars(chains: YarnChains, stiffness: np.ndarray) -> np.ndarray:
    """Stiffness of bars that are as short as they may get [N/m], shape [bar].

    Args:
        chains: of a ply.
        stiffness: line stiffness of warp and weft [N/m], shape [2].
    """
    return stiffness[chains.family] * chains.widths / (CLOSEST * chains.lengths)
