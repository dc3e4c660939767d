"""Studies that run: equal to single runs, gone on with, failures kept, on workers elsewhere."""

import csv
import json
import shutil
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
from resume_checks import assert_same_folder
from study_checks import SETTINGS, write_study

from warpdrape import cli
from warpdrape.commands.scene_library import find_script
from warpdrape.errors import InputError, RunFailed
from warpdrape.results.folder_lock import FolderLock
from warpdrape.scene import Scene
from warpdrape.studies import one_run
from warpdrape.studies.folder import StudyFolder
from warpdrape.studies.one_run import do_run
from warpdrape.studies.running import Cost, _outcome, jobs_of
from warpdrape.studies.study_file import read_study


def jobs(path: Path, out: Path):
    """Jobs of a study, its folder made."""
    study, folder = read_study(path), StudyFolder(out)
    folder.take()
    folder.release()
    return jobs_of(study, folder, folder.plan(study))


@pytest.fixture(scope="module")
def address():
    """A scheduler with two workers that are threads, where nothing need be started."""
    distributed = pytest.importorskip("distributed")
    options = {"n_workers": 2, "threads_per_worker": 1, "processes": False}
    with distributed.LocalCluster(**options, dashboard_address="127.0.0.1:0") as cluster:
        yield cluster.scheduler_address


@pytest.fixture(scope="module")
def done(address, tmp_path_factory):
    """A study that is done: its file and folder, to be read only."""
    place = tmp_path_factory.mktemp("study")
    path, out = write_study(place), place / "out"
    argv = ["study", str(path), "--out", str(out), "--scheduler", address, "-q"]
    assert cli.main(argv) == 0
    return path, out


def test_runs_are_those_of_single_runs(done, tmp_path):
    _, out = done
    single = find_script("hemisphere").make(SETTINGS).run(tmp_path / "one", frames=3, threads=1)
    assert single.completed
    assert_same_folder(out / "runs" / "00001", tmp_path / "one")


def test_failed_runs_are_kept_with_their_reason(done):
    _, out = done
    ends = [json.loads((out / "outcomes" / f"0000{k}.json").read_text()) for k in range(5)]
    assert [end["status"] for end in ends] == [
        "completed",
        "completed",
        "failed",
        "refused",
        "completed",
    ]
    assert "of the energy is unbalanced" in ends[2]["message"]
    assert "travels 10 m, more than 20 times" in ends[3]["message"]
    assert (out / "runs" / "00002" / "summary.json").exists()
    with (out / "table.csv").open(encoding="utf-8", newline="") as file:
        table = list(csv.DictReader(file))
    assert [row["status"] for row in table] == [end["status"] for end in ends]
    assert [row["max_shear_deg"] != "" for row in table] == [True, True, False, False, True]
    page = (out / "report.html").read_text("utf-8")
    assert "3 completed, 1 failed, 1 refused" in page and "of the energy is unbalanced" in page


def test_started_again_only_what_is_missing_runs(done, tmp_path, address, capsys):
    path, first = done
    out = tmp_path / "out"
    shutil.copytree(first, out)
    shutil.rmtree(out / "runs" / "00001")
    (out / "outcomes" / "00001.json").unlink()
    (out / "fields" / "00001.npz").unlink()
    kept = {f: f.stat().st_mtime_ns for f in out.rglob("runs/*/summary.json")}
    assert len(kept) == 3
    argv = ["study", str(path), "--out", str(out), "--scheduler", address]
    assert cli.main(argv) == 0
    said, progress = capsys.readouterr()
    assert "4 of 5 runs have ended before, 1 to go." in progress
    assert "5 runs: 3 completed, 1 failed, 1 refused" in said
    assert all(f.stat().st_mtime_ns == when for f, when in kept.items())
    assert_same_folder(out / "runs" / "00001", first / "runs" / "00001")
    assert (out / "fields" / "00001.npz").exists()


def test_failed_runs_are_run_again_on_request(done, tmp_path, address):
    path, first = done
    out = tmp_path / "out"
    shutil.copytree(first, out)
    mark = out / "runs" / "00000" / "summary.json"
    before = mark.stat().st_mtime_ns
    (out / "outcomes" / "00002.json").write_text('{"status": "lost", "settings": []}')
    argv = ["study", str(path), "--out", str(out), "--scheduler", address, "-q", "--retry-failed"]
    assert cli.main(argv) == 0
    again = json.loads((out / "outcomes" / "00002.json").read_text())
    assert again["status"] == "failed" and "unbalanced" in again["message"]
    assert mark.stat().st_mtime_ns == before


def test_a_run_that_was_cut_off_goes_on(done, tmp_path, monkeypatch):
    """A worker that dies leaves a checkpoint: the next one goes on, to the same result."""
    path, first = done
    job = jobs(path, tmp_path / "out")[4]

    class Died(BaseException):
        pass

    from warpdrape import restart

    at_frame = restart.Keeper.at_frame

    def die(self, frame):
        at_frame(self, frame)
        if frame == 2:
            raise Died

    with monkeypatch.context() as patch:
        patch.setattr(restart.Keeper, "at_frame", die)
        patch.setattr("warpdrape.recorder.Recorder.finish", lambda *_: None)
        with pytest.raises(Died):
            do_run(job)
    assert not (tmp_path / "out" / "outcomes" / "00004.json").exists()
    asked, run = [], Scene.run
    monkeypatch.setattr(Scene, "run", lambda *a, **how: (asked.append(how), run(*a, **how))[1])
    ended = do_run(job)
    assert ended["status"] == "completed" and ended["resumed"]
    assert [how["resume"] for how in asked] == [tmp_path / "out" / "runs" / "00004"]
    assert_same_folder(tmp_path / "out" / "runs" / "00004", first / "runs" / "00004")
    monkeypatch.setattr(Scene, "run", None)
    assert do_run(job) == ended  # what has ended is not done again


def test_what_dask_takes_beside_a_run_is_not_the_run(done, tmp_path, monkeypatch):
    path, _ = done
    job = jobs(path, tmp_path / "out")[0]
    monkeypatch.setattr(one_run, "_compute", lambda *_: ("completed", "", {}))
    monkeypatch.setattr(one_run, "_cpu", iter([10.0, 17.0, 17.5]).__next__)
    monkeypatch.setattr(one_run, "_watch", iter([1.0, 3.0]).__next__)
    ended = do_run(job)
    assert (ended["cpu_s"], ended["watch_s"], ended["worker_cpu_s"]) == (5.0, 2.0, 17.5)
    cost = Cost()
    cost.add(ended)
    assert (cost.runs_s, cost.start_s) == (5.0, 10.5)


def test_a_run_whose_end_was_not_noted_is_not_run_again(done, tmp_path, monkeypatch):
    path, first = done
    job = jobs(path, tmp_path / "out")[0]
    shutil.copytree(first / "runs" / "00000", tmp_path / "out" / "runs" / "00000")
    monkeypatch.setattr(Scene, "run", None)
    assert do_run(job)["status"] == "completed"
    assert (tmp_path / "out" / "fields" / "00000.npz").exists()


def test_a_checkpoint_that_does_not_fit_is_no_end(done, tmp_path):
    path, first = done
    job = jobs(path, tmp_path / "out")[0]
    folder = tmp_path / "out" / "runs" / "00000"
    folder.mkdir(parents=True)
    (folder / "checkpoint.npz").write_bytes(b"half a checkpo")
    ended = do_run(job)
    assert ended["status"] == "completed" and not ended["resumed"]
    assert_same_folder(folder, first / "runs" / "00000")


def test_a_run_that_another_process_is_at_waits(done, tmp_path):
    path, _ = done
    job = jobs(path, tmp_path / "out")[0]
    folder = tmp_path / "out" / "runs" / "00000"
    folder.mkdir()
    lock = FolderLock(folder)
    lock.take()
    assert do_run(job)["status"] == "busy"
    lock.release()
    assert not (tmp_path / "out" / "outcomes" / "00000.json").exists()
    assert do_run(job)["status"] == "completed"


def test_a_fault_of_ours_is_the_end_of_one_run(done, tmp_path, monkeypatch):
    path, _ = done
    job = jobs(path, tmp_path / "out")[0]

    def fault(*_, **__):
        return 1 // 0

    monkeypatch.setattr(Scene, "run", fault)
    ended = do_run(job)
    assert ended["status"] == "failed"
    assert "unexpected ZeroDivisionError in test_study_runs.py, line" in ended["message"]


def test_workers_that_cannot_do_a_run_end_the_study_and_not_the_run(done, tmp_path, address):
    import dataclasses

    path, _ = done
    job = jobs(path, tmp_path / "out")[0]
    elsewhere = dataclasses.replace(job, study=str(tmp_path / "nowhere"))
    assert "does not see" in do_run(elsewhere)["message"]
    other = dataclasses.replace(job, versions={**job.versions, "warp-lang": "0.1"})
    ended = do_run(other)
    assert ended["status"] == "unfit" and "warp-lang 0.1: install the same" in ended["message"]
    assert not list((tmp_path / "out" / "outcomes").iterdir())


def test_a_study_grows_and_another_is_refused(tmp_path):
    text = (
        'scene = "hemisphere"\n[parameters.friction]\nrange = [0.1, 0.4]\n'
        '[design]\nkind = "sobol"\nruns = 8\n'
    )
    folder = StudyFolder(tmp_path / "out")
    folder.take()
    eight = folder.plan(read_study(write_study(tmp_path, text)))
    folder.plan(read_study(write_study(tmp_path, text)))  # the same again
    more = folder.plan(read_study(write_study(tmp_path, text.replace("runs = 8", "runs = 16"))))
    assert len(more) == 16 and more[:8] == eight
    text = text.replace("runs = 8", "runs = 16")
    for old, new, words in (
        ("0.4", "0.5", "other parameters or another design"),
        ("runs = 16", "runs = 16\nseed = 2", "other parameters or another design"),
        ("runs = 16", "runs = 8", "other parameters or another design"),
        ("[design]", "[set]\ncells = 4\n[design]", "another [set]"),
        ("[design]", "[run]\nframes = 4\n[design]", "another [run]"),
    ):
        with pytest.raises(InputError) as caught:
            folder.plan(read_study(write_study(tmp_path, text.replace(old, new))))
        assert words in str(caught.value) and "give another folder" in str(caught.value)


def test_one_study_at_a_time_and_no_foreign_folder(tmp_path, capsys):
    path = write_study(tmp_path)
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.txt").write_text("years")
    assert cli.main(["study", str(path), "--out", str(tmp_path / "mine")]) == 2
    assert "holds other files and no study" in capsys.readouterr().err
    folder = StudyFolder(tmp_path / "out")
    folder.take()
    assert cli.main(["study", str(path), "--out", str(tmp_path / "out")]) == 2
    assert "is being written by another study" in capsys.readouterr().err
    folder.release()


def test_options_that_make_no_sense(tmp_path, capsys, monkeypatch):
    path = str(write_study(tmp_path))
    out = ["--out", str(tmp_path / "out")]
    assert cli.main(["study", path, *out, "--workers", "2", "--scheduler", "tcp://a:1"]) == 2
    assert "not both" in capsys.readouterr().err
    assert cli.main(["study", path, *out, "--workers", "0"]) == 2
    assert "--workers 0 must be 1 or more" in capsys.readouterr().err
    monkeypatch.setattr("warpdrape.studies.cluster.CONNECT_S", 0.5)
    assert cli.main(["study", path, *out, "--scheduler", "tcp://127.0.0.1:9"]) == 2
    said = capsys.readouterr().err
    assert "no Dask scheduler answers there" in said and said.count("\n") == 1
    monkeypatch.setitem(sys.modules, "distributed", None)
    assert cli.main(["study", path, *out]) == 2
    assert "pip install 'warpdrape[studies]'" in capsys.readouterr().err


def test_a_worker_that_dies_over_a_run_and_a_scheduler_that_is_gone(tmp_path):
    """What Dask says of them becomes an end of that run, or a line; nothing has ended but it."""
    distributed = pytest.importorskip("distributed")
    from concurrent.futures import CancelledError

    job, folder = jobs(write_study(tmp_path), tmp_path / "out")[1], StudyFolder(tmp_path / "out")
    worker = SimpleNamespace(address="tcp://here:1")

    def raising(error):
        def result():
            raise error

        return SimpleNamespace(result=result)

    killed = distributed.KilledWorker("run", worker, 3)
    ended = _outcome(raising(killed), job, folder, distributed)
    assert ended["status"] == "lost" and "its worker died 4 times over it" in ended["message"]
    assert json.loads(folder.outcome(1).read_text("utf-8")) == ended
    with pytest.raises(RunFailed, match="the scheduler is gone"):
        _outcome(raising(CancelledError()), job, folder, distributed)
    with pytest.raises(InputError, match=r"cannot load warpdrape .*install the same version"):
        _outcome(raising(ImportError("no")), job, folder, distributed)


def test_the_plan_is_shown_and_nothing_run(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert cli.main(["study", str(write_study(tmp_path)), "--plan"]) == 0
    said = capsys.readouterr().out
    assert "tiny: 5 runs of hemisphere, design list" in said
    assert "run 1: duration 0.002 s, holder_force 200 N, travel 0.02 m" in said
    assert not (tmp_path / "runs").exists()


FABRIC = """
scene = "hemisphere"
[set]
cells = 4
duration = "2ms"
[run]
frames = 2
[parameters.stiff]
card = "tension.warp"
range = [40, 50]
[design]
kind = "grid"
steps = 2
"""


def test_values_of_the_card_reach_the_run(tmp_path):
    for job, warp in zip(
        jobs(write_study(tmp_path, FABRIC), tmp_path / "out"), (40e3, 50e3), strict=True
    ):
        assert do_run(job)["status"] == "completed"
        folder = tmp_path / "out" / "runs" / f"{job.number:05d}"
        record = json.loads((folder / "run.json").read_text("utf-8"))
        assert record["fabrics"]["carbon_interlock"]["tension"]["warp"] == warp
        assert (
            record["parameters"]["fabric"]
            == str(tmp_path / "out" / "cards" / folder.name) + ".toml"
        )
