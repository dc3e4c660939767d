"""Closed forms against independent numbers, power balance and their own limits."""

import math

import numpy as np
import pytest
from law_checks import PLAIN, UNEQUAL, fabric

from warpdrape.coupons import closed_forms as exact
from warpdrape.errors import InputError
from warpdrape.materials.fabric_library import load_fabric
from warpdrape.materials.laws import LinearTension, ShearPolynomial

INTERLOCK = load_fabric("carbon_interlock")
ANGLES = np.radians([5.0, 20.0, 40.0, 55.0])

# Net on a sphere, bias diagonal: polar angle [deg], u/R, γ [deg], from an independent integration.
NET = [
    (15, 0.184086, 1.9415),
    (30, 0.362465, 7.5204),
    (45, 0.531476, 16.1128),
    (60, 0.690070, 26.9457),
    (90, 0.980507, 52.4252),
]


@pytest.mark.parametrize(("polar", "u", "gamma"), NET)
def test_net_on_a_sphere(polar, u, gamma):
    shear = exact.net_shear_on_sphere(np.array(u**2))
    reached = exact.bias_diagonal_of_net(np.array([u]))[0]
    assert math.degrees(shear) == pytest.approx(gamma, abs=2e-4)
    assert math.degrees(reached) == pytest.approx(polar, abs=2e-4)


def test_net_on_a_sphere_starts_as_its_series():
    z = np.array([0.0, 1e-4, 1e-3, 0.05])
    series = z - z**3 / 18 + 7 * z**5 / 1800
    np.testing.assert_allclose(exact.net_shear_on_sphere(z), series, atol=1e-9)


@pytest.mark.parametrize("angle", ANGLES)
def test_forces_follow_from_power_balance(angle):
    """F dδ/dγ = Σ zone C(γ_zone) A_zone dγ_zone/dγ, with the travels differentiated numerically."""
    step, side, width, height = 1e-5, 0.17, 0.1, 0.23
    couple = INTERLOCK.shear_per_area
    frame = exact.frame_travel(side, angle + step) - exact.frame_travel(side, angle - step)
    power = couple(angle) * side**2 / (frame / (2 * step))
    assert exact.frame_force(INTERLOCK, side, angle) == pytest.approx(power, rel=1e-8)
    bias = [exact.bias_travel(width, height, angle + s) for s in (step, -step)]
    middle, beside = width * (2 * height - 3 * width) / 2, width**2
    power = (couple(angle) * middle + couple(angle / 2) * beside / 2) / (
        (bias[0] - bias[1]) / (2 * step)
    )
    assert exact.bias_force(INTERLOCK, width, height, angle) == pytest.approx(power, rel=1e-8)


def test_reference_values_of_frame_and_strip():
    unit = fabric(LinearTension(1e3, 1e3), ShearPolynomial((1.0,)))
    couple = 0.5 / unit.cell_area
    at = exact.frame_angle(1.0, 0.31783724519578205)
    assert math.degrees(at) == pytest.approx(30.0, abs=1e-9)
    scaled = exact.frame_force(unit, 1.0, 0.5, sample=0.5) / (couple * 0.25)
    assert scaled == pytest.approx(math.sqrt(2) / (math.cos(0.25) - math.sin(0.25)), rel=1e-12)
    assert exact.bias_travel(0.1, 0.2, math.radians(40)) == pytest.approx(0.02817127641115771)


def test_travels_and_angles_turn_each_other_round():
    np.testing.assert_allclose(exact.frame_angle(0.2, exact.frame_travel(0.2, ANGLES)), ANGLES)
    travels = exact.bias_travel(0.1, 0.25, ANGLES)
    np.testing.assert_allclose(exact.bias_angle(0.1, 0.25, travels), ANGLES)


def test_crimp_tensions_of_equal_yarns_need_no_root_finder():
    """Equal yarns at equal strains keep their heights: T = EA (L/l − 1) p(1 + ε)/L."""
    e, p, length = 0.01, PLAIN.spacing_warp, PLAIN.lengths[0]
    stretched = math.hypot(p * (1 + e), PLAIN.heights[0])
    tension = PLAIN.stiffness_warp * (stretched / length - 1) * p * (1 + e) / stretched
    np.testing.assert_allclose(exact.crimp_tensions(PLAIN, e, e), tension, rtol=1e-11)


def test_yarn_tensions_are_those_of_the_card():
    strains = np.array([[0.001, 0.002], [0.004, 0.0]])
    np.testing.assert_allclose(
        exact.yarn_tensions(INTERLOCK, strains), strains * (46e3, 48e3), rtol=1e-12
    )
    crimped = exact.yarn_tensions(fabric(UNEQUAL), strains)
    np.testing.assert_allclose(crimped[1], exact.crimp_tensions(UNEQUAL, 0.004, 0.0))


def test_catenary_of_a_nearly_straight_chain():
    span, more = 1.0, 1e-4
    assert exact.catenary_sag(span + more, span) == pytest.approx(
        math.sqrt(3 * span * more / 8), rel=1e-3
    )
    with pytest.raises(InputError, match="below the length"):
        exact.catenary_sag(1.0, 1.0)


@pytest.mark.parametrize("degrees", [0.0, -5.0, 90.0, 120.0, math.nan, "40"])
def test_angles_past_collapse_are_refused(degrees):
    with pytest.raises(InputError, match="angle"):
        exact.check_shear_angle("angle", degrees)
