"""Studies whose workers are processes: killed, cut off and gone on with, equal to single runs."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from resume_checks import assert_same_folder, timeless
from study_checks import SETTINGS, TINY, hears_ctrl_c, write_study

from warpdrape.commands.scene_library import find_script
from warpdrape.studies.cluster import KEEPER_LOST
from warpdrape.studies.folder import StudyFolder
from warpdrape.studies.running import run_study
from warpdrape.studies.study_file import read_study

ROOT = Path(__file__).parents[1]
LOCAL = [sys.executable, "-m", "warpdrape", "study"]
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT)}
LONGER = TINY.replace("2ms", "20ms").replace("frames = 3", "frames = 40\ncheckpoint = 1")


def assert_equal_to_single_runs(out: Path, place: Path):
    for number, force in ((0, 50.0), (1, 200.0)):
        settings = [s.replace("duration=0.002", "duration=0.02") for s in SETTINGS]
        settings = [s.replace("force=200.0", f"force={force}") for s in settings]
        single = place / f"single {number}"
        find_script("hemisphere").make(settings).run(single, frames=40, threads=1, checkpoint=1)
        assert_same_folder(out / "runs" / f"{number:05d}", single)


@pytest.mark.slow
@pytest.mark.parametrize("who", ["worker", "keeper", "both", "all keepers"])
def test_a_worker_that_is_killed_loses_nothing(tmp_path, who):
    """Nor one whose keeper dies: another is begun in its place."""
    import psutil

    path, out = write_study(tmp_path, LONGER), tmp_path / "out"
    argv = [*LOCAL, str(path), "--out", str(out), "--workers", "2"]
    process = subprocess.Popen(
        argv, cwd=tmp_path, stderr=subprocess.PIPE, text=True, env=ENVIRONMENT
    )
    worker = _at_work(out / "runs" / "00000", psutil.Process(process.pid))
    keeper, all_of = psutil.Process(worker).ppid(), psutil.Process(process.pid).children()
    killed = {"worker": [worker], "keeper": [keeper], "both": [keeper, worker]}
    for number in killed.get(who, [each.pid for each in all_of]):
        os.kill(number, signal.SIGKILL)
    said = process.communicate()[1]
    assert process.returncode == 0
    dead = {"worker": 0, "all keepers": 2}.get(who, 1) if sys.platform == "linux" else 0
    assert said.count(KEEPER_LOST) == dead
    ended = json.loads((out / "outcomes" / "00000.json").read_text())
    assert ended["status"] == "completed" and ended["process"] != worker and ended["resumed"]
    assert_equal_to_single_runs(out, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("how", "kill"),
    [
        (signal.SIGKILL, os.kill),
        (signal.SIGINT, os.kill),
        (signal.SIGINT, os.killpg),
        (signal.SIGTERM, os.kill),
        (signal.SIGTERM, os.killpg),
    ],
)
def test_a_study_that_is_killed_goes_on(how, kill, tmp_path):
    """Its workers end with it; a Ctrl-C, which reaches them too, reports what there is."""
    import psutil

    path, out = write_study(tmp_path, LONGER), tmp_path / "out"
    argv = [*LOCAL, str(path), "--out", str(out), "--workers", "2"]
    process = subprocess.Popen(
        argv,
        cwd=tmp_path,
        stderr=subprocess.PIPE,
        text=True,
        env=ENVIRONMENT,
        start_new_session=True,
        preexec_fn=hears_ctrl_c if os.name == "posix" else None,
    )
    worker = _at_work(out / "runs" / "00000", psutil.Process(process.pid))
    kill(process.pid, how)
    said = process.communicate()[1]
    assert process.returncode == (-how if how == signal.SIGKILL else 1)
    if how != signal.SIGKILL:
        words = {signal.SIGINT: "interrupted: ", signal.SIGTERM: "asked to end by SIGTERM: "}[how]
        assert words in said and "start it again and it goes on" in said
        assert (out / "report.html").exists() and "Traceback" not in said
    for _ in range(50):
        if not psutil.pid_exists(worker):
            break
        time.sleep(0.1)
    assert not psutil.pid_exists(worker)
    cut_off = not (out / "outcomes" / "00000.json").exists()
    assert cut_off or how != signal.SIGKILL  # runs have some seconds to end by themselves
    subprocess.run(argv, cwd=tmp_path, check=True, capture_output=True, env=ENVIRONMENT)
    ended = json.loads((out / "outcomes" / "00000.json").read_text())
    assert ended["status"] == "completed" and ended["resumed"] is cut_off
    assert_equal_to_single_runs(out, tmp_path)


def _at_work(folder: Path, study) -> int:
    """The worker process that has a run's folder open, once it has kept a checkpoint."""
    for _ in range(3000):
        time.sleep(0.02)
        if not (folder / "checkpoint.npz").exists():
            continue
        for process in study.children(recursive=True):
            if any(str(folder) in file.path for file in process.open_files()):
                return process.pid
    raise AssertionError("no worker came to it")


def _wait_for(path: Path) -> dict:
    for _ in range(3000):
        if path.exists():
            return json.loads(path.read_text())
        time.sleep(0.1)
    raise AssertionError(f"{path.name} did not come")


@pytest.mark.slow
def test_a_scheduler_and_workers_of_other_processes(tmp_path):
    """As on a cluster: Dask's own commands start them, the study knows an address."""
    path, place = write_study(tmp_path), str(tmp_path / "scheduler.json")
    dask = [sys.executable, "-m", "distributed.cli.dask_scheduler"]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "cwd": tmp_path}
    quiet["env"] = ENVIRONMENT
    scheduler = subprocess.Popen(
        [*dask, "--port", "0", "--no-dashboard", "--scheduler-file", place], **quiet
    )
    worker = subprocess.Popen(
        [
            sys.executable,
            "-m",
            "distributed.cli.dask_worker",
            "--scheduler-file",
            place,
            "--nworkers",
            "2",
            "--nthreads",
            "1",
            "--no-dashboard",
        ],
        **quiet,
    )
    try:
        address = _wait_for(Path(place))["address"]
        argv = [*LOCAL, str(path), "--out", str(tmp_path / "out"), "--scheduler", address]
        done = subprocess.run(
            argv, cwd=tmp_path, capture_output=True, text=True, check=True, env=ENVIRONMENT
        )
    finally:
        worker.terminate()
        scheduler.terminate()
    assert "3 completed, 1 failed, 1 refused" in done.stdout
    ends = [json.loads(f.read_text()) for f in (tmp_path / "out" / "outcomes").iterdir()]
    assert os.getpid() not in {end["process"] for end in ends}
    single = find_script("hemisphere").make(SETTINGS)
    single.run(tmp_path / "one", frames=3, threads=1)
    assert_same_folder(tmp_path / "out" / "runs" / "00001", tmp_path / "one")


@pytest.mark.slow
def test_sixty_four_runs_on_two_workers_to_the_bit(tmp_path):
    text = (
        'scene = "hemisphere"\n[set]\ncells = 4\nduration = "4ms"\n[run]\nframes = 2\n'
        "[parameters.friction]\nrange = [0.1, 0.4]\n[parameters.angle_deg]\nrange = [0, 45]\n"
        '[design]\nkind = "sobol"\nruns = 64\n'
    )
    path = write_study(tmp_path, text)
    study = read_study(path)
    folder = StudyFolder(tmp_path / "out")
    folder.take()
    rows = folder.plan(study)
    _, ends, cost = run_study(study, folder, rows=rows, workers=2, quiet=True)
    assert len(ends) == 64 and {end["status"] for end in ends.values()} == {"completed"}
    assert len(cost.workers) == 2
    for number in (0, 31, 62, 63):
        scene = study.script.make(study.settings(rows[number]))
        single = scene.run(None, frames=2, threads=1).summary
        mine = json.loads((folder.run(number) / "summary.json").read_text("utf-8"))
        assert timeless(mine) == json.loads(json.dumps(timeless(single)))
