"""What is told of the interfaces between plies: forces and pressures by pair, slip, depth."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from warpdrape.contact.partners import Partners
from warpdrape.contact.pressure import LOWER, UPPER, on_corners
from warpdrape.contact.slots import SlotMemory
from warpdrape.interaction import Span

if TYPE_CHECKING:
    from warpdrape.contact.ply_contact import PlyLook


class Met(NamedTuple):
    """Vertices of a ply that another presses on."""

    searching: int  # number of their ply
    other: int  # number of the other one
    across: bool  # whether they lie on the other side than the stacking order says


Forces = Mapping[Met, tuple[np.ndarray, np.ndarray]]
"""Normal forces on such vertices, and on corners of the other ply's triangles [N], each of shape
[vertex]."""


def forces_of_pairs(
    looks: Sequence[PlyLook], spans: Sequence[Span], memory: SlotMemory, vertices: int
) -> Forces:
    """Normal forces between plies by pair.

    Args:
        looks: whose vertices look which way.
        spans: where plies are.
        memory: what contacts remember.
        vertices: of all plies.
    """
    contacts, searches = memory.contacts.numpy(), memory.seen.numpy()
    seen = 2 * (searches["ply"] - 1) + (searches["across"] == 1)
    forces, found = memory.forces.numpy(), {}
    for look in looks:
        span = spans[look.searching]
        slots = slice(look.first_slot, look.first_slot + span.vertex_count)
        pressed = forces[slots] > 0.0
        for met in np.unique(seen[slots][pressed]).tolist():
            other, across = divmod(met, 2)
            of_pair = np.where(seen[slots] == met, forces[slots], 0.0)
            own = np.zeros(vertices)
            own[span.vertices] = of_pair
            corners = on_corners(contacts[slots], of_pair, vertices)
            found[Met(look.searching, other, bool(across))] = own, corners
    return found


def pressing_on_faces(met: Forces, vertices: int) -> np.ndarray:
    """Normal forces of plies on each other's lower and upper faces [N], shape [2, vertex]."""
    pressing = np.zeros((2, vertices))
    for pair, (own, corners) in met.items():
        upward = (pair.other > pair.searching) != pair.across
        pressing[UPPER if upward else LOWER] += own
        pressing[LOWER if upward else UPPER] += corners
    return pressing


def interface_entries(
    names: Sequence[str],
    looks: Sequence[PlyLook],
    spans: Sequence[Span],
    partners: Partners,
    memory: SlotMemory,
    depths: np.ndarray,
    met: Forces,
    areas: np.ndarray,
    slips: np.ndarray,
) -> list[dict[str, Any]]:
    """An entry for vertices of each ply on each ply that is next to it, or that they met.

    What a vertex has slid counts for the ply that it saw last. Pressures are of both plies'
    vertices on the other's triangles, so that the two entries of an interface tell the same.

    Args:
        names: of the plies.
        looks: whose vertices look which way.
        spans: where plies are.
        partners: which places lay on each other.
        memory: what contacts remember.
        depths: of penetration now [m], shape [slot].
        met: from `forces_of_pairs`.
        areas: of the vertices [m²], shape [vertex].
        slips: from where vertices lay on the next ply [m], shape [vertex, 3].
    """
    sizes, count = np.linalg.norm(slips, axis=1), len(names)
    slip, searches = memory.slip.numpy(), memory.seen.numpy()
    seen, across = searches["ply"] - 1, searches["across"] == 1
    deepest = memory.deepest.numpy().copy().reshape(count, count)
    jump = memory.jump.numpy().reshape(count, count)
    entries = []
    for look in looks:
        slots = slice(look.first_slot, look.first_slot + spans[look.searching].vertex_count)
        next_one = look.searching + look.way
        for other in range(next_one, count if look.way > 0 else -1, look.way):
            way = np.where(seen[slots] == other, slip[slots], 0.0)
            pair = (look.searching, other)
            now = depths[slots][seen[slots] == other].max(initial=0.0)
            deepest[pair] = max(deepest[pair], now)
            if other != next_one and not (way.any() or deepest[pair] > 0.0):
                continue
            net = {}
            if other == next_one:  # told by the lower ply's vertices, the same for both
                lower = spans[min(pair)].vertices
                apart = sizes[lower][partners.covers(lower)]
                net = {
                    "mean_net_slip_m": float(apart.mean()) if len(apart) else 0.0,
                    "max_net_slip_m": float(apart.max(initial=0.0)),
                }
            entries.append(
                {
                    "vertices_of": names[look.searching],
                    "on": names[other],
                    "across_vertices": int(((seen[slots] == other) & across[slots]).sum()),
                    "max_slip_m": float(way.max()),
                    "mean_slip_m": float(way.mean()),
                    **net,
                    **_pressures(met, *pair, areas, spans[look.searching]),
                    "max_penetration_m": float(deepest[pair]),
                    "max_gap_jump_m": float(jump[pair]),
                }
            )
    return entries


def _pressures(
    met: Forces, searching: int, other: int, areas: np.ndarray, span: Span
) -> dict[str, float]:
    """Normal force of an interface, mean and largest pressure where vertices of a ply feel it.

    Args:
        met: forces by pair.
        searching: number of the ply.
        other: number of the other one.
        areas: of the vertices [m²], shape [vertex].
        span: where the ply is.
    """
    normal, felt = 0.0, np.zeros(len(areas))
    for across in (False, True):
        for pair, mine in (
            (Met(searching, other, across), 0),
            (Met(other, searching, across), 1),
        ):
            if pair in met:
                normal += float(met[pair][0].sum())
                felt += met[pair][mine]
    forces = felt[span.vertices]
    pressed = forces > 0.0
    over = float(areas[span.vertices][pressed].sum())
    return {
        "normal_force_n": normal,
        "mean_pressure_pa": float(forces.sum()) / over if over > 0.0 else 0.0,
        "max_pressure_pa": float((forces / areas[span.vertices]).max()),
    }
