"""Contact between plies: what it needs on a device, its launches, energy and entries."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import warp as wp

from warpdrape.contact.law import contact_law, near_reach
from warpdrape.contact.ply_facets import build_facets
from warpdrape.interaction import Bodies, Launch, Launches, Measured, Run, Share, Span
from warpdrape.kernels.contact import ply_contact as kernels
from warpdrape.kernels.contact.contact import ContactLaw
from warpdrape.kernels.contact.facets import PlyFacets
from warpdrape.kernels.contact.ply_contact import PlyFaces, PlySearch
from warpdrape.setup import Setup
from warpdrape.state import Across, Apart, PlyState
from warpdrape.timing import Timing, peak_speed

ASK_EVERY = 16
"""Contact searches from one in which every vertex asks for the nearest facet of another ply to the
next such one; between, it walks from the facet that it remembers."""
FADING = 2e-4
"""Time in which a penetration that appeared by a jump of the gap is pushed out [s].

Pushing it out does work that nothing supplies: in the three-ply hemisphere about a hundredth of the
energy, at 4 ms a third of that, but then up to 0.2 mm are on their way out at a time, not 0.03 mm.
"""
PUSH_OUT = 0.1
"""… but no faster than at this share of the tools' speed [-]. A vertex that has slid over another
ply's border and back is found 2 mm deep; out in 0.2 ms it was thrown up at 40 m/s.
"""


@dataclass(frozen=True, eq=False)
class PlyPair:
    """Vertices of one ply that may meet the triangles of another.

    Attributes:
        number: of the pair.
        searching: index of the ply whose vertices are looked at.
        searched: index of the ply whose triangles are.
        first_slot: where these contacts begin.
        faces: the searched ply for the kernels.
    """

    number: int
    searching: int
    searched: int
    first_slot: int
    faces: PlyFaces


@dataclass(frozen=True, eq=False)
class PlyMemory:
    """What contact between plies remembers; a slot is a vertex and another ply.

    Attributes:
        normals: at vertices [-], shape [vertex].
        hollows: room on either side of a vertex, shape [vertex].
        seen: the triangle last seen, shape [slot].
        contacts: the nearest triangle, shape [slot].
        springs: friction springs [m], shape [slot].
        dashpots: dashpot forces of the step before [N], shape [slot].
        stored: energy in contact [J], shape [slot].
        slip: way slid [m], shape [slot].
        spent: lost to friction and damping since the last search [J], shape [slot].
        deepest: deepest penetration of each pair [m], shape [pair].
        jump: largest penetration of each pair that a jump of the gap allowed [m], shape [pair].
    """

    normals: wp.array
    hollows: wp.array
    seen: wp.array
    contacts: wp.array
    springs: wp.array
    dashpots: wp.array
    stored: wp.array
    slip: wp.array
    spent: wp.array
    deepest: wp.array
    jump: wp.array
    apart: ClassVar[Apart] = {"deepest": Across.LARGEST, "jump": Across.LARGEST}


@dataclass(frozen=True, eq=False)
class PlyContact:
    """Contact of all plies with each other.

    Attributes:
        device: Warp device.
        scene: what is computed.
        timing: the steps.
        spans: where plies are.
        mass: vertex masses [kg], shape [vertex].
        facets: the plies' triangles.
        meshes: per ply, moved along for searches.
        pairs: directed pairs of plies that may touch.
        law: the contact law.
    """

    device: str
    scene: Setup
    timing: Timing
    spans: tuple[Span, ...]
    mass: wp.array
    facets: PlyFacets
    meshes: tuple[wp.Mesh, ...]
    pairs: tuple[PlyPair, ...]
    law: ContactLaw
    name: str = "ply contact"
    searches: str = "ply search"

    def start(self) -> PlyMemory:
        """Nothing found yet."""
        n, pairs, real = self.mass.shape[0], len(self.pairs), wp.float64
        slots = sum(self.spans[pair.searching].vertex_count for pair in self.pairs)

        def zeros(count: int, dtype: Any) -> wp.array:
            return wp.zeros(count, dtype=dtype, device=self.device)

        return PlyMemory(
            normals=zeros(n, wp.vec3d),
            hollows=zeros(n, wp.vec2d),
            seen=zeros(slots, kernels.PlyMemory),
            contacts=zeros(slots, kernels.PlyContact),
            springs=zeros(slots, wp.vec3d),
            dashpots=zeros(slots, real),
            stored=zeros(slots, real),
            slip=zeros(slots, real),
            spent=zeros(slots, real),
            deepest=zeros(pairs, real),
            jump=zeros(pairs, real),
        )

    def launches(self, share: Share, bodies: Bodies, memory: PlyMemory) -> Launches:
        """Searches of a part's own vertices, and the forces of what they found."""
        x = bodies.plies.x
        prepare, measure = [], []
        for first, count in share.vertices:
            inputs = [first, self.facets, x]
            prepare.append(Launch(kernels.compute_vertex_normals, count, inputs, [memory.normals]))
            inputs = [first, self.facets, x, memory.normals]
            measure.append(Launch(kernels.compute_hollows, count, inputs, [memory.hollows]))
        copy = [
            Launch(
                kernels.copy_to_single,
                self.spans[number].vertex_count,
                [self.spans[number].first_vertex, x],
                [self.meshes[number].points],
            )
            for number in share.plies
        ]
        looks = [(pair, run) for pair in self.pairs for run in share.by_ply[pair.searching]]
        return Launches(
            prepare=tuple(prepare),
            copy=tuple(copy),
            refit=tuple(self.meshes[number] for number in share.plies),
            measure=tuple(measure),
            ask=tuple(self._find(*look, bodies.plies, memory, asking=True) for look in looks),
            walk=tuple(self._find(*look, bodies.plies, memory, asking=False) for look in looks),
            scatter=tuple(self._forces(*look, bodies.plies, memory) for look in looks),
        )

    def _slot(self, pair: PlyPair, run: Run) -> int:
        return run.first + pair.first_slot - self.spans[pair.searching].first_vertex

    def _find(
        self, pair: PlyPair, run: Run, plies: PlyState, memory: PlyMemory, *, asking: bool
    ) -> Launch:
        inputs = [
            self.law,
            self.look(pair.faces.thickness, asking=asking),
            self.facets,
            pair.faces,
            pair.number,
            run.first,
            self._slot(pair, run),
            self.mass,
            plies.x,
            memory.normals,
            memory.hollows,
            memory.springs,
            memory.stored,
        ]
        seen = [memory.spent, memory.seen, memory.contacts]
        outputs = [*seen, plies.lost, memory.deepest, memory.jump]
        return Launch(kernels.find_ply_contacts, run.count, inputs, outputs)

    def _forces(self, pair: PlyPair, run: Run, plies: PlyState, memory: PlyMemory) -> Launch:
        inputs = [
            self.law,
            self.scene.ply_friction,
            pair.faces.thickness,
            run.first,
            self._slot(pair, run),
            plies.x,
            plies.v,
            memory.contacts,
        ]
        kept = [memory.springs, memory.dashpots]
        outputs = [*kept, plies.f, plies.lost, memory.stored, memory.slip, memory.spent]
        return Launch(kernels.add_ply_forces, run.count, inputs, outputs)

    def look(self, thickness: float, *, asking: bool) -> PlySearch:
        """How far a search looks for plies that touch at a thickness [m].

        What it does not see must not come near before it asks again.
        """
        search = PlySearch()
        search.asks = int(asking)
        search.reach = near_reach(self.scene)
        beyond = max(3.0 * thickness + 2.0 * search.reach, (1 + ASK_EVERY) * search.reach)
        search.radius = thickness + beyond
        interval = self.timing.search_every * self.timing.time_step
        search.keep = math.exp(-interval / FADING)
        search.ease = PUSH_OUT * peak_speed(self.scene) * interval
        return search

    def measure(self, bodies: Bodies, memory: PlyMemory) -> Measured:
        """Energy in contact springs and friction springs; slip and penetration of each pair."""
        slip, deepest = memory.slip.numpy(), memory.deepest.numpy()
        jump, plies = memory.jump.numpy(), self.scene.plies
        entries = []
        for pair in self.pairs:
            count = self.spans[pair.searching].vertex_count
            of_pair = slip[pair.first_slot : pair.first_slot + count]
            entries.append(
                {
                    "vertices_of": plies[pair.searching].name,
                    "on": plies[pair.searched].name,
                    "max_slip_m": float(of_pair.max()),
                    "mean_slip_m": float(of_pair.mean()),
                    "max_penetration_m": float(deepest[pair.number]),
                    "max_gap_jump_m": float(jump[pair.number]),
                }
            )
        stored = float(memory.stored.numpy().sum())
        return Measured({"contact": stored}, entries={"interfaces": entries})


def build(
    scene: Setup, spans: tuple[Span, ...], timing: Timing, mass: wp.array, device: str
) -> PlyContact | None:
    """Put what searches need of the plies on a device; None for a single ply.

    Args:
        scene: what is computed.
        spans: where plies are.
        timing: the steps.
        mass: vertex masses [kg], shape [vertex].
        device: Warp device.
    """
    if len(scene.plies) == 1:
        return None
    meshes = tuple(
        wp.Mesh(
            wp.array(ply.rest_points, dtype=wp.vec3f, device=device),
            wp.array(np.ravel(ply.mesh.triangles), dtype=wp.int32, device=device),
        )
        for ply in scene.plies
    )
    first_vertex = np.array([*(s.first_vertex for s in spans), mass.shape[0]])
    facets = build_facets([ply.mesh.triangles for ply in scene.plies], first_vertex, device)
    return PlyContact(
        device,
        scene,
        timing,
        spans,
        mass,
        facets,
        meshes,
        _pairs(scene, meshes, spans),
        contact_law(scene, timing.time_step),
    )


def _pairs(scene: Setup, meshes: tuple[wp.Mesh, ...], spans: tuple[Span, ...]) -> tuple:
    pairs, slot = [], 0
    for searching, ply in enumerate(scene.plies):
        for searched, other in enumerate(scene.plies):
            if searching == searched:
                continue
            faces = PlyFaces()
            faces.mesh = meshes[searched].id
            faces.first_triangle = spans[searched].first_triangle
            faces.side = 1.0 if searching > searched else -1.0
            faces.thickness = 0.5 * (ply.fabric.thickness + other.fabric.thickness)
            pairs.append(PlyPair(len(pairs), searching, searched, slot, faces))
            slot += spans[searching].vertex_count
    return tuple(pairs)
