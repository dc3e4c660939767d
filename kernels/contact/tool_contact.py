"""Contact forces of rigid tools that translate and turn on the plies' vertices.

They act every step on the planes that `tool_search` has found. All that is kept here is in the
tool's own frame; a slot is a vertex of a tool, number tool · vertices + vertex.
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
    for i in range(sweep.first + wp.tid(), sweep.end, sweep.threads):
        bits = touching[i]
        if bits == 0:
            continue
        count = rubs.shape[0]
        place = i % (reaction.shape[0] // count) * count
        for tool in range(count):
            if may_touch(bits, tool):
                slot = tool * x.shape[0] + i
                plane = planes[slot]
                offset = x[i] - tools.shift[tool]
                moving = v[i] - tools.velocity[tool]
                at = offset
                turning = tools.turning.turns[tool] == 1
                if turning:
                    back = wp.transpose(tools.turned[tool])
                    at = back * offset
                    arm = offset - tools.turned[tool] * tools.turning.point[tool]
                    moving = back * velocity_from(tools.spin[tool], arm, moving, law.time_step)
                gap = plane_gap(plane, at)
                if gap < wp.float64(0.0) or holds[slot].stored > wp.float64(0.0):
                    t = contact_traction(
                        law,
                        laws,
                        mass[i],
                        pads[i],
                        at_vertex(law.friction, rubs[tool], i),
                        gap,
                        plane.normal,
                        moving,
                        holds[slot].spring,
                        holds[slot].dashpot,
                    )
                    holds[slot].spring = t.spring
                    holds[slot].dashpot = t.dashpot
                    holds[slot].pressing = t.pressing
                    holds[slot].stored = t.stored
                    force = t.force
                    if turning:
                        force = tools.turned[tool] * force
                        arm = offset - tools.turned[tool] * tools.turning.point[tool]
                        wp.atomic_sub(moment, place + tool, wp.cross(arm, force))
                    f[i] += force
                    lost[i] += wp.vec3d(t.friction, t.damping, wp.float64(0.0))
                    wp.atomic_sub(reaction, place + tool, force)
