"""Explicit time integration of vertices and tools: kick, then drift (symplectic).

Whatever depends on time reads ``step``, an integer on the device, and tables of one frame's steps.
"""

import warp as wp

from ..sweep import Sweep
from ..tool_pose import TurningTools, rotation


@wp.struct
class Medium:
    """What acts on every vertex alike, at all times."""

    gravity: wp.vec3d  # m/s²
    time_step: wp.float64  # s
    speed_limit: wp.float64  # m/s, beyond which the run counts as blown up


@wp.kernel(enable_backward=False)
def advance_clamped(
    sweep: Sweep,
    medium: Medium,
    mass: wp.array(dtype=wp.float64),
    added_mass: wp.array(dtype=wp.float64),
    clamp: wp.array(dtype=wp.int32),
    rest: wp.array(dtype=wp.vec3d),
    clamp_matrix: wp.array(dtype=wp.mat33d),
    clamp_shift: wp.array(dtype=wp.vec3d),
    step: wp.array(dtype=wp.int32),
    x: wp.array(dtype=wp.vec3d),
    v: wp.array(dtype=wp.vec3d),
    f: wp.array(dtype=wp.vec3d),
    clamp_work: wp.array(dtype=wp.float64),
    clamp_force: wp.array(dtype=wp.vec3d),
):
    """Advance clamped vertices by a step and clear their ``f``; a sweep.

    A clamped vertex follows x = M(step) x_rest + s(step) of its clamp.

    Args:
        sweep: numbers of the vertices.
        medium: gravity, step.
        mass: shape [vertex] [kg].
        added_mass: what mass scaling added to it, without weight [kg], shape [vertex].
        clamp: index of the clamp that holds the vertex, −1 if free, shape [vertex].
        rest: positions at the start [m], shape [vertex].
        clamp_matrix: M of each step of the frame, shape [clamp · (step in frame + 1)].
        clamp_shift: s [m], likewise.
        step: number of the step in the frame, shape [1].
        x: positions [m], shape [vertex]; advanced.
        v: velocities [m/s], shape [vertex]; advanced.
        f: forces [N], shape [vertex]; cleared.
        clamp_work: work done by the clamps [J], shape [vertex]; accumulated.
        clamp_force: sum over the steps of the force of each clamp [N], shape [clamp]; accumulated.
    """
    for i in range(sweep.first + wp.tid(), sweep.end, sweep.threads):
        held = clamp[i]
        if held < 0:
            continue
        dt = medium.time_step
        load = f[i] + (mass[i] - added_mass[i]) * medium.gravity
        k = held * (clamp_shift.shape[0] // clamp_force.shape[0]) + step[0] + 1
        target = clamp_matrix[k] * rest[i] + clamp_shift[k]
        old = v[i]
        new = (target - x[i]) / dt
        force = mass[i] * (new - old) / dt - load
        clamp_work[i] += wp.float64(0.5) * dt * wp.dot(force, old + new)
        wp.atomic_add(clamp_force, held, force)
        f[i] = wp.vec3d()
        v[i] = new
        x[i] = target


@wp.kernel(enable_backward=False)
def advance_vertices(
    sweep: Sweep,
    medium: Medium,
    mass: wp.array(dtype=wp.float64),
    added_mass: wp.array(dtype=wp.float64),
    clamp: wp.array(dtype=wp.int32),
    rates: wp.array(dtype=wp.float64),
    step: wp.array(dtype=wp.int32),
    x: wp.array(dtype=wp.vec3d),
    v: wp.array(dtype=wp.vec3d),
    f: wp.array(dtype=wp.vec3d),
    lost: wp.array(dtype=wp.vec3d),
    runaway: wp.array(dtype=wp.int32),
):
    """Advance free vertices by a step and clear their ``f``; a sweep.

    All its arrays have one dimension: Warp 1.19 then knows their strides, and takes half the time.

    Args:
        sweep: numbers of the vertices.
        medium: gravity, step.
        mass: shape [vertex] [kg].
        added_mass: what mass scaling added to it, without weight [kg], shape [vertex].
        clamp: index of the clamp that holds the vertex, −1 if free, shape [vertex].
        rates: mass-proportional damping in each step of the frame [1/s], shape [step + 1].
        step: number of the step in the frame, shape [1].
        x: positions [m], shape [vertex]; advanced.
        v: velocities [m/s], shape [vertex]; advanced.
        f: forces [N], shape [vertex]; cleared.
        lost: (friction, contact damping, mass damping) [J], shape [vertex]; accumulated.
        runaway: first runaway vertex, −1 while there is none, shape [1].
    """
    one = wp.float64(1.0)
    half = wp.float64(0.5)
    dt = medium.time_step
    rate = rates[step[0]]
    drag = half * rate * dt
    kept = one - drag
    shared = one / (one + drag)
    fastest = medium.speed_limit * medium.speed_limit
    for entry in range(sweep.first + wp.tid(), sweep.end, sweep.threads):
        i = wp.max(entry, 0)  # so that Warp need not ask whether it counts from the end
        if clamp[i] >= 0:
            continue
        load = f[i] + (mass[i] - added_mass[i]) * medium.gravity
        old = v[i]
        new = shared * (kept * old + (dt / mass[i]) * load)
        if rate > wp.float64(0.0):
            mean = half * (old + new)
            loss = rate * mass[i] * dt * wp.dot(mean, mean)
            lost[i] += wp.vec3d(wp.float64(0.0), wp.float64(0.0), loss)
        if not (wp.dot(new, new) < fastest):
            wp.atomic_cas(runaway, 0, -1, i)
        f[i] = wp.vec3d()
        v[i] = new
        x[i] += dt * new


@wp.struct
class FloatingTools:
    """Tools that move under a force along their axis; the others follow their path."""

    floats: wp.array(dtype=wp.int32)  # 1 if force-controlled, shape [tool]
    axis: wp.array(dtype=wp.vec3d)  # unit, shape [tool]
    mass: wp.array(dtype=wp.float64)  # kg, shape [tool]
    damping: wp.array(dtype=wp.float64)  # N s/m, shape [tool]


@wp.func
def taken(tool: int, tools: int, each: wp.array(dtype=wp.vec3d)) -> wp.vec3d:
    """Sum of what contacts have put in the places of a tool, which are cleared."""
    total = each[tool]
    for place in range(1, each.shape[0] // tools):
        total += each[place * tools + tool]
    for place in range(each.shape[0] // tools):
        each[place * tools + tool] = wp.vec3d()
    return total


@wp.kernel(enable_backward=False)
def advance_tools(
    time_step: wp.float64,
    floating: FloatingTools,
    turning: TurningTools,
    path: wp.array2d(dtype=wp.vec3d),
    force: wp.array2d(dtype=wp.float64),
    angle: wp.array2d(dtype=wp.float64),
    step: wp.array(dtype=wp.int32),
    turned: wp.array(dtype=wp.mat33d),
    shift: wp.array(dtype=wp.vec3d),
    velocity: wp.array(dtype=wp.vec3d),
    spin: wp.array(dtype=wp.vec3d),
    reaction: wp.array(dtype=wp.vec3d),
    moment: wp.array(dtype=wp.vec3d),
    impulse: wp.array(dtype=wp.vec3d),
    twist: wp.array(dtype=wp.float64),
    work: wp.array(dtype=wp.float64),
    damped: wp.array(dtype=wp.float64),
):
    """Advance the tools by a step and clear ``reaction`` and ``moment``; one thread a tool.

    The axis of a tool that turns goes where the motion says; about it, x = R (X − c) + c + way.

    Args:
        time_step: Δt [s].
        floating: which tools float, and how.
        turning: which tools turn.
        path: translation of each step of the frame [m], shape [tool, step in frame + 1].
        force: force along the axis of each step [N], shape [tool, step in frame + 1].
        angle: turned at each step [rad], shape [tool, step in frame + 1].
        step: number of the step in the frame, shape [1].
        turned: rotations R, shape [tool]; advanced.
        shift: translations x − R X [m], shape [tool]; advanced.
        velocity: velocities of the motion [m/s], shape [tool]; advanced.
        spin: angular velocities [rad/s], shape [tool]; advanced.
        reaction: contact forces on the tools [N], shape [place · tool]; cleared.
        moment: theirs about the axis's point [N·m], shape [place · tool]; cleared.
        impulse: sum over the steps of the reaction [N], shape [tool]; accumulated.
        twist: sum over the steps of the moment about the axis [N·m], shape [tool]; accumulated.
        work: work done on the tools from outside [J], shape [tool]; accumulated.
        damped: energy lost in the tools' dashpots [J], shape [tool]; accumulated.
    """
    t = wp.tid()
    half = wp.float64(0.5)
    k = step[0]
    old = velocity[t]
    acting = taken(t, shift.shape[0], reaction)
    carried = wp.vec3d()
    carried_before = wp.vec3d()
    if turning.turns[t] == 1:
        axis = turning.axis[t]
        c = turning.point[t]
        carried_before = c - turned[t] * c
        turned[t] = rotation(axis, angle[t, k + 1])
        carried = c - turned[t] * c
        torque = wp.dot(axis, taken(t, shift.shape[0], moment))
        rate = (angle[t, k + 1] - angle[t, k]) / time_step
        work[t] -= half * time_step * torque * (wp.dot(axis, spin[t]) + rate)
        twist[t] += torque
        spin[t] = rate * axis
    if floating.floats[t] == 1:
        along = floating.axis[t]
        speed = wp.dot(along, old)
        drag = half * time_step * floating.damping[t] / floating.mass[t]
        push = force[t, k] + wp.dot(along, acting)
        one = wp.float64(1.0)
        new = ((one - drag) * speed + time_step * push / floating.mass[t]) / (one + drag)
        mean = half * (speed + new)
        velocity[t] = new * along
        shift[t] += time_step * new * along + (carried - carried_before)
        work[t] += time_step * force[t, k] * mean
        damped[t] += time_step * floating.damping[t] * mean * mean
    else:
        velocity[t] = (path[t, k + 1] - path[t, k]) / time_step
        shift[t] = path[t, k + 1] + carried
        work[t] -= half * time_step * wp.dot(acting, old + velocity[t])
    impulse[t] += acting


@wp.kernel(enable_backward=False)
def count_step(step: wp.array(dtype=wp.int32)):
    """Go to the next step; one thread in all."""
    step[0] = step[0] + 1
