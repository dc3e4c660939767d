"""Workers of this machine: forked where that is safe, begun anew elsewhere and after a death."""

import json
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import psutil
import pytest
import warp as wp

from warpdrape.errors import RunFailed
from warpdrape.studies.cluster import _wait
from warpdrape.studies.forked import may_fork

pytest.importorskip("distributed")
LINUX = pytest.mark.skipif(sys.platform != "linux", reason="forks are for Linux")
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[1])}
AT_WORK = """
import json, os, sys, time
from warpdrape.studies.cluster import connected
from warpdrape.studies.forked import may_fork

def about():
    loaded = "warpdrape.results.run_record" in sys.modules
    return os.getpid(), loaded, time.process_time()

if __name__ == "__main__":
    import warpdrape.results.run_record
    if len(sys.argv) > 1:
        import threading
        threading.Thread(target=time.sleep, args=(60.0,), daemon=True).start()
    said = {"may": may_fork()}
    with connected(None, 1) as client:
        said["one"] = client.submit(about, pure=False).result()
        print(json.dumps(said), flush=True)
        os.kill(said["one"][0], 9)
        said["two"] = client.submit(about, pure=False).result()
        print(json.dumps(said), flush=True)
        time.sleep(float(os.environ.get("STAY", "0")))
    said["left"] = [p.pid for p in __import__("psutil").Process().children()]
    print(json.dumps(said), flush=True)
"""
"""A study's process: what its worker is, and what another after that is killed."""


def started(place: Path, *arguments: str, stay: float = 0.0) -> subprocess.Popen:
    script = place / "at_work.py"
    script.write_text(AT_WORK, encoding="utf-8")
    return subprocess.Popen(
        [sys.executable, str(script), *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**ENVIRONMENT, "STAY": str(stay)},
        start_new_session=True,
    )


def gone(number: int) -> bool:
    for _ in range(100):
        if not psutil.pid_exists(number):
            return True
        time.sleep(0.05)
    return False


@LINUX
def test_a_fork_has_what_its_study_has_loaded_and_so_has_the_next(tmp_path):
    process = started(tmp_path)
    said, errors = process.communicate(timeout=120)
    assert process.returncode == 0, errors
    said = json.loads(said.splitlines()[-1])
    assert said["may"] and said["left"] == []
    (first, loaded, cpu), (second, again, more) = said["one"], said["two"]
    assert loaded and again and first != second
    assert cpu < 0.4 and more < 0.4  # Python and libraries alone take 1.5 s
    assert gone(first) and gone(second)


@pytest.mark.slow
def test_beside_a_thread_a_worker_is_begun_anew(tmp_path):
    process = started(tmp_path, "thread")
    said, errors = process.communicate(timeout=120)
    assert process.returncode == 0, errors
    said = json.loads(said.splitlines()[-1])
    assert not said["may"] and said["left"] == []
    assert not said["one"][1] and not said["two"][1] and said["one"][0] != said["two"][0]


@LINUX
def test_forks_end_with_a_study_that_is_killed(tmp_path):
    process = started(tmp_path, stay=60.0)
    lines = [process.stdout.readline(), process.stdout.readline()]
    worker = json.loads(lines[1])["two"][0]
    keeper = psutil.Process(worker).ppid()
    assert keeper != process.pid and psutil.pid_exists(worker)
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does: to all of them
    time.sleep(0.3)
    assert process.wait(30) != 0 and gone(worker) and gone(keeper)


@LINUX
def test_forks_end_when_the_study_cannot_say_so(tmp_path):
    process = started(tmp_path, stay=60.0)
    process.stdout.readline()
    worker = json.loads(process.stdout.readline())["two"][0]
    keeper = psutil.Process(worker).ppid()
    process.kill()
    process.wait()
    assert gone(worker) and gone(keeper)


def test_workers_that_do_not_come_up_are_told_of():
    class Client:
        def wait_for_workers(self, count, timeout):
            raise TimeoutError("as told")

    with pytest.raises(RunFailed, match=r"not all of 3 workers .* take fewer --workers"):
        _wait(Client(), 3)


def test_no_fork_beside_threads_or_once_warp_has_begun(monkeypatch):
    monkeypatch.setattr(threading, "active_count", lambda: 1)
    wp.init()
    assert not may_fork()
    monkeypatch.setattr(wp._src.context, "runtime", None)
    assert may_fork() is (sys.platform == "linux")
    monkeypatch.setattr(threading, "active_count", lambda: 2)
    assert not may_fork()
    monkeypatch.setattr(threading, "active_count", lambda: 1)
    monkeypatch.setattr(sys, "platform", "darwin")
    assert not may_fork()
