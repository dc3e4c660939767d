"""One ply's yarns that slide: what they remember, their launches, and what they show."""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import warp as wp

from warpdrape.blanks.ply import Ply
from warpdrape.blanks.yarn_chains import YarnChains
from warpdrape.forces import yarns
from warpdrape.forces.membrane import without_rates, yarn_viscosity
from warpdrape.forces.pressed_crossings import bearers_on, press_crossings
from warpdrape.forces.sliding_chains import (
    CLOSEST,
    ChainKernels,
    along_bars,
    bars_on,
    chains_of,
    crossover_of,
    crossovers_on,
    kernels_of,
    law_of,
)
from warpdrape.forces.yarns import PlyYarns
from warpdrape.interaction import Bodies, Launch, Launches, Share, Span
from warpdrape.kernels.forces.bar_loads import make_no_tension
from warpdrape.kernels.forces.membrane import make_yarn_membrane
from warpdrape.kernels.forces.pressed_crossings import Bearers
from warpdrape.kernels.forces.recovery import Recovery
from warpdrape.kernels.forces.slides import take_slides
from warpdrape.kernels.forces.sliding_bars import BarMemory, take_bars
from warpdrape.kernels.forces.yarn_chains import Bars, Crossovers, Slide
from warpdrape.materials.law_data import membrane_functions, tension_stiffness
from warpdrape.materials.softening import soften
from warpdrape.numerics import Numerics
from warpdrape.setup import Setup

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
        bearers: which vertices' forces press crossings, None where yarns do not rub there.
    """

    pinned: PlyYarns
    chains: YarnChains
    kernels: ChainKernels
    law: Any
    bars: Bars
    crossovers: Crossovers
    bearers: Bearers | None

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
        recovered = wp.empty(0, Recovery, device=x.device)
        scatter = self.pinned.launches(*ours, x, nothing, recovered, f)
        known, push = [self.law, self.bars, self.crossovers, memory.slides], []
        if bars.count:
            first, count = bars
            inputs = [first, *known, x, memory.bars]
            scatter.append(Launch(self.kernels.pull, count, inputs, [memory.kept, f]))
            push.append(Launch(take_bars, count, [first, memory.kept], [memory.bars]))
        if crossovers.count:
            first, count = crossovers
            scatter += press_crossings(self.bearers, self.crossovers, crossovers, bodies)
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


def build_ply_sliding(scene: Setup, ply: Ply, span: Span, device: str) -> PlySliding:
    """Put a ply's yarns on a device."""
    law = crossover_of(ply)
    chains, numerics = chains_of(ply), scene.numerics
    couples = yarns.build_ply_yarns(ply, numerics, span, without_rates(), device)
    add_couples, measure = _couples(*membrane_functions(ply.fabric)[2:])
    pinned = replace(
        couples,
        load=couples.load._replace(kernel=add_couples),
        measurement=(measure, couples.measurement[1]),
    )
    return PlySliding(
        pinned,
        chains,
        kernels_of(ply),
        law_of(ply, numerics, device),
        bars_on(ply, chains, numerics, span, device),
        crossovers_on(scene, ply, law, chains, _stiffest(ply, chains, numerics), device),
        bearers_on(ply, law, chains, span, device),
    )


def _stiffest(ply: Ply, chains: YarnChains, numerics: Numerics) -> np.ndarray:
    """Bound on the stiffness of bars, with what viscosity takes of the step [N/m], shape [bar]."""
    yarns_alone = tension_stiffness(soften(ply.fabric, numerics.yarn_softening))
    drag = yarn_viscosity(ply.fabric, numerics)
    return along_bars(ply, chains, np.array(yarns_alone) + 2.0 * np.array(drag))


@functools.cache
def _couples(shear: Callable, shear_energy: Callable, Tension: type, Shear: type) -> tuple:
    """Kernels of quadrants that have couples alone."""
    return make_yarn_membrane(*make_no_tension(Tension), shear, shear_energy, Tension, Shear)
