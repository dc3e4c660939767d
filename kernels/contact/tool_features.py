"""Forces between points of a tool that are finer than a ply's mesh and the ply's triangles.

The other way round than `tool_contact`: `feature_search` looks for the triangles from the tool. A
slot is a point of a tool and a ply.
"""

import warp as wp

from ..tool_pose import ToolPoses, out_of_tool, velocity_from
from .contact import CompactionLaws, ContactLaw, contact_traction
from .friction import Rub
from .on_ply import PlyContact, contact_gap


@wp.struct
class Features:
    """Points of the tools, one tool after the other."""

    points: wp.array(dtype=wp.vec3d)  # in the tool's frame [m], shape [point]
    tools: wp.array(dtype=wp.int32)  # number of its tool, shape [point]
    rubs: wp.array(dtype=Rub)  # friction, shape [tool]
    third: wp.array(dtype=wp.float64)  # of the mass of the plies' triangles [kg], shape [triangle]
    pressing: wp.float64  # gap below which a point may press before the next search [m]


@wp.kernel(enable_backward=False)
def add_feature_forces(
    law: ContactLaw,
    laws: CompactionLaws,
    features: Features,
    first_slot: int,
    tools: ToolPoses,
    x: wp.array(dtype=wp.vec3d),
    v: wp.array(dtype=wp.vec3d),
    contacts: wp.array(dtype=PlyContact),
    springs: wp.array(dtype=wp.vec3d),
    dashpots: wp.array(dtype=wp.float64),
    stored: wp.array(dtype=wp.float64),
    pressing: wp.array(dtype=wp.float64),
    spent: wp.array(dtype=wp.float64),
    lost: wp.array(dtype=wp.vec2d),
    f: wp.array(dtype=wp.vec3d),
    reaction: wp.array(dtype=wp.vec3d),
    moment: wp.array(dtype=wp.vec3d),
):
    """Add the forces between points of tools and the triangles of a ply; one thread a point.

    Args:
        law: contact law.
        laws: of compaction, which points of tools do without.
        features: points of the tools.
        first_slot: of its contacts.
        tools: where they are, and their velocities over the last step.
        x: positions [m], shape [vertex].
        v: velocities half a step ago [m/s], shape [vertex].
        contacts: shape [slot].
        springs: stick springs [m], shape [slot]; updated.
        dashpots: dashpot forces [N], shape [slot]; updated.
        stored: energy of the contact springs [J], shape [slot]; overwritten.
        pressing: normal force [N], shape [slot]; overwritten.
        spent: what it has lost so far, less what was taken back [J], shape [slot]; accumulated.
        lost: (friction, contact damping) [J], shape [slot]; accumulated.
        f: forces [N], shape [vertex]; accumulated.
        reaction: forces on the tools [N], shape [place · tool]; accumulated.
        moment: theirs about a point of the axis of tools that turn [N·m], likewise.
    """
    k = wp.tid()
    slot = first_slot + k
    zero = wp.float64(0.0)
    if contacts[slot].near == 0:
        if stored[slot] > zero:  # slid over the ply's border
            lost[slot] += wp.vec2d(stored[slot], zero)
            stored[slot] = zero
            pressing[slot] = zero
            springs[slot] = wp.vec3d()
            dashpots[slot] = zero
        return
    tool = features.tools[k]
    contact = contacts[slot]
    at = out_of_tool(tools, tool, features.points[k])
    gap = contact_gap(contact, x, at)
    if gap >= zero and stored[slot] == zero:
        return
    a = contact.a
    b = contact.b
    c = contact.c
    w = contact.weights
    touched = w[0] * x[a] + w[1] * x[b] + w[2] * x[c]
    moving = w[0] * v[a] + w[1] * v[b] + w[2] * v[c]
    offset = touched - tools.shift[tool]
    moving = moving - tools.velocity[tool]
    spring = springs[slot]
    arm = offset
    if tools.turning.turns[tool] == 1:
        arm = offset - tools.turned[tool] * tools.turning.point[tool]
        moving = velocity_from(tools.spin[tool], arm, moving, law.time_step)
        spring += law.time_step * wp.cross(tools.spin[tool], spring)  # it turns with the tool
    t = contact_traction(
        law,
        laws,
        contact.mass,
        contact.pad,
        contact.rub,
        gap,
        contact.normal,
        -moving,
        spring,
        dashpots[slot],
    )
    springs[slot] = t.spring
    dashpots[slot] = t.dashpot
    stored[slot] = t.stored
    pressing[slot] = t.pressing
    spent[slot] += t.friction + t.damping
    lost[slot] += wp.vec2d(t.friction, t.damping)
    wp.atomic_sub(f, a, w[0] * t.force)
    wp.atomic_sub(f, b, w[1] * t.force)
    wp.atomic_sub(f, c, w[2] * t.force)
    wp.atomic_add(reaction, tool, t.force)
    if tools.turning.turns[tool] == 1:
        wp.atomic_add(moment, tool, wp.cross(arm, t.force))
