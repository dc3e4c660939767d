"""The discrete approach with crossovers that slide: yarns as chains of bars that carry on through.

A vertex stays the place where a warp bundle and a weft bundle cross; what slides is the yarn in it
(`kernels.forces.yarn_chains`). Couples, ties and bending are those of `yarns`; tensions are the
card's, those that depend on both families' strains by what crossings add (`bar_loads`).
"""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import warp as wp

from warpdrape.approaches import SLIDING_YARNS
from warpdrape.blanks.ply import Ply
from warpdrape.blanks.yarn_chains import YarnChains
from warpdrape.errors import InputError
from warpdrape.forces import membrane, yarns
from warpdrape.forces.membrane import strain_entries, summary_of_softening, yarn_viscosity
from warpdrape.forces.sliding_chains import (
    CLOSEST,
    ChainKernels,
    along_bars,
    bars_on,
    chains_of,
    check_card,
    closeness,
    crossovers_on,
    kernels_of,
    law_of,
)
from warpdrape.forces.yarns import PlyYarns, net_of, yarns_per_bar
from warpdrape.interaction import Bodies, Launch, Launches, Measured, Share, Span
from warpdrape.kernels.forces.bar_loads import make_no_tension
from warpdrape.kernels.forces.membrane import make_yarn_membrane
from warpdrape.kernels.forces.slides import SLIDES_SHARE, take_slides
from warpdrape.kernels.forces.sliding_bars import BarMemory, take_bars
from warpdrape.kernels.forces.yarn_chains import Bars, Crossovers, Slide
from warpdrape.materials.law_data import membrane_functions, tension_stiffness
from warpdrape.materials.softening import soften
from warpdrape.numerics import Numerics
from warpdrape.setup import Setup

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
        kernels: those of its law of tension.
        law: the law for them.
        bars: the bars for them.
        crossovers: the crossovers for them.
    """

    pinned: PlyYarns
    chains: YarnChains
    kernels: ChainKernels
    law: Any
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
        known, push = [self.law, self.bars, self.crossovers, memory.slides], []
        if bars.count:
            first, count = bars
            inputs = [first, *known, x, memory.bars]
            scatter.append(Launch(self.kernels.pull, count, inputs, [memory.kept, f]))
            push.append(Launch(take_bars, count, [first, memory.kept], [memory.bars]))
        if crossovers.count:
            first, count = crossovers
            inputs = [first, *known, memory.bars, x]
            scatter.append(Launch(self.kernels.slide, count, inputs, [memory.moved]))
            push.append(Launch(take_slides, count, [first, memory.moved], [memory.slides]))
        return Launches(scatter=tuple(scatter), push=tuple(push))

    def measure(self, x: wp.array, memory: SlidingMemory) -> tuple[dict, dict, dict]:
        """Energies stored and lost [J], and fields, by name."""
        known, device = [self.law, self.bars, self.crossovers, memory.slides], x.device
        count = len(self.chains.ends)
        shown = [wp.empty(count, dtype=wp.float64, device=device) for _ in range(3)]
        Launch(self.kernels.measure_bars, count, [*known, x], shown)(device)
        strain, tension, energy = (array.numpy() for array in shown)
        count = len(self.chains.vertices)
        energies = wp.empty(count, dtype=wp.vec3d, device=device)
        Launch(self.kernels.measure_slides, count, [*known, memory.bars, x], [energies])(device)
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
    chains, numerics = chains_of(ply), scene.numerics
    couples = yarns.build_ply_yarns(ply, numerics, span, device)
    add_couples, measure = _couples(*membrane_functions(ply.fabric)[2:])
    pinned = replace(
        couples,
        load=couples.load._replace(kernel=add_couples),
        measurement=(measure, couples.measurement[1]),
        viscosity=(0.0, 0.0),
    )
    return PlySliding(
        pinned,
        chains,
        kernels_of(ply),
        law_of(ply, numerics, device),
        bars_on(ply, chains, numerics, span, device),
        crossovers_on(scene, ply, chains, _stiffest(ply, chains, numerics), device),
    )


def _stiffest(ply: Ply, chains: YarnChains, numerics: Numerics) -> np.ndarray:
    """Bound on the stiffness of bars, with what viscosity takes of the step [N/m], shape [bar]."""
    yarns_alone = tension_stiffness(soften(ply.fabric, numerics.yarn_softening))
    drag = yarn_viscosity(ply.fabric, numerics)
    return along_bars(ply, chains, np.array(yarns_alone) + 2.0 * np.array(drag))


@functools.cache
def _couples(shear, shear_energy, Tension, Shear) -> tuple:
    """Kernels of quadrants that have couples alone."""
    return make_yarn_membrane(*make_no_tension(Tension), shear, shear_energy, Tension, Shear)


def sheet_stiffness(ply: Ply, numerics: Numerics) -> tuple[tuple[float, float], float]:
    """Bounds as `yarns.sheet_stiffness`, of bars that have slid together [N/m]."""
    (warp, weft), shear = yarns.sheet_stiffness(ply, numerics)
    least = closeness(ply)
    return (warp / least, weft / least), shear


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
    chains, net = chains_of(ply), net_of(ply)
    stiffness, shear = membrane.sheet_stiffness(ply, numerics)
    k = along_bars(ply, chains, np.array(stiffness))[:, None, None] * np.ones((2, 2))
    n = len(ply.mesh.vertices)
    matrix = yarns.assembled(chains.ends, k, n)
    matrix = matrix + yarns.assembled(net.quadrants, yarns.couple_rows(net, shear), n)
    return yarns.bound_of(ply, numerics, matrix)
