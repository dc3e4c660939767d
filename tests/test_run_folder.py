import csv
import json
import os
import tempfile
from pathlib import Path

import numpy as np
import pytest

from warpdrape.errors import InputError, RunFailed
from warpdrape.results.run_folder import RESULTS, RunFolder
from warpdrape.results.tables import HistoryWriter


def names(folder: Path) -> list[str]:
    return sorted(f.name for f in folder.iterdir())


def test_looking_leaves_no_trace_and_begin_makes_parents(tmp_path):
    folder = RunFolder(tmp_path / "a" / "b")
    assert names(tmp_path) == []
    folder.begin()
    assert folder.scene_path == tmp_path / "a" / "b" / "scene.usdc"
    assert (tmp_path / "a" / "b").is_dir()


@pytest.mark.parametrize("name", [*RESULTS, ".scene.partial.usdc", ".history.partial.csv"])
def test_results_are_refused_unless_overwritten(tmp_path, name):
    (tmp_path / name).write_text("old")
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(InputError, match="--overwrite") as caught:
        RunFolder(tmp_path)
    assert name in str(caught.value)
    folder = RunFolder(tmp_path, overwrite=True)
    assert (tmp_path / name).read_text() == "old"  # until the run begins
    with pytest.warns(UserWarning, match=r"also holds notes\.txt: left as it is"):
        folder.begin()
    assert names(tmp_path) == ["notes.txt"]


def test_going_on_removes_what_told_of_the_end(tmp_path):
    for name in ("summary.json", "report.html", "judgement.png", "stack.png"):
        (tmp_path / name).write_text("old")
    (tmp_path / "run.json").write_text('{"plies": [{"name": "ply 1"}]}')
    (tmp_path / "ply_1_wrinkle.mp4").write_text("old")
    RunFolder.of_run(tmp_path).go_on()
    assert names(tmp_path) == ["run.json"]


MADE = ("ply_0.png", "ply_0_fibre-volume.png", "stack_slip.mp4", ".ply_0.partial.png")
OWN = ("ply_0_notes.png", "ply_7.png", "ply_0.gif", "setup.png")


@pytest.mark.parametrize("record", ['{"plies": [{"name": "ply_0"}]}', "damaged"])
def test_pictures_of_the_run_before_go_with_it_and_those_of_the_user_stay(tmp_path, record):
    (tmp_path / "run.json").write_text(record)
    for name in (*MADE, *OWN):
        (tmp_path / name).write_text("old")
    with pytest.warns(UserWarning, match=r"also holds .* and \d more: left"):
        RunFolder(tmp_path, overwrite=True).begin()
    gone = MADE if record != "damaged" else ("stack_slip.mp4",)
    assert names(tmp_path) == sorted({*MADE, *OWN} - set(gone))


def test_a_picture_is_replaced_where_a_kill_came_between(tmp_path, monkeypatch):
    """The record, which names the plies, outlives what it names."""
    (tmp_path / "run.json").write_text('{"plies": [{"name": "ply_0"}]}')
    for name in ("ply_0.png", "summary.json"):
        (tmp_path / name).write_text("old")
    removed = []
    unlink = Path.unlink
    monkeypatch.setattr(Path, "unlink", lambda path: removed.append(path.name) or unlink(path))
    RunFolder(tmp_path, overwrite=True).begin()
    assert removed[0] == "ply_0.png" and set(removed[1:]) == {"summary.json", "run.json"}


def test_begin_removes_only_what_was_there_before(tmp_path):
    folder = RunFolder(tmp_path, overwrite=True)
    folder.write_json("run.json", {})
    folder.begin()
    folder.write_json("summary.json", {})
    assert names(tmp_path) == ["run.json", "summary.json"]


def test_folder_with_other_files_is_fine(tmp_path):
    (tmp_path / "ply_1.png").write_text("x")
    RunFolder(tmp_path).begin()
    assert names(tmp_path) == ["ply_1.png"]


def test_file_in_the_way(tmp_path):
    (tmp_path / "out").write_text("a file")
    for path in (tmp_path / "out", tmp_path / "out" / "run"):
        with pytest.raises(InputError, match="is a file: give another folder"):
            RunFolder(path)


def test_folder_under_the_name_of_a_result(tmp_path):
    (tmp_path / "run.json").mkdir()
    with pytest.raises(InputError, match="is a folder"):
        RunFolder(tmp_path, overwrite=True)


def test_not_writable(tmp_path, monkeypatch):
    def refuse(**_):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(tempfile, "TemporaryFile", refuse)
    with pytest.raises(InputError, match=r"not writable \(Permission denied\)"):
        RunFolder(tmp_path / "run")


def test_json_takes_numpy_and_is_whole_or_absent(tmp_path):
    folder = RunFolder(tmp_path)
    data = {
        "status": "completed",
        "quasi_static": np.bool_(True),
        "steps": np.int64(12),
        "time_step_s": np.float32(0.5),
        "wall_s": None,
        "plies": ({"name": "größe", "draw_in_m": {"x": np.float64(0.1)}},),
        "values": np.arange(3.0),
        "scene": Path("a"),
    }
    path = folder.write_json("summary.json", data)
    assert json.loads(path.read_text(encoding="utf-8")) == {
        "status": "completed",
        "quasi_static": True,
        "steps": 12,
        "time_step_s": 0.5,
        "wall_s": None,
        "plies": [{"name": "größe", "draw_in_m": {"x": 0.1}}],
        "values": [0.0, 1.0, 2.0],
        "scene": "a",
    }
    folder.write_json("summary.json", {"status": "failed"})  # replaced in one move
    for bad in (np.nan, np.float32(np.inf), np.array([0.0, np.nan])):
        with pytest.raises(ValueError, match=r"summary.json: plies\[0\]: p95_shear_deg"):
            folder.write_json("summary.json", {"plies": [{"p95_shear_deg": bad}]})
    with pytest.raises(TypeError, match=r"summary.json: a = \{1, 2\} is a set"):
        folder.write_json("summary.json", {"a": {1, 2}})
    with pytest.raises(TypeError, match="key 1 must be a string"):
        folder.write_json("summary.json", {1: 2})
    assert json.loads(path.read_text()) == {"status": "failed"}
    assert names(tmp_path) == ["summary.json"]


def test_full_disk_is_a_failed_run(tmp_path, monkeypatch):
    folder = RunFolder(tmp_path)

    def refuse(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_text", refuse)
    with pytest.raises(RunFailed, match=r"summary.json could not be written \(No space left"):
        folder.write_json("summary.json", {})


def test_history_grows_row_by_row(tmp_path):
    partial = tmp_path / ".history.partial.csv"
    with HistoryWriter(tmp_path / "history.csv") as history:
        history.append({"time_s": 0.0, "punch_force_n": np.float64(0.1)})
        assert partial.read_text() == "time_s,punch_force_n\n0.0,0.1\n"
        history.append({"punch_force_n": 1 / 3, "time_s": np.float64(1e-3)})  # any order
        assert names(tmp_path) == [partial.name]
    assert names(tmp_path) == ["history.csv"]
    with open(tmp_path / "history.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [float(r["punch_force_n"]) for r in rows] == [0.1, 1 / 3]  # no digit lost
    assert [float(r["time_s"]) for r in rows] == [0.0, 1e-3]


def test_history_refuses_other_columns_and_nan(tmp_path):
    with pytest.raises(RuntimeError), HistoryWriter(tmp_path / "history.csv") as history:
        history.append({"time_s": 0.0, "kinetic_j": 0.0})
        with pytest.raises(ValueError, match=r"history.csv: kinetic_j not in both"):
            history.append({"time_s": 1.0})
        with pytest.raises(ValueError, match=r"history.csv: extra not in both"):
            history.append({"time_s": 1.0, "kinetic_j": 0.0, "extra": 1.0})
        with pytest.raises(ValueError, match="kinetic_j = nan"):
            history.append({"time_s": 1.0, "kinetic_j": np.nan})
        raise RuntimeError("the run failed")
    assert (tmp_path / "history.csv").read_text() == "time_s,kinetic_j\n0.0,0.0\n"
    with pytest.raises(ValueError, match="closed"):
        history.append({"time_s": 1.0, "kinetic_j": 0.0})


def test_history_without_rows_leaves_no_file(tmp_path):
    with HistoryWriter(tmp_path / "history.csv"):
        pass
    assert os.listdir(tmp_path) == []
