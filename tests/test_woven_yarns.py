"""Yarns of a unit cell as woven: compaction, splines, paths, crimps that must fit, sections."""

import math
from dataclasses import replace

import numpy as np
import pytest
from cell_checks import SOFT, cell_of

from warpdrape.errors import InputError
from warpdrape.unit_cell.cell import fibre_shares
from warpdrape.unit_cell.path import amplitude_of, crimp_of, woven_height
from warpdrape.unit_cell.splines import spline_basis, spline_value, through


def test_a_yarns_pressure_is_the_slope_of_its_energy():
    e, step = np.array([0.02, 0.2, 0.6]), 1e-6
    rise = (SOFT.energy(e + step) - SOFT.energy(e - step)) / (2 * step)
    np.testing.assert_allclose(SOFT.stress(e), rise, rtol=1e-7)
    bend = (SOFT.stress(e + step) - SOFT.stress(e - step)) / (2 * step)
    np.testing.assert_allclose(SOFT.stiffness(e), bend, rtol=1e-7)
    assert SOFT.stress(np.array([0.5]))[0] == pytest.approx(5e3 * (2.0**8 - 1.0))
    for law in (SOFT.energy, SOFT.stress, SOFT.stiffness):
        assert not law(np.array([-0.3, -1e-9])).any()
    assert np.isinf(SOFT.energy(np.array([1.0, 1.5]))).all()


@pytest.mark.parametrize(("name", "value"), [("pressure", 0.0), ("exponent", 1.0)])
def test_compaction_laws_that_are_none_are_refused(name, value):
    with pytest.raises(InputError, match=f"compaction_{name}"):
        replace(SOFT, **{name: value})


def test_splines_are_periodic_and_their_slopes_are_slopes():
    rng = np.random.default_rng(1)
    coefficients, step = rng.normal(size=10), 0.3
    at = rng.uniform(-5.0, 8.0, 40)
    for order in (0, 1):
        here, there = (spline_value(coefficients, at + d, step, order) for d in (-1e-6, 1e-6))
        slope = spline_value(coefficients, at, step, order + 1)
        np.testing.assert_allclose((there - here) / 2e-6, slope, atol=2e-5)
    value = spline_value(coefficients, at, step)
    np.testing.assert_allclose(spline_value(coefficients, at + 3.0, step), value)
    np.testing.assert_allclose(spline_basis(at, 10, step) @ coefficients, value)
    turned = spline_value(coefficients, at + 1e-30j, step).imag / 1e-30
    np.testing.assert_allclose(turned, spline_value(coefficients, at, step, 1))
    heights = rng.normal(size=10)
    np.testing.assert_allclose(
        spline_value(through(heights, step), step * np.arange(10), step), heights
    )


def test_the_woven_path_climbs_from_side_to_side():
    signs, a, s, w = (1, 1, -1), 0.3e-3, 5e-3, 3e-3
    x = np.linspace(-1.0, 1.0, 200_001) * s * 3
    z = woven_height(x, signs, a, s, w)
    at = woven_height(np.arange(-3, 4) * s, signs, a, s, w)
    np.testing.assert_allclose(at, a * np.array([1, 1, -1, 1, 1, -1, 1]))
    slope = np.diff(z) / np.diff(x)
    assert np.abs(np.diff(slope)).max() < 1e-4  # no kink
    long = np.sqrt(np.diff(x) ** 2 + np.diff(z) ** 2).sum()
    crimp = crimp_of(a, s, w, 2.0 / 3.0)
    assert long / np.ptp(x) - 1.0 == pytest.approx(crimp, rel=1e-6)
    assert crimp > 0.005
    assert amplitude_of(crimp, s, w, 2.0 / 3.0) == pytest.approx(a, rel=1e-9)


def test_crimps_and_heights_must_fit():
    assert cell_of().amplitudes == (0.25e-3, 0.3e-3)  # half of what they cross
    # the warp fills more of its spacing than the weft does, and comes to it first or last
    assert cell_of().locking == min(math.acos(4.1 / 5.2), math.acos(3.9 / 4.8))
    assert cell_of().locking < math.acos(4.1 / 5.2) - 0.01
    wanted = cell_of().crimps
    both = cell_of(crimp=wanted)
    np.testing.assert_allclose(both.amplitudes, (0.25e-3, 0.3e-3), rtol=1e-9)
    flat = cell_of(crimp=(0.0, None))  # the weft waves round a straight warp
    np.testing.assert_allclose(flat.amplitudes, (0.0, 0.55e-3))
    assert flat.crimps[1] > 3.0 * wanted[1]
    with pytest.raises(InputError, match="correct one, or leave one crimp out"):
        cell_of(crimp=(2.0 * wanted[0], wanted[1]))
    assert cell_of(crimp=(2.0 * wanted[0], None)).crimps[0] == pytest.approx(2.0 * wanted[0])
    with pytest.raises(InputError, match=r"more than the .* % that heights"):
        cell_of(crimp=(0.2, None))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"width": (5.3e-3, 3.9e-3)}, "width_warp = 5.3 mm must be below spacing_warp = 5.2 mm"),
        ({"height": (0.0, 0.5e-3)}, "height_warp"),
        ({"stiffness": (44e3, -1.0)}, "stiffness_weft"),
        ({"bending": (0.0, 1e-7)}, "bending_warp"),
        ({"section": "disc"}, "unknown section 'disc'"),
        ({"friction": -0.1}, "friction"),
        ({"sticking_angle": 0.7}, "below 29°"),
        ({"crimp": (0.9, None)}, "above 0.5"),
        ({"slack": 0.0}, "slack"),
    ],
)
def test_cells_that_cannot_be_are_refused(change, words):
    with pytest.raises(InputError, match=words):
        cell_of(**change)


def test_more_fibres_than_a_section_holds_are_refused():
    area = 2.0 / 3.0 * 4e-3 * 0.5e-3
    shares = fibre_shares("lens", (4e-3,) * 2, (0.5e-3,) * 2, (0.6 * area, 0.8 * area))
    np.testing.assert_allclose(shares, (0.6, 0.8))
    with pytest.raises(InputError, match="fibres fill 95 % of a weft yarn's section"):
        fibre_shares("lens", (4e-3,) * 2, (0.5e-3,) * 2, (0.6 * area, 0.95 * area))
