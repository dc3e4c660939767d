"""A user's fabric file: laws, bending, limits, as a fabric and on its card."""

import math
import re

import numpy as np
import pytest
from fabric_text import GOOD, TOLD, writer

from warpdrape.errors import InputError
from warpdrape.materials.fabric import Source
from warpdrape.materials.fabric_card import card
from warpdrape.materials.fabric_library import load_fabric
from warpdrape.materials.laws import IsotropicMembrane, ShearTable, TabulatedTension


@pytest.fixture
def write(tmp_path):
    return writer(tmp_path)


def test_a_users_file(write):
    fabric = load_fabric(write())
    assert fabric.name == "mine"
    assert fabric.areal_density == pytest.approx(0.3)
    assert (fabric.cell_warp, fabric.cell_weft) == pytest.approx((2.5e-3, 2e-3))
    assert isinstance(fabric.shear, ShearTable)
    assert fabric.shear.angles == pytest.approx(np.radians([0, 10, 30, 60]))
    assert fabric.shear.couples == pytest.approx([0, 1e-4, 2e-4, 9e-4])
    assert fabric.sources["tension.warp"] == Source("assumed", "a guess", "", "40 kN")


def test_a_users_file_with_slanted_yarns(write):
    angle = '[yarn_angle]\nvalue = 60\nunit = "°"\nstatus = "measured"\nsource = "x"\n\n[tension]'
    fabric = load_fabric(write(("[tension]", angle)))
    assert fabric.yarn_angle == pytest.approx(math.radians(60))
    assert fabric.yarn_width[0] == pytest.approx(2e-3)  # 5 warp yarns per cm across them


def test_other_laws_in_a_file(write):
    start, end = GOOD.index("[tension]"), GOOD.index("[shear]")
    told = 'status = "measured", source = "biaxial rig"'
    rows = "[[0, 1, 2, 3], [1, 2, 3, 4], [2, 3, 4, 5], [3, 4, 5, 6]]"
    table = f"""[tension]
law = "table"
strain_warp = {{ value = [0, 0.1, 0.2, 0.3], unit = "%", {told} }}
strain_weft = {{ value = [0, 0.1, 0.2, 0.3], unit = "%", {told} }}
tension_warp = {{ value = {rows}, unit = "N", {told} }}
tension_weft = {{ value = {rows}, unit = "N", {told} }}

"""
    fabric = load_fabric(write((GOOD[start:end], table)))
    assert isinstance(fabric.tension, TabulatedTension)
    assert fabric.tension.strain_warp == pytest.approx([0, 1e-3, 2e-3, 3e-3])
    assert "table of 4 rows N" in card(fabric)

    sheet = f"""[tension]
law = "isotropic"
stiffness = {{ value = 20, unit = "N/mm", {told} }}
poisson = {{ value = 0.3, unit = "-", {told} }}
"""
    cell = GOOD[GOOD.index("[yarns_warp]") : start]
    fabric = load_fabric(write((GOOD[start:], sheet), (cell, "")))
    assert fabric.tension == IsotropicMembrane(2e4, 0.3)
    assert "isotropic membrane" in card(fabric)


def bent(text):
    return f"{GOOD}\n[bending]\n" + text


def test_bending_as_stiffness_and_as_flexural_length(write):
    text = bent(
        f'warp = {{ value = 2, unit = "N·mm", {TOLD} }}\n'
        f'flexural_length_weft = {{ value = 60, unit = "mm", {TOLD} }}\n'
    )
    fabric = load_fabric(write((GOOD, text)))
    weft = 9.81 * 0.3 * 0.06**3
    assert fabric.bending.warp == pytest.approx(2e-3)
    assert fabric.bending.weft == pytest.approx(weft)
    assert fabric.bending.twist == pytest.approx(0.1 * math.sqrt(2e-3 * weft))
    shown = card(fabric)
    assert "bending.warp" in shown and "flexural length 60 mm" in shown
    assert "flexural length, warp and weft" in shown and "60 mm" in shown


def test_bending_as_a_curve(write):
    text = bent(
        'law = "curve"\n'
        f'curvatures = {{ value = [0, 2, 10], unit = "1/m", {TOLD} }}\n'
        f'moments_warp = {{ value = [0, 10, 20], unit = "mN", {TOLD} }}\n'
        f'moments_weft = {{ value = [0, 5, 15], unit = "mN", {TOLD} }}\n'
        f'friction_warp = {{ value = 2, unit = "mN", {TOLD} }}\n'
        f'friction_weft = {{ value = 1, unit = "mN", {TOLD} }}\n'
    )
    curve = load_fabric(write((GOOD, text))).bending
    assert list(curve.moments_warp) == pytest.approx([0.0, 0.01, 0.02])
    assert curve.in_plane == pytest.approx((2e-3, 1.5e-3))
    assert curve.friction == pytest.approx((2e-3, 1e-3))
    assert "bending.moments_weft" in card(load_fabric(write((GOOD, text))))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "give either 'warp' or 'flexural_length_warp'"),
        ('law = "linaer"\n', "'linaer' is unknown here; known: linear, curve"),
        ('law = "solid"\n', "'solid' is unknown here"),
        (
            f'warp = {{ value = -2, unit = "N·mm", {TOLD} }}\n'
            f'weft = {{ value = 2, unit = "N·mm", {TOLD} }}\n',
            "must be zero or more",
        ),
        (f'warp = {{ value = 2, unit = "N", {TOLD} }}\n', "'N' is no unit of bending stiffness"),
        (
            f'law = "curve"\ncurvatures = {{ value = [0, 2], unit = "1/m", {TOLD} }}\n',
            "moments_warp",
        ),
    ],
)
def test_bending_that_is_wrong_is_refused_with_its_line(text, words, write):
    with pytest.raises(InputError, match=re.escape(words)) as refused:
        load_fabric(write((GOOD, bent(text))))
    assert ", line " in str(refused.value)


LIMITS = """
[fibre_density]
value = 2.6
unit = "g/cm³"
status = "assumed"
source = "glass"

[locking_angle]
value = 48
unit = "deg"
status = "measured"
source = "picture frame"

[failure_strain_warp]
value = 1.5
unit = "%"
status = "assumed"
source = "data sheet"
"""


def test_limits_for_judging_are_read_and_shown(write):
    fabric = load_fabric(write(("[tension]", f"{LIMITS}\n[tension]")))
    assert fabric.fibre_density == pytest.approx(2600.0)
    assert fabric.locking_angle == pytest.approx(math.radians(48.0))
    assert fabric.failure_strain_warp == pytest.approx(0.015)
    assert fabric.failure_strain_weft is None
    text = card(fabric)
    assert re.search(r"locking_angle +48 deg +0\.8378 rad +measured", text)
    assert re.search(r"failure_strain_warp +1\.5 % +0\.015", text)
    assert re.search(r"fibre volume fraction, flat +38\.5 %", text)
    with pytest.raises(InputError, match=r"line \d+: .*failure_strain_warp = 15.*give 0.015"):
        load_fabric(write(("[tension]", f"{LIMITS}\n[tension]"), ("value = 1.5", "value = 1500")))
