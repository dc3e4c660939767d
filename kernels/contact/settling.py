"""A contact from one search to the next: what it was, and what of a jump it may keep."""

import warp as wp

from .contact import CompactionLaws, ContactLaw
from .on_ply import PlyContact, PlySearch, Slots, before_search, settled


@wp.struct
class Earlier:
    """What a contact was before a search."""

    gap: wp.float64  # if below zero [m]
    had: wp.float64  # energy of its springs [J]
    budget: wp.float64  # lost since it came near, less what was taken back [J]


@wp.func
def let_go(
    law: ContactLaw,
    laws: CompactionLaws,
    slots: Slots,
    slot: int,
    x: wp.array(dtype=wp.vec3d),
    point: wp.vec3d,
) -> Earlier:
    """Empty a slot before a search, and say what was in it.

    Args:
        law: contact law.
        laws: of compaction.
        slots: memory of the contacts; updated.
        slot: number of this one.
        x: positions [m], shape [vertex].
        point: that touched [m].
    """
    earlier = Earlier()
    gap, had = before_search(
        law, laws, slots.contacts[slot], x, point, slots.springs[slot], slots.stored[slot]
    )
    earlier.gap = gap
    earlier.had = had
    earlier.budget = wp.max(slots.spent[slot], wp.float64(0.0))
    slots.spent[slot] = wp.float64(0.0)
    slots.contacts[slot].near = 0
    return earlier


@wp.func
def hold(
    law: ContactLaw,
    laws: CompactionLaws,
    search: PlySearch,
    slots: Slots,
    slot: int,
    contact: PlyContact,
    x: wp.array(dtype=wp.vec3d),
    point: wp.vec3d,
    gap: wp.float64,
    earlier: Earlier,
    i: int,
    lost: wp.array(dtype=wp.vec3d),
) -> wp.float64:
    """Put a contact that a search has found into a slot; return what it may keep of a jump [m].

    Args:
        law: contact law.
        laws: of compaction.
        search: how to look.
        slots: memory of the contacts; updated.
        slot: number of this one.
        contact: what was found.
        x: positions [m], shape [vertex].
        point: that touches [m].
        gap: between them [m].
        earlier: what was in the slot.
        i: vertex in whose name losses are booked.
        lost: (friction, contact damping, mass damping) [J], shape [vertex]; accumulated.
    """
    zero = wp.float64(0.0)
    jump = wp.max(earlier.gap - gap, zero)
    spring = slots.springs[slot]
    allowance, taken = settled(
        law, laws, search, contact, x, point, spring, jump, earlier.had, earlier.budget
    )
    contact.near = 1
    contact.allowance = allowance
    slots.contacts[slot] = contact
    slots.spent[slot] = earlier.budget + taken
    lost[i] += wp.vec3d(zero, taken, zero)
    return allowance
