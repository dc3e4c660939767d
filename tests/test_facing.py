"""Which way a ply faces at a corner: by the angles of its facets there, whatever their size."""

import numpy as np
import warp as wp

from warpdrape.contact.ply_facets import build_facets
from warpdrape.kernels.contact.facets import PlyFacets, fan_facing


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
