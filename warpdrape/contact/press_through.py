"""What contacts press on plies with, step by step, for forces inside the plies that depend on it.

Contacts add to `PressingState`; this comes after them. Only yarns that rub where they cross ask.
"""

from __future__ import annotations

from dataclasses import dataclass

import warp as wp

from warpdrape.contact.slots import SlotMemory
from warpdrape.interaction import Bodies, Launch, Launches, Measured, Run, Share
from warpdrape.kernels.contact.on_ply import Slots
from warpdrape.kernels.contact.press_through import (
    press_edges,
    press_on_tools,
    press_triangles,
    press_vertices,
    take_pressing,
)
from warpdrape.kernels.contact.ridges import PlyEdges
from warpdrape.setup import Setup


@dataclass(frozen=True, eq=False)
class Pressing:
    """Hands on to the next step what contacts press with."""

    name: str = "press through"
    searches: str = ""

    def start(self) -> None:
        """It is kept in `PressingState`."""

    def launches(self, share: Share, bodies: Bodies, memory: None) -> Launches:
        """A part's own vertices."""
        pressing = bodies.pressed
        outputs = [pressing.pressing, pressing.through]
        return Launches(
            push=tuple(
                Launch(take_pressing, run.count, [run.first], outputs) for run in share.vertices
            )
        )

    def measure(self, bodies: Bodies, memory: None) -> Measured:
        """Nothing: contacts show their pressures."""
        return Measured()


def build(scene: Setup) -> Pressing | None:
    """None where nothing asks what contacts press with."""
    return Pressing() if scene.yarns_rub else None


def of_vertices(run: Run, first_slot: int, slots: Slots, bodies: Bodies) -> tuple[Launch, ...]:
    """What contacts of a run of vertices with plies press with, after their forces.

    Args:
        run: the vertices.
        first_slot: contact of the first.
        slots: memory of the contacts.
        bodies: the plies.
    """
    if bodies.pressing is None:
        return ()
    inputs, outputs = [run.first, first_slot, slots], [bodies.pressing.pressing]
    return (Launch(press_vertices, run.count, inputs, outputs),)


def of_edges(run: Run, edges: PlyEdges, memory: SlotMemory, bodies: Bodies) -> tuple[Launch, ...]:
    """Likewise contacts of the edges that begin at a run of vertices."""
    if bodies.pressing is None:
        return ()
    inputs = [run.first, edges, memory.seen, memory.slots]
    return (Launch(press_edges, run.count, inputs, [bodies.pressing.pressing]),)


def of_points(contacts: wp.array, forces: wp.array, bodies: Bodies) -> tuple[Launch, ...]:
    """Likewise contacts of points of tools with triangles."""
    if bodies.pressing is None:
        return ()
    outputs = [bodies.pressing.pressing]
    return (Launch(press_triangles, contacts.size, [contacts, forces], outputs),)


def of_tools(share: Share, holds: wp.array, bodies: Bodies) -> tuple[Launch, ...]:
    """Likewise contacts of a part's vertices with tools."""
    if bodies.pressing is None:
        return ()
    outputs = [bodies.pressing.pressing]
    return tuple(
        Launch(press_on_tools, run.count, [run.first, holds], outputs) for run in share.vertices
    )
