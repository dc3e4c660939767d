"""Heat between plies and the tools that press on them."""

import warp as wp

from .heat import covered
from .tool_contact import ToolHold, may_touch
from .tool_planes import ToolPlane


@wp.kernel(enable_backward=False)
def draw_to_tools(
    first: int,
    rate: wp.float64,
    tools: wp.array(dtype=wp.float64),
    turned: wp.array(dtype=wp.mat33d),
    touching: wp.array(dtype=wp.int32),
    planes: wp.array(dtype=ToolPlane),
    holds: wp.array(dtype=ToolHold),
    pull: wp.array(dtype=wp.vec2d),
    cover: wp.array(dtype=wp.vec4d),
):
    """Add the rates at which tools that press draw a ply to their temperatures; a thread a vertex.

    A face with a tool near it is covered, pressed or not.

    Args:
        first: number of the first vertex.
        rate: conductance of the contact over the ply's heat capacity [1/s].
        tools: temperatures of the tools, below zero of those that pass no heat [K], shape [tool].
        turned: rotations of the tools, shape [tool].
        touching: bits of the tools that are near, shape [vertex].
        planes: tangent planes, shape [tool · vertex].
        holds: memory of the contacts, shape [tool · vertex].
        pull: rate [1/s], and rate times temperature [K/s], shape [vertex]; accumulated.
        cover: see `covered`, shape [vertex]; accumulated.
    """
    i = first + wp.tid()
    bits = touching[i]
    if bits == 0:
        return
    zero = wp.float64(0.0)
    for tool in range(tools.shape[0]):
        if may_touch(bits, tool):
            slot = tool * touching.shape[0] + i
            cover[i] = covered(cover[i], turned[tool] * planes[slot].normal)
            if tools[tool] >= zero and holds[slot].pressing > zero:
                pull[i] += wp.vec2d(rate, rate * tools[tool])
