"""Fabric files: what they hold, what is wrong with bad ones, and the card."""

import math
import re
import warnings
from importlib import resources

import numpy as np
import pytest

from warpdrape.errors import InputError
from warpdrape.materials.fabric import STATUSES, Source
from warpdrape.materials.fabric_card import card, plot_card
from warpdrape.materials.fabric_library import fabric_names, load_fabric, odd_yarns
from warpdrape.materials.fabric_units import UNITS, si_factor
from warpdrape.materials.laws import IsotropicMembrane, NoShear, ShearTable, TabulatedTension

GOOD = """\
name = "mine"

[areal_density]
value = 300
unit = "g/m^2"
status = "measured"
source = "own scales"

[thickness]
value = 0.3
unit = "mm"
status = "measured"
source = "own gauge"

[yarns_warp]
value = 5
unit = "1/cm"
status = "measured"
source = "counted"

[cell_warp]
value = 2.5
unit = "mm"
status = "measured"
source = "counted"

[tension]
law = "linear"
warp = { value = 40, unit = "kN", status = "assumed", source = "a guess" }
weft = { value = 50, unit = "kN", status = "assumed", source = "a guess" }

[shear]
law = "table"

[shear.angles]
value = [0, 10, 30, 60]
unit = "deg"
status = "measured"
source = "picture frame"

[shear.couples]
value = [0, 0.1, 0.2, 0.9]
unit = "N*mm"
status = "measured"
source = "picture frame"
"""


@pytest.fixture
def write(tmp_path):
    """Write a fabric file, ``GOOD`` with replacements, and return its path."""

    def write(*replacements):
        text = GOOD
        for old, new in replacements:
            assert old in text
            text = text.replace(old, new, 1)
        path = tmp_path / "mine.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return write


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


TOLD = 'status = "measured", source = "own test"'


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


def test_units_of_the_field():
    assert si_factor("couple", "N mm") is None
    assert si_factor("couple", "N·mm") == si_factor("couple", "N.mm") == 1e-3
    assert si_factor("areal density", "g/m2") == 1e-3
    assert si_factor("yarns per length", "1/inch") == pytest.approx(39.3700787)
    # One, written in the larger unit and in the smaller: the same quantity.
    for quantity, one, many, count in (
        ("areal density", "kg/m²", "g/m²", 1000),
        ("length", "m", "cm", 100),
        ("length", "cm", "mm", 10),
        ("length", "mm", "µm", 1000),
        ("yarns per length", "1/mm", "1/cm", 10),
        ("yarns per length", "1/cm", "1/m", 100),
        ("force", "kN", "N", 1000),
        ("force", "N", "cN", 100),
        ("couple", "N·m", "N·cm", 100),
        ("couple", "N·cm", "N·mm", 10),
        ("couple", "N·mm", "mN·m", 1),
        ("bending stiffness", "N·m", "N·mm", 1000),
        ("bending stiffness", "N·mm", "mN·m", 1),
        ("bending stiffness", "mN·m", "µN·m", 1000),
        ("bending stiffness", "cN·cm²/cm", "µN·m", 100),
        ("bending stiffness", "cN·cm²/cm", "gf·cm²/cm", 1 / 0.980665),
        ("curvature", "1/mm", "1/cm", 10),
        ("curvature", "1/cm", "1/m", 100),
        ("moment per width", "N", "mN", 1000),
        ("moment per width", "N·m/m", "N·mm/mm", 1),
        ("moment per width", "cN·cm/cm", "mN", 10),
        ("moment per width", "gf·cm/cm", "cN·cm/cm", 0.980665),
        ("force per length", "N/mm", "kN/m", 1),
        ("force per length", "kN/m", "N/m", 1000),
        ("angle", "rad", "°", 180.0 / math.pi),
        ("angle", "deg", "°", 1),
        ("ratio", "-", "%", 100),
    ):
        assert si_factor(quantity, one) == pytest.approx(count * si_factor(quantity, many)), one
    for quantity, units in UNITS.items():
        assert 1.0 in units.values(), quantity
        assert all(si_factor(quantity, unit) == factor for unit, factor in units.items())


# What is wrong → the line it is on and words of the message.
FAULTS = {
    "unknown unit": (('unit = "g/m^2"', 'unit = "oz/yd²"'), 5, "areal_density.unit.*g/m²"),
    "wrong quantity": (('unit = "mm"', 'unit = "N"'), 11, "thickness.unit.*no unit of length"),
    "no unit": (('unit = "mm"\n', ""), 9, "'thickness': 'unit'.*missing"),
    "empty source": (('source = "own gauge"', 'source = " "'), 13, "source.*where the value comes"),
    "angles in radians": (('unit = "deg"', 'unit = "rad"'), 36, "below 90°.*3438°.*unit"),
    "past collapse": (("[0, 10, 30, 60]", "[0, 10, 30, 90]"), 36, "below 90°.*reach 90°"),
    "not from zero": (("[0, 10, 30, 60]", "[5, 10, 30, 60]"), 32, "starts at 0°.*not at 5°"),
    "no value": (("value = 0.3\n", ""), 9, "'thickness': 'value' is missing"),
    "no source": (('source = "own gauge"', ""), 9, "'thickness': 'source'.*missing"),
    "unknown status": (('status = "measured"', 'status = "mesured"'), 6, "'measured'"),
    "unknown key": (('law = "linear"', 'law = "linear"\nwrap = 1'), 29, "did you mean 'warp'"),
    "unknown key of a value": (('source = "own gauge"', 'sauce = "x"'), 13, "mean 'source'"),
    "unknown table": (("[thickness]", "[thicknes]"), 9, "did you mean 'thickness'"),
    "unknown law": (('law = "linear"', 'law = "liner"'), 28, "did you mean 'linear'"),
    "text for a number": (("value = 0.3", 'value = "0.3"'), 10, "thickness.value.*finite num"),
    "array for a number": (("value = 0.3", "value = [0.3]"), 10, "thickness.value.*one number"),
    "not finite": (("value = 0.3", "value = nan"), 10, "thickness.value.*finite"),
    "negative": (("value = 0.3", "value = -0.3"), 10, "thickness.value.*above zero"),
    "negative count": (("value = 5", "value = -5"), 16, "yarns_warp.value.*above zero"),
    "unsorted": (("[0, 10, 30, 60]", "[0, 30, 10, 60]"), 36, "shear.angles.value.*10° follows 30°"),
    "falling at the end": (("0.2, 0.9", "0.2, 0.1"), 42, "shear.couples.value.*must not fall"),
    "negative couple": (("0.1, 0.2", "0.1, -0.2"), 42, "shear.couples.value.*at 30°"),
    "lengths differ": (("0.1, 0.2, 0.9", "0.1, 0.9"), 42, "as many couples"),
    "ragged": (("[0, 10, 30, 60]", "[[0, 10], [30]]"), 36, "shear.angles.value.*array of numbers"),
    "cell twice": (("[thickness]", "[cell_weft]\n[thickness]"), 16, "either 'yarns_warp' or"),
    "zero stiffness": (("value = 40", "value = 0"), 29, "tension.warp.value.*above zero"),
    "no name": (('name = "mine"', ""), 1, "'name'.*missing"),
    "broken": (("[thickness]", "[thickness"), 9, "not valid TOML"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_faults_name_file_line_and_key(write, fault):
    replacement, line, words = FAULTS[fault]
    path = write(replacement)
    with pytest.raises(InputError, match=words) as caught:
        load_fabric(path)
    text = str(caught.value)
    assert str(path) in text
    assert re.search(rf"line {line}\b", text)
    assert "\n" not in text


def test_a_file_that_is_not_utf_8_is_named_with_its_line(write):
    path = write()
    path.write_bytes(path.read_bytes().replace(b"own gauge", "größe".encode("latin-1")))
    with pytest.raises(InputError, match=r"mine.toml, line 13: not UTF-8"):
        load_fabric(path)


def test_a_fault_is_told_once(write):
    start = GOOD.index("[shear]")
    scalar = """[shear]
law = "polynomial"
coefficients = { value = 3.0, unit = "N·mm", status = "assumed", source = "a guess" }
"""
    with pytest.raises(InputError) as caught:
        load_fabric(write((GOOD[start:], scalar)))
    assert str(caught.value).count("line 34") == 1
    assert str(caught.value).endswith("must be an array of numbers")


def test_unknown_names_get_the_nearest_known_one(tmp_path):
    with pytest.raises(InputError, match="did you mean 'carbon_interlock'"):
        load_fabric("carbon_interlok")
    with pytest.raises(InputError, match="cannot be read"):
        load_fabric(tmp_path / "none.toml")
    with pytest.raises(InputError, match="name or the path"):
        load_fabric(3)


def test_falling_couple_of_a_file_is_warned_about(write):
    start = GOOD.index("[shear]")
    falling = """[shear]
law = "polynomial"
coefficients = { value = [1, -1], unit = "N·mm", status = "assumed", source = "a guess" }
"""
    with pytest.warns(UserWarning, match="'mine'.*falls beyond 33.1°"):
        load_fabric(write((GOOD[start:], falling)))
    with pytest.warns(UserWarning, match="check the signs of its coefficients"):
        load_fabric(write((GOOD[start:], falling)))
    with warnings.catch_warnings(action="error"):
        load_fabric(write((GOOD[start:], falling.replace("-1", "1"))))


def test_a_table_that_falls_is_told_where_and_what_helps(write):
    with pytest.warns(
        UserWarning, match="couple falls from 10° to 30° of its table; leave out"
    ) as w:
        load_fabric(write(("0.1, 0.2, 0.9", "0.1, 0.05, 0.9")))
    assert "coefficients" not in str(w[0].message) and "calibrate" in str(w[0].message)
    for angles, couples in (("0, 30, 60", "0.05, 0.9"), ("0, 10, 60", "0.1, 0.9")):
        changes = ("[0, 10, 30, 60]", f"[{angles}]"), ("0.1, 0.2, 0.9", couples)
        with warnings.catch_warnings(action="error"):
            load_fabric(write(*changes))


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


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (
            'value = 46\nunit = "kN"',
            'value = 46\nunit = "N"',
            "warp yarns of 0.046 kN, 7.5 per cm, ",
        ),
        ('value = 46\nunit = "kN"', 'value = 46000\nunit = "kN"', "warp yarns of 4.6e+04 kN"),
        ('value = 7.5\nunit = "1/cm"', 'value = 75\nunit = "1/cm"', "75 per cm, are 1.1e+09 m"),
    ],
)
def test_yarns_of_a_wrong_unit_are_warned_about(tmp_path, old, new, words):
    text = resources.files("warpdrape.fabrics").joinpath("carbon_interlock.toml").read_text("utf-8")
    assert old in text
    path = tmp_path / "odd.toml"
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    with pytest.warns(UserWarning, match=re.escape(words)) as caught:
        load_fabric(path)
    assert "check the stiffness, the yarns per length" in str(caught[0].message)


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
