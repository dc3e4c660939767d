"""Selective mass scaling: inertia for the stretching of single triangles, none for rigid motion.

The scaled mass is M P⁻¹ with the lumped mass M and P = p(M⁻¹L), L the stiffness of the yarns as a
scalar Laplacian and p a polynomial with p(0) = 1. So velocities are v = P w, where w is momentum
over lumped mass: nothing is solved, L is applied once per power. The host's module of this name
makes p; docs/theory.md says why the step may grow. Vertices gather from their neighbours, so that
no two threads write the same entry.
"""

import warp as wp

from .motion import Medium


@wp.struct
class Filter:
    """M⁻¹L over a bound on its eigenvalues, by rows, no diagonal: Σ_j a_ij (u_i − u_j)."""

    offsets: wp.array(dtype=wp.int32)  # first entry of each row, shape [vertex + 1]
    neighbours: wp.array(dtype=wp.int32)  # vertex j of each entry
    weights: wp.array(dtype=wp.float64)  # a_ij of each entry [-]


@wp.struct
class Power:
    """One step y″ = a y + b M⁻¹L y + c w − d y′ of the recurrence that ends in v = P w."""

    own: wp.float64  # a
    spread: wp.float64  # b
    source: wp.float64  # c
    before: wp.float64  # d


@wp.func
def next_power(
    i: int,
    row: Filter,
    power: Power,
    w: wp.array(dtype=wp.vec3d),
    now: wp.array(dtype=wp.vec3d),
    old: wp.array(dtype=wp.vec3d),
) -> wp.vec3d:
    """Next term of the recurrence at a vertex [m/s]."""
    here = now[i]
    spread = wp.vec3d()
    for k in range(row.offsets[i], row.offsets[i + 1]):
        spread += row.weights[k] * (here - now[row.neighbours[k]])
    return power.own * here + power.spread * spread + power.source * w[i] - power.before * old[i]


@wp.kernel(enable_backward=False)
def push_vertices(
    first: int,
    medium: Medium,
    start: wp.float64,
    mass: wp.array(dtype=wp.float64),
    rates: wp.array(dtype=wp.float64),
    step: wp.array(dtype=wp.int32),
    f: wp.array(dtype=wp.vec3d),
    w: wp.array(dtype=wp.vec3d),
    mean: wp.array(dtype=wp.vec3d),
    now: wp.array(dtype=wp.vec3d),
):
    """Advance momenta by a step and clear ``f``; one thread a vertex.

    Args:
        first: number of the first vertex.
        medium: gravity, step.
        start: y over w at the start of the recurrence [-].
        mass: lumped [kg], shape [vertex].
        rates: mass-proportional damping in each step of the frame [1/s], shape [step + 1].
        step: number of the step in the frame, shape [1].
        f: forces [N], shape [vertex]; cleared.
        w: momentum over lumped mass [m/s], shape [vertex]; advanced.
        mean: of w over the step [m/s], shape [vertex]; overwritten where there is damping.
        now: first term of the recurrence [m/s], shape [vertex]; overwritten.
    """
    i = first + wp.tid()
    one = wp.float64(1.0)
    half = wp.float64(0.5)
    rate = rates[step[0]]
    drag = half * rate * medium.time_step
    old = w[i]
    push = medium.time_step * (f[i] / mass[i] + medium.gravity)
    new = ((one - drag) * old + push) / (one + drag)
    if rate > wp.float64(0.0):
        mean[i] = half * (old + new)
    f[i] = wp.vec3d()
    w[i] = new
    now[i] = start * new


@wp.kernel(enable_backward=False)
def raise_power(
    first: int,
    row: Filter,
    power: Power,
    w: wp.array(dtype=wp.vec3d),
    now: wp.array(dtype=wp.vec3d),
    old: wp.array(dtype=wp.vec3d),
):
    """Go on with the recurrence, from ``now`` and ``old`` to a new term in ``old``."""
    i = first + wp.tid()
    old[i] = next_power(i, row, power, w, now, old)


@wp.kernel(enable_backward=False)
def drift_vertices(
    first: int,
    medium: Medium,
    row: Filter,
    power: Power,
    mass: wp.array(dtype=wp.float64),
    rates: wp.array(dtype=wp.float64),
    step: wp.array(dtype=wp.int32),
    w: wp.array(dtype=wp.vec3d),
    mean: wp.array(dtype=wp.vec3d),
    now: wp.array(dtype=wp.vec3d),
    old: wp.array(dtype=wp.vec3d),
    x: wp.array(dtype=wp.vec3d),
    v: wp.array(dtype=wp.vec3d),
    lost: wp.array(dtype=wp.vec3d),
    runaway: wp.array(dtype=wp.int32),
):
    """End the recurrence in the velocities and advance positions by a step; one thread a vertex.

    Args:
        first: number of the first vertex.
        medium: step, speed limit.
        row: M⁻¹L.
        power: the last of the recurrence.
        mass: lumped [kg], shape [vertex].
        rates: mass-proportional damping in each step of the frame [1/s], shape [step + 1].
        step: number of the step in the frame, shape [1].
        w: momentum over lumped mass [m/s], shape [vertex].
        mean: of w over the step [m/s], shape [vertex], where there is damping.
        now: last term of the recurrence [m/s], shape [vertex].
        old: the one before [m/s], shape [vertex].
        x: positions [m], shape [vertex]; advanced.
        v: velocities [m/s], shape [vertex]; advanced.
        lost: (friction, contact damping, mass damping) [J], shape [vertex]; accumulated.
        runaway: first runaway vertex, −1 while there is none, shape [1].
    """
    i = first + wp.tid()
    new = next_power(i, row, power, w, now, old)
    rate = rates[step[0]]
    if rate > wp.float64(0.0):
        drift = wp.float64(0.5) * (v[i] + new)
        loss = rate * mass[i] * medium.time_step * wp.dot(mean[i], drift)
        lost[i] += wp.vec3d(wp.float64(0.0), wp.float64(0.0), loss)
    if not (wp.dot(new, new) < medium.speed_limit * medium.speed_limit):
        wp.atomic_cas(runaway, 0, -1, i)
    v[i] = new
    x[i] += medium.time_step * new
