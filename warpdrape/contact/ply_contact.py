"""Contact between plies: what it needs on a device, its launches, energy and entries."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import warp as wp

from warpdrape.contact import press_through
from warpdrape.contact.compaction import Pads
from warpdrape.contact.interfaces import forces_of_pairs, interface_entries, pressing_on_faces
from warpdrape.contact.law import contact_law
from warpdrape.contact.partners import Partners, find_partners
from warpdrape.contact.ply_heat import PlyHeat, ply_heat
from warpdrape.contact.ply_surfaces import PlySurfaces, ply_search
from warpdrape.contact.pressure import depths_now, vertex_shapes
from warpdrape.contact.slots import SlotMemory
from warpdrape.contact.stack import ply_stack
from warpdrape.interaction import Bodies, Launch, Launches, Measured, Run, Share, Span, Swept
from warpdrape.kernels.contact import on_ply
from warpdrape.kernels.contact import ply_contact as kernels
from warpdrape.kernels.contact.contact import CompactionLaws, ContactLaw
from warpdrape.kernels.contact.ply_contact import PlyStack
from warpdrape.setup import Setup
from warpdrape.state import PlyState
from warpdrape.timing import Timing


@dataclass(frozen=True)
class PlyLook:
    """Vertices of one ply that look for the plies above it, or below.

    Attributes:
        searching: number of the ply whose vertices look.
        way: +1 up, −1 down.
        first_slot: where these contacts begin.
    """

    searching: int
    way: int
    first_slot: int


@dataclass(frozen=True, eq=False)
class PlyContact:
    """Contact of all plies with each other; a slot is a vertex and the plies on one side of it.

    Attributes:
        device: Warp device.
        scene: what is computed.
        timing: the steps.
        spans: where plies are.
        mass: vertex masses [kg], shape [vertex].
        surfaces: the plies' surfaces.
        stack: the plies, for the kernels.
        looks: whose vertices look which way.
        partners: which places lay on each other.
        law: the contact law.
        laws: of compaction.
        heat: what passes between them, None where none cools.
    """

    device: str
    scene: Setup
    timing: Timing
    spans: tuple[Span, ...]
    mass: wp.array
    surfaces: PlySurfaces
    stack: PlyStack
    looks: tuple[PlyLook, ...]
    partners: Partners
    law: ContactLaw
    laws: CompactionLaws
    heat: PlyHeat | None
    name: str = "ply contact"
    searches: str = "ply search"

    def start(self) -> SlotMemory:
        """Nothing found yet."""
        slots = sum(self.spans[look.searching].vertex_count for look in self.looks)
        pairs = len(self.scene.plies) ** 2
        return SlotMemory(**SlotMemory.empty(slots, pairs, on_ply.PlyMemory, self.device))

    def launches(self, share: Share, bodies: Bodies, memory: SlotMemory) -> Launches:
        """Searches of a part's own vertices, and the forces of what they found."""
        part = share.number
        looks = [(look, run) for look in self.looks for run in share.by_ply[look.searching]]
        return Launches(
            ask=tuple(self._find(*look, part, bodies.plies, memory, asking=True) for look in looks),
            walk=tuple(
                self._find(*look, part, bodies.plies, memory, asking=False) for look in looks
            ),
            scatter=tuple(self._forces(*look, bodies.plies, memory) for look in looks)
            + self._heat(looks, bodies, memory)
            + tuple(
                launch
                for look, run in looks
                for launch in press_through.of_vertices(
                    run, self._slot(look, run), memory.slots, bodies
                )
            ),
        )

    def _slot(self, look: PlyLook, run: Run) -> int:
        return run.first + look.first_slot - self.spans[look.searching].first_vertex

    def _find(
        self,
        look: PlyLook,
        run: Run,
        part: int,
        plies: PlyState,
        memory: SlotMemory,
        *,
        asking: bool,
    ) -> Swept:
        thickness = thickest(self.scene)
        inputs = [
            self.law,
            self.laws,
            ply_search(self.scene, self.timing, plies, part, thickness, asking=asking),
            self.surfaces.facets,
            self.stack,
            look.searching,
            look.way,
            self._slot(look, run),
            self.mass,
            plies.x,
            self.surfaces.normals,
            self.surfaces.hollows,
        ]
        outputs = [memory.seen, memory.slots, plies.lost, memory.deepest, memory.jump]
        return Swept(kernels.find_ply_contacts, run, inputs, outputs)

    def _forces(self, look: PlyLook, run: Run, plies: PlyState, memory: SlotMemory) -> Swept:
        inputs = [
            self.law,
            self.laws,
            self._slot(look, run),
            plies.x,
            plies.v,
        ]
        outputs = [memory.slots, plies.f, plies.lost]
        return Swept(kernels.add_ply_forces, run, inputs, outputs)

    def _heat(
        self, looks: Sequence[tuple[PlyLook, Run]], bodies: Bodies, memory: SlotMemory
    ) -> tuple[Launch, ...]:
        if self.heat is None:
            return ()
        return tuple(
            launch
            for look, run in looks
            for launch in self.heat.launches(
                look.searching, run, self._slot(look, run), bodies, memory.seen, memory.slots
            )
        )

    def measure(self, bodies: Bodies, memory: SlotMemory) -> Measured:
        """Energy in contact springs and friction springs; pressure, slip, depth of each pair."""
        x = bodies.plies.x.numpy()
        normals, areas = vertex_shapes(x, self.surfaces.facets.corners.numpy())
        slip = self.partners.slip(x, normals)
        met = forces_of_pairs(self.looks, self.spans, memory, len(x))
        points = np.concatenate([x[self.spans[look.searching].vertices] for look in self.looks])
        depths = depths_now(memory.contacts.numpy(), points, x)
        entries = interface_entries(
            [ply.name for ply in self.scene.plies],
            self.looks,
            self.spans,
            self.partners,
            memory,
            depths,
            met,
            areas,
            slip,
        )
        return Measured(
            {"contact": float(memory.stored.numpy().sum())},
            fields=tuple({"slip": slip[span.vertices]} for span in self.spans),
            pressing={"contact_pressure": pressing_on_faces(met, len(x))},
            entries={"interfaces": entries},
        )


def thickest(scene: Setup) -> float:
    """Largest distance of mid-surfaces in contact [m]."""
    return max(ply.fabric.thickness for ply in scene.plies)


def build(
    scene: Setup,
    spans: tuple[Span, ...],
    timing: Timing,
    mass: wp.array,
    surfaces: PlySurfaces,
    pads: Pads,
    device: str,
) -> PlyContact | None:
    """Put what searches need of the plies on a device; None for a single ply.

    Args:
        scene: what is computed.
        spans: where plies are.
        timing: the steps.
        mass: vertex masses [kg], shape [vertex].
        surfaces: the plies' surfaces.
        pads: what gives way in contacts.
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
        ply_stack(scene, surfaces, spans, pads, device),
        _looks(spans),
        find_partners(scene.plies, surfaces),
        contact_law(scene, timing.time_step, device),
        pads.laws,
        ply_heat(scene, timing, device),
    )


def _looks(spans: tuple[Span, ...]) -> tuple[PlyLook, ...]:
    looks, slot = [], 0
    for searching, span in enumerate(spans):
        for way in (-1, 1):
            if 0 <= searching + way < len(spans):
                looks.append(PlyLook(searching, way, slot))
                slot += span.vertex_count
    return tuple(looks)
