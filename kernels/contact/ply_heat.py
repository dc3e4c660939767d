"""Heat between plies that press on each other: what one loses the other gains."""

import warp as wp

from .heat import covered
from .on_ply import PlyMemory, Slots


@wp.kernel(enable_backward=False)
def exchange_between_plies(
    first_vertex: int,
    first_slot: int,
    first_pair: int,
    conductances: wp.array(dtype=wp.float64),
    most: wp.float64,
    areas: wp.array(dtype=wp.float64),
    capacities: wp.array(dtype=wp.float64),
    seen: wp.array(dtype=PlyMemory),
    slots: Slots,
    temperature: wp.array(dtype=wp.float64),
    power: wp.array(dtype=wp.float64),
    cover: wp.array(dtype=wp.vec4d),
):
    """Add the powers between a vertex and the triangle it presses on; a thread a vertex.

    P = H A (T_place − T_vertex), the place's temperature by the weights of its corners, which lose
    by the same weights. A face with a ply near it is covered, pressed or not.

    Args:
        first_vertex: of the searching ply.
        first_slot: of its contacts with the plies above or below.
        first_pair: of the searching ply with the others.
        conductances: H from each ply's vertices to each other ply [W/(m²·K)], 0 where none passes,
            shape [ply · ply].
        most: share of the heat between the two that may pass in a time [1/s].
        areas: of vertices in the flat plies [m²], shape [vertex].
        capacities: heat per kelvin of each vertex [J/K], shape [vertex].
        seen: of the searches, shape [slot].
        slots: memory of the contacts.
        temperature: [K], shape [vertex].
        power: from other plies [W], shape [vertex]; accumulated.
        cover: see `covered`, shape [vertex]; accumulated.
    """
    thread = wp.tid()
    i = first_vertex + thread
    slot = first_slot + thread
    contact = slots.contacts[slot]
    if contact.near == 0:
        return
    cover[i] = covered(cover[i], contact.normal)
    conductance = conductances[first_pair + seen[slot].ply - 1]
    if conductance == wp.float64(0.0) or slots.forces[slot] <= wp.float64(0.0):
        return
    a = contact.a
    b = contact.b
    c = contact.c
    w = contact.weights
    one = wp.float64(1.0)
    inverse = w[0] * w[0] / capacities[a] + w[1] * w[1] / capacities[b]
    inverse += w[2] * w[2] / capacities[c] + one / capacities[i]
    place = w[0] * temperature[a] + w[1] * temperature[b] + w[2] * temperature[c]
    passed = wp.min(conductance * areas[i], most / inverse) * (place - temperature[i])
    wp.atomic_add(power, i, passed)
    wp.atomic_sub(power, a, w[0] * passed)
    wp.atomic_sub(power, b, w[1] * passed)
    wp.atomic_sub(power, c, w[2] * passed)
