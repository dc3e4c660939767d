"""Defects of a finished run measured again with other thresholds: as a run with them has them."""

import json
from dataclasses import asdict, replace

import numpy as np
import pytest

import warpdrape as wd
from warpdrape import cli
from warpdrape.command_line.command import UNFIT
from warpdrape.commands.scene_library import find_script
from warpdrape.defects.limits import read_thresholds
from warpdrape.results.run_folder import SUMMARY

SETTINGS = ["cells=12", "accuracy=draft", "holder_force=1", "travel=65mm", "duration=0.02"]
SETTINGS += ["bending=0.0005"]
OTHERS = wd.DefectThresholds(
    wrinkle_amplitude=0.2, wrinkle_steepness=0.004, bridge_gap=0.3, yarn_compression=1e-4
)
SINGLE = 1e-4
"""What single precision of the animation may change of a wrinkle, over its size [-]."""


def scene(*settings):
    return find_script("hemisphere").make([*SETTINGS, *settings])


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs") / "run"
    return folder, scene().run(folder, frames=5, threads=1, quiet=True)


@pytest.fixture(scope="module")
def with_others():
    return replace(scene(), defects=OTHERS).run(frames=5, threads=1, quiet=True)


def flat(entry, path=""):
    """All numbers of an entry by their place."""
    if isinstance(entry, dict):
        return {k: v for n, e in entry.items() for k, v in flat(e, f"{path}.{n}").items()}
    if isinstance(entry, list | tuple):
        return {k: v for n, e in enumerate(entry) for k, v in flat(e, f"{path}.{n}").items()}
    return {path: entry}


def assert_same(found, expected):
    for part in ("plies", "tools"):
        mine, theirs = flat(found[part]), flat(expected[part])
        assert mine.keys() == theirs.keys()
        for name, value in theirs.items():
            if isinstance(value, float):
                assert mine[name] == pytest.approx(value, rel=SINGLE, abs=1e-7), name
            else:
                assert mine[name] == value, name


def test_with_its_own_thresholds_a_run_has_its_own_defects(run):
    folder, result = run
    again = wd.remeasure(folder, scene(), wd.DefectThresholds())
    assert_same(again.summary, result.summary)
    wrinkles = result.summary["plies"][0]["defects"]["wrinkles"]
    assert wrinkles["too_short_for_the_mesh"]["number"] + wrinkles["number"] > 0
    for name, column in result.history.items():
        assert again.history[name] == pytest.approx(column, rel=SINGLE, abs=1e-7), name


def test_with_others_it_has_those_of_a_run_with_them(run, with_others):
    folder, result = run
    before = (folder / SUMMARY).read_bytes()
    given = replace(scene(), defects=wd.DefectThresholds(bridge_gap=9))  # which does not matter
    again = wd.remeasure(folder, given, OTHERS)
    assert (folder / SUMMARY).read_bytes() == before
    assert_same(again.summary, with_others.summary)
    assert again.summary["defect_thresholds"] == asdict(OTHERS)
    changed = [
        name
        for name, column in again.history.items()
        if not np.allclose(column, result.history[name], rtol=1e-3, atol=1e-7)
    ]
    assert set(changed) <= {"ply_0_wrinkle_m", "ply_0_short_wrinkle_m"} and changed
    for name in changed:
        assert again.history[name] == pytest.approx(with_others.history[name], rel=SINGLE)
    mine, theirs = (r.summary["tools"][0]["coverage"] for r in (again, result))
    assert mine < theirs  # within a shorter reach
    (formed,), (expected,) = again.plies, with_others.plies
    assert formed.wrinkle == pytest.approx(expected.wrinkle, rel=SINGLE, abs=1e-8)
    json.dumps(again.summary)


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        (["holder_force=2"], "a run with holder_force = 1.0, not 2.0"),
        (["cells=11"], "a run with cells = 12, not 11"),
    ],
)
def test_another_scene_is_refused(run, settings, words):
    with pytest.raises(wd.InputError, match=words):
        wd.remeasure(run[0], scene(*settings), OTHERS)


def test_another_mesh_of_the_same_parameters_is_refused(run):
    other = scene()
    punch = other.tools[0]
    mesh = punch.surface.mesh.copy()
    mesh.vertices = mesh.vertices * (1.0, 1.0, 1.001)
    tools = [replace(punch, surface=replace(punch.surface, mesh=mesh)), *other.tools[1:]]
    with pytest.raises(wd.InputError, match="another mesh of tool punch"):
        wd.remeasure(run[0], replace(other, tools=tools), OTHERS)


def test_a_run_that_failed_is_refused(run, tmp_path):
    folder = tmp_path / "failed"
    folder.mkdir()
    for file in run[0].iterdir():
        if file.is_file():
            (folder / file.name).write_bytes(file.read_bytes())
    summary = json.loads((folder / SUMMARY).read_text()) | {"status": "failed", "message": "blew"}
    (folder / SUMMARY).write_text(json.dumps(summary))
    with pytest.raises(wd.InputError, match="the run failed: blew"):
        wd.remeasure(folder, scene(), OTHERS)


def test_a_net_is_refused(tmp_path):
    net = scene("approach=fishnet")
    net.run(tmp_path / "net", quiet=True)
    with pytest.raises(wd.InputError, match="fishnet's: run the scene again"):
        wd.remeasure(tmp_path / "net", net, OTHERS)


def judge(*arguments):
    return cli.main(["judge", *map(str, arguments)])


def test_judging_with_a_table_of_thresholds_measures_again(run, with_others, tmp_path, capsys):
    folder, limits = run[0], tmp_path / "limits.toml"
    names = ("wrinkle_amplitude", "wrinkle_steepness", "bridge_gap", "yarn_compression")
    table = "\n".join(f"{name} = {getattr(OTHERS, name)}" for name in names)
    limits.write_text(f"shear_deg = 80\n[thresholds]\n{table}\n")
    picture = tmp_path / "marked.png"
    assert judge(folder, limits, "--out", picture) == cli.DONE
    said, _ = capsys.readouterr()
    assert said.startswith("Measured again, with the thresholds of the file:\nply_0: ")
    wrinkles = with_others.summary["plies"][0]["defects"]["wrinkles"]
    waves = wrinkles["too_short_for_the_mesh"]["number"]
    assert f"{waves} wave{'s' if waves > 1 else ''}, the largest" in " ".join(said.split())
    assert "Fit" in said and picture.is_file()
    limits.write_text(f"wrinkle_amplitude = 0\n[thresholds]\n{table}\n")
    assert judge(folder, limits, "--out", picture) == UNFIT
    limits.write_text("wrinkle_amplitude = 0\n[thresholds]\nwrinkle_amplitude = 100\n")
    assert judge(folder, limits, "--out", picture) == cli.DONE
    assert "no wrinkles" in capsys.readouterr()[0]


def test_what_a_table_of_thresholds_may_not_say(tmp_path):
    limits, own = tmp_path / "limits.toml", wd.DefectThresholds(bridge_gap=3.0)
    limits.write_text("shear_deg = 50\n")
    assert read_thresholds(limits, own) is None
    limits.write_text("[thresholds]\nwrinkle_amplitude = 0.25\n")
    assert read_thresholds(limits, own) == replace(own, wrinkle_amplitude=0.25)
    for text, words in (
        ("[thresholds]\nwrinkle_amplitud = 1\n", "did you mean 'wrinkle_amplitude'"),
        ("[thresholds]\nlongest_wrinkle = 2\n", "limits .*longest_wrinkle = 2 must lie above 0"),
        ("thresholds = 3\n", r"must be a table: write \[thresholds\]"),
    ):
        limits.write_text(text)
        with pytest.raises(wd.InputError, match=words):
            read_thresholds(limits, own)


def test_a_scene_without_thresholds_and_a_run_from_python_are_refused(run, tmp_path, capsys):
    folder, limits = run[0], tmp_path / "limits.toml"
    limits.write_text("shear_deg = 50\n")
    assert judge(folder, limits, "--scene", "hemisphere") == cli.UNUSABLE
    assert "give a file of limits with a table [thresholds]" in capsys.readouterr()[1]
    limits.write_text("shear_deg = 50\n[thresholds]\nbridge_gap = 2\n")
    by_hand = tmp_path / "by_hand"
    by_hand.mkdir()
    for file in folder.iterdir():
        if file.is_file() and file.suffix != ".npz":
            (by_hand / file.name).write_bytes(file.read_bytes())
    record = json.loads((by_hand / "run.json").read_text())
    (by_hand / "run.json").write_text(json.dumps(record | {"call": {}}))
    assert judge(by_hand, limits) == cli.UNUSABLE
    assert "warpdrape.remeasure(" in capsys.readouterr()[1]
