"""What contacts with plies remember: of vertices with another ply or their own, and of edges."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import warp as wp

from warpdrape.kernels.contact import on_ply
from warpdrape.kernels.contact.hollow import OtherPlane
from warpdrape.state import Across, Apart

OF_SLOTS = ("contacts", "others", "springs", "dashpots", "stored", "forces", "slip", "spent")
"""Fields that are `warpdrape.kernels.contact.on_ply.Slots` for the kernels."""


@dataclass(frozen=True, eq=False)
class SlotMemory:
    """Arrays of the slots, and how deep what is in them has been in each other.

    Attributes:
        contacts: the nearest triangle, or edge, shape [slot].
        others: the plane across the edge of a hollow, likewise.
        springs: friction springs [m], shape [slot].
        dashpots: dashpot forces of the step before [N], shape [slot].
        stored: energy in contact [J], shape [slot].
        forces: normal forces [N], shape [slot].
        slip: way slid [m], shape [slot].
        spent: what a contact has lost since it came near, less what was taken back [J],
            shape [slot].
        seen: of the searches, shape [slot].
        deepest: deepest penetration of each two that meet [m], shape [pair].
        jump: largest penetration that a jump of the gap allowed [m], likewise.
    """

    contacts: wp.array
    others: wp.array
    springs: wp.array
    dashpots: wp.array
    stored: wp.array
    forces: wp.array
    slip: wp.array
    spent: wp.array
    seen: wp.array
    deepest: wp.array
    jump: wp.array
    apart: ClassVar[Apart] = {"deepest": Across.LARGEST, "jump": Across.LARGEST}

    @staticmethod
    def empty(slots: int, pairs: int, seen: Any, device: str) -> dict[str, wp.array]:
        """Arrays in which nothing is touched, by name.

        Args:
            slots: so many.
            pairs: so many that may meet.
            seen: type of what a search remembers.
            device: Warp device.
        """
        kinds: dict[str, Any] = {
            "contacts": on_ply.PlyContact,
            "others": OtherPlane,
            "springs": wp.vec3d,
            "seen": seen,
        }
        sizes = dict.fromkeys((*OF_SLOTS, "seen"), slots) | {"deepest": pairs, "jump": pairs}
        return {
            name: wp.zeros(size, dtype=kinds.get(name, wp.float64), device=device)
            for name, size in sizes.items()
        }

    @property
    def slots(self) -> on_ply.Slots:
        """For the kernels."""
        slots = on_ply.Slots()
        for name in OF_SLOTS:
            setattr(slots, name, getattr(self, name))
        return slots
