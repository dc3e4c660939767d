"""Pressure on triangles, along their normals of now: a load, with its work.

Over a triangle p A n is shared by its corners alike, exact for a uniform pressure on flat
triangles: over a closed surface the sum is p times the gradient of the volume.
"""

import warp as wp


@wp.func
def pressure_force(pressure: wp.float64, a: wp.vec3d, b: wp.vec3d, c: wp.vec3d) -> wp.vec3d:
    """Force [N] of a pressure [Pa] on the whole of a triangle, along its normal."""
    return wp.float64(0.5) * pressure * wp.cross(b - a, c - a)


@wp.kernel(enable_backward=False)
def add_pressure(
    load: int,
    corners: wp.array(dtype=wp.vec3i),
    pressure: wp.array2d(dtype=wp.float64),
    step: wp.array(dtype=wp.int32),
    x: wp.array(dtype=wp.vec3d),
    f: wp.array(dtype=wp.vec3d),
    acted: wp.array(dtype=wp.vec3d),
    middle: wp.array(dtype=wp.vec3d),
    work: wp.array(dtype=wp.float64),
):
    """Add the force of a pressure to ``f``; one thread a triangle that it acts on.

    Its work over a step is that of the mean of the forces at both ends.

    Args:
        load: number of the pressure.
        corners: vertices of its triangles, shape [loaded].
        pressure: along the triangles' normals at each step [Pa], shape [load, step + 1].
        step: number of the step, shape [1].
        x: positions [m], shape [vertex].
        f: forces [N], shape [vertex]; accumulated.
        acted: force in the last step [N], shape [loaded]; overwritten.
        middle: where the triangles' centroids were then [m], likewise.
        work: done by the pressure [J], shape [loaded]; accumulated.
    """
    t = wp.tid()
    at = corners[t]
    force = pressure_force(pressure[load, step[0]], x[at[0]], x[at[1]], x[at[2]])
    third = force / wp.float64(3.0)
    centroid = (x[at[0]] + x[at[1]] + x[at[2]]) / wp.float64(3.0)
    work[t] += wp.float64(0.5) * wp.dot(acted[t] + force, centroid - middle[t])
    acted[t] = force
    middle[t] = centroid
    wp.atomic_add(f, at[0], third)
    wp.atomic_add(f, at[1], third)
    wp.atomic_add(f, at[2], third)
