"""Contact forces of rigid tools that translate and turn on the plies' vertices.

They act every step on the planes that `tool_search` has found. All that is kept here is in the
tool's own frame; a slot is a vertex of a tool, number tool · vertices + vertex.

A third of a press's steps goes here. So it goes tool by tool, and reads what is a tool's own once;
and indices are said not to be negative, which Warp would look at otherwise: 0.85 of the time.
"""

import warp as wp

from ..sweep import Sweep
from ..tool_pose import ToolPoses, velocity_from
from .contact import CompactionLaws, ContactLaw, Pad, contact_traction
from .friction import Rub, at_vertex
from .tool_planes import ToolPlane, plane_gap


@wp.struct
class ToolHold:
    """What the contact of a vertex with a tool remembers from step to step."""

    spring: wp.vec3d  # stick spring, tool frame [m]
    dashpot: wp.float64  # force [N]
    pressing: wp.float64  # normal force [N]
    stored: wp.float64  # energy of normal and stick spring [J]


@wp.func
def may_touch(bits: wp.int32, tool: int) -> bool:
    """Whether a vertex's bits allow that a tool is near; tools 32 apart share a bit."""
    return (bits >> (tool & 31)) & 1 == 1


@wp.kernel(enable_backward=False)
def add_tool_forces(
    sweep: Sweep,
    law: ContactLaw,
    laws: CompactionLaws,
    pads: wp.array(dtype=Pad),
    rubs: wp.array(dtype=Rub),
    mass: wp.array(dtype=wp.float64),
    tools: ToolPoses,
    x: wp.array(dtype=wp.vec3d),
    v: wp.array(dtype=wp.vec3d),
    planes: wp.array(dtype=ToolPlane),
    touching: wp.array(dtype=wp.int32),
    holds: wp.array(dtype=ToolHold),
    f: wp.array(dtype=wp.vec3d),
    reaction: wp.array(dtype=wp.vec3d),
    moment: wp.array(dtype=wp.vec3d),
    lost: wp.array(dtype=wp.vec3d),
):
    """Add the tools' contact forces to ``f``; a sweep over vertices.

    Args:
        sweep: numbers of the vertices.
        law: contact law.
        laws: of compaction.
        pads: what gives way of a vertex's ply, shape [vertex].
        rubs: friction, shape [tool].
        mass: shape [vertex] [kg].
        tools: where they are, and their velocities over the last step.
        x: positions [m], shape [vertex].
        v: velocities half a step ago [m/s], shape [vertex].
        planes: tangent planes, shape [tool · vertex].
        touching: bits of the tools that are near, shape [vertex].
        holds: memory of the contacts, shape [tool · vertex]; updated.
        f: forces [N], shape [vertex]; accumulated.
        reaction: forces on the tools [N], shape [place · tool]; accumulated.
        moment: theirs about a point of the axis of tools that turn [N·m], likewise.
        lost: (friction, contact damping, mass damping) [J], shape [vertex]; accumulated.
    """
    count = rubs.shape[0]
    places = reaction.shape[0] // count
    for tool in range(count):
        shift = tools.shift[tool]
        velocity = tools.velocity[tool]
        turning = tools.turning.turns[tool] == 1
        rub = rubs[tool]
        first_slot = tool * x.shape[0]
        for entry in range(sweep.first + wp.tid(), sweep.end, sweep.threads):
            i = wp.max(entry, 0)
            if may_touch(touching[i], tool):
                slot = wp.max(first_slot + i, 0)
                plane = planes[slot]
                offset = x[i] - shift
                moving = v[i] - velocity
                at = offset
                if turning:
                    back = wp.transpose(tools.turned[tool])
                    at = back * offset
                    arm = offset - tools.turned[tool] * tools.turning.point[tool]
                    moving = back * velocity_from(tools.spin[tool], arm, moving, law.time_step)
                gap = plane_gap(plane, at)
                hold = holds[slot]
                if gap < wp.float64(0.0) or hold.stored > wp.float64(0.0):
                    t = contact_traction(
                        law,
                        laws,
                        mass[i],
                        pads[i],
                        at_vertex(law.friction, rub, i),
                        gap,
                        plane.normal,
                        moving,
                        hold.spring,
                        hold.dashpot,
                    )
                    hold.spring = t.spring
                    hold.dashpot = t.dashpot
                    hold.pressing = t.pressing
                    hold.stored = t.stored
                    holds[slot] = hold
                    force = t.force
                    place = i % places * count + tool
                    if turning:
                        force = tools.turned[tool] * force
                        arm = offset - tools.turned[tool] * tools.turning.point[tool]
                        wp.atomic_sub(moment, place, wp.cross(arm, force))
                    f[i] += force
                    lost[i] += wp.vec3d(t.friction, t.damping, wp.float64(0.0))
                    wp.atomic_sub(reaction, place, force)
