"""A scene by several approaches, side by side: what is run, what is written, what is said."""

import argparse
import csv
import dataclasses
import json
import shutil

import numpy as np
import pytest

import warpdrape.fishnet_run
import warpdrape.simulation
from warpdrape.approaches import APPROACHES
from warpdrape.blanks.flat_mesh import FlatMesh
from warpdrape.cli import main
from warpdrape.commands.comparing import read_approaches, run_one
from warpdrape.commands.finished import what_differs
from warpdrape.commands.scene_library import find_script
from warpdrape.defects.limits import Limits
from warpdrape.defects.thresholds import DefectThresholds
from warpdrape.errors import RunFailed
from warpdrape.results.read_run import read_run
from warpdrape.results.result import FormedPly
from warpdrape.results.run_folder import as_json
from warpdrape.results.run_record import run_record
from warpdrape.results.same_scene import _OF_SCENE, scene_difference
from warpdrape.results.shear_difference import shear_difference
from warpdrape.scenes import hemisphere
from warpdrape.stops import asked_to_end

QUICK = ["hemisphere", "--set", "cells=6", "--set", "duration=0.005", "--frames", "3"]
FORCES = ("_max_force_n", "_force_n")
WAVES = ("wrinkles", "wrinkle_amplitude_m", "short_wrinkles", "short_wrinkle_amplitude_m")
BOTH = ["--approaches", "semi_discrete,fishnet"]


def compare(*argv) -> int:
    return main(["compare", *map(str, argv), "--threads", "1", "--quiet"])


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A comparison that no test changes."""
    out = tmp_path_factory.mktemp("compare") / "press"
    assert compare(*QUICK, *BOTH, "--out", out) == 0
    return out


def rows(folder):
    with (folder / "comparison.csv").open(encoding="utf-8") as file:
        return {row["approach"]: row for row in csv.DictReader(file)}


def summary(folder, approach):
    return json.loads((folder / approach / "summary.json").read_text("utf-8"))


def test_figures_are_those_of_the_runs(folder):
    table = rows(folder)
    assert list(table) == ["semi_discrete", "fishnet"]
    for approach, row in table.items():
        told = summary(folder, approach)
        (ply,) = told["plies"]
        assert told["approach"] == approach and row["ply"] == "ply_0"
        assert float(row["max_shear_deg"]) == ply["max_shear_deg"]
        assert float(row["p95_shear_deg"]) == ply["p95_shear_deg"]
        for way in ("warp", "weft", "bias"):
            assert float(row[f"draw_in_{way}_m"]) == ply["draw_in_m"][way]
        assert float(row["wall_s"]) == told["wall_s"]
    told, row = summary(folder, "semi_discrete"), table["semi_discrete"]
    assert float(row["energy_error"]) == told["energy_error"]
    for tool in told["tools"]:
        assert float(row[f"{tool['name']}_max_force_n"]) == tool["max_force_n"] > 1.0
    assert int(row["wrinkles"]) == told["plies"][0]["defects"]["wrinkles"]["number"]


def test_what_is_not_given_is_empty(folder, capsys):
    row = rows(folder)["fishnet"]
    empty = {name for name, cell in row.items() if cell == ""}
    forces = {f"{tool}{end}" for tool in ("punch", "die", "holder") for end in FORCES}
    assert empty == forces | {"energy_error", "steps", *WAVES}
    assert compare(*QUICK, *BOTH, "--out", folder) == 0
    said = capsys.readouterr().out
    (line,) = [x for x in said.split("\n\n")[1].splitlines() if x.startswith("fishnet")]
    assert line.split()[1] == "-" and line.split()[4:8] == ["-", "-", "-", "-"]
    assert "fishnet gives no forces" in said
    assert "warning: semi_discrete: not quasi-static" in said


def test_differences_are_those_of_the_triangles(folder):
    """One mesh for both, all triangles alike: plain quantiles, by numpy."""
    one, other = (read_run(folder / name).plies[0] for name in ("semi_discrete", "fishnet"))
    assert np.array_equal(one.triangles, other.triangles)
    off = np.abs(one.shear_angle_deg - other.shear_angle_deg)
    row, reference = rows(folder)["fishnet"], rows(folder)["semi_discrete"]
    # Triangles of one area, each at the middle of its share: numpy's "hazen".
    for column, share in (("off_median_shear_deg", 0.5), ("off_p95_shear_deg", 0.95)):
        # … within the single precision of places on the blank.
        assert float(row[column]) == pytest.approx(np.quantile(off, share, method="hazen"), 1e-6)
    assert float(row["off_area_share"]) == pytest.approx(1.0)
    assert row["off"] == "semi_discrete" and reference["off_median_shear_deg"] == ""


def strip(shear_deg, length, across):
    """A flat strip from x = 0 of squares cut in two; the shear angle is a function of middles."""
    x, y = np.meshgrid(np.linspace(0.0, length, across + 1), [0.0, 0.1], indexing="ij")
    points = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    k = 2 * np.arange(across)[:, None]
    triangles = np.concatenate([k + np.array(corners) for corners in ([0, 2, 3], [0, 3, 1])])
    gamma = np.radians(shear_deg(points[triangles].mean(axis=1)[:, 0]))
    ways = np.tile([1.0, 0.0, 0.0], (len(triangles), 1))
    zero = np.zeros((len(triangles), 2))
    return FormedPly("ply", points, points, triangles, ways, ways, gamma, zero, None)


def test_difference_on_another_mesh_has_its_sign_and_its_share():
    first = strip(lambda x: np.where(x < 0.5, -10.0, 30.0), 1.0, 8)
    ply = strip(lambda x: np.where(x < 0.5, 10.0, 31.0), 2.0, 20)
    off = shear_difference(ply, first)
    # Half of what lies on the other differs by 20°, half by 1°; half of the ply lies beside it.
    assert off.share == pytest.approx(0.5)
    assert off.median_deg == pytest.approx(10.5) and off.p95_deg == pytest.approx(20.0)
    away = strip(lambda x: 0.0 * x, 1.0, 4)
    away.rest_points[:, 1] += 5.0
    assert shear_difference(away, first) is None


def test_finished_runs_are_not_run_again(folder, monkeypatch, capsys):
    def again(*_, **__):
        raise AssertionError("run again")

    monkeypatch.setattr(warpdrape.simulation, "run_scene", again)
    monkeypatch.setattr(warpdrape.fishnet_run, "run_scene", again)
    before = rows(folder)
    (folder / "comparison.png").unlink()
    assert compare(*QUICK, *BOTH, "--out", folder, "--report") == 0
    assert rows(folder) == before
    assert (folder / "comparison.png").read_bytes().startswith(b"\x89PNG")
    page = (folder / "comparison.html").read_text("utf-8")
    assert "semi_discrete" in page and "fishnet" in page
    assert "comparison.html" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        (["--set", "friction=0.1"], "a run with friction = 0.2, not 0.1"),
        (["--frames", "4"], "a run with frames = 3 on cpu"),
        (["--set", "holder_force=90"], "a run with holder_force = 100.0, not 90.0"),
    ],
)
def test_another_run_is_not_replaced_unasked(folder, changed, words, capsys):
    kept = (folder / "semi_discrete" / "run.json").read_bytes()
    assert compare(*QUICK, *changed, *BOTH, "--out", folder) == 2
    complaint = capsys.readouterr().err
    assert words in complaint and "--overwrite" in complaint and complaint.count("\n") == 1
    assert (folder / "semi_discrete" / "run.json").read_bytes() == kept


@pytest.fixture
def copied(folder, tmp_path):
    """A copy of the runs that a test may change; and the call that made the net of it."""
    for name in ("semi_discrete", "fishnet"):
        shutil.copytree(folder / name, tmp_path / name)
    return tmp_path


def bent(ply):
    """A ply whose mesh is another of as many vertices."""
    mesh = ply.mesh
    vertices = np.asarray(mesh.vertices) * [1.0, 1.0001]
    return dataclasses.replace(ply, mesh=FlatMesh.from_arrays(vertices, mesh.triangles))


def blunt(tool):
    """A tool of as many facets, a little wider."""
    mesh = tool.surface.mesh.copy()
    mesh.vertices = mesh.vertices * [1.001, 1.001, 1.0]
    return dataclasses.replace(tool, surface=dataclasses.replace(tool.surface, mesh=mesh))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda scene: {}, ""),
        (lambda scene: {"limits": Limits(shear_deg=40.0)}, "a run with other limits"),
        (
            lambda scene: {"self_contact": False},
            "a run with other contact of plies with themselves",
        ),
        (
            lambda scene: {"defects": DefectThresholds(bridge_gap=3.0)},
            "a run with other thresholds of defects",
        ),
        (lambda scene: {"plies": [bent(scene.plies[0])]}, "a run with other plies"),
        (
            lambda scene: {"plies": [dataclasses.replace(scene.plies[0], warp_angle=0.1)]},
            "a run with other plies",
        ),
        (
            lambda scene: {"tools": [*scene.tools[:-1], blunt(scene.tools[-1])]},
            "a run with other tools",
        ),
    ],
)
def test_a_run_of_a_scene_that_differs_in_one_thing(folder, change, words):
    """What no parameter tells: a mesh that a script reads, limits that it states."""
    scene = find_script("hemisphere").make(["cells=6", "duration=0.005"])
    scene = dataclasses.replace(scene, **change(scene))
    assert what_differs(folder / "semi_discrete", scene, frames=3, device="cpu") == words


def changed(ply, **entries):
    """A record's ply with other entries; without those that are given as gone."""
    return {name: value for name, value in {**ply, **entries}.items() if value != "gone"}


@pytest.mark.parametrize(
    ("entries", "words"),
    [
        ({}, ""),
        (
            {"stabiliser_n_m": [3.0, 4.5]},
            "a run with a stabiliser of 3 to 4.5 N/m on ply ply_0, not ",
        ),
        ({"stabiliser_n_m": [3.0, 3.0]}, "a run with a stabiliser of 3 N/m on ply ply_0, not "),
        ({"stabiliser_n_m": "gone"}, "a run of before its stabiliser was written down, "),
        ({"stabiliser_n_m": "gone", "warp_angle_deg": 9.0}, "a run with other plies"),
    ],
)
def test_a_stabiliser_has_its_own_words(entries, words):
    """What holds pairs of triangles together is none of a ply's own, and was not always said."""
    scene = hemisphere.build(cells=6)
    record = as_json(run_record(scene, None, 1, 1), "run")
    (ply,) = record["plies"]
    found = scene_difference(record | {"plies": [changed(ply, **entries)]}, scene)
    assert found.startswith(words) and bool(found) == bool(words)
    if words.endswith("not "):
        own = dict.fromkeys(f"{each:.6g}" for each in ply["stabiliser_n_m"])
        assert found == f"{words}{' to '.join(own)} N/m"


def test_a_ply_without_a_stabiliser_is_told_from_one_with():
    yarns = hemisphere.build(cells=6, approach="yarns")
    record = as_json(run_record(hemisphere.build(cells=6), None, 1, 1), "run")
    assert scene_difference(record, yarns) == "a run with other approach"
    (ply,) = record["plies"]
    found = scene_difference(
        {**as_json(run_record(yarns, None, 1, 1), "run"), "plies": [ply]}, yarns
    )
    assert found.startswith("a run with a stabiliser of ") and found.endswith(", not none")


def test_whatever_the_record_has_of_a_scene_is_compared():
    """All but what tells of a run, and the script, which has its own words."""
    of_run = {"frames", "time_step_s", "search_every", "device", "threads", "versions"}
    of_run |= {"floating_mass_kg"}  # with what mass scaling added
    record = run_record(hemisphere.build(cells=6), None, 1, 1)
    assert set(record) - of_run - {"script", "call"} == set(_OF_SCENE)


def test_overwrite_replaces_what_differs_only(copied):
    (copied / "semi_discrete" / "summary.json").unlink()
    first = summary(copied, "fishnet")["wall_s"]
    assert compare(*QUICK, *BOTH, "--out", copied) == 2
    assert compare(*QUICK, *BOTH, "--out", copied, "--overwrite") == 0
    assert summary(copied, "fishnet")["wall_s"] == first
    assert summary(copied, "semi_discrete")["status"] == "completed"


def test_no_comparison_stays_that_is_of_other_runs(copied, monkeypatch):
    for name in ("comparison.csv", "comparison.png", "comparison.html"):
        (copied / name).write_text("of the runs before")
    assert compare(*QUICK, *BOTH, "--out", copied, "--set", "friction=0.1") == 2
    assert (copied / "comparison.html").read_text() == "of the runs before"  # refused in time
    assert compare(*QUICK, *BOTH, "--out", copied) == 0
    assert not (copied / "comparison.html").exists()  # not asked for
    assert "of the runs before" not in (copied / "comparison.csv").read_text()
    monkeypatch.setattr("warpdrape.scene.Scene.run", lambda *_, **__: 1 / 0)
    other = ["--set", "friction=0.1", "--out", copied, "--overwrite"]
    assert compare(*QUICK, *BOTH, *other) == 1
    assert not list(copied.glob("comparison.*"))


@pytest.mark.parametrize(
    ("name", "change", "words"),
    [
        ("run.json", ('"warpdrape": "', '"warpdrape": "9.'), "a run of version 9."),
        ("run.json", ('"digest": ""', '"digest": "x"'), "a run of another script"),
        ("run.json", ('"safety": 0.9', '"safety": 0.5'), "a run with safety = 0.5, not 0.9"),
        ("run.json", ('"cell_warp"', '"cell"'), "a run with other fabrics"),
        ("run.json", ('"device"', '"where"'), "run.json has no usable device: it is of"),
        ("summary.json", ('"completed"', '"failed"'), "a run that failed"),
    ],
)
def test_a_folder_that_is_not_this_run_is_told(copied, name, change, words, capsys):
    file = copied / "fishnet" / name
    text = file.read_text("utf-8")
    assert change[0] in text
    file.write_text(text.replace(*change), "utf-8")
    assert compare(*QUICK, *BOTH, "--out", copied) == 2
    assert words in capsys.readouterr().err


def raising(error):
    """A ``run_scene`` that fails."""

    def run_scene(*_, **__):
        raise error

    return run_scene


def test_a_failure_is_told_and_stops_no_other(copied, monkeypatch, capsys):
    reason = "vertex 7 ran away: lower the speed"
    monkeypatch.setattr(warpdrape.simulation, "run_scene", raising(RunFailed(reason)))
    three = ["--approaches", "fibre_frame,green_naghdi,fishnet"]
    assert compare(*QUICK, *three, "--out", copied) == 1
    said, complaint = capsys.readouterr()
    assert complaint.count(reason) == 2
    for name in ("fibre_frame", "green_naghdi"):
        assert f"{name} has no result: {reason}" in said
        row = rows(copied)[name]
        assert row["status"] == "failed" and row["message"] == reason
        assert row["max_shear_deg"] == "" == row["wall_s"] == row["warnings"]
    assert "Differences are from fishnet, the first that has a result." in said
    assert float(rows(copied)["fishnet"]["max_shear_deg"]) > 30.0


@pytest.mark.parametrize(
    ("error", "reason"),
    [
        (MemoryError(), "out of memory: take fewer cells or larger facets"),
        (ZeroDivisionError("by zero"), "unexpected ZeroDivisionError: by zero; please report it"),
        (KeyboardInterrupt(), "interrupted by the user"),
    ],
)
def test_whatever_goes_wrong_is_the_reason_of_one_approach(tmp_path, monkeypatch, error, reason):
    monkeypatch.setattr(warpdrape.simulation, "run_scene", raising(error))
    how = argparse.Namespace(quiet=True, overwrite=False)
    assert run_one(hemisphere.build(cells=6), tmp_path, how, {}) == reason


def test_nothing_is_written_where_no_approach_has_a_result(tmp_path, capsys):
    assert compare("picture_frame", "--approaches", "fishnet", "--out", tmp_path) == 1
    assert "'fishnet' needs tools to drape over" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_interrupted_it_keeps_what_there_is(copied, monkeypatch, capsys):
    monkeypatch.setattr(warpdrape.simulation, "run_scene", raising(KeyboardInterrupt()))
    three = ["--approaches", "fishnet,fibre_frame,green_naghdi"]
    assert compare(*QUICK, *three, "--out", copied) == 1
    complaint = capsys.readouterr().err
    assert "fibre_frame: interrupted by the user" in complaint
    assert "green_naghdi: not run, as fibre_frame was interrupted by the user" in complaint
    table = rows(copied)
    assert table["fishnet"]["status"] == "completed" and table["fibre_frame"]["status"] == "failed"
    assert (copied / "comparison.png").is_file()


def test_a_run_that_a_signal_ends_stops_the_rest():
    assert asked_to_end("interrupted by the user") and asked_to_end("asked to end by SIGTERM")
    assert not asked_to_end("vertex 7 ran away") and not asked_to_end("")


@pytest.mark.parametrize(
    ("argv", "words"),
    [
        (["--approaches", "fisnet"], "did you mean 'fishnet'?"),
        (["--approaches", "fishnet,fishnet"], "fishnet is given twice"),
        (["--approaches", ""], "unknown approach ''"),
        (["--set", "approach=fishnet"], "--approaches"),
        (["--set", "cell=6"], "did you mean 'cells'?"),
        (["--ply", "ply_7"], "unknown ply 'ply_7'"),
        (["--frames", "0"], "--frames 0 must be 1 or more"),
        (["--set", "cells=-1"], "cells"),
    ],
)
def test_unusable_input(tmp_path, argv, words, capsys):
    assert compare("hemisphere", "--out", tmp_path / "out", *argv) == 2
    complaint = capsys.readouterr().err
    assert words in complaint and complaint.count("\n") == 1
    assert not (tmp_path / "out").exists()


SCRIPT = """
import warpdrape as wd

def build(cells: int = 4):
    plies = [
        wd.Ply.rectangle(f"ply_{k}", "carbon_interlock", width=0.1, cells=cells, z=0.002 * k)
        for k in (1, 2)
    ]
    mould = wd.Tool.sphere(radius=0.1)
    return wd.Scene(name="two", plies=plies, tools=[mould], duration=0.01)
"""


def test_a_script_without_the_parameter(tmp_path, capsys):
    script = tmp_path / "mine.py"
    script.write_text(SCRIPT, "utf-8")
    argv = [script, "--approaches", "fishnet", "--out", tmp_path / "out"]
    assert compare(*argv, "--ply", "ply_2") == 0
    assert capsys.readouterr().out.startswith("ply_2 ")
    assert summary(tmp_path / "out", "fishnet")["approach"] == "fishnet"
    with (tmp_path / "out" / "comparison.csv").open(encoding="utf-8") as file:
        assert [row["ply"] for row in csv.DictReader(file)] == ["ply_1", "ply_2"]
    script.write_text(f"{SCRIPT}# changed\n", "utf-8")
    assert compare(*argv) == 2
    assert "of another script" in capsys.readouterr().err


def test_all_approaches_unless_some_are_named():
    assert read_approaches(None) == [name for name in APPROACHES if name != "sliding_yarns"]
    assert read_approaches("fishnet, semi_discrete") == ["fishnet", "semi_discrete"]
