"""A point that touches a triangle of a ply: what is kept of it, and its force step by step.

The plane is found by a search and moves with the triangle until the next one.
"""

import warp as wp

from .contact import CompactionLaws, ContactLaw, Pad, contact_traction
from .friction import Rub
from .hollow import Hollow, OtherPlane
from .look_ahead import Pace, sight


@wp.struct
class PlyContact:
    """A point that may touch a triangle of a ply."""

    a: wp.int32  # vertices of the triangle
    b: wp.int32
    c: wp.int32
    near: wp.int32  # 1 if the point may touch before the next search
    hollow: wp.int32  # 1 if it lies in a hollow, where another plane may be the nearer one
    weights: wp.vec3d  # of a, b, c at the nearest point
    normal: wp.vec3d  # towards the point's side
    rise: wp.float64  # of the tangent plane over the nearest point, less the thickness [m]
    allowance: wp.float64  # penetration still allowed after a jump of the gap [m]
    mass: wp.float64  # with which the point meets the triangle [kg]
    thickness: wp.float64  # from the mid-surface in contact [m]
    rub: Rub  # its friction
    pad: Pad  # what gives way


@wp.struct
class Slots:
    """What contacts of points with plies remember from step to step; each has shape [slot]."""

    contacts: wp.array(dtype=PlyContact)
    others: wp.array(dtype=OtherPlane)  # planes across the edge of a hollow
    springs: wp.array(dtype=wp.vec3d)  # stick springs [m]
    dashpots: wp.array(dtype=wp.float64)  # their forces [N]
    stored: wp.array(dtype=wp.float64)  # energy of normal and stick springs after the last step [J]
    forces: wp.array(dtype=wp.float64)  # normal forces [N]
    slip: wp.array(dtype=wp.float64)  # way slid so far [m]
    spent: wp.array(dtype=wp.float64)  # lost since it came near, less what was taken back [J]


@wp.struct
class PlyMemory:
    """What the search of a point for a ply remembers; zero at first."""

    seen: wp.int32  # number of the nearest triangle plus one; 0 if none was in sight
    way: wp.float64  # that it may come closer before it is near [m]
    ply: wp.int32  # number of the ply that was last seen plus one, 0 if none was
    across: wp.int32  # 1 if it lies across the stacking order, 2 if undecided past the border
    loose: wp.int32  # 1 if a ply is in sight, but the next one does not cover it in its order


@wp.struct
class PlySearch:
    """How a search looks."""

    asks: wp.int32  # 1 to ask for every point; 0 to walk from what it remembers
    part: wp.int32  # of the model that searches
    paces: wp.array(dtype=Pace)  # shape [part]
    thickness: wp.float64  # largest of mid-surfaces in contact [m]
    keep: wp.float64  # share of an allowed penetration that lasts until the next search [-]
    ease: wp.float64  # by which one may shrink at most until then [m]
    interval: wp.float64  # time since the search before [s]
    asked: wp.float64  # time from one search that asks to the next [s]


@wp.func
def reach_of(search: PlySearch) -> wp.float64:
    """Distance beyond the thickness that counts as near [m]."""
    return search.paces[search.part].reach


@wp.func
def radius_of(search: PlySearch) -> wp.float64:
    """Radius of a mesh query [m]."""
    return search.thickness + sight(search.thickness, reach_of(search))


@wp.func
def contact_gap(contact: PlyContact, x: wp.array(dtype=wp.vec3d), point: wp.vec3d):
    """Gap [m] of a point to the tangent plane of its contact, penetration still allowed added."""
    w = contact.weights
    nearest = w[0] * x[contact.a] + w[1] * x[contact.b] + w[2] * x[contact.c]
    offset = contact.thickness + contact.rise - contact.allowance
    return wp.dot(contact.normal, point - nearest) - offset


@wp.func
def has_gone_through(contact: PlyContact, x: wp.array(dtype=wp.vec3d), point: wp.vec3d) -> bool:
    """Whether a point lies behind the mid-surface by the plane that it has held until now."""
    height = contact_gap(contact, x, point) - contact.allowance + contact.thickness
    return contact.near == 1 and height < wp.float64(0.0)


@wp.func
def turn_to_nearer(slots: Slots, slot: int, x: wp.array(dtype=wp.vec3d), point: wp.vec3d):
    """In a hollow, hold the nearer of two planes from now on.

    Args:
        slots: memory of the contacts; updated.
        slot: of the contact.
        x: positions [m], shape [vertex].
        point: that touches [m].
    """
    contact = slots.contacts[slot]
    if contact.hollow == 0:
        return
    turned = turned_to(contact, slots.others[slot])
    if contact_gap(turned, x, point) < contact_gap(contact, x, point):
        slots.others[slot] = plane_in(contact)
        slots.contacts[slot] = turned


@wp.func
def turned_to(contact: PlyContact, other: OtherPlane) -> PlyContact:
    """A contact with another plane in place of its own."""
    turned = contact
    turned.a = other.corners[0]
    turned.b = other.corners[1]
    turned.c = other.corners[2]
    turned.weights = other.weights
    turned.normal = other.normal
    turned.rise = other.rise
    return turned


@wp.func
def plane_in(contact: PlyContact) -> OtherPlane:
    """The plane that a contact holds."""
    plane = OtherPlane()
    plane.corners = wp.vec3i(contact.a, contact.b, contact.c)
    plane.weights = contact.weights
    plane.normal = contact.normal
    plane.rise = contact.rise
    return plane


@wp.func
def between(slots: Slots, slot: int, contact: PlyContact, hollow: Hollow) -> PlyContact:
    """A contact with the nearer plane of a hollow; its slot keeps the other one."""
    contact.hollow = 1
    if hollow.other.gap < hollow.own.gap:
        slots.others[slot] = hollow.own
        return turned_to(contact, hollow.other)
    slots.others[slot] = hollow.other
    return turned_to(contact, hollow.own)


@wp.func
def effective_mass(
    mass: wp.array(dtype=wp.float64), corners: wp.vec3i, w: wp.vec3d, i: int
) -> wp.float64:
    """Mass [kg] with which vertex i meets a triangle at the point of weights w."""
    inverse = w[0] * w[0] / mass[corners[0]] + w[1] * w[1] / mass[corners[1]]
    inverse += w[2] * w[2] / mass[corners[2]]
    return wp.float64(1.0) / (wp.float64(1.0) / mass[i] + inverse)


@wp.func
def leave_slot(i: int, slot: int, slots: Slots, lost: wp.array(dtype=wp.vec3d)):
    """Let go a contact that is near no more, as past a ply's edge; vertex i books what is lost."""
    stored = slots.stored[slot]
    zero = wp.float64(0.0)
    if stored > zero:
        lost[i] += wp.vec3d(stored, zero, zero)
        slots.stored[slot] = zero
        slots.forces[slot] = zero
        slots.springs[slot] = wp.vec3d()
        slots.dashpots[slot] = zero


@wp.func
def press_slot(
    law: ContactLaw,
    laws: CompactionLaws,
    i: int,
    slot: int,
    point: wp.vec3d,
    velocity: wp.vec3d,
    x: wp.array(dtype=wp.vec3d),
    v: wp.array(dtype=wp.vec3d),
    slots: Slots,
    f: wp.array(dtype=wp.vec3d),
    lost: wp.array(dtype=wp.vec3d),
):
    """Add the force of a point on the triangle that its slot touches, and return the one on it.

    Args:
        law: contact law.
        laws: of compaction.
        i: vertex in whose name losses are booked.
        slot: of the contact.
        point: that touches [m].
        velocity: its own, half a step ago [m/s].
        x: positions [m], shape [vertex].
        v: velocities half a step ago [m/s], shape [vertex].
        slots: memory of the contacts; updated.
        f: forces [N], shape [vertex]; accumulated.
        lost: (friction, contact damping, mass damping) [J], shape [vertex]; accumulated.

    Returns:
        Whether there is a force, and the one on the point [N].
    """
    zero = wp.float64(0.0)
    turn_to_nearer(slots, slot, x, point)
    contact = slots.contacts[slot]
    stored = slots.stored[slot]
    if contact.near == 0:
        leave_slot(i, slot, slots, lost)
        return False, wp.vec3d()
    gap = contact_gap(contact, x, point)
    if gap >= zero and stored == zero:
        return False, wp.vec3d()
    a = wp.max(contact.a, 0)  # known not to count from the end, which Warp would ask each time
    b = wp.max(contact.b, 0)
    c = wp.max(contact.c, 0)
    w = contact.weights
    t = contact_traction(
        law,
        laws,
        contact.mass,
        contact.pad,
        contact.rub,
        gap,
        contact.normal,
        velocity - (w[0] * v[a] + w[1] * v[b] + w[2] * v[c]),
        slots.springs[slot],
        slots.dashpots[slot],
    )
    slots.springs[slot] = t.spring
    slots.dashpots[slot] = t.dashpot
    slots.stored[slot] = t.stored
    slots.forces[slot] = t.pressing
    slots.slip[slot] += t.slip
    slots.spent[slot] += t.friction + t.damping
    lost[i] += wp.vec3d(t.friction, t.damping, zero)
    wp.atomic_sub(f, a, w[0] * t.force)
    wp.atomic_sub(f, b, w[1] * t.force)
    wp.atomic_sub(f, c, w[2] * t.force)
    return True, t.force


@wp.func
def press_on_ply(
    law: ContactLaw,
    laws: CompactionLaws,
    i: int,
    slot: int,
    x: wp.array(dtype=wp.vec3d),
    v: wp.array(dtype=wp.vec3d),
    slots: Slots,
    f: wp.array(dtype=wp.vec3d),
    lost: wp.array(dtype=wp.vec3d),
):
    """Add the forces between vertex i and the triangle that its slot touches.

    Args:
        law: contact law.
        laws: of compaction.
        i: the vertex.
        slot: its slot.
        x: positions [m], shape [vertex].
        v: velocities half a step ago [m/s], shape [vertex].
        slots: memory of the contacts; updated.
        f: forces [N], shape [vertex]; accumulated.
        lost: (friction, contact damping, mass damping) [J], shape [vertex]; accumulated.
    """
    i = wp.max(i, 0)
    slot = wp.max(slot, 0)
    pressed, force = press_slot(law, laws, i, slot, x[i], v[i], x, v, slots, f, lost)
    if pressed:
        wp.atomic_add(f, i, force)
