"""Which way a ply faces at a corner, whatever its facets' size; and on which side points lie."""

import numpy as np
import warp as wp

from warpdrape.contact.ply_facets import build_facets
from warpdrape.kernels.contact.facets import (
    PlyFacets,
    fan_facing,
    is_on_side,
    nearest_on_facet,
)


@wp.kernel(enable_backward=False)
def compute_facing(facets: PlyFacets, x: wp.array(dtype=wp.vec3d), out: wp.array(dtype=wp.vec3d)):
    """At vertex 0; one thread."""
    out[0] = fan_facing(facets, 0, x)


def test_how_far_facets_reach_from_a_corner_does_not_turn_it(device):
    fan = np.array([[0, k, k % 5 + 1] for k in range(1, 6)])
    facets = build_facets([fan], np.array([0, 6]), device)
    turn = np.array([0.0, 0.7, 2.1, 3.3, 4.9])
    rim = np.column_stack([np.cos(turn), np.sin(turn), [-0.9, 0.2, -0.5, 0.3, -0.7]])
    found = []
    for stretch in (1.0, 4.0):
        points = np.vstack([np.zeros(3), rim])
        points[2] *= stretch
        out = wp.zeros(1, dtype=wp.vec3d, device=device)
        x = wp.array(points, dtype=wp.vec3d, device=device)
        wp.launch(compute_facing, 1, [facets, x], [out], device=device)
        found.append(out.numpy()[0])
    one, other = found
    assert one[2] > 1.0
    np.testing.assert_allclose(one, other, atol=1e-12)


@wp.kernel(enable_backward=False)
def find_sides(
    facets: PlyFacets,
    x: wp.array(dtype=wp.vec3d),
    points: wp.array(dtype=wp.vec3d),
    out: wp.array(dtype=wp.vec2i),
):
    """Whether points lie above the nearer of two facets, and below; one thread a point."""
    i = wp.tid()
    near = nearest_on_facet(facets, 0, x, points[i])
    other = nearest_on_facet(facets, 1, x, points[i])
    if wp.length_sq(other.offset) < wp.length_sq(near.offset):
        near = other
    above = is_on_side(facets, near, wp.float64(1.0), x)
    below = is_on_side(facets, near, wp.float64(-1.0), x)
    out[i] = wp.vec2i(wp.where(above, 1, 0), wp.where(below, 1, 0))


def test_points_round_a_fold_lie_on_the_side_that_its_half_planes_give(device):
    """A fold of 2 long facets: a point is above where it is above both planes, or any if hollow."""
    random = np.random.default_rng(3)
    for rise in (9.0, -9.0):  # a valley, a ridge: steep sides to the left and right of y
        corners = np.array([[0, -50, 0], [0, 50, 0], [-9, 0, rise * 3], [9, 0, rise * 3.0]])
        facets = build_facets([np.array([[0, 1, 2], [1, 0, 3]])], np.array([0, 4]), device)
        points = random.uniform(-1.0, 1.0, (400, 3))
        out = wp.zeros(len(points), dtype=wp.vec2i, device=device)
        x, asked = (wp.array(a, dtype=wp.vec3d, device=device) for a in (corners, points))
        wp.launch(find_sides, len(points), [facets, x, asked], [out], device=device)
        slope = rise / 3.0  # the sheet is z = slope |x|, and above is towards +z
        expected = points[:, 2] > slope * np.abs(points[:, 0])
        above, below = out.numpy().T == 1
        assert 10 < expected.sum() < 390
        np.testing.assert_array_equal(above, expected)
        np.testing.assert_array_equal(below, ~expected)
