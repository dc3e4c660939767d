"""What contacts of vertices with plies remember, be it another ply or their own."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import warp as wp

from warpdrape.kernels.contact import on_ply


@dataclass(frozen=True, eq=False)
class SlotMemory:
    """Arrays of the slots, as `warpdrape.kernels.contact.on_ply.Slots` describes them.

    Attributes:
        contacts: the nearest triangle, shape [slot].
        springs: friction springs [m], shape [slot].
        dashpots: dashpot forces of the step before [N], shape [slot].
        stored: energy in contact [J], shape [slot].
        forces: normal forces [N], shape [slot].
        slip: way slid [m], shape [slot].
        spent: what a contact has lost since it came near, less what was taken back [J],
            shape [slot].
    """

    contacts: wp.array
    springs: wp.array
    dashpots: wp.array
    stored: wp.array
    forces: wp.array
    slip: wp.array
    spent: wp.array

    @staticmethod
    def empty(count: int, device: str) -> dict[str, wp.array]:
        """Arrays of so many slots in which nothing is touched, by name."""
        kinds: dict[str, Any] = {"contacts": on_ply.PlyContact, "springs": wp.vec3d}
        return {
            each.name: wp.zeros(count, dtype=kinds.get(each.name, wp.float64), device=device)
            for each in fields(SlotMemory)
        }

    @property
    def slots(self) -> on_ply.Slots:
        """For the kernels."""
        slots = on_ply.Slots()
        for each in fields(SlotMemory):
            setattr(slots, each.name, getattr(self, each.name))
        return slots
