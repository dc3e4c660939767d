"""The matrix in a fabric's file: what is read, what is refused and where, what the card shows."""

import re
import warnings
from importlib import resources

import pytest

from warpdrape.errors import InputError
from warpdrape.laws import WLF, Cross, Newtonian, PowerLaw
from warpdrape.materials.fabric_card import card, plot_card
from warpdrape.materials.fabric_library import load_fabric
from warpdrape.materials.fabric_units import si_factor, si_zero
from warpdrape.report.record import record_section
from warpdrape.results.run_record import plain
from warpdrape.studies.cards import read_card

CARD = resources.files("warpdrape.fabrics").joinpath("synthetic_prepreg.toml").read_text("utf-8")


def quantity(key, value, unit):
    return f'[{key}]\nvalue = {value}\nunit = "{unit}"\nstatus = "assumed"\nsource = "test"\n'


@pytest.fixture
def write(tmp_path):
    """Write the card with replacements, and return its path."""

    def write(*replacements, more=""):
        text = CARD
        for old, new in replacements:
            assert old in text
            text = text.replace(old, new, 1)
        path = tmp_path / "mine.toml"
        path.write_text(text + more, encoding="utf-8")
        return path

    return write


def without_matrix(text):
    """The card up to its matrix."""
    return text[: text.index("# the viscous part")]


def test_the_bundled_card_holds_what_its_file_says():
    fabric = load_fabric("synthetic_prepreg")
    matrix = fabric.matrix
    assert matrix.viscosity == PowerLaw(1e6, 0.45, 0.1, 0.01)
    assert matrix.shift.activation_energy == 60e3
    assert matrix.shift.reference_temperature == pytest.approx(533.15)
    assert matrix.shift.lowest_temperature == pytest.approx(463.15)
    assert (matrix.heat.capacity, matrix.heat.conductance) == (920.0, 500.0)
    assert (matrix.heat.between, matrix.heat.emissivity) == (800.0, 0.9)
    assert matrix.modulus is None and matrix.rise == (0.0, 0.0)
    stated = {name for name in fabric.sources if name.startswith("matrix.")}
    assert len(stated) == 11 and "matrix.shift.activation_energy" in stated
    assert {fabric.sources[name].status for name in fabric.sources} == {"assumed"}
    assert fabric.sources["matrix.shift.reference_temperature"].given == "260 °C"


def test_the_card_shows_the_matrix(tmp_path):
    fabric = load_fabric("synthetic_prepreg")
    shown = card(fabric)
    assert "beside a viscous matrix: power law" in shown
    for row in (
        r"matrix.viscosity +1 MPa·s +1e\+06 Pa·s",
        r"matrix.shift.lowest_temperature +190 °C +463.15 K",
        r"viscous couple per area at 0.1 1/s +50 N/m",
        r"time to cool on one tool, to 1/e +1.84 s",
    ):
        assert re.search(row, shown), row
    assert all(f"{name} " in shown for name in fabric.sources)
    plot_card(fabric, tmp_path / "card.png")
    assert (tmp_path / "card.png").stat().st_size > 10_000
    assert "matrix" not in card(load_fabric("carbon_interlock"))


@pytest.mark.parametrize("law", ["newtonian", "cross"])
def test_other_laws_are_read(tmp_path, law):
    values = {
        "newtonian": quantity("matrix.viscosity", 200, "kPa·s"),
        "cross": quantity("matrix.at_rest", 4, "MPa·s")
        + quantity("matrix.at_last", 20, "kPa·s")
        + quantity("matrix.time", 500, "ms")
        + quantity("matrix.exponent", 0.7, "-"),
    }[law]
    text = without_matrix(CARD) + f'[matrix]\nlaw = "{law}"\n' + values
    text += '[matrix.shift]\nlaw = "wlf"\n' + quantity("matrix.shift.c1", 4, "-")
    text += quantity("matrix.shift.c2", 150, "K")
    text += quantity("matrix.shift.reference_temperature", 533, "K")
    text += quantity("matrix.shift.lowest_temperature", 190, "°C")
    text += quantity("matrix.rise", "[0.5, 1.5]", "-") + quantity("matrix.modulus", 3, "MPa")
    path = tmp_path / "mine.toml"
    path.write_text(text, encoding="utf-8")
    fabric = load_fabric(path)
    expected = {"newtonian": Newtonian(2e5), "cross": Cross(4e6, 2e4, 0.5, 0.7)}[law]
    assert fabric.matrix.viscosity == expected
    assert isinstance(fabric.matrix.shift, WLF) and fabric.matrix.shift.c2 == 150.0
    assert fabric.matrix.rise == (0.5, 1.5) and fabric.matrix.modulus == 3e6
    shown = card(fabric)
    assert "matrix.rise" in shown and "matrix.modulus" in shown


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (('law = "power"', 'law = "powr"'), "key 'matrix.law': .*did you mean 'power'"),
        (('unit = "MPa·s"', 'unit = "MPa"'), "'MPa' is no unit of viscosity; known: Pa·s"),
        (("value = 0.45", "value = 1.4"), "key 'matrix.exponent.value': exponent = 1.4"),
        (("value = 0.45", "value = [0.4, 0.5]"), "matrix.exponent.value': must be one number"),
        (("[matrix.exponent]", "[matrix.exponnt]"), "key 'matrix.exponnt': unknown"),
        (('law = "arrhenius"', 'law = "wlf"'), "matrix.shift.activation_energy': unknown"),
        (('unit = "kJ/mol"', 'unit = "J/mol"'), "key 'matrix.shift.activation_energy.value'"),
        (("value = 260", "value = 160"), "lowest_temperature = .* must not exceed"),
        (("[matrix.heat.capacity]", "[matrix.heat.capacty]"), "key 'matrix.heat.capacty': unkno"),
        (('unit = "W/(m²·K)"', 'unit = "W/K"'), "is no unit of conductance"),
    ],
)
def test_faults_are_said_with_file_line_and_key(write, change, words):
    path = write(change)
    with pytest.raises(InputError, match=words) as refused:
        load_fabric(path)
    line = int(re.search(r"mine.toml, line (\d+)", str(refused.value))[1])
    assert line > CARD[: CARD.index("[matrix]")].count("\n")


def test_plies_that_pass_no_heat_to_others_need_no_value_for_it(tmp_path):
    text = CARD[: CARD.index("[matrix.heat.between]")]
    path = tmp_path / "mine.toml"
    path.write_text(text, encoding="utf-8")
    held = load_fabric(path).matrix.heat
    assert held.between is None and held.emissivity == 0.0
    assert "matrix.heat.between" not in card(load_fabric(path))
    assert "matrix.heat.between" in card(load_fabric("synthetic_prepreg"))
    path.write_text(CARD.replace("value = 0.9\n", "value = 1.9\n"), encoding="utf-8")
    with pytest.raises(InputError, match=r"matrix.heat.emissivity.*must lie in 0 … 1"):
        load_fabric(path)


@pytest.mark.parametrize("value", ["1", "[1, 2, 3]"])
def test_a_rise_that_is_not_two_numbers_is_refused(write, value):
    with pytest.raises(InputError, match="two numbers, of γ² and γ⁴"):
        load_fabric(write(more="\n" + quantity("matrix.rise", value, "-")))


def test_heat_without_a_shift_is_refused(tmp_path):
    text = without_matrix(CARD) + '[matrix]\nlaw = "newtonian"\n'
    text += quantity("matrix.viscosity", 1, "MPa·s") + CARD[CARD.index("[matrix.heat.capacity]") :]
    path = tmp_path / "mine.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match="give shift too, or leave heat out"):
        load_fabric(path)


def test_degrees_celsius_begin_elsewhere_than_kelvin():
    assert si_zero("temperature", "°C") == 273.15 and si_zero("temperature", "K") == 0.0
    assert si_factor("temperature", "°C") == 1.0
    assert si_factor("temperature difference", "°C") is None
    assert si_factor("conductance", "W/(m2*K)") == 1.0


def test_the_bundled_card_raises_no_warning():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        load_fabric("synthetic_prepreg")


def test_a_report_has_units_and_sources_of_a_matrix():
    record = {"fabrics": {"prepreg": plain(load_fabric("synthetic_prepreg"))}}
    rows = re.findall(r"<tr>(.*?)</tr>", str(record_section(record)), re.S)
    found = (re.findall(r"<t[dh][^>]*>(.*?)</t[dh]>", row, re.S) for row in rows)
    cells = {name: values for name, *values in found}
    assert cells["matrix.viscosity.viscosity"][:3] == ["1000000 Pa·s", "1 MPa·s", "assumed"]
    assert cells["matrix.viscosity.lowest_rate"][:3] == ["0.01 1/s", "0.01 1/s", "assumed"]
    assert cells["matrix.shift.reference_temperature"][:2] == ["533.15 K", "260 °C"]
    assert cells["matrix.heat.capacity"][0] == "920 J/(m²·K)"


def test_a_study_varies_degrees_celsius_as_degrees_and_not_by_a_factor():
    prepreg, key = read_card("synthetic_prepreg"), "matrix.shift.reference_temperature"
    with pytest.raises(InputError, match="is in °C, of which a factor means nothing"):
        prepreg.check(key, relative=True)
    assert prepreg.check(key, relative=False) == "°C"
    assert prepreg.check("matrix.viscosity", relative=True) == "MPa·s"
