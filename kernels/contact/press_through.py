"""How hard contacts press on plies where their vertices are: on both faces together.

A contact with a triangle presses on its corners by their weights, as its force does.
"""

import warp as wp

from .edge_contact import EdgeMemory
from .on_ply import PlyContact, Slots
from .ridges import PlyEdges
from .tool_contact import ToolHold


@wp.func
def press_corners(contact: PlyContact, force: wp.float64, pressing: wp.array(dtype=wp.float64)):
    """Add a contact's normal force [N] to the corners of what it touches."""
    wp.atomic_add(pressing, contact.a, contact.weights[0] * force)
    wp.atomic_add(pressing, contact.b, contact.weights[1] * force)
    wp.atomic_add(pressing, contact.c, contact.weights[2] * force)


@wp.kernel(enable_backward=False)
def press_vertices(first: int, first_slot: int, slots: Slots, pressing: wp.array(dtype=wp.float64)):
    """Add the normal forces between vertices and plies; one thread a vertex.

    Args:
        first: number of the first vertex.
        first_slot: its contact.
        slots: memory of the contacts.
        pressing: [N], shape [vertex]; accumulated.
    """
    slot = first_slot + wp.tid()
    force = slots.forces[slot]
    if force > wp.float64(0.0):
        wp.atomic_add(pressing, first + wp.tid(), force)
        press_corners(slots.contacts[slot], force, pressing)


@wp.kernel(enable_backward=False)
def press_edges(
    first: int,
    edges: PlyEdges,
    memory: wp.array(dtype=EdgeMemory),
    slots: Slots,
    pressing: wp.array(dtype=wp.float64),
):
    """Add the normal forces between edges; one thread a vertex, over the edges that begin there.

    Args:
        first: number of the first vertex.
        edges: of the plies.
        memory: of the searches, shape [edge].
        slots: memory of the contacts.
        pressing: [N], shape [vertex]; accumulated.
    """
    i = first + wp.tid()
    for e in range(edges.first_of_own[i], edges.first_of_own[i + 1]):
        force = slots.forces[e]
        if force > wp.float64(0.0):
            share = memory[e].share
            wp.atomic_add(pressing, i, (wp.float64(1.0) - share) * force)
            wp.atomic_add(pressing, edges.ends[e][1], share * force)
            press_corners(slots.contacts[e], force, pressing)


@wp.kernel(enable_backward=False)
def press_triangles(
    contacts: wp.array(dtype=PlyContact),
    forces: wp.array(dtype=wp.float64),
    pressing: wp.array(dtype=wp.float64),
):
    """Add the normal forces of points of tools on plies; one thread a point and a ply.

    Args:
        contacts: the nearest triangle, shape [slot].
        forces: normal forces [N], shape [slot].
        pressing: [N], shape [vertex]; accumulated.
    """
    slot = wp.tid()
    if forces[slot] > wp.float64(0.0):
        press_corners(contacts[slot], forces[slot], pressing)


@wp.kernel(enable_backward=False)
def press_on_tools(
    first: int, holds: wp.array(dtype=ToolHold), pressing: wp.array(dtype=wp.float64)
):
    """Add the normal forces between vertices and tools; one thread a vertex.

    Args:
        first: number of the first vertex.
        holds: memory of the contacts, shape [tool · vertex].
        pressing: [N], shape [vertex]; accumulated.
    """
    i = first + wp.tid()
    vertices = pressing.shape[0]
    for tool in range(holds.shape[0] // vertices):
        pressing[i] += holds[tool * vertices + i].pressing


@wp.kernel(enable_backward=False)
def take_pressing(
    first: int, pressing: wp.array(dtype=wp.float64), through: wp.array(dtype=wp.float64)
):
    """Go on to the next step: what goes through a ply is the mean of its faces; a thread a vertex.

    Of a force on one face the yarns' curvature bears half on either side of their crossings.

    Args:
        first: number of the first vertex.
        pressing: of this step on both faces [N], shape [vertex]; cleared.
        through: for the next step [N], shape [vertex]; overwritten.
    """
    i = first + wp.tid()
    through[i] = wp.float64(0.5) * pressing[i]
    pressing[i] = wp.float64(0.0)
