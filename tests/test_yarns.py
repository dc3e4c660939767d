"""The angle functions of `kernels.yarns`, against the library's."""

import math

import numpy as np
import pytest
import warp as wp

from warpdrape.kernels.materials.yarns import angles_within_quarter_turn, arc_sine


@wp.kernel
def four_angles(
    sine: wp.array(dtype=wp.vec4d),
    cosine: wp.array(dtype=wp.vec4d),
    angle: wp.array(dtype=wp.vec4d),
):
    i = wp.tid()
    angle[i] = angles_within_quarter_turn(sine[i], cosine[i])


@wp.kernel
def one_angle(sine: wp.array(dtype=wp.float64), angle: wp.array(dtype=wp.float64)):
    i = wp.tid()
    angle[i] = arc_sine(sine[i])


def mixed_angles(largest_deg):
    """Groups of four within the largest angle, some with all four alike [rad]."""
    rng = np.random.default_rng(0)
    angles = np.radians(largest_deg) * rng.uniform(-1, 1, (4000, 4))
    angles[:1000] = angles[:1000, :1]
    return angles


@pytest.mark.parametrize("largest_deg", [1e-6, 14.9, 30.1, 89.0, 90.0])
def test_four_angles_from_sines_and_cosines(largest_deg, device):
    exact = mixed_angles(largest_deg)
    sine, cosine = (wp.array(of(exact), dtype=wp.vec4d, device=device) for of in (np.sin, np.cos))
    found = wp.zeros(len(exact), dtype=wp.vec4d, device=device)
    wp.launch(four_angles, len(exact), inputs=[sine, cosine], outputs=[found], device=device)
    np.testing.assert_allclose(found.numpy(), exact, rtol=1e-15, atol=1e-15)


def test_not_a_number_among_four_angles_stays(device):
    sine = wp.array([[0.1, math.nan, 0.6, -0.2]], dtype=wp.vec4d, device=device)
    cosine = wp.array([[1.0, 0.0, 0.8, 1.0]], dtype=wp.vec4d, device=device)
    found = wp.zeros(1, dtype=wp.vec4d, device=device)
    wp.launch(four_angles, 1, inputs=[sine, cosine], outputs=[found], device=device)
    assert np.isnan(found.numpy()).tolist() == [[False, True, False, False]]


def test_arc_sine(device):
    sine = np.linspace(-1.0, 1.0, 20_001)
    given = wp.array(sine, dtype=wp.float64, device=device)
    found = wp.zeros(len(sine), dtype=wp.float64, device=device)
    wp.launch(one_angle, len(sine), inputs=[given], outputs=[found], device=device)
    np.testing.assert_allclose(found.numpy(), np.arcsin(sine), rtol=1e-15, atol=4e-16)
