"""``warpdrape unit_cell`` from a file to a card that is read back and run."""

import csv
import json
import math
import re
import runpy
import shlex
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from warpdrape import cli
from warpdrape.calibration.card_file import fabric_of
from warpdrape.cli import build_parser
from warpdrape.errors import InputError
from warpdrape.materials.fabric_library import load_fabric
from warpdrape.materials.laws import ShearTable, TabulatedTension
from warpdrape.materials.spline import fit_energy
from warpdrape.results.run_record import versions
from warpdrape.scenes import picture_frame
from warpdrape.unit_cell.card import areal_density, card_tables, thickness
from warpdrape.unit_cell.cell_file import ASSUMED, known_names, read_cell
from warpdrape.unit_cell.command import run_unit_cell, simulate, understood
from warpdrape.unit_cell.equilibrium import settle
from warpdrape.unit_cell.model import build_model

EXAMPLE = Path(__file__).parents[1] / "examples" / "unit_cell" / "glass_plain.toml"
COARSE = ("elements=4", "points=5", "largest_angle=20 deg")
PLAIN = (
    "spacing=5 mm",
    "width=3.5 mm",
    "height=0.5 mm",
    "linear_density=600 tex",
    "fibre_modulus=72 GPa",
    "fibre_density=2.55 g/cm³",
)


def run(*argv) -> int:
    return cli.main([str(a) for a in argv])


@pytest.fixture(scope="module")
def found():
    """The coarse cell of the example, loaded."""
    return simulate(read_cell(EXAMPLE, COARSE))


@pytest.fixture(scope="module")
def made(found, tmp_path_factory):
    """Its card, the folder beside it, and what was said."""
    out = tmp_path_factory.mktemp("card") / "glass.toml"
    lines = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("warpdrape.unit_cell.command.simulate", lambda *_: found)
        said = run_unit_cell(EXAMPLE, out, COARSE, say=lines.append)
    return out, out.with_name("glass_unit_cell"), said, lines


def test_the_card_says_that_its_laws_are_simulated(made):
    fabric = load_fabric(made[0])
    assert isinstance(fabric.tension, TabulatedTension) and isinstance(fabric.shear, ShearTable)
    for name in ("tension.tension_warp", "tension.tension_weft", "shear.couples", "thickness"):
        assert fabric.sources[name].status == "simulated"
        assert "unit cell of a plain weave" in fabric.sources[name].text
        assert "scipy" in fabric.sources[name].text
    assert fabric.sources["cell_warp"].status == "assumed"  # as the example says
    assert "held at 2 and 2 N" in fabric.sources["shear.couples"].doubt
    assert "beyond which it is extrapolated" in fabric.sources["tension.tension_warp"].doubt
    assert "Simulated, not measured" in fabric.doubts[0]
    assert fabric.cell_warp == pytest.approx(1.0 / 193.0, rel=1e-4)
    assert fabric.cell_weft == pytest.approx(1.0 / 191.0, rel=1e-4)
    assert fabric.locking_angle is None  # the curve ends before


def test_the_cards_tables_are_the_cells(made):
    fabric = load_fabric(made[0])
    plan = read_cell(EXAMPLE, COARSE)
    model = build_model(plan.cell, plan.elements)
    law = fabric.tension
    for i, j in ((-1, -1), (-1, 4), (5, -2)):
        rest = settle(model, np.array([law.strain_warp[i], law.strain_weft[j], 0.0]))
        table = law.tension_warp[i, j], law.tension_weft[i, j]
        np.testing.assert_allclose(rest.tension, table, rtol=2e-3, atol=1e-3)
    assert law.tension_warp.max() > 100.0
    at = int(np.argmin(np.abs(law.strain_warp))), int(np.argmin(np.abs(law.strain_weft)))
    assert law.tension_warp[at] == pytest.approx(0.0, abs=1e-6)
    assert fit_energy(law, fabric.yarn_width).misfit < 0.02
    strain = (0.004, 0.004, math.radians(20.0))
    rest = settle(model, np.array(strain), tension=(2.0, 2.0))
    couple = fabric.shear.couple(math.radians(20.0))
    assert couple == pytest.approx(rest.couple + rest.friction, rel=1e-3)


def test_a_couple_that_falls_is_kept_level_and_the_card_says_so(found):
    curve = found.curve
    middle = len(curve.angles) // 2
    elastic = curve.elastic.copy()
    elastic[middle] = -curve.friction[middle] + 0.5 * curve.couples[middle - 1]
    for given, said in ((curve, False), (replace(curve, elastic=elastic), True)):
        tables = card_tables(found.plan, found.table, given, versions())["shear"]["couples"]
        couples = np.array(tables["value"])
        assert (np.diff(couples) >= 0.0).all() and couples[0] == 0.0
        assert ("the simulated couple falls" in tables["doubt"]) == said
    assert couples[middle] == pytest.approx(1e3 * curve.couples[middle - 1], rel=1e-3)
    by = 100 * 0.5 * curve.couples[middle - 1] / curve.couples.max()
    assert f"by {by:.2g} % of its largest" in tables["doubt"]


def test_what_lies_beside_the_card(made):
    _, folder, said, lines = made
    record = json.loads((folder / "unit_cell.json").read_text("utf-8"))
    assert record["given"]["elements"] == 4 and record["given"]["width"] == "4.2 mm"
    assert set(record["versions"]) >= {"warpdrape", "numpy", "scipy"}
    assert record["cell"]["spacing"] == pytest.approx([1 / 191, 1 / 193])
    assert record["assumed"] == [] and record["shear_end"] == "as asked for"
    with (folder / "shear.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert float(rows[-1]["angle_deg"]) == pytest.approx(20.0)
    parts = [float(rows[-1][n]) for n in ("elastic_nm", "friction_nm", "couple_nm")]
    assert parts[0] + parts[1] == pytest.approx(parts[2], rel=1e-6) and min(parts) > 0.0
    with (folder / "tension.csv").open(encoding="utf-8") as file:
        assert len(list(csv.DictReader(file))) == load_fabric(made[0]).tension.tension_warp.size
    for name in ("cell.png", "curves.png"):
        assert (folder / name).stat().st_size > 20_000
    assert "shear couple at 20°" in said and "Card in" in said
    assert "plain weave, 2 yarns in a repeat" in lines[0]


def test_a_coupon_runs_with_the_card(made, tmp_path):
    scene = picture_frame.build(fabric=str(made[0]), edge=0.05, shear_angle_deg=18.0, duration=0.05)
    result = scene.run(tmp_path / "frame", frames=12)
    assert result.completed
    summary = json.loads((tmp_path / "frame" / "summary.json").read_text("utf-8"))
    assert summary["coupon"]["shear_angle_deg"] == pytest.approx(18.0, abs=1e-6)
    assert summary["coupon"]["force_n"] == pytest.approx(
        summary["coupon"]["closed_form_force_n"], rel=0.1
    )


def test_mass_and_thickness_of_the_ply():
    plan = read_cell("plain", PLAIN)
    crimp = plan.cell.crimps[0]
    assert areal_density(plan) == pytest.approx(2 * 600e-6 * (1.0 + crimp) / 5e-3)
    assert thickness(plan) == pytest.approx(1e-3)
    assert plan.cell.stiffness[0] == pytest.approx(72e9 * 600e-6 / 2550.0)
    assert plan.fibre_share[0] == pytest.approx(600e-6 / 2550.0 / (2 / 3 * 3.5e-3 * 0.5e-3))


def test_what_is_assumed_is_said():
    plan = read_cell("plain", PLAIN)
    assert set(plan.assumed) == set(ASSUMED)
    assert "assumed, since not given: bending" in understood(plan)
    given = read_cell("plain", (*PLAIN, "bending_warp=1 N·mm²", "bending_weft=2 N·mm²"))
    assert given.cell.bending == (1e-6, 2e-6) and "bending" not in given.assumed
    both = read_cell("plain", (*PLAIN, "width_weft=3 mm", "friction=0.3"))
    assert both.cell.width == (3.5e-3, 3e-3) and both.cell.friction == 0.3


def test_twills_and_satins_from_the_command_line():
    twill = read_cell("twill", (*PLAIN, "over=3", "under=1"))
    assert twill.cell.weave.name == "twill 3/1" and twill.name == "twill_weave"
    satin = read_cell("satin", (*PLAIN, "harness=8", "move=3"))
    assert satin.cell.weave.repeat == 8
    text = understood(satin)
    assert text.count("■") == 8 and text.count("·\n") >= 7


@pytest.mark.parametrize(
    ("settings", "words", "mended"),
    [
        (("width=3.5",), "number with its unit", ("width=3.5 mm",)),
        (("width=3.5 kg",), "no unit of length", ("width=3.5 mm",)),
        (("widht=3.5 mm",), "did you mean 'width'", ("width=3.5 mm",)),
        (("width",), "must be NAME=VALUE", ("width=3.5 mm",)),
        (("width=-3 mm",), "must be above zero", ("width=3 mm",)),
        (("width=6 mm",), "must be below spacing_warp = 5 mm", ("width=4 mm",)),
        (("yarns=2 1/cm",), "give either 'spacing_warp' or 'yarns_warp'", ()),
        (("over=2",), "says nothing of a plain weave", ("weave=twill", "over=2")),
        (("weave=twil",), "did you mean 'twill'", ("weave=twill",)),
        (("elements=7",), "must be even", ("elements=6",)),
        (("elements=many",), "whole number", ("elements=6",)),
        (("status=guessed",), "must be one of measured, simulated", ("status=assumed",)),
        (("linear_density=3000 tex",), "fibres fill", ("linear_density=1000 tex",)),
        (("crimp=9 %",), "correct one, or leave one crimp out", ("crimp_warp=0.5 %",)),
        (("compaction_exponent=0.5",), "1.5 … 30", ("compaction_exponent=5",)),
        (("largest_angle=5 deg",), "10 … 80°", ("largest_angle=10 deg",)),
        (("section=disc",), "known: ellipse, lens", ("section=ellipse",)),
        (("fibre_modulus=0 GPa",), "stiffness_warp", ("fibre_modulus=70 GPa",)),
    ],
)
def test_input_that_cannot_be_used_says_what_to_do(settings, words, mended):
    with pytest.raises(InputError) as error:
        read_cell("plain", (*PLAIN, *settings))
    assert words in str(error.value), error.value
    assert "\n" not in str(error.value) and ", line 1" not in str(error.value)
    assert read_cell("plain", (*PLAIN, *mended))


@pytest.mark.parametrize("name", ["spacing", "width", "linear_density", "fibre_density"])
def test_what_is_missing_is_named(name):
    left = [each for each in PLAIN if not each.startswith(name)]
    with pytest.raises(InputError, match=f"plain: .*{name}"):
        read_cell("plain", left)
    with pytest.raises(InputError, match="'fibre_modulus', or 'stiffness_warp'"):
        read_cell("plain", [each for each in PLAIN if "modulus" not in each])


def test_a_fault_in_a_file_is_told_with_its_line(tmp_path):
    path = tmp_path / "cell.toml"
    text = EXAMPLE.read_text("utf-8")
    path.write_text(text.replace('width = "4.2 mm"', 'width = "4.2"'), encoding="utf-8")
    line = next(n for n, t in enumerate(text.splitlines(), 1) if t.startswith("width"))
    with pytest.raises(InputError, match=rf"cell\.toml, line {line}: key 'width'"):
        read_cell(path)
    path.write_text(text.replace('width = "4.2 mm"', 'width = "9 mm"'), encoding="utf-8")
    with pytest.raises(InputError, match=rf"cell\.toml, line {line}: key 'width': width_warp"):
        read_cell(path)
    with pytest.raises(InputError, match=r"^--set: key 'width'"):
        read_cell(EXAMPLE, ("width=9 mm",))
    with pytest.raises(InputError, match="cannot be read"):
        read_cell(tmp_path / "none.toml")
    with pytest.raises(InputError, match=r"must be plain, twill, satin or a \.toml file"):
        read_cell("basket")


def test_names_of_the_example_are_all_known():
    plan = read_cell(EXAMPLE)
    assert set(plan.given) <= set(known_names())
    assert plan.assumed == ()


def test_the_command_refuses_before_it_computes(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(
        "warpdrape.unit_cell.command.simulate", lambda *_: pytest.fail("it computed")
    )
    taken = tmp_path / "there.toml"
    taken.write_text("mine", encoding="utf-8")
    for argv, words in (
        ((), "give --out FABRIC.toml"),
        (("--out", tmp_path / "x.txt"), "must end in .toml"),
        (("--out", tmp_path / "no" / "x.toml"), "in a folder that exists"),
        (("--out", taken), "give --overwrite"),
    ):
        assert run("unit_cell", EXAMPLE, *argv) == 2
        error = capsys.readouterr().err
        assert words in error and error.count("\n") == 1
    assert taken.read_text("utf-8") == "mine"
    assert run("unit_cell", EXAMPLE, "--dry") == 0
    assert "crimp 0.865 %" in capsys.readouterr().out
    assert run("unit_cell", EXAMPLE, "--dry", "--set", "width_warp=3.9 mm") == 0
    assert "warp yarns: 3.9 × 0.6 mm" in capsys.readouterr().out


def test_a_cell_without_rest_fails_the_command_and_leaves_no_card(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("warpdrape.unit_cell.equilibrium.ITERATIONS", 1)
    out = tmp_path / "x.toml"
    sets = [word for each in COARSE for word in ("--set", each)]
    assert run("unit_cell", EXAMPLE, "--out", out, *sets, "-q") == 1
    error = capsys.readouterr().err
    assert "finds no rest" in error and error.count("\n") == 1
    assert not out.exists() and not (tmp_path / "x_unit_cell").exists()


def test_the_command_prints_a_card(found, tmp_path, capsys, monkeypatch):
    assert fabric_of(found.text, "x").name == "glass_plain"
    monkeypatch.setattr("warpdrape.unit_cell.command.simulate", lambda *_: found)
    out = tmp_path / "card.toml"
    assert run("unit_cell", EXAMPLE, "--out", out) == 0
    said = capsys.readouterr()
    assert f"warpdrape fabrics {out}" in said.out and "2 yarns in a repeat" in said.err
    assert load_fabric(out).description.startswith("Plain weave of glass/PP yarns")
    assert run("unit_cell", EXAMPLE, "--out", out, "--overwrite", "--quiet") == 0
    said = capsys.readouterr()
    assert said.out == "" and said.err == ""


PAGE = Path(__file__).parents[1] / "docs" / "unit_cell.md"
COMPARISON = runpy.run_path(str(EXAMPLE.with_name("compare_benchmark.py")), run_name="read")


def test_commands_of_the_page_are_understood(monkeypatch):
    monkeypatch.chdir(EXAMPLE.parents[2])
    lines = [line for line in PAGE.read_text("utf-8").splitlines() if line.startswith("warpdrape ")]
    assert len(lines) >= 3
    for line in lines:
        arguments = build_parser().parse_args(shlex.split(line, comments=True)[1:])
        assert read_cell(arguments.weave, arguments.settings)
    names = {
        n
        for row in re.findall(r"^\| (`.*?) \|", PAGE.read_text("utf-8"), re.M)
        for n in re.findall(r"`(\w+)`", row)
    }
    plain_names = {n for n in known_names() if not n.endswith(("_warp", "_weft"))}
    assert plain_names - names <= {"over", "under", "harness", "move"}
    assert names <= plain_names


def rows_of_the_page():
    text = PAGE.read_text("utf-8").partition("C_s [N·mm per cell] at")[2].partition("\n\n")[0]
    rows = [line.strip("|").split("|") for line in text.splitlines()[2:]]
    return np.array([[float(cell.strip(" °")) for cell in row] for row in rows])


def test_published_couples_are_those_of_the_page():
    page, area = rows_of_the_page(), 1.0 / (191.0 * 193.0)
    assert page.shape == (5, 6)
    rows = np.array(COMPARISON["table"]({}, area))
    np.testing.assert_allclose(rows[:, 1:], page[:, 1:3], atol=0.0051)
    for (width, height), (angle, couple) in COMPARISON["published"]().items():
        half = np.interp(angle / 2, np.append(0, angle), np.append(0, couple))
        force = ((2 * height - 3 * width) * couple + width * half) / (
            (height / width - 1) * (np.cos(angle / 2) - np.sin(angle / 2))
        )
        assert force[-1] == pytest.approx(8.777 if width < 0.12 else 11.649, rel=1e-9)
        assert (1.0 + (0.040155 if width < 0.12 else 0.092734) / (height - width)) ** 2 - 1.0 == (
            pytest.approx(math.sin(angle[-1]), rel=1e-9)
        )


def test_the_example_is_near_the_published_curve():
    """Coarse, at 20°: between both tests and half as much again, as on the page."""
    curves = COMPARISON["simulated"]((2.0,), COARSE)
    page = rows_of_the_page()
    couple = 1e3 * curves[2.0].couples[-1]
    assert couple == pytest.approx(page[2, 4], rel=0.03)
    assert page[2, 1:3].min() < couple < 1.5 * page[2, 1:3].max()


@pytest.mark.slow
def test_the_table_of_the_page_is_what_the_example_gives():
    curves = COMPARISON["simulated"]()
    rows = np.array(COMPARISON["table"](curves, 1.0 / (191.0 * 193.0)))
    np.testing.assert_allclose(rows, rows_of_the_page(), atol=0.0051)
