"""A contact from one search to the next: what it was, and what of a jump it may keep."""

import warp as wp

from .contact import CompactionLaws, ContactLaw, normal_energy
from .on_ply import PlyContact, PlySearch, Slots, contact_gap, turn_to_nearer


@wp.func
def spring_energy(
    law: ContactLaw,
    laws: CompactionLaws,
    contact: PlyContact,
    x: wp.array(dtype=wp.vec3d),
    point: wp.vec3d,
    spring: wp.vec3d,
) -> wp.float64:
    """Energy [J] in the normal and stick springs of a contact."""
    depth = wp.max(-contact_gap(contact, x, point), wp.float64(0.0))
    stick = wp.float64(0.5) * law.stiffness * contact.mass * wp.length_sq(spring)
    return stick + normal_energy(law, contact.mass, laws, contact.pad, depth)


@wp.func
def before_search(
    law: ContactLaw,
    laws: CompactionLaws,
    contact: PlyContact,
    x: wp.array(dtype=wp.vec3d),
    point: wp.vec3d,
    spring: wp.vec3d,
    stored: wp.float64,
):
    """Gap of a contact, if below zero [m], and energy of its springs [J], before a search."""
    before = wp.float64(0.0)
    had = wp.float64(0.0)
    if contact.near == 1:
        if stored > had:
            had = spring_energy(law, laws, contact, x, point, spring)
        before = wp.min(contact_gap(contact, x, point), before)
    return before, had


@wp.func
def settled(
    law: ContactLaw,
    laws: CompactionLaws,
    search: PlySearch,
    contact: PlyContact,
    x: wp.array(dtype=wp.vec3d),
    point: wp.vec3d,
    spring: wp.vec3d,
    jump: wp.float64,
    had: wp.float64,
    budget: wp.float64,
):
    """What of a jump of the gap stays allowed [m], and what the springs lose by it [J].

    When the gap would jump to a deeper penetration the difference is allowed for and fades, slowly
    where it is large, so that forces stay continuous and nothing is thrown out. What fades loads
    the spring: it is paid for by what the contact has lost to friction and damping, so
    that no energy comes from nowhere.

    Args:
        law: contact law.
        laws: of compaction.
        search: how to look.
        contact: with its mass and plane as they are now.
        x: positions [m], shape [vertex].
        point: that touches [m].
        spring: stick spring [m].
        jump: by which the gap has become deeper, or 0 [m].
        had: energy of the springs before the search [J].
        budget: what the contact has lost since it came near, less what was taken back [J].
    """
    zero = wp.float64(0.0)
    if jump == zero and had + budget == zero:
        return zero, zero
    contact.allowance = jump
    stays = spring_energy(law, laws, contact, x, point, spring)
    contact.allowance = wp.max(search.keep * jump, jump - search.ease)
    fades = spring_energy(law, laws, contact, x, point, spring)
    allowance = contact.allowance
    if fades - stays > budget:  # so far as losses pay for it
        contact.allowance = jump
        gap = contact_gap(contact, x, point)
        deep = wp.min(gap, zero)
        paid = wp.float64(2.0) * budget / (law.stiffness * contact.mass)
        allowance = jump - (gap + wp.sqrt(deep * deep + paid))
    taken = zero
    if had + budget > zero:
        contact.allowance = allowance
        has = spring_energy(law, laws, contact, x, point, spring)
        taken = wp.max(had - has, -budget)
    return allowance, taken


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
    turn_to_nearer(slots, slot, x, point)
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
