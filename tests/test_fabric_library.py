"""The library's fabrics: what they hold, where it comes from, their cards."""

import math
import warnings

import numpy as np
import pytest

from warpdrape.materials.fabric import STATUSES
from warpdrape.materials.fabric_card import card, plot_card
from warpdrape.materials.fabric_library import fabric_names, load_fabric, odd_yarns
from warpdrape.materials.laws import NoShear


@pytest.mark.parametrize("name", fabric_names())
def test_bundled_fabrics_say_where_every_value_comes_from(name):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        fabric = load_fabric(name)
    assert fabric.name == name
    assert fabric.description
    assert len(fabric.sources) >= 7
    for source in fabric.sources.values():
        assert source.status in STATUSES
        assert source.text
        assert source.given


def test_carbon_interlock_is_the_fabric_of_the_reference_press():
    fabric = load_fabric("carbon_interlock")
    assert fabric.areal_density == pytest.approx(0.63)
    assert fabric.thickness == pytest.approx(6e-4)
    # The weft yarns' spacing is the cell's length along the warp.
    assert (1 / fabric.cell_warp, 1 / fabric.cell_weft) == pytest.approx((740, 750))
    assert fabric.yarn_width == pytest.approx((1 / 750, 1 / 740))
    assert (fabric.tension.warp, fabric.tension.weft) == pytest.approx((46e3, 48e3))
    assert fabric.shear.coefficients == pytest.approx((0.37044e-3, -0.84105e-3, 1.03113e-3))
    assert fabric.compressive_factor == 0.01
    assert fabric.sources["compressive_factor"].status == "assumed"
    assert "sign" in fabric.sources["shear.coefficients"].doubt
    assert "name" in fabric.doubts[0] and "inferred" in fabric.doubts[0]


def test_carbon_interlock_has_its_least_slope_at_28_degrees():
    law = load_fabric("carbon_interlock").shear
    angles = np.radians(np.linspace(0, 80, 8001))
    slopes = law.slope(angles)
    assert slopes.min() * 1e3 == pytest.approx(0.06174, abs=1e-5)
    assert math.degrees(angles[slopes.argmin()]) == pytest.approx(28.36, abs=0.02)


def test_synthetic_plain_crimp_is_that_of_the_closed_form():
    fabric = load_fabric("synthetic_plain_crimp")
    law = fabric.tension
    assert law.heights == pytest.approx((0.465567e-3,) * 2, abs=1e-9)
    assert law.lengths == pytest.approx((5.220800e-3,) * 2, abs=1e-9)
    assert law.stiffness_warp == 34e3
    assert fabric.shear == NoShear()


def test_card_shows_every_value_with_status_source_and_doubt():
    fabric = load_fabric("carbon_interlock")
    text = card(fabric)
    flat = " ".join(text.split())
    for source in fabric.sources.values():
        for part in (source.given, source.status, source.text, source.doubt):
            assert " ".join(part.split()) in flat
    for doubt in fabric.doubts:
        assert doubt in flat
    assert max(map(len, text.splitlines())) <= 100


def test_card_plot(tmp_path):
    for name in fabric_names():
        plot_card(load_fabric(name), tmp_path / f"{name}.png")
        assert (tmp_path / f"{name}.png").stat().st_size > 10_000


@pytest.mark.parametrize("name", fabric_names())
def test_the_bundled_yarns_are_plausible(name):
    assert odd_yarns(load_fabric(name)) == []
