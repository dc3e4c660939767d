"""Study files: distributions against closed forms, designs, cards, and words for what is wrong."""

import math
import tomllib
from collections import Counter
from statistics import NormalDist

import numpy as np
import pytest
from study_checks import write_study

from warpdrape.commands.scene_library import find_script
from warpdrape.errors import InputError
from warpdrape.materials.card_text import card_text
from warpdrape.materials.fabric_library import fabric_names, load_fabric
from warpdrape.studies.cards import read_card, write_card
from warpdrape.studies.design import Design
from warpdrape.studies.distributions import EDGE, read_spread
from warpdrape.studies.parameters import band_of, exact, read_parameter
from warpdrape.studies.study_file import read_study

SHARES = np.linspace(0.001, 0.999, 57)
STUDY = """
scene = "hemisphere"
[parameters.holder_force]
range = ["50 N", "0.4 kN"]
[parameters.friction]
range = [0.1, 0.4]
[parameters.cells]
range = [4, 7]
[design]
kind = "latin"
runs = 8
"""


def spread(**given):
    return read_spread(given, float, numeric=True)


def triangular_below(x, low, mode, high):
    """Share of a triangular distribution below x, by its area."""
    if x <= mode:
        return (x - low) ** 2 / ((high - low) * (mode - low))
    return 1.0 - (high - x) ** 2 / ((high - low) * (high - mode))


@pytest.mark.parametrize(
    ("given", "below"),
    [
        ({"range": [2.0, 6.0]}, lambda x: (x - 2.0) / 4.0),
        ({"log_range": [1.0, 1e4]}, lambda x: math.log10(x) / 4.0),
        ({"normal": {"mean": 3.0, "sd": 0.5}}, NormalDist(3.0, 0.5).cdf),
        (
            {"lognormal": {"median": 2.0, "spread": 0.3}},
            lambda x: NormalDist(0.0, 0.3).cdf(math.log(x / 2.0)),
        ),
        (
            {"triangular": {"low": 1.0, "mode": 2.0, "high": 5.0}},
            lambda x: triangular_below(x, 1.0, 2.0, 5.0),
        ),
    ],
)
def test_a_share_of_all_values_lies_below_the_one_at_it(given, below):
    found = spread(**given)
    assert [below(found.at(u)) for u in SHARES] == pytest.approx(SHARES, abs=1e-9)


def test_ends_cut_off_a_normal_distribution():
    found = spread(normal={"mean": 1.0, "sd": 1.0, "low": 0.0, "high": 1.5})
    n = NormalDist(1.0, 1.0)
    within = n.cdf(1.5) - n.cdf(0.0)
    for u in SHARES:
        assert (n.cdf(found.at(u)) - n.cdf(0.0)) / within == pytest.approx(u, abs=1e-9)
    assert 0.0 <= found.at(0.0) < 1e-4 and 1.5 - 1e-4 < found.at(1.0) <= 1.5


def test_a_distribution_without_ends_gives_no_infinity():
    found = spread(normal={"mean": 0.0, "sd": 1.0})
    assert found.at(0.0) == pytest.approx(NormalDist().inv_cdf(EDGE))
    assert found.at(1.0) == pytest.approx(-found.at(0.0))


def test_whole_numbers_and_values_have_the_same_chance():
    shares = (np.arange(1000) + 0.5) / 1000
    counts = Counter(spread(range=[3, 7]).whole_at(u) for u in shares)
    assert counts == dict.fromkeys(range(3, 8), 200)
    counts = Counter(spread(values=[5, 6, 9, 1]).at(u) for u in shares)
    assert counts == dict.fromkeys((5.0, 6.0, 9.0, 1.0), 250)
    assert spread(values=[1, 2]).at(1.0) == 2.0 and spread(range=[3, 7]).whole_at(1.0) == 7


def test_units_and_a_latin_hypercube(tmp_path):
    study = read_study(write_study(tmp_path, STUDY))
    rows = study.rows()
    assert len(rows) == 8
    for name, low, high in (("holder_force", 50.0, 400.0), ("friction", 0.1, 0.4)):
        parts = sorted(int(8 * (row[name] - low) / (high - low)) for row in rows)
        assert parts == list(range(8)), name  # one in each eighth: what makes it a Latin hypercube
    assert {type(row["cells"]) for row in rows} == {int}
    assert Counter(row["cells"] for row in rows) == dict.fromkeys((4, 5, 6, 7), 2)
    assert rows == study.rows()  # the same again


def test_a_grid_has_every_combination_once(tmp_path):
    text = STUDY.partition("[design]")[0] + '[parameters.mesh]\nvalues = ["grid", "aligned"]\n'
    study = read_study(write_study(tmp_path, text + '[design]\nkind = "grid"\nsteps = 3\n'))
    rows = study.rows()
    assert len(rows) == 3 * 3 * 3 * 2 == len({tuple(row.values()) for row in rows})
    assert sorted({row["holder_force"] for row in rows}) == [50.0, 225.0, 400.0]
    assert sorted({row["cells"] for row in rows}) == [4, 6, 7]  # 5.5 is no number of cells


def test_a_sobol_sequence_grows_without_changing(tmp_path):
    short, long = Design("sobol", runs=16, seed=3), Design("sobol", runs=64, seed=3)
    assert np.array_equal(long.shares(3)[:16], short.shares(3))
    counts = np.histogram(long.shares(3)[:, 1], bins=64, range=(0, 1))[0]
    assert (counts == 1).all()  # a (0, m, 1) net in every coordinate


def test_saltelli_has_a_row_for_each_parameter_and_two_more():
    pytest.importorskip("SALib")
    shares = Design("indices", runs=8).shares(3)
    assert shares.shape == (8 * 5, 3)
    blocks = shares.reshape(8, 5, 3)
    for k in range(3):  # a row of the middle has one column of the last row, all else of the first
        changed = blocks[:, 1 + k] != blocks[:, 0]
        assert changed[:, k].all() and not np.delete(changed, k, axis=1).any()
        assert np.array_equal(blocks[:, 1 + k, k], blocks[:, 4, k])


def test_a_list_from_a_file(tmp_path):
    (tmp_path / "rows.csv").write_text("friction,angle_deg\n0.1,45\n0.2,30deg\n", encoding="utf-8")
    text = 'scene = "hemisphere"\n[design]\nkind = "list"\nfile = "rows.csv"\n'
    rows = read_study(write_study(tmp_path, text)).rows()
    assert rows == [{"friction": 0.1, "angle_deg": 45.0}, {"friction": 0.2, "angle_deg": 30.0}]


def test_fabric_files_are_looked_for_beside_the_study(tmp_path):
    text = 'scene = "hemisphere"\n[parameters.fabric]\nvalues = ["mine.toml", "carbon_interlock"]\n'
    rows = read_study(write_study(tmp_path, text + '[design]\nkind = "grid"\n')).rows()
    assert [row["fabric"] for row in rows] == [str(tmp_path / "mine.toml"), "carbon_interlock"]
    text = 'scene = "hemisphere"\n[design]\nkind = "list"\nrows = [{ fabric = "mine.toml" }]\n'
    assert read_study(write_study(tmp_path, text)).rows() == [
        {"fabric": str(tmp_path / "mine.toml")}
    ]


def test_a_setting_gives_a_value_back_to_the_last_bit():
    script = find_script("hemisphere")
    for value in (0.1 + 0.2, 1e-17, 123456.789012345678, 1.0 / 3.0):
        text = f"holder_force={exact(value)}"
        assert script.read_settings([text]) == {"holder_force": value}
    gaps = (0.1, 1 / 3)
    assert exact(gaps) == f"0.1,{1 / 3!r}" and exact(True) == "true"


def test_values_of_a_card(tmp_path):
    card = read_card("carbon_interlock")
    changes = [("tension.warp", 50.0, False), ("shear.coefficients", 1.1, True)]
    write_card(tmp_path / "mine.toml", card.with_values(changes, "s"))
    mine, own = load_fabric(tmp_path / "mine.toml"), load_fabric("carbon_interlock")
    assert mine.tension.warp == 50e3 and mine.tension.weft == own.tension.weft
    assert mine.shear.coefficients == pytest.approx([1.1 * c for c in own.shear.coefficients])
    assert "study s: in place of 46; FEA_Draping" in mine.sources["tension.warp"].text
    assert load_fabric("carbon_interlock").tension.warp == own.tension.warp


@pytest.mark.parametrize("name", fabric_names())
def test_every_card_comes_back_as_it_was_written(name, tmp_path):
    tables = {**read_card(name).tables, "key of words": {"a.b": 'ü \\ " \n'}}
    assert tomllib.loads(card_text(tables, "of a test")) == tables


def test_a_band_becomes_the_normal_distribution_that_has_it(tmp_path):
    text = 'doubt = "90% band over 5 or more specimens a test: ±3.2 % at 20° and ±4.5 % at 40°"'
    file = tmp_path / "card.toml"
    tables = dict(read_card("carbon_interlock").tables)
    tables["tension"] = {**tables["tension"], "warp": {**tables["tension"]["warp"]}}
    tables["tension"]["warp"] |= tomllib.loads(text)
    write_card(file, tables)
    card = read_card(str(file))
    assert band_of(card, "tension.warp") == (0.9, 0.045)  # the wider one
    given = {"card": "tension.warp", "band": "card"}
    varied = read_parameter("stiff", given, find_script("hemisphere"), card)
    assert varied.relative and varied.unit == "-"
    assert varied.at(0.95) == pytest.approx(1.045, abs=1e-9)  # 90 % of it between the ends
    assert varied.at(0.05) == pytest.approx(0.955, abs=1e-9)
    with pytest.raises(InputError, match=r"tension.weft of .* no band beside it.*give a number"):
        band_of(card, "tension.weft")


LATIN = '[design]\nkind = "latin"\nruns = 4\n'
ONE = "[parameters.friction]\nrange = [0.1, 0.2]\n"
BAD = {
    "nothing at all": ("", "scene is missing"),
    "no TOML": ("scene = ", "not valid TOML"),
    "a scene unknown": ('scene = "hemisfere"', "did you mean 'hemisphere'"),
    "a key unknown": ('scene = "hemisphere"\nparametres = 1', "did you mean 'parameters'"),
    "no design": ('scene = "hemisphere"\n' + ONE, "[design] needs kind, one of grid"),
    "a design unknown": ('scene = "hemisphere"\n[design]\nkind = "sobel"', "did you mean 'sobol'"),
    "no runs": ('scene = "hemisphere"\n' + ONE + '[design]\nkind = "latin"', "needs runs"),
    "no power of two": (
        'scene = "hemisphere"\n' + ONE + '[design]\nkind = "sobol"\nruns = 100',
        "must be a power of two, for which a Sobol sequence fills its space evenly: 64 or 128",
    ),
    "too many runs": (
        'scene = "hemisphere"\n' + ONE + '[design]\nkind = "latin"\nruns = 10000000',
        "10000000 runs, 1000000 at most",
    ),
    "no parameters": ('scene = "hemisphere"\n' + LATIN, "no parameters: give [parameters.NAME]"),
    "a parameter unknown": (
        'scene = "hemisphere"\n[parameters.frictoin]\nrange = [0, 1]\n' + LATIN,
        "has no parameter 'frictoin'; did you mean 'friction'",
    ),
    "varies in no way": (
        'scene = "hemisphere"\n[parameters.friction]\n' + LATIN,
        "parameter 'friction': give one of values, range",
    ),
    "varies in two": (
        'scene = "hemisphere"\n[parameters.friction]\nrange = [0, 1]\nvalues = [1]\n' + LATIN,
        "there are 2",
    ),
    "a range that falls": (
        'scene = "hemisphere"\n[parameters.friction]\nrange = [0.4, 0.1]\n' + LATIN,
        "must rise from its lowest to its highest",
    ),
    "a range of words": (
        'scene = "hemisphere"\n[parameters.mesh]\nrange = ["a", "b"]\n' + LATIN,
        "range needs a parameter that is one number: give values",
    ),
    "a wrong unit": (
        'scene = "hemisphere"\n[parameters.travel]\nrange = ["10N", "20N"]\n' + LATIN,
        "units it may be given with: m, cm, mm",
    ),
    "a normal without sd": (
        'scene = "hemisphere"\n[parameters.friction]\nnormal = { mean = 1 }\n' + LATIN,
        "normal lacks sd",
    ),
    "a normal with sd 0": (
        'scene = "hemisphere"\n[parameters.friction]\nnormal = { mean = 1, sd = 0 }\n' + LATIN,
        "sd = 0 must be above zero",
    ),
    "a mode outside": (
        'scene = "hemisphere"\n[parameters.friction]\n'
        "triangular = { low = 0, mode = 2, high = 1 }\n" + LATIN,
        "must have low below high, and mode between",
    ),
    "nothing left of a normal": (
        'scene = "hemisphere"\n[parameters.friction]\n'
        "normal = { mean = 0, sd = 1e-3, low = 1, high = 2 }\n" + LATIN,
        "low and high leave nothing of it",
    ),
    "set and varied": (
        'scene = "hemisphere"\n[set]\nfriction = 0.1\n' + ONE + LATIN,
        "friction is both in [set] and a parameter",
    ),
    "a key of the card unknown": (
        'scene = "hemisphere"\n[parameters.k]\ncard = "tension.wrap"\nrange = [1, 2]\n' + LATIN,
        "has no value 'tension.wrap'; did you mean 'tension.warp'",
    ),
    "a list of the card": (
        'scene = "hemisphere"\n[parameters.k]\ncard = "shear.coefficients"\nrange = [1, 2]\n'
        + LATIN,
        "is a list of 3 values: say relative = true",
    ),
    "another unit than the card's": (
        'scene = "hemisphere"\n[parameters.k]\ncard = "tension.warp"\nrange = ["1 N", "2 N"]\n'
        + LATIN,
        "must be in the card's unit, kN",
    ),
    "a band and no card": (
        'scene = "hemisphere"\n[parameters.friction]\nband = 0.1\n' + LATIN,
        "relative and band are for values of a card",
    ),
    "indices of words": (
        'scene = "hemisphere"\n[parameters.mesh]\nvalues = ["grid", "random"]\n'
        '[design]\nkind = "indices"\nsamples = 8',
        "is no number: Sobol indices are of numbers",
    ),
    "rows that differ": (
        'scene = "hemisphere"\n[design]\nkind = "list"\n'
        "rows = [{ friction = 0.1 }, { travel = 0.1 }]",
        "row 2 and the first one differ in friction, travel",
    ),
    "a measure that is no path": (
        'scene = "hemisphere"\n' + ONE + LATIN + '[measures]\na = "history.punch_force_n"',
        "must be history.COLUMN.HOW, HOW one of last, max, min, mean",
    ),
    "a measure's name taken": (
        'scene = "hemisphere"\n' + ONE + LATIN + '[measures]\nstatus = "steps"',
        "measure 'status': give another name",
    ),
    "frames": ('scene = "hemisphere"\n' + ONE + LATIN + "[run]\nframes = 0", "frames = 0 must be"),
    "a map option": (
        'scene = "hemisphere"\n' + ONE + LATIN + '[maps]\nwrinkle = "3 kg"',
        "wrinkle = '3 kg': units it may be given with: m",
    ),
    "a name that leads elsewhere": (
        'scene = "hemisphere"\nname = "../a"\n' + ONE + LATIN,
        "name = '../a' must be of letters",
    ),
    "limits not there": ('limits = "no.toml"\nscene = "hemisphere"\n' + ONE + LATIN, "no.toml"),
}


@pytest.mark.parametrize(("text", "words"), BAD.values(), ids=BAD.keys())
def test_what_is_wrong_is_said_in_a_line(text, words, tmp_path):
    path = write_study(tmp_path, text)
    with pytest.raises(InputError) as caught:
        read_study(path).rows()
    assert words in str(caught.value) and "\n" not in str(caught.value)
    assert text.count("rows") or str(path) in str(caught.value)


def test_a_study_that_is_not_there(tmp_path):
    with pytest.raises(InputError, match="cannot be read: No such file"):
        read_study(tmp_path / "none.toml")
