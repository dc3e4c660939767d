"""Contact of a ply with itself: which plies, what it needs on a device, launches, entries."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import warp as wp

from warpdrape.blanks.ply import Ply
from warpdrape.contact import press_through
from warpdrape.contact.compaction import Pads
from warpdrape.contact.friction import rub
from warpdrape.contact.law import contact_law
from warpdrape.contact.ply_surfaces import PlySurfaces, ply_search
from warpdrape.contact.pressure import (
    LOWER,
    UPPER,
    depths_now,
    on_corners,
    vertex_shapes,
)
from warpdrape.contact.slots import SlotMemory
from warpdrape.interaction import Bodies, Launch, Launches, Measured, Run, Share, Span, Swept
from warpdrape.kernels.contact import folds
from warpdrape.kernels.contact import self_contact as kernels
from warpdrape.kernels.contact.contact import CompactionLaws, ContactLaw
from warpdrape.kernels.contact.fold_search import FlatPly
from warpdrape.kernels.contact.folds import Patches
from warpdrape.kernels.contact.self_contact import SearchedSelf, SelfSlots
from warpdrape.setup import Setup
from warpdrape.state import Across, Apart, PlyState
from warpdrape.timing import Timing

THICKNESSES_APART = 4.0
"""Distance along the flat ply, in thicknesses, from which on points may touch. Pressed shut, the
sides of a fold are a thickness apart π/2 thicknesses along it; shear of 70° brings points of a
flat ply to a quarter of their distance."""
SIDES_APART = 1.25
"""The same in sides of triangles, the longest at the vertex: a fold goes along a row of edges."""


@dataclass(frozen=True, eq=False)
class SelfContactMemory(SlotMemory):
    """What it remembers; a slot is a vertex and a side of its ply, a pair a ply and itself.

    Attributes:
        pressing: whether a vertex may touch before the next search, shape [vertex].
        passed: way of vertices over what searches had seen where folds passed each other [-],
            shape [ply].
    """

    pressing: wp.array
    passed: wp.array
    apart: ClassVar[Apart] = {**SlotMemory.apart, "passed": Across.LARGEST}

    @property
    def kept(self) -> SelfSlots:
        """For the kernels."""
        kept = SelfSlots()
        kept.seen, kept.slots, kept.pressing = self.seen, self.slots, self.pressing
        kept.deepest, kept.jump, kept.passed = self.deepest, self.jump, self.passed
        return kept


@dataclass(frozen=True, eq=False)
class SelfContact:
    """Contact of plies with themselves.

    Attributes:
        device: Warp device.
        scene: what is computed.
        timing: the steps.
        mass: vertex masses [kg], shape [vertex].
        surfaces: the plies' surfaces.
        flat: the flat plies.
        plies: those that may touch themselves, for the kernels.
        patches: all plies cut into patches.
        runs: which patches are of each ply.
        law: the contact law.
        laws: of compaction.
    """

    device: str
    scene: Setup
    timing: Timing
    mass: wp.array
    surfaces: PlySurfaces
    flat: FlatPly
    plies: tuple[SearchedSelf, ...]
    patches: Patches
    runs: tuple[Run, ...]
    law: ContactLaw
    laws: CompactionLaws
    name: str = "self-contact"
    searches: str = "self-search"

    def start(self) -> SelfContactMemory:
        """Nothing found yet."""
        slots, plies = 2 * sum(ply.vertices for ply in self.plies), len(self.scene.plies)
        device = self.device
        return SelfContactMemory(
            **SlotMemory.empty(slots, plies, wp.int32, device),
            pressing=wp.zeros(self.mass.shape[0], dtype=wp.int32, device=device),
            passed=wp.zeros(plies, dtype=wp.float64, device=device),
        )

    def launches(self, share: Share, bodies: Bodies, memory: SelfContactMemory) -> Launches:
        """Searches of a part's own vertices, and the forces of what they found."""
        plies, part = bodies.plies, share.number
        own = [(ply, run) for ply in self.plies for run in share.by_ply[ply.number]]
        marked = self.plies if self.scene.numerics.contact == "fast" else ()
        in_care = [ply for ply in marked if ply.number in share.plies]
        return Launches(
            copy=tuple(self._bound(ply, plies) for ply in in_care),
            measure=tuple(self._mark(ply, part, plies) for ply in in_care),
            ask=tuple(self._find(*each, part, plies, memory, asking=True) for each in own),
            walk=tuple(self._find(*each, part, plies, memory, asking=False) for each in own),
            scatter=tuple(self._forces(*each, plies, memory) for each in own)
            + tuple(
                launch
                for ply, run in own
                for slot in self._slots(ply, run)
                for launch in press_through.of_vertices(run, slot, memory.slots, bodies)
            ),
        )

    def _slots(self, ply: SearchedSelf, run: Run) -> tuple[int, int]:
        """First contacts of a run of its vertices on either side."""
        first = ply.first_slot + run.first - ply.first_vertex
        return first, first + ply.vertices

    def _bound(self, ply: SearchedSelf, plies: PlyState) -> Launch:
        first, count = self.runs[ply.number]
        inputs = [self.surfaces.facets, plies.x, first]
        return Launch(folds.bound_patches, count, inputs, [self.patches])

    def _mark(self, ply: SearchedSelf, part: int, plies: PlyState) -> Launch:
        """Comes after the pace of this search is set, which the plies' surfaces do."""
        first, count = self.runs[ply.number]
        search = ply_search(self.scene, self.timing, plies, part, ply.thickness, asking=True)
        return Launch(folds.mark_folds, count, [self.patches, first, count, search], [])

    def _find(
        self,
        ply: SearchedSelf,
        run: Run,
        part: int,
        plies: PlyState,
        memory: SelfContactMemory,
        *,
        asking: bool,
    ) -> Swept:
        thickness = ply.thickness
        search = ply_search(self.scene, self.timing, plies, part, thickness, asking=asking)
        inputs = [self.law, self.laws, search, self.surfaces.facets, self.flat, ply]
        inputs += [self.patches, self.mass, plies.x, plies.v]
        outputs = [memory.kept, plies.lost]
        return Swept(kernels.find_self_contacts, run, inputs, outputs)

    def _forces(
        self, ply: SearchedSelf, run: Run, plies: PlyState, memory: SelfContactMemory
    ) -> Launch:
        inputs = [self.law, self.laws, ply, run.first, plies.x, plies.v]
        outputs = [memory.kept, plies.f, plies.lost]
        return Launch(kernels.add_self_forces, run.count, inputs, outputs)

    def measure(self, bodies: Bodies, memory: SelfContactMemory) -> Measured:
        """Energy in contact springs and friction springs; slip and penetration of each ply."""
        stored, slip = memory.stored.numpy(), memory.slip.numpy()
        pressing = self._pressing(bodies, memory)
        deepest, jump = memory.deepest.numpy(), memory.jump.numpy()
        contacts, x = memory.contacts.numpy(), bodies.plies.x.numpy()
        entries = []
        for ply in self.plies:
            slots = slice(ply.first_slot, ply.first_slot + 2 * ply.vertices)
            own = x[ply.first_vertex : ply.first_vertex + ply.vertices]
            now = depths_now(contacts[slots], np.tile(own, (2, 1)), x).max(initial=0.0)
            touching = (stored[slots] > 0.0).reshape(2, -1).any(axis=0)
            entries.append(
                {
                    "ply": self.scene.plies[ply.number].name,
                    "touching_vertices": int(touching.sum()),
                    "max_slip_m": float(slip[slots].max()),
                    "max_penetration_m": float(max(deepest[ply.number], now)),
                    "max_gap_jump_m": float(jump[ply.number]),
                }
            )
        return Measured(
            {"contact": float(stored.sum())},
            pressing={"contact_pressure": pressing},
            entries={"self_contact": entries},
            warnings=self._passing(memory),
        )

    def _passing(self, memory: SelfContactMemory) -> tuple[str, ...]:
        passed = memory.passed.numpy()
        return tuple(
            f"ply {self.scene.plies[ply].name!r} gained speed faster than its self-contact looks "
            f"ahead (by {passed[ply]:.3g} times) and its folds passed each other: load it more "
            "slowly, or set contact to exact"
            for ply in np.flatnonzero(passed).tolist()
        )

    def _pressing(self, bodies: Bodies, memory: SelfContactMemory) -> np.ndarray:
        """Normal forces on lower and upper faces [N], shape [2, vertex]."""
        x, contacts = bodies.plies.x.numpy(), memory.contacts.numpy()
        forces = memory.forces.numpy()
        pressing = np.zeros((2, len(x)))
        if not forces.any():
            return pressing
        normals, _ = vertex_shapes(x, self.surfaces.facets.corners.numpy())
        for ply in self.plies:
            vertices = slice(ply.first_vertex, ply.first_vertex + ply.vertices)
            for side, face in ((0, UPPER), (1, LOWER)):
                first = ply.first_slot + side * ply.vertices
                slots = slice(first, first + ply.vertices)
                own, seen = forces[slots], contacts[slots]
                pressing[face] += on_corners(seen, own, len(x))
                above = (normals[vertices] * seen["normal"]).sum(axis=1) < 0.0
                pressing[UPPER, vertices] += np.where(above, own, 0.0)
                pressing[LOWER, vertices] += np.where(above, 0.0, own)
        return pressing


def build(
    scene: Setup,
    spans: tuple[Span, ...],
    timing: Timing,
    mass: wp.array,
    surfaces: PlySurfaces,
    pads: Pads,
    device: str,
) -> SelfContact | None:
    """Put on a device what searches need of the plies that touch themselves; None if none does.

    Args:
        scene: what is computed.
        spans: where plies are.
        timing: the steps.
        mass: vertex masses [kg], shape [vertex].
        surfaces: the plies' surfaces.
        pads: what gives way in contacts.
        device: Warp device.
    """
    numbers = [n for n, ply in enumerate(scene.plies) if scene.touches_itself(ply)]
    if not numbers:
        return None
    plies, slot = [], 0
    for number in numbers:
        ply, span, searched = scene.plies[number], spans[number], SearchedSelf()
        searched.mesh = surfaces.meshes[number].id
        searched.number = number
        searched.first_triangle = span.first_triangle
        searched.first_vertex = span.first_vertex
        searched.vertices = span.vertex_count
        searched.first_slot = slot
        searched.thickness = ply.fabric.thickness
        searched.rub = rub(scene, scene.friction_between(ply, ply))
        searched.pad = int(pads.of_plies[number, number])
        plies.append(searched)
        slot += 2 * span.vertex_count
    law = contact_law(scene, timing.time_step, device)
    patches, runs = surfaces.patches, surfaces.patch_runs
    flat = flat_plies(scene.plies, pads, device)
    return SelfContact(
        device, scene, timing, mass, surfaces, flat, tuple(plies), patches, runs, law, pads.laws
    )


def flat_plies(plies: Sequence[Ply], pads: Pads, device: str) -> FlatPly:
    """Put on a device where the plies' vertices lie on the flat sheets.

    Args:
        plies: all plies.
        pads: what gives way in contacts.
        device: Warp device.
    """
    flat = FlatPly()
    places = np.concatenate([ply.rest_points for ply in plies])
    flat.places = wp.array(places, dtype=wp.vec3d, device=device)
    apart = np.concatenate([_apart(ply) for ply in plies])
    flat.apart = wp.array(apart, dtype=wp.float64, device=device)
    # Vertices of both folds bear what is between them, each with half of its area.
    flat.areas = wp.array(0.5 * pads.areas, dtype=wp.float64, device=device)
    return flat


def _apart(ply: Ply) -> np.ndarray:
    """Distance along the flat ply from which on points may touch a vertex [m], shape [n]."""
    points, triangles = np.asarray(ply.mesh.vertices), np.asarray(ply.mesh.triangles)
    longest = np.zeros(len(points))
    for side in ((0, 1), (1, 2), (2, 0)):
        ends = triangles[:, side]
        length = np.linalg.norm(points[ends[:, 0]] - points[ends[:, 1]], axis=1)
        for end in ends.T:
            np.maximum.at(longest, end, length)
    return np.maximum(THICKNESSES_APART * ply.fabric.thickness, SIDES_APART * longest)
