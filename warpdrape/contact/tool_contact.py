"""Contact of plies with tools: what it needs on a device, its launches, energy and entries."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import warp as wp

from warpdrape.contact import press_through
from warpdrape.contact.compaction import Pads
from warpdrape.contact.law import contact_law, near_reach
from warpdrape.contact.tool_heat import ToolHeat, tool_heat
from warpdrape.contact.tool_surfaces import tool_surfaces
from warpdrape.interaction import Bodies, Launch, Launches, Measured, Share, Swept
from warpdrape.kernels.contact.contact import CompactionLaws, ContactLaw
from warpdrape.kernels.contact.tool_contact import ToolHold, add_tool_forces
from warpdrape.kernels.contact.tool_facets import ToolSurfaces
from warpdrape.kernels.contact.tool_planes import ToolPlane
from warpdrape.kernels.contact.tool_search import ToolQuery, ToolSearch, find_tool_contacts
from warpdrape.kernels.tool_pose import TurningTools
from warpdrape.setup import Setup
from warpdrape.state import Across, Apart
from warpdrape.timing import Timing
from warpdrape.tool_pose import tool_poses, turning_tools

SEARCH_BEYOND = 2e-3
"""How far past the near zone a tool query looks [m]; what it finds farther off need not be asked
again until the vertex has come closer."""
PLANE_SERVES = 0.5
"""Way of a vertex along a tool for which its plane serves, in units of `search_slide` [-]."""
FACET_SERVES = 4.0
"""… and for which the nearest facet may, as long as none beside it can have become nearer [-]."""
LOOK_AHEAD = 2.0
"""Time for which a search follows free vertices at their speed, in intervals between searches [-]:
a sheet that snaps gains speed."""


@dataclass(frozen=True, eq=False)
class ToolMemory:
    """What contact with tools remembers; a slot is a vertex and a tool.

    Attributes:
        planes: tangent planes that vertices may touch, shape [slot].
        queries: where vertices last asked, shape [slot].
        touching: whether a vertex may touch a tool before the next search, shape [vertex].
        holds: friction springs, and the energy in contact, shape [slot].
        deepest: deepest penetration of each tool [m], shape [tool].
        fastest: way of vertices that passed each tool unseen over what searches had seen [-],
            0 where none did, shape [tool].
    """

    planes: wp.array
    queries: wp.array
    touching: wp.array
    holds: wp.array
    deepest: wp.array
    fastest: wp.array
    apart: ClassVar[Apart] = {"deepest": Across.LARGEST, "fastest": Across.LARGEST}


@dataclass(frozen=True, eq=False)
class ToolContact:
    """Contact of all plies with all tools.

    Attributes:
        device: Warp device.
        mass: vertex masses [kg], shape [vertex].
        offset: half the ply thickness [m], shape [vertex].
        meshes: per tool, in its own frame.
        surfaces: the tools' facets.
        law: the contact law.
        laws: of compaction.
        pads: what gives way of each vertex's ply, shape [vertex].
        search: how far searches look.
        turning: which tools turn.
        heat: what cools plies on them, None where none cools.
        names: of the tools.
    """

    device: str
    mass: wp.array
    offset: wp.array
    meshes: tuple[wp.Mesh, ...]
    surfaces: ToolSurfaces
    law: ContactLaw
    laws: CompactionLaws
    pads: wp.array
    search: ToolSearch
    turning: TurningTools
    heat: ToolHeat | None
    names: tuple[str, ...]
    name: str = "tool contact"
    searches: str = "tool search"

    def start(self) -> ToolMemory:
        """Nothing found yet."""
        n, tools = self.mass.shape[0], len(self.meshes)

        def zeros(count: int, dtype: Any) -> wp.array:
            return wp.zeros(count, dtype=dtype, device=self.device)

        return ToolMemory(
            planes=zeros(tools * n, ToolPlane),
            queries=_nothing_asked(tools * n, self.device),
            touching=zeros(n, wp.int32),
            holds=zeros(tools * n, ToolHold),
            deepest=zeros(tools, wp.float64),
            fastest=zeros(tools, wp.float64),
        )

    def launches(self, share: Share, bodies: Bodies, memory: ToolMemory) -> Launches:
        """Searches and forces of a part's own vertices."""
        plies, tools = bodies.plies, bodies.tools
        moving = [tool_poses(self.turning, tools), plies.x, plies.v]
        find: list[Swept] = []
        push: list[Launch | Swept] = []
        for run in share.vertices:
            inputs = [self.surfaces, self.search, self.offset, *moving]
            found = [memory.planes, memory.queries, memory.touching, memory.holds]
            outputs = [*found, plies.lost, memory.deepest, memory.fastest]
            find.append(Swept(find_tool_contacts, run, inputs, outputs))
            known = [memory.planes, memory.touching]
            inputs = [self.law, self.laws, self.pads, self.surfaces.rubs, self.mass]
            inputs += [*moving, *known]
            outputs = [memory.holds, plies.f, tools.reaction, tools.moment, plies.lost]
            push.append(Swept(add_tool_forces, run, inputs, outputs))
        if self.heat is not None:
            push += self.heat.launches(share, bodies, memory.touching, memory.planes, memory.holds)
        push += press_through.of_tools(share, memory.holds, bodies)
        return Launches(ask=tuple(find), walk=tuple(find), push=tuple(push))

    def measure(self, bodies: Bodies, memory: ToolMemory) -> Measured:
        """Energy in contact springs and friction springs; forces and penetration of each tool."""
        deepest, holds = memory.deepest.numpy(), memory.holds.numpy()
        return Measured(
            {"contact": float(holds["stored"].sum())},
            pressing={"tool_pressure": holds["pressing"].reshape(len(self.meshes), -1)},
            entries={"tools": [{"max_penetration_m": float(depth)} for depth in deepest]},
            warnings=self._passing(memory),
        )

    def _passing(self, memory: ToolMemory) -> tuple[str, ...]:
        """Warning of the tool that vertices may have passed, faster than searches look for it."""
        fastest = memory.fastest.numpy()
        if not fastest.any():
            return ()
        tool = int(np.argmax(fastest))
        return (
            f"a ply gained speed faster than contact with tool {self.names[tool]!r} looks ahead "
            f"(by {fastest[tool]:.3g} times) and passed it: load it more slowly, or set contact to "
            "exact",
        )


def build(
    scene: Setup, timing: Timing, mass: wp.array, pads: Pads, device: str
) -> ToolContact | None:
    """Put the tools on a device; None where there are none.

    Args:
        scene: what is computed.
        timing: the steps.
        mass: vertex masses [kg], shape [vertex].
        pads: what gives way in contacts.
        device: Warp device.
    """
    if not scene.tools:
        return None
    half = [np.full(len(p.mesh.vertices), 0.5 * p.fabric.thickness) for p in scene.plies]
    return ToolContact(
        device,
        mass,
        wp.array(np.concatenate(half), dtype=wp.float64, device=device),
        *tool_surfaces(scene, device),
        contact_law(scene, timing.time_step, device),
        pads.laws,
        pads.at_vertices(scene, device),
        _tool_search(scene, timing),
        turning_tools(scene, device),
        tool_heat(scene, device),
        tuple(tool.name for tool in scene.tools),
    )


def _tool_search(scene: Setup, timing: Timing) -> ToolSearch:
    thickest = max(ply.fabric.thickness for ply in scene.plies)
    search = ToolSearch()
    search.reach = near_reach(scene)
    search.radius = 0.5 * thickest + search.reach + SEARCH_BEYOND
    search.keep = PLANE_SERVES * scene.numerics.search_slide
    search.trust = FACET_SERVES * scene.numerics.search_slide
    search.ahead = LOOK_AHEAD * timing.search_every * timing.time_step
    search.plain = int(scene.numerics.contact == "exact")
    return search


def _nothing_asked(slots: int, device: str) -> wp.array:
    """Queries that leave no vertex a way to move before it is asked, shape [slot]."""
    queries = np.zeros(slots, dtype=ToolQuery.numpy_dtype())
    queries["distance"] = math.inf
    queries["facet"] = -1
    return wp.array(queries, dtype=ToolQuery, device=device)
