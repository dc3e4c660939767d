"""What is wrong with a fabric file is refused, or warned about, with its line."""

import re
import warnings
from importlib import resources

import pytest
from fabric_text import GOOD, writer

from warpdrape.errors import InputError
from warpdrape.materials.fabric_library import load_fabric

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


@pytest.fixture
def write(tmp_path):
    return writer(tmp_path)


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
