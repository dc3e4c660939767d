"""Raw tables as laboratories write them: what is read, and what is refused."""

import re
from pathlib import Path

import duckdb
import numpy as np
import pytest

from warpdrape.calibration.columns import heading
from warpdrape.calibration.kinds import KINDS
from warpdrape.calibration.lab_units import lab_factor, si_value
from warpdrape.calibration.raw_layout import Wanted
from warpdrape.calibration.raw_table import read_table
from warpdrape.calibration.raw_text import read_number, read_text
from warpdrape.calibration.tests_file import read_plan
from warpdrape.errors import InputError

RAW = Path(__file__).parents[1] / "examples" / "calibration" / "raw"
TRAVEL = np.array([0.0, 0.5, 1.25, 2.0, 3.75, 1234.5])
FORCE = np.array([0.0, 1.5, -2.25, 10.0, 1000.12, 7.0])


def wanted(kind="picture_frame", **options):
    about = KINDS[kind]
    return Wanted(
        about.columns, about.also, options.pop("columns", {}), options.pop("units", {}), **options
    )


def table(tmp_path, text, encoding="utf-8", name="raw.csv"):
    path = tmp_path / name
    path.write_bytes(text.encode(encoding))
    return path


def body(delimiter, decimal, head):
    rows = [head]
    for pair in zip(TRAVEL, FORCE, strict=True):
        rows.append(delimiter.join(f"{v:g}".replace(".", decimal) for v in pair))
    return "\n".join(rows) + "\n"


STYLES = {
    "plain": (body(",", ".", "travel [mm],force [N]"), "utf-8", 1.0),
    "German": (body(";", ",", "Standardweg;Standardkraft\nmm;N"), "cp1252", 1.0),
    "umlauts, preamble": (
        "Prüfer;Käse\nGeschwindigkeit;20;mm/min\n\n" + body(";", ",", "Weg [mm];Kraft [N]"),
        "cp1252",
        1.0,
    ),
    "version": ("Software;3.1\n" + body(";", ",", "Weg [mm];Kraft [N]"), "utf-8", 1.0),
    "French": (body("\t", ",", "Déplacement (mm)\tEffort (kN)"), "latin-1", 1e3),
    "mark": (body(";", ".", "Extension in mm;Load in N"), "utf-8-sig", 1.0),
    "wide": (body("\t", ",", "Extension (mm)\tLoad (N)"), "utf-16", 1.0),
    "spaces": (body("  ", ",", "travel_mm  force_N"), "utf-8", 1.0),
    "comments": (
        "# made\n% up\n" + body(";", ".", "Travel, mm;Force, N") + "# end\n",
        "utf-8",
        1.0,
    ),
    "other order, more columns": (
        "time [s],load [cN],extension [cm]\n"
        + "".join(
            f"{i},{1e2 * f:g},{0.1 * t:g}\n"
            for i, (t, f) in enumerate(zip(TRAVEL, FORCE, strict=True))
        ),
        "utf-8",
        1.0,
    ),
    "spreadsheet": ("sep=;\n" + body(";", ",", '"Weg [mm]";"Kraft [N]"'), "utf-8", 1.0),
    "quoted": (
        '"travel [mm]","force [N]"\n'
        + "".join(
            '"{}","{}"\n'.format(*(f"{v:g}".replace(".", ",") for v in pair))
            for pair in zip(TRAVEL, FORCE, strict=True)
        ),
        "utf-8",
        1.0,
    ),
}


@pytest.mark.parametrize("style", STYLES)
def test_one_table_in_many_styles(style, tmp_path):
    text, encoding, factor = STYLES[style]
    (specimen,) = read_table(table(tmp_path, text, encoding), wanted())
    np.testing.assert_allclose(specimen.columns["travel"], 1e-3 * TRAVEL, rtol=1e-12)
    np.testing.assert_allclose(specimen.columns["force"], factor * FORCE, rtol=1e-12)


def test_another_reader_reads_the_same():
    """duckdb, told what the file is like, against what is found out here."""
    path = RAW / "frame_1.csv"
    rows = duckdb.sql(
        f"select * from read_csv('{path}', delim=';', decimal_separator=',', skip=6, header=false, "
        "encoding='latin-1', columns={'d': 'DOUBLE', 'f': 'DOUBLE', 't': 'DOUBLE'})"
    ).fetchnumpy()
    (specimen,) = read_table(path, wanted())
    assert len(rows["d"]) == 150
    np.testing.assert_allclose(specimen.columns["travel"], 1e-3 * rows["d"], rtol=1e-14)
    np.testing.assert_allclose(specimen.columns["force"], rows["f"], rtol=1e-14)


@pytest.mark.parametrize(
    ("cell", "decimal", "value"),
    [
        ("1,5", ",", 1.5),
        ("1.234,5", ",", 1234.5),
        ("1 234,5", ",", 1234.5),
        ("1,234.5", ".", 1234.5),
        ("-1e-3", ".", -1e-3),
        ("\u22122.5", ".", -2.5),
        ("1.5", ",", None),
        ("nan", ".", None),
        ("inf", ".", None),
        ("1_000", ".", None),
        ("", ".", None),
    ],
)
def test_numbers(cell, decimal, value):
    assert read_number(cell, decimal) == value


@pytest.mark.parametrize(
    ("text", "name", "unit"),
    [
        ("Kraft [N]", "Kraft", "N"),
        ("Load (kN)", "Load", "kN"),
        ("Weg in mm", "Weg", "mm"),
        ("force_N", "force", "N"),
        ("Extension, mm", "Extension", "mm"),
        ("M (gf·cm/cm)", "M", "gf·cm/cm"),
        ("Force", "Force", ""),
        ("Force max", "Force max", ""),
    ],
)
def test_headings(text, name, unit):
    found = heading(text)
    assert (found.name, found.unit) == (name, unit)


def test_units():
    assert lab_factor("force", "gf") == pytest.approx(9.80665e-3)
    assert lab_factor("moment per width", "gf.cm/cm") == pytest.approx(9.80665e-3)
    assert lab_factor("force", "KN") == 1e3
    assert lab_factor("force", "MN") is None  # milli or mega
    assert lab_factor("force", "mm") is None
    assert si_value("side", "200 mm", "length") == pytest.approx(0.2)
    assert si_value("side", "0,2 m", "length") == pytest.approx(0.2)


def test_specimens_by_column_side_by_side_and_below_each_other(tmp_path):
    column = "sample;travel [mm];force [N]\n" + "".join(
        f"{s};{k};{k * f}\n" for s, f in (("A", 1), ("B", 2)) for k in range(5)
    )
    side = "travel [mm];force [N];travel [mm];force [N]\n" + "".join(
        f"{k};{k};{k};{2 * k}\n" if k < 5 else f"{k};{k};;\n" for k in range(6)
    )
    shared = "travel [mm];force 1 [N];force 2 [N]\n" + "".join(
        f"{k};{k};{2 * k}\n" for k in range(5)
    )
    head, rows = "travel [mm];force [N]\n", "".join(f"{k};{k}\n" for k in range(5))
    more = "".join(f"{k};{2 * k}\n" for k in range(5))
    below, marked = head + rows + head + more, head + rows + "Specimen B\n" + more
    for text in (column, side, shared, below, marked):
        found = read_table(table(tmp_path, text), wanted())
        assert len(found) == 2
        for factor, specimen in zip((1.0, 2.0), found, strict=True):
            travel = specimen.columns["travel"]
            assert len(travel) >= 5
            np.testing.assert_allclose(specimen.columns["force"], factor * 1e3 * travel)
    assert [s.name for s in read_table(table(tmp_path, column), wanted())] == ["raw A", "raw B"]


def test_names_of_several_words(tmp_path):
    text = (
        "Force in warp direction [N];Strain warp mean [%];Weft strain (corr.) [%];Load, weft [N]\n"
        + "".join(f"{k};{k / 10};{k / 20};{2 * k}\n" for k in range(5))
    )
    (specimen,) = read_table(table(tmp_path, text), wanted("biaxial_tension"))
    found = {role: values[-1] for role, values in specimen.columns.items()}
    exact = {"strain_warp": 4e-3, "strain_weft": 2e-3, "force_warp": 4.0, "force_weft": 8.0}
    assert found == pytest.approx(exact)


def test_rows_without_numbers_are_left_out_and_said(tmp_path):
    text = "travel [mm];force [N]\n0;0\n1;---\n2;NaN\n3;3\n4;4\n"
    (specimen,) = read_table(table(tmp_path, text), wanted())
    np.testing.assert_allclose(specimen.columns["force"], [0.0, 3.0, 4.0])
    assert any("2 rows without all numbers" in words for words in specimen.understood)


def test_columns_and_units_that_the_user_says(tmp_path):
    path = table(tmp_path, "a;b\n0;0\n1;2\n2;4\n")
    said = wanted(columns={"travel": "a", "force": "b"}, units={"travel": "mm", "force": "kN"})
    (specimen,) = read_table(path, said)
    np.testing.assert_allclose(specimen.columns["force"], [0.0, 2e3, 4e3])
    path = table(tmp_path, "0;0\n1;2\n2;4\n")
    said = wanted(columns={"travel": 2, "force": 1}, units={"travel": "mm", "force": "N"})
    (specimen,) = read_table(path, said)
    np.testing.assert_allclose(specimen.columns["travel"], [0.0, 2e-3, 4e-3])


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "holds no line of data"),
        ("travel [mm];force\n1;2\n", "force ('force') has no unit"),
        ("travel [mm];force [N]\n", "no row of numbers"),
        ("a [mm];b [N]\n1;2\n", "no header that names travel, force or angle, force"),
        ("travel [mm];force [N]\n1,5;2.5\n2,5;3.5\n", "decimal commas (1,5) and with decimal"),
        ("travel,force\nmm,N\n0,5,1,5\n0,7,1,6\n", "export it with semicolons"),
        ("travel [mm];load [N];kraft [N]\n1;2;3\n", "force may be 'load [N]', 'kraft [N]'"),
        ("1;2\n3;4\n", "no header"),
    ],
)
def test_tables_that_cannot_be_read_in_one_way(text, words, tmp_path):
    with pytest.raises(InputError) as error:
        read_table(table(tmp_path, text), wanted())
    assert words in str(error.value)


@pytest.mark.parametrize(("mark", "other"), [(",", "."), (".", ",")])
def test_thousands_are_not_taken_for_decimals(tmp_path, mark, other):
    """998 N, then 1,002 N: the advice is followed, and the curve goes on."""
    text = f"travel [mm];force [N]\n1;500\n2;998\n3;1{mark}002\n4;1{mark}500\n"
    path = table(tmp_path, text)
    words = (
        f'say decimal = "{other}" of the test if that is 1002, decimal = "{mark}" if it is 1.002'
    )
    with pytest.raises(InputError) as error:
        read_table(path, wanted())
    assert words in str(error.value)
    (specimen,) = read_table(path, wanted(decimal=other))
    np.testing.assert_allclose(specimen.columns["force"], [500.0, 998.0, 1002.0, 1500.0])
    settled = text.replace("1;", f"0{mark}5;", 1)  # a decimal mark elsewhere leaves no doubt
    (specimen,) = read_table(table(tmp_path, settled), wanted())
    assert specimen.columns["force"][2] == 1.002
    small = text.replace("500\n2;998", "5\n2;9", 1)  # no hundreds: nothing comes near a thousand
    (specimen,) = read_table(table(tmp_path, small), wanted())
    assert specimen.columns["force"][2] == 1.002
    few = text.replace("500\n2;998", f"0{mark}998\n2;0{mark}999", 1)
    (specimen,) = read_table(table(tmp_path, few), wanted())
    assert specimen.columns["force"][2] == 1.002


def test_quoted_thousands_between_commas_are_no_doubt(tmp_path):
    path = table(tmp_path, 'travel [mm],force [N]\n1,500\n2,998\n3,"1,002"\n4,"1,500"\n')
    (specimen,) = read_table(path, wanted())
    np.testing.assert_allclose(specimen.columns["force"], [500.0, 998.0, 1002.0, 1500.0])


def test_files_that_are_no_text(tmp_path):
    path = tmp_path / "book.csv"
    path.write_bytes(b"PK\x03\x04\x00\x00\x00")
    with pytest.raises(InputError, match="export the table as CSV"):
        read_text(path)
    with pytest.raises(InputError, match="cannot be read"):
        read_text(tmp_path / "none.csv")


GOOD = """
base = "carbon_interlock"
[tests.frame]
kind = "picture_frame"
files = ["raw.csv"]
side = "200 mm"
"""


@pytest.fixture
def plan(tmp_path):
    """Write a file of tests, ``GOOD`` with a replacement, and read it."""
    table(tmp_path, "travel [mm];force [N]\n" + "".join(f"{k};{k}\n" for k in range(20)))

    def plan(old="", new=""):
        assert old in GOOD
        path = tmp_path / "tests.toml"
        path.write_text(GOOD.replace(old, new, 1) if old else GOOD + new, encoding="utf-8")
        return read_plan(path)

    return plan


def test_plan(plan):
    found = plan()
    assert found.tests[0].values == {"side": 0.2}
    assert found.fabric["name"] == "carbon_interlock"
    assert len(found.tests[0].specimens[0].columns["force"]) == 20


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('side = "200 mm"', "side = 200", "line 6: key 'tests.frame.side': side = 200 must be a"),
        ('side = "200 mm"', 'side = "200 N"', "'N' is no unit of length"),
        ('side = "200 mm"', 'side = "-1 mm"', "must be above zero"),
        ('side = "200 mm"', "", "'side' (length, such as of this picture frame) is missing"),
        ('"picture_frame"', '"frame"', "did you mean 'picture_frame'?"),
        ('["raw.csv"]', '["rew.csv"]', "'rew.csv' is not there"),
        ('["raw.csv"]', '["r*.txt"]', "'r*.txt' matches no file"),
        ('["raw.csv"]', "[]", "is empty"),
        ('base = "carbon_interlock"', "", "give base (a fabric's name or file), or the table"),
        ('base = "carbon_interlock"', 'base = "steel"', "'steel' is neither a fabric"),
        ('base = "carbon_interlock"', 'colour = "red"', "key 'colour': unknown"),
        ("", 'sample = "300 mm"', "is larger than the frame's side"),
        ("", "sidee = 1", "unknown; did you mean 'side'?"),
        ("", "weight = 0", "weight = 0 must be above zero"),
        ("", 'decimal = "x"', 'must be "." or ","'),
        ("", "columns = { travel = 1.5 }", "must be a header's text or a column's number"),
        ("", 'columns = { weg = "a" }', "'weg' is no column of this test"),
        ("", 'columns = { travel = "weg" }', "no column 'weg' for travel"),
        ("", "[laws]\nshear = \"cubic\"", "unknown shear 'cubic'"),
        ("", '[tests.b]\nkind = "bias_extension"\nfiles = ["raw.csv"]\nwidth = "100 mm"\n'
             'height = "150 mm"', "twice the width"),
        ("", '[tests.u]\nkind = "uniaxial_tension"\nfiles = ["raw.csv"]\nwidth = "50 mm"\n'
             'family = "warp"', "'gauge' is missing"),
        ("", '[tests.s]\nkind = "sled"\nfiles = ["raw.csv"]\nspeed = "1 mm/s"\n'
             'against = "tool"', "give two of"),
    ],
)  # fmt: skip
def test_plans_that_are_refused(old, new, words, plan):
    with pytest.raises(InputError) as error:
        plan(old, new)
    assert words in str(error.value)
    assert "\n" not in str(error.value)
    assert re.search(r"line \d+|raw\.csv", str(error.value))
