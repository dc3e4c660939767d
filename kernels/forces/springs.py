"""Springs that pull vertices to a frame: force, slip, letting go, and their work."""

import warp as wp

HOLDS = wp.constant(0)
BROKEN = wp.constant(1)


@wp.struct
class SpringLaw:
    """One spring of a device; each of its vertices has the same."""

    stiffness: wp.float64  # N/m
    preload: wp.float64  # N
    slips_at: wp.float64  # N, infinite where it does not
    breaks_at: wp.float64  # N, likewise
    to: wp.vec3d  # from where a vertex starts to its point of the frame [m]
    follows: wp.int32  # 1 along the line to the frame, 0 along ``to``


@wp.func
def spring_line(law: SpringLaw, start: wp.vec3d, x: wp.vec3d):
    """Unit direction of the pull on a vertex, and by how much its spring is longer [m]."""
    at_first = wp.length(law.to)
    if law.follows == 1:
        line = start + law.to - x
        length = wp.length(line)
        return line / wp.max(length, wp.float64(1.0e-30)), length - at_first
    along = law.to / at_first
    return along, wp.dot(along, start - x)


@wp.func
def spring_pull(law: SpringLaw, longer: wp.float64) -> wp.float64:
    """Force [N] of a spring that is longer than at the start [m]; none where it is slack."""
    return wp.max(law.preload + law.stiffness * longer, wp.float64(0.0))


@wp.kernel(enable_backward=False)
def add_spring_forces(
    first: int,
    law: SpringLaw,
    vertices: wp.array(dtype=wp.int32),
    start: wp.array(dtype=wp.vec3d),
    x: wp.array(dtype=wp.vec3d),
    f: wp.array(dtype=wp.vec3d),
    slipped: wp.array(dtype=wp.float64),
    state: wp.array(dtype=wp.int32),
    acted: wp.array(dtype=wp.vec3d),
    before: wp.array(dtype=wp.vec3d),
    work: wp.array(dtype=wp.float64),
):
    """Add the pull of springs to ``f``; one thread a vertex of the device.

    Its work over a step is that of the mean of the forces at both ends.

    Args:
        first: number of the first of these vertices.
        law: of the springs.
        vertices: that they pull at, shape [pulled].
        start: where these started [m], shape [pulled].
        x: positions [m], shape [vertex].
        f: forces [N], shape [vertex]; accumulated.
        slipped: way that the ply has slipped through the grip [m], shape [pulled]; accumulated.
        state: `HOLDS` or `BROKEN`, shape [pulled]; updated.
        acted: force in the last step [N], shape [pulled]; overwritten.
        before: position then [m], likewise.
        work: done by the springs [J], shape [pulled]; accumulated.
    """
    k = first + wp.tid()
    i = vertices[k]
    along, longer = spring_line(law, start[k], x[i])
    pull = spring_pull(law, longer - slipped[k])
    if pull > law.breaks_at:
        state[k] = BROKEN
    if pull > law.slips_at:
        slipped[k] += (pull - law.slips_at) / law.stiffness
        pull = law.slips_at
    if state[k] == BROKEN:
        pull = wp.float64(0.0)
    force = pull * along
    work[k] += wp.float64(0.5) * wp.dot(acted[k] + force, x[i] - before[k])
    acted[k] = force
    before[k] = x[i]
    wp.atomic_add(f, i, force)
