"""Contact of points of a tool that are finer than a ply's mesh with the ply's triangles.

The other way round than `tool_contact`: the triangles are looked for from the tool. A slot is a
point of a tool and a ply. A point keeps to the side of the ply from which it came.

Points that press one triangle share its stiffness, which follows the triangle's own third of its
vertices' masses: however many they are, they take no more of the step than one contact a vertex.
"""

import warp as wp

from ..tool_pose import ToolPoses, out_of_tool, velocity_from
from .contact import CompactionLaws, ContactLaw, contact_traction
from .facets import (
    PlyFacets,
    ask_for_nearest,
    facing,
    is_at_border,
    no_facet,
    walk_to_nearest,
)
from .friction import Rub
from .on_ply import PlyContact, PlySearch, contact_gap, radius_of, reach_of
from .settling import before_search, settled


@wp.struct
class FeatureMemory:
    """What the search of a point for a ply remembers; zero at first."""

    seen: wp.int32  # number of the nearest triangle plus one; 0 if none was in sight
    way: wp.float64  # that it may come closer before it is near [m]
    side: wp.float64  # of the ply on which it is, +1 above; 0 while it is not near
    before: wp.float64  # gap before the search, if below zero [m]
    had: wp.float64  # energy of the springs before the search [J]
    gap: wp.float64  # found by the search [m]


@wp.struct
class Features:
    """Points of the tools, one tool after the other."""

    points: wp.array(dtype=wp.vec3d)  # in the tool's frame [m], shape [point]
    tools: wp.array(dtype=wp.int32)  # number of its tool, shape [point]
    rubs: wp.array(dtype=Rub)  # friction, shape [tool]
    third: wp.array(dtype=wp.float64)  # of the mass of the plies' triangles [kg], shape [triangle]
    pressing: wp.float64  # gap below which a point may press before the next search [m]


@wp.struct
class SearchedPly:
    """The ply whose triangles are searched."""

    mesh: wp.uint64
    first_triangle: wp.int32
    half: wp.float64  # of its thickness [m]


@wp.kernel(enable_backward=False)
def forget_presses(
    contacts: wp.array(dtype=PlyContact),
    memory: wp.array(dtype=FeatureMemory),
    presses: wp.array(dtype=wp.int32),
):
    """Clear the counts of the triangles that were near; one thread a slot.

    Args:
        contacts: shape [slot].
        memory: of the searches, shape [slot].
        presses: points that may press a triangle, shape [triangle]; cleared.
    """
    slot = wp.tid()
    if contacts[slot].near == 1:
        presses[memory[slot].seen - 1] = 0


@wp.kernel(enable_backward=False)
def find_features(
    law: ContactLaw,
    laws: CompactionLaws,
    search: PlySearch,
    features: Features,
    facets: PlyFacets,
    ply: SearchedPly,
    first_slot: int,
    tools: ToolPoses,
    x: wp.array(dtype=wp.vec3d),
    hollows: wp.array(dtype=wp.vec2d),
    springs: wp.array(dtype=wp.vec3d),
    stored: wp.array(dtype=wp.float64),
    memory: wp.array(dtype=FeatureMemory),
    contacts: wp.array(dtype=PlyContact),
    presses: wp.array(dtype=wp.int32),
    deepest: wp.array(dtype=wp.float64),
):
    """Find the triangle of a ply that is nearest to each point of the tools; one thread a point.

    Beyond a border of the ply a point touches for half a thickness more, then nothing.

    Args:
        law: contact law.
        laws: of compaction, which points of tools do without.
        search: how to look.
        features: points of the tools.
        facets: of all plies.
        ply: the searched one.
        first_slot: of its contacts.
        tools: where they are.
        x: positions [m], shape [vertex].
        hollows: of the vertices, for walks [m], shape [vertex].
        springs: stick springs [m], shape [slot].
        stored: energy of the contact springs after the last step [J], shape [slot].
        memory: of the searches, shape [slot]; updated.
        contacts: shape [slot]; overwritten, but for mass and allowance.
        presses: points that may press a triangle, shape [triangle]; raised.
        deepest: largest penetration so far [m], shape [tool]; raised.
    """
    k = wp.tid()
    slot = first_slot + k
    reach = reach_of(search)
    memory[slot].way -= reach
    if memory[slot].way > reach and search.asks == 0:
        return
    zero = wp.float64(0.0)
    tool = features.tools[k]
    at = out_of_tool(tools, tool, features.points[k])
    side = memory[slot].side
    before, had = before_search(law, laws, contacts[slot], x, at, springs[slot], stored[slot])
    contacts[slot].near = 0
    memory[slot].way = zero
    memory[slot].side = zero
    memory[slot].before = before
    memory[slot].had = had
    nearest = no_facet()
    if search.asks == 1:
        radius = radius_of(search)
        nearest = ask_for_nearest(facets, ply.mesh, ply.first_triangle, radius, x, at)
    elif memory[slot].seen > 0:
        nearest = walk_to_nearest(facets, memory[slot].seen - 1, x, hollows, at)
    memory[slot].seen = nearest.facet + 1
    if nearest.facet < 0:
        return
    corners = facets.corners[nearest.facet]
    w = nearest.weights
    offset = nearest.offset
    up = wp.normalize(facing(facets, nearest, x))
    if side == zero:
        side = wp.where(wp.dot(offset, up) < zero, -wp.float64(1.0), wp.float64(1.0))
    height = side * wp.dot(offset, up)
    if is_at_border(facets, nearest):
        beyond = wp.length_sq(offset) - height * height
        if beyond > ply.half * ply.half:
            return
    distance = wp.where(height < zero, -wp.length(offset), wp.length(offset))
    normal = side * up
    if wp.abs(distance) > wp.float64(1.0e-3) * ply.half:
        normal = offset / distance
    gap = distance - ply.half
    if gap > reach:
        memory[slot].way = gap
        return
    memory[slot].side = side
    memory[slot].gap = gap
    contacts[slot].near = 1
    contacts[slot].a = corners[0]
    contacts[slot].b = corners[1]
    contacts[slot].c = corners[2]
    contacts[slot].weights = w
    contacts[slot].normal = normal
    contacts[slot].rise = wp.dot(normal, offset) - distance
    contacts[slot].thickness = ply.half
    contacts[slot].rub = features.rubs[tool]
    if gap < features.pressing:
        wp.atomic_add(presses, nearest.facet, 1)
    wp.atomic_max(deepest, tool, -gap)


@wp.kernel(enable_backward=False)
def settle_features(
    law: ContactLaw,
    laws: CompactionLaws,
    search: PlySearch,
    features: Features,
    first_slot: int,
    tools: ToolPoses,
    x: wp.array(dtype=wp.vec3d),
    springs: wp.array(dtype=wp.vec3d),
    presses: wp.array(dtype=wp.int32),
    memory: wp.array(dtype=FeatureMemory),
    contacts: wp.array(dtype=PlyContact),
    spent: wp.array(dtype=wp.float64),
    lost: wp.array(dtype=wp.vec2d),
):
    """Give the contacts that a search has found their masses, and ease jumps; one thread a point.

    Args:
        law: contact law.
        laws: of compaction, which points of tools do without.
        search: how to look.
        features: points of the tools.
        first_slot: of the contacts with the searched ply.
        tools: where they are.
        x: positions [m], shape [vertex].
        springs: stick springs [m], shape [slot].
        presses: points that may press a triangle, shape [triangle].
        memory: of the searches, shape [slot]; what it was before them is cleared.
        contacts: shape [slot]; mass and allowance are overwritten.
        spent: lost since it came near, less what was taken back [J], shape [slot]; updated.
        lost: (friction, contact damping) [J], shape [slot]; accumulated.
    """
    k = wp.tid()
    slot = first_slot + k
    budget = wp.max(spent[slot], wp.float64(0.0))
    spent[slot] = wp.float64(0.0)
    if contacts[slot].near == 0:
        return
    facet = memory[slot].seen - 1
    shared = wp.float64(wp.max(presses[facet], 1))
    mass = features.third[facet] / (shared * wp.length_sq(contacts[slot].weights))
    contacts[slot].mass = mass
    at = out_of_tool(tools, features.tools[k], features.points[k])
    jump = wp.max(memory[slot].before - memory[slot].gap, wp.float64(0.0))
    had = memory[slot].had
    allowance, taken = settled(
        law, laws, search, contacts[slot], x, at, springs[slot], jump, had, budget
    )
    contacts[slot].allowance = allowance
    spent[slot] = budget + taken
    lost[slot] += wp.vec2d(wp.float64(0.0), taken)


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
