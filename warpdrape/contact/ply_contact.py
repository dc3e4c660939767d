"""Contact between plies: what it needs on a device, its launches, energy and entries."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import warp as wp

from warpdrape.contact.law import contact_law
from warpdrape.contact.ply_surfaces import PlySurfaces, ply_search
from warpdrape.interaction import Bodies, Launch, Launches, Measured, Run, Share, Span
from warpdrape.kernels.contact import on_ply
from warpdrape.kernels.contact import ply_contact as kernels
from warpdrape.kernels.contact.contact import ContactLaw
from warpdrape.kernels.contact.ply_contact import PlyFaces
from warpdrape.setup import Setup
from warpdrape.state import Across, Apart, PlyState
from warpdrape.timing import Timing


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
        surfaces: the plies' surfaces.
        pairs: directed pairs of plies that may touch.
        law: the contact law.
    """

    device: str
    scene: Setup
    timing: Timing
    spans: tuple[Span, ...]
    mass: wp.array
    surfaces: PlySurfaces
    pairs: tuple[PlyPair, ...]
    law: ContactLaw
    name: str = "ply contact"
    searches: str = "ply search"

    def start(self) -> PlyMemory:
        """Nothing found yet."""
        pairs, real = len(self.pairs), wp.float64
        slots = sum(self.spans[pair.searching].vertex_count for pair in self.pairs)

        def zeros(count: int, dtype: Any) -> wp.array:
            return wp.zeros(count, dtype=dtype, device=self.device)

        return PlyMemory(
            seen=zeros(slots, on_ply.PlyMemory),
            contacts=zeros(slots, on_ply.PlyContact),
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
        looks = [(pair, run) for pair in self.pairs for run in share.by_ply[pair.searching]]
        return Launches(
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
            ply_search(self.scene, self.timing, pair.faces.thickness, asking=asking),
            self.surfaces.facets,
            pair.faces,
            pair.number,
            run.first,
            self._slot(pair, run),
            self.mass,
            plies.x,
            self.surfaces.normals,
            self.surfaces.hollows,
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
    scene: Setup,
    spans: tuple[Span, ...],
    timing: Timing,
    mass: wp.array,
    surfaces: PlySurfaces | None,
    device: str,
) -> PlyContact | None:
    """Put what searches need of the plies on a device; None for a single ply.

    Args:
        scene: what is computed.
        spans: where plies are.
        timing: the steps.
        mass: vertex masses [kg], shape [vertex].
        surfaces: the plies' surfaces.
        device: Warp device.
    """
    if len(scene.plies) == 1:
        return None
    return PlyContact(
        device,
        scene,
        timing,
        spans,
        mass,
        surfaces,
        _pairs(scene, surfaces.meshes, spans),
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
