"""Contact of edges with edges, between plies and within one: launches, energy and entries."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp

from warpdrape.contact import press_through
from warpdrape.contact.compaction import Pads
from warpdrape.contact.law import contact_law
from warpdrape.contact.ply_contact import thickest
from warpdrape.contact.ply_edges import build_edges
from warpdrape.contact.ply_surfaces import PlySurfaces, ply_search
from warpdrape.contact.pressure import LOWER, UPPER, depths_now, on_corners
from warpdrape.contact.self_contact import flat_plies
from warpdrape.contact.slots import SlotMemory
from warpdrape.contact.stack import ply_stack
from warpdrape.interaction import Bodies, Launch, Launches, Measured, Run, Share, Span, Swept
from warpdrape.kernels.contact import edge_contact as kernels
from warpdrape.kernels.contact import ridges
from warpdrape.kernels.contact.contact import CompactionLaws, ContactLaw
from warpdrape.kernels.contact.edge_contact import EdgeSlots
from warpdrape.kernels.contact.edge_search import Sheets
from warpdrape.kernels.contact.ridges import Ridges
from warpdrape.setup import Setup
from warpdrape.state import PlyState
from warpdrape.timing import Timing


@dataclass(frozen=True, eq=False)
class EdgeContactMemory(SlotMemory):
    """What contact of edges remembers; a slot is an edge, a pair two plies or a ply and itself.

    Attributes:
        ridges: to which side edges stick out, 2 for both, shape [edge].
        pressing: whether an edge may touch before the next search, shape [edge].
        watched: whether edges of a vertex are ridges or touch, shape [vertex].
        touching: whether they may touch before the next search, shape [vertex].
    """

    ridges: wp.array
    pressing: wp.array
    watched: wp.array
    touching: wp.array

    @property
    def kept(self) -> EdgeSlots:
        """For the kernels."""
        kept = EdgeSlots()
        kept.memory, kept.slots, kept.pressing = self.seen, self.slots, self.pressing
        kept.deepest, kept.jump = self.deepest, self.jump
        return kept


@dataclass(frozen=True, eq=False)
class EdgeContact:
    """Contact of the plies' edges with each other.

    Attributes:
        device: Warp device.
        scene: what is computed.
        timing: the steps.
        mass: vertex masses [kg], shape [vertex].
        spans: where plies are.
        sheets: the plies, for the kernels.
        hollows: room on either side of a vertex [m], shape [vertex].
        law: the contact law.
        laws: of compaction.
    """

    device: str
    scene: Setup
    timing: Timing
    mass: wp.array
    spans: tuple[Span, ...]
    sheets: Sheets
    hollows: wp.array
    law: ContactLaw
    laws: CompactionLaws
    name: str = "edge contact"
    searches: str = "edge search"

    def start(self) -> EdgeContactMemory:
        """Nothing found yet."""
        pairs, device = len(self.scene.plies) ** 2, self.device
        edges, vertices = self.sheets.edges.ends.shape[0], self.mass.shape[0]
        return EdgeContactMemory(
            **SlotMemory.empty(edges, pairs, kernels.EdgeMemory, device),
            ridges=wp.zeros(edges, dtype=wp.int32, device=device),
            pressing=wp.zeros(edges, dtype=wp.int32, device=device),
            watched=wp.zeros(vertices, dtype=wp.int32, device=device),
            touching=wp.zeros(vertices, dtype=wp.int32, device=device),
        )

    def launches(self, share: Share, bodies: Bodies, memory: EdgeContactMemory) -> Launches:
        """Searches of the edges that begin at a part's own vertices, and what these bring."""
        plies, part = bodies.plies, share.number
        own = [(number, run) for number, runs in enumerate(share.by_ply) for run in runs]
        return Launches(
            copy=tuple(self._mark(run, plies, memory) for run in share.vertices),
            ask=tuple(self._find(*each, part, plies, memory, asking=True) for each in own),
            walk=tuple(self._find(*each, part, plies, memory, asking=False) for each in own),
            scatter=tuple(self._forces(run, plies, memory) for run in share.vertices)
            + tuple(
                launch
                for run in share.vertices
                for launch in press_through.of_edges(run, self.sheets.edges, memory, bodies)
            ),
        )

    def _mark(self, run: Run, plies: PlyState, memory: EdgeContactMemory) -> Swept:
        inputs = [self.sheets.facets, self.sheets.edges, plies.x, memory.pressing]
        outputs = [memory.ridges, memory.watched]
        return Swept(ridges.find_ridges, run, inputs, outputs)

    def _find(
        self,
        number: int,
        run: Run,
        part: int,
        plies: PlyState,
        memory: EdgeContactMemory,
        *,
        asking: bool,
    ) -> Swept:
        thickness = thickest(self.scene)
        search = ply_search(self.scene, self.timing, plies, part, thickness, asking=asking)
        now = Ridges()
        now.x, now.hollows, now.ways = plies.x, self.hollows, memory.ridges
        inputs = [self.law, self.laws, search, self.sheets, now, number, memory.watched]
        outputs = [memory.kept, memory.touching, plies.lost]
        return Swept(kernels.find_edge_contacts, run, inputs, outputs)

    def _forces(self, run: Run, plies: PlyState, memory: EdgeContactMemory) -> Launch:
        inputs = [self.law, self.laws, self.sheets.edges, run.first, plies.x, plies.v]
        inputs += [memory.touching]
        outputs = [memory.kept, plies.f, plies.lost]
        return Launch(kernels.add_edge_forces, run.count, inputs, outputs)

    def measure(self, bodies: Bodies, memory: EdgeContactMemory) -> Measured:
        """Energy in contact springs and friction springs, pressure, and depth of each pair."""
        stored = memory.stored.numpy()
        return Measured(
            {"contact": float(stored.sum())},
            pressing={"contact_pressure": self._pressing(memory)},
            entries={"edge_contact": self._entries(bodies, memory, stored)},
        )

    def _entries(
        self, bodies: Bodies, memory: EdgeContactMemory, stored: np.ndarray
    ) -> list[dict[str, Any]]:
        """An entry for each two plies, or ply, whose edges have met.

        Penetration is how far they press into each other. What lay in each other before both were
        ridges, as chords do where the mesh is coarse, is the jump of the gap.
        """
        x, contacts, seen = (a.numpy() for a in (bodies.plies.x, memory.contacts, memory.seen))
        ends, share = self.sheets.edges.ends.numpy(), seen["share"][:, None]
        points = (1.0 - share) * x[ends[:, 0]] + share * x[ends[:, 1]]
        (near,) = np.nonzero(contacts["near"])
        depths = (depths_now(contacts, points, x) - contacts["allowance"])[near]
        own, other = (self._plies_of(at[near]) for at in (ends[:, 0], contacts["a"]))
        count = len(self.scene.plies)
        pair = own * count + other
        touching = np.bincount(pair, stored[near] > 0.0, count**2)
        deepest, slip = memory.deepest.numpy().copy(), np.zeros(count**2)
        np.maximum.at(deepest, pair, depths)
        np.maximum.at(slip, pair, memory.slip.numpy()[near])
        jump = memory.jump.numpy()
        return [
            {
                "edges_of": self.scene.plies[met // count].name,
                "on": self.scene.plies[met % count].name,
                "touching_edges": int(touching[met]),
                "max_slip_m": float(slip[met]),
                "max_penetration_m": float(deepest[met]),
                "max_gap_jump_m": float(jump[met]),
            }
            for met in np.flatnonzero((deepest > 0.0) | (touching > 0.0)).tolist()
        ]

    def _pressing(self, memory: EdgeContactMemory) -> np.ndarray:
        """Normal forces on lower and upper faces [N], shape [2, vertex]."""
        forces, vertices = memory.forces.numpy(), self.mass.shape[0]
        pressing = np.zeros((2, vertices))
        if not forces.any():
            return pressing
        contacts, ends = memory.contacts.numpy(), self.sheets.edges.ends.numpy()
        share = memory.seen.numpy()["share"]
        way_out, other = self._ways(memory)
        for face, way in ((UPPER, 1), (LOWER, -1)):
            mine = np.where(way_out == way, forces, 0.0)
            for end, part in ((0, 1.0 - share), (1, share)):
                pressing[face] += np.bincount(ends[:, end], mine * part, vertices)
            pressing[face] += on_corners(contacts, np.where(other == way, forces, 0.0), vertices)
        return pressing

    def _ways(self, memory: EdgeContactMemory) -> tuple[np.ndarray, np.ndarray]:
        """To which sides of their plies edges and what they touch look, +1 up, shape [edge]."""
        ridges, contacts = memory.ridges.numpy(), memory.contacts.numpy()
        own = self._plies_of(self.sheets.edges.ends.numpy()[:, 0])
        way = np.sign(self._plies_of(contacts["a"]) - own)
        met = ridges[np.maximum(memory.seen.numpy()["other"] - 1, 0)]
        return np.where(way == 0, ridges, way), np.where(way == 0, met, -way)

    def _plies_of(self, vertices: np.ndarray) -> np.ndarray:
        """Numbers of the plies that vertices are of."""
        firsts = [span.first_vertex for span in self.spans]
        return np.searchsorted(firsts, vertices, side="right") - 1


def build(
    scene: Setup,
    spans: tuple[Span, ...],
    timing: Timing,
    mass: wp.array,
    surfaces: PlySurfaces,
    pads: Pads,
    device: str,
) -> EdgeContact | None:
    """Put the plies' edges on a device; None for a single ply that does not touch itself.

    Args:
        scene: what is computed.
        spans: where plies are.
        timing: the steps.
        mass: vertex masses [kg], shape [vertex].
        surfaces: the plies' surfaces.
        pads: what gives way in contacts.
        device: Warp device.
    """
    if len(scene.plies) == 1 and not scene.touches_itself(scene.plies[0]):
        return None
    sheets = Sheets()
    triangles = [ply.mesh.triangles for ply in scene.plies]
    sheets.facets, sheets.patches = surfaces.facets, surfaces.patches
    sheets.edges = build_edges(triangles, spans, device)
    sheets.flat = flat_plies(scene.plies, pads, device)
    sheets.stack = ply_stack(scene, surfaces, spans, pads, device)
    folds = [int(scene.touches_itself(ply)) for ply in scene.plies]
    sheets.folds = wp.array(folds, dtype=wp.int32, device=device)
    sheets.mass = mass
    law = contact_law(scene, timing.time_step, device)
    hollows = surfaces.hollows
    return EdgeContact(device, scene, timing, mass, spans, sheets, hollows, law, pads.laws)
