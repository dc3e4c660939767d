"""Contact of what is finer of a tool than the plies' meshes with the plies' triangles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import warp as wp

from warpdrape.contact import press_through
from warpdrape.contact.compaction import Pads
from warpdrape.contact.features import points_of
from warpdrape.contact.friction import rubs
from warpdrape.contact.law import contact_law
from warpdrape.contact.ply_surfaces import PlySurfaces, ply_search
from warpdrape.contact.pressure import on_corners
from warpdrape.interaction import Bodies, Launch, Launches, Measured, Share, Span
from warpdrape.kernels.contact import feature_search, on_ply
from warpdrape.kernels.contact.contact import CompactionLaws, ContactLaw
from warpdrape.kernels.contact.feature_search import SearchedPly
from warpdrape.kernels.contact.tool_features import Features, add_feature_forces
from warpdrape.kernels.tool_pose import TurningTools
from warpdrape.setup import Setup
from warpdrape.state import Across, Apart
from warpdrape.timing import Timing
from warpdrape.tool_pose import tool_poses, turning_tools


@dataclass(frozen=True, eq=False)
class FeatureContactMemory:
    """What it remembers; a slot is a point of a tool and a ply.

    Attributes:
        seen: of the searches, shape [slot].
        contacts: the nearest triangle, shape [slot].
        presses: points that may press a triangle, shape [triangle].
        springs: friction springs [m], shape [slot].
        dashpots: dashpot forces of the step before [N], shape [slot].
        stored: energy in contact [J], shape [slot].
        pressing: normal forces [N], shape [slot].
        spent: what a contact has lost since it came near, less what was taken back [J],
            shape [slot].
        lost: (friction, contact damping) [J], shape [slot].
        deepest: deepest penetration of each tool [m], shape [tool].
    """

    seen: wp.array
    contacts: wp.array
    presses: wp.array
    springs: wp.array
    dashpots: wp.array
    stored: wp.array
    pressing: wp.array
    spent: wp.array
    lost: wp.array
    deepest: wp.array
    apart: ClassVar[Apart] = {"deepest": Across.LARGEST}


@dataclass(frozen=True, eq=False)
class FeatureContact:
    """Contact of points of the tools with the plies' triangles.

    They are few: part 0 alone does them, after it has moved the tools.

    Attributes:
        device: Warp device.
        scene: what is computed.
        timing: the steps.
        spans: where plies are.
        surfaces: the plies' surfaces.
        features: points of the tools.
        plies: the searched plies, for the kernels.
        law: the contact law.
        laws: of compaction, which points of tools do without.
        turning: which tools turn.
    """

    device: str
    scene: Setup
    timing: Timing
    spans: tuple[Span, ...]
    surfaces: PlySurfaces
    features: Features
    plies: tuple[SearchedPly, ...]
    law: ContactLaw
    laws: CompactionLaws
    turning: TurningTools
    name: str = "tool features"
    searches: str = "feature search"

    @property
    def count(self) -> int:
        """Number of points."""
        return self.features.points.shape[0]

    def start(self) -> FeatureContactMemory:
        """Nothing found yet."""
        slots, real = self.count * len(self.plies), wp.float64

        def zeros(count: int, dtype: Any) -> wp.array:
            return wp.zeros(count, dtype=dtype, device=self.device)

        return FeatureContactMemory(
            seen=zeros(slots, feature_search.FeatureMemory),
            contacts=zeros(slots, on_ply.PlyContact),
            presses=zeros(self.spans[-1].triangles.stop, wp.int32),
            springs=zeros(slots, wp.vec3d),
            dashpots=zeros(slots, real),
            stored=zeros(slots, real),
            pressing=zeros(slots, real),
            spent=zeros(slots, real),
            lost=zeros(slots, wp.vec2d),
            deepest=zeros(len(self.scene.tools), real),
        )

    def launches(self, share: Share, bodies: Bodies, memory: FeatureContactMemory) -> Launches:
        """All of it by part 0."""
        if share.number > 0:
            return Launches()
        return Launches(
            ask=self._search(bodies, memory, asking=True),
            walk=self._search(bodies, memory, asking=False),
            scatter=tuple(self._forces(number, bodies, memory) for number in range(len(self.plies)))
            + press_through.of_points(memory.contacts, memory.pressing, bodies),
        )

    def _search(
        self, bodies: Bodies, memory: FeatureContactMemory, *, asking: bool
    ) -> tuple[Launch, ...]:
        x, surfaces = bodies.plies.x, self.surfaces
        tools = tool_poses(self.turning, bodies.tools)
        forget = Launch(
            feature_search.forget_presses,
            memory.seen.size,
            [memory.contacts, memory.seen],
            [memory.presses],
        )
        find, settle = [], []
        for number, ply in enumerate(self.plies):
            search = ply_search(self.scene, self.timing, bodies.plies, 0, ply.half, asking=asking)
            first = number * self.count
            inputs = [
                self.law,
                self.laws,
                search,
                self.features,
                surfaces.facets,
                ply,
                first,
                tools,
                x,
            ]
            inputs += [surfaces.hollows, memory.springs, memory.stored]
            outputs = [memory.seen, memory.contacts, memory.presses, memory.deepest]
            find.append(Launch(feature_search.find_features, self.count, inputs, outputs))
            inputs = [self.law, self.laws, search, self.features, first, tools, x]
            inputs += [memory.springs, memory.presses]
            outputs = [memory.seen, memory.contacts, memory.spent, memory.lost]
            settle.append(Launch(feature_search.settle_features, self.count, inputs, outputs))
        return (forget, *find, *settle)

    def _forces(self, number: int, bodies: Bodies, memory: FeatureContactMemory) -> Launch:
        plies, tools = bodies.plies, bodies.tools
        inputs = [self.law, self.laws, self.features, number * self.count]
        inputs += [tool_poses(self.turning, tools), plies.x, plies.v, memory.contacts]
        kept = [memory.springs, memory.dashpots, memory.stored, memory.pressing]
        kept += [memory.spent, memory.lost]
        outputs = [*kept, plies.f, tools.reaction, tools.moment]
        return Launch(add_feature_forces, self.count, inputs, outputs)

    def measure(self, bodies: Bodies, memory: FeatureContactMemory) -> Measured:
        """Energy in springs, what was lost; penetration of each tool, and the plies it touched."""
        friction, damping = memory.lost.numpy().sum(axis=0)
        touched = memory.lost.numpy().any(axis=1).reshape(len(self.plies), -1).any(axis=1)
        contacts, vertices = memory.contacts.numpy(), bodies.plies.x.shape[0]
        forces = memory.pressing.numpy()
        tool = np.tile(self.features.tools.numpy(), len(self.plies))
        pressing = [
            on_corners(contacts, np.where(tool == number, forces, 0.0), vertices)
            for number in range(len(self.scene.tools))
        ]
        return Measured(
            {"contact": float(memory.stored.numpy().sum())},
            {"friction": float(friction), "contact damping": float(damping)},
            pressing={"tool_pressure": np.array(pressing)},
            entries={
                "tools": [{"max_penetration_m": float(d)} for d in memory.deepest.numpy()],
            },
            touched=frozenset(np.flatnonzero(touched).tolist()),
        )


def build(
    scene: Setup,
    spans: tuple[Span, ...],
    timing: Timing,
    mass: wp.array,
    surfaces: PlySurfaces,
    pads: Pads,
    device: str,
) -> FeatureContact | None:
    """Put the tools' points on a device; None where vertices feel all of the tools.

    Args:
        scene: what is computed.
        spans: where plies are.
        timing: the steps.
        mass: vertex masses [kg], shape [vertex]; it is the triangles' that count here.
        surfaces: the plies' surfaces.
        pads: what gives way in contacts.
        device: Warp device.
    """
    points = points_of(scene)
    if not any(map(len, points)):
        return None
    features = Features()
    features.points = wp.array(np.concatenate(points), dtype=wp.vec3d, device=device)
    tools = np.repeat(np.arange(len(points)), [len(each) for each in points])
    features.tools = wp.array(tools, dtype=wp.int32, device=device)
    features.rubs = rubs(scene, [scene.friction_of(tool) for tool in scene.tools], device)
    third = [ply.fabric.areal_density * ply.mesh.areas / 3.0 for ply in scene.plies]
    features.third = wp.array(np.concatenate(third), dtype=wp.float64, device=device)
    features.pressing = scene.numerics.search_slide
    plies = []
    for ply, span, mesh in zip(scene.plies, spans, surfaces.meshes, strict=True):
        searched = SearchedPly()
        searched.mesh = mesh.id
        searched.first_triangle = span.first_triangle
        searched.half = 0.5 * ply.fabric.thickness
        plies.append(searched)
    law = contact_law(scene, timing.time_step, device)
    turning = turning_tools(scene, device)
    return FeatureContact(
        device, scene, timing, spans, surfaces, features, tuple(plies), law, pads.laws, turning
    )
