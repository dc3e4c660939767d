"""The discrete approach with crossovers that slide: yarns as chains of bars that carry on through.

A vertex stays the place where a warp bundle and a weft bundle cross; what slides is the yarn in it
(`kernels.forces.yarn_chains`). Couples, ties and bending are those of `yarns`; tensions are the
card's, those that depend on both families' strains by what crossings add (`bar_loads`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from warpdrape.approaches import SLIDING_YARNS
from warpdrape.blanks.ply import Ply
from warpdrape.errors import InputError
from warpdrape.forces import membrane, yarns
from warpdrape.forces.membrane import strain_entries, summary_of_softening
from warpdrape.forces.ply_net import net_of, yarns_per_bar
from warpdrape.forces.ply_sliding import PlySliding, SlidingMemory, build_ply_sliding
from warpdrape.forces.sliding_chains import along_bars, chains_of, closeness, crossover_of
from warpdrape.interaction import Bodies, Launches, Measured, Share, Span
from warpdrape.kernels.forces.slides import SLIDES_SHARE
from warpdrape.numerics import Numerics
from warpdrape.setup import Setup

MOST_TAKEN = 3.5
"""Of the 4 in (Δt ω)² ≤ 4 that contacts and slides may take together [-]."""


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


def build(scene: Setup, spans: tuple[Span, ...], time_step: float, device: str) -> SlidingYarns:
    """Put the yarns of all plies on a device."""
    plies = zip(scene.plies, spans, strict=True)
    return SlidingYarns(
        tuple(build_ply_sliding(scene, ply, span, device) for ply, span in plies),
        scene.numerics.yarn_softening,
    )


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
    crossover_of(ply)  # refuses a card without
    chains, net = chains_of(ply), net_of(ply)
    stiffness, shear = membrane.sheet_stiffness(ply, numerics)
    k = along_bars(ply, chains, np.array(stiffness))[:, None, None] * np.ones((2, 2))
    n = len(ply.mesh.vertices)
    matrix = yarns.assembled(chains.ends, k, n)
    matrix = matrix + yarns.assembled(net.quadrants, yarns.couple_rows(net, shear), n)
    return yarns.bound_of(ply, numerics, matrix)
