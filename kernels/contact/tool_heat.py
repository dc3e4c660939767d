"""Heat between plies and the tools that press on them: one temperature a vertex."""

import warp as wp

from .tool_contact import ToolHold, may_touch


@wp.func
def approached(now: wp.float64, goal: wp.float64, rate: wp.float64, time: wp.float64) -> wp.float64:
    """Temperature [K] after a time [s] of going to a goal [K] at a rate [1/s]: Ṫ = rate (goal − T).

    Exact, however long the time.
    """
    return goal + (now - goal) * wp.exp(-rate * time)


@wp.kernel(enable_backward=False)
def exchange_heat(
    first: int,
    rates: wp.array(dtype=wp.float64),
    tools: wp.array(dtype=wp.float64),
    touching: wp.array(dtype=wp.int32),
    holds: wp.array(dtype=ToolHold),
    process: wp.array(dtype=wp.float64),
    step: wp.array(dtype=wp.int32),
    temperature: wp.array(dtype=wp.float64),
):
    """Advance the vertices' temperatures by a step; one thread a vertex.

    C Ṫ = Σ H (T_tool − T) over the tools that press on it, C the heat capacity and H the contact's
    conductance, both per area of the ply.

    Args:
        first: number of the first vertex.
        rates: H/C [1/s], shape [vertex]; 0 of plies that keep their temperature.
        tools: temperatures of the tools, below zero of those that pass no heat [K], shape [tool].
        touching: bits of the tools that are near, shape [vertex].
        holds: memory of the contacts, shape [tool · vertex].
        process: time of the process before the coming steps and after each [s], shape [step + 1].
        step: number of the step, shape [1].
        temperature: [K], shape [vertex]; advanced.
    """
    i = first + wp.tid()
    bits = touching[i]
    zero = wp.float64(0.0)
    if bits == 0 or rates[i] == zero:
        return
    pressing = wp.float64(0.0)
    total = wp.float64(0.0)
    for tool in range(tools.shape[0]):
        if may_touch(bits, tool) and tools[tool] >= zero:
            if holds[tool * rates.shape[0] + i].pressing > zero:
                pressing += wp.float64(1.0)
                total += tools[tool]
    if pressing > zero:
        goal = total / pressing
        time = process[step[0] + 1] - process[step[0]]
        temperature[i] = approached(temperature[i], goal, pressing * rates[i], time)
