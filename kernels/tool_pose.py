"""Where tools are and how they move: a point X of a tool is at R X + s.

What contact keeps of a tool is in the tool's own frame, where its query mesh stands still. Of tools
that do not turn R is left out.
"""

import warp as wp


@wp.struct
class TurningTools:
    """Tools that turn about an axis."""

    turns: wp.array(dtype=wp.int32)  # 1 if it turns, shape [tool]
    axis: wp.array(dtype=wp.vec3d)  # unit, shape [tool]
    point: wp.array(dtype=wp.vec3d)  # of the axis, in the tool's frame [m], shape [tool]


@wp.struct
class ToolPoses:
    """Where the tools are, and their velocities over the last step."""

    turning: TurningTools
    turned: wp.array(dtype=wp.mat33d)  # R, shape [tool]
    shift: wp.array(dtype=wp.vec3d)  # s [m], shape [tool]
    velocity: wp.array(dtype=wp.vec3d)  # of the axis, or of the whole tool [m/s], shape [tool]
    spin: wp.array(dtype=wp.vec3d)  # angular velocity [rad/s], shape [tool]


@wp.func
def rotation(axis: wp.vec3d, angle: wp.float64) -> wp.mat33d:
    """Right-handed rotation about a unit axis by an angle [rad] (Rodrigues)."""
    one = wp.float64(1.0)
    zero = wp.float64(0.0)
    x = axis[0]
    y = axis[1]
    z = axis[2]
    cross = wp.mat33d(zero, -z, y, z, zero, -x, -y, x, zero)
    eye = wp.mat33d(one, zero, zero, zero, one, zero, zero, zero, one)
    cosine = wp.cos(angle)
    return cosine * eye + wp.sin(angle) * cross + (one - cosine) * wp.outer(axis, axis)


@wp.func
def out_of_tool(tools: ToolPoses, tool: int, point: wp.vec3d) -> wp.vec3d:
    """Where a point of the tool is now [m]."""
    if tools.turning.turns[tool] == 1:
        return tools.turned[tool] * point + tools.shift[tool]
    return point + tools.shift[tool]


@wp.func
def velocity_from(
    spin: wp.vec3d, arm: wp.vec3d, moving: wp.vec3d, time_step: wp.float64
) -> wp.vec3d:
    """Velocity relative to a tool that turns, over the last step [m/s].

    The tool goes on a chord of its circle in a step, which is square to the arm of half a step ago:
    so a point that the tool carries along has no velocity from it.

    Args:
        spin: angular velocity [rad/s].
        arm: from the axis's point [m].
        moving: velocity relative to the axis [m/s].
        time_step: Δt [s].
    """
    return moving - wp.cross(spin, arm - wp.float64(0.5) * time_step * moving)
