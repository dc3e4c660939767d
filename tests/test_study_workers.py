"""Workers of this machine: forked where that is safe, begun anew elsewhere and after a death."""

import asyncio
import json
import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from types import SimpleNamespace

import psutil
import pytest
import warp as wp
from study_checks import hears_ctrl_c

from warpdrape.errors import RunFailed
from warpdrape.studies import cluster, forked
from warpdrape.studies.cluster import KEEPER_LOST, _wait
from warpdrape.studies.command import cost_text
from warpdrape.studies.ending import ends_as_interrupted
from warpdrape.studies.forked import Keepers, may_fork
from warpdrape.studies.running import Cost

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
    import psutil
    import warpdrape.results.run_record
    import warpdrape.studies.cluster as made_here
    if "thread" in sys.argv:
        import threading
        threading.Thread(target=time.sleep, args=(60.0,), daemon=True).start()
    if "early" in sys.argv:
        make = made_here._cluster
        def late(*arguments):
            for keeper in psutil.Process().children():
                keeper.kill()
            time.sleep(0.2)
            return make(*arguments)
        made_here._cluster = late
    said = {"may": may_fork(), "lines": []}
    with connected(None, 1, said["lines"].append) as client:
        said["one"] = client.submit(about, pure=False).result()
        print(json.dumps(said), flush=True)
        worker = psutil.Process(said["one"][0])
        time.sleep(1.0)  # one killed before its keeper has heard that it is up takes that along
        for process in [worker.parent(), worker] if "keeper" in sys.argv else [worker]:
            process.kill()
        said["two"] = client.submit(about, pure=False).result()
        print(json.dumps(said), flush=True)
        time.sleep(float(os.environ.get("STAY", "0")))
    left = [p for p in psutil.Process().children() if "resource_tracker" not in str(p.cmdline())]
    said["left"] = [p.pid for p in left]
    print(json.dumps(said), flush=True)
"""
"""A study's process: what its worker is, and what another after that is killed; with ``keeper``
its keeper too, with ``early`` the keeper before there is a scheduler, with ``thread`` no fork."""


def started(place: Path, *arguments: str, stay: float = 0.0) -> subprocess.Popen:
    script = place / "at_work.py"
    script.write_text(AT_WORK, encoding="utf-8")
    return subprocess.Popen(
        [sys.executable, str(script), *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**ENVIRONMENT, "STAY": str(stay), "TMPDIR": str(place)},
        start_new_session=True,
        preexec_fn=hears_ctrl_c if os.name == "posix" else None,
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


@LINUX
@pytest.mark.parametrize("how", ["keeper", pytest.param("early", marks=pytest.mark.slow)])
def test_what_a_keeper_that_dies_had_another_worker_does(tmp_path, how):
    """It is begun anew, as no fork is safe any more; nothing waits for ever, and it is said."""
    process = started(tmp_path, how)
    said, errors = process.communicate(timeout=120)
    assert process.returncode == 0, errors
    said = json.loads(said.splitlines()[-1])
    assert said["may"] and said["left"] == [] and said["lines"] == [KEEPER_LOST]
    (first, forked, _), (second, again, _) = said["one"], said["two"]
    assert forked is (how == "keeper") and not again and first != second
    assert gone(first) and gone(second)


def test_a_keeper_that_is_gone_is_told_nothing():
    ear, line = multiprocessing.Pipe(duplex=False)
    other, still = multiprocessing.Pipe(duplex=False)
    ear.close()
    Keepers([line, still]).tell("tcp://address")  # a broken pipe to the first
    assert other.recv() == "tcp://address"


def loop_of_a_thread():
    loop = asyncio.new_event_loop()
    threading.Thread(target=loop.run_forever, daemon=True).start()
    return loop


@pytest.mark.parametrize("workers", [{}, {"tcp://one": "is there"}])
def test_a_study_that_has_lost_all_workers_does_not_wait_for_ever(monkeypatch, workers):
    monkeypatch.setattr(cluster, "LOOK_S", 0.01)
    monkeypatch.setattr(cluster, "WORKERS_S", 0.05)
    closed, loop = threading.Event(), loop_of_a_thread()

    async def close():
        closed.set()

    scheduler = SimpleNamespace(workers=workers, close=close)
    made = SimpleNamespace(scheduler=scheduler, loop=SimpleNamespace(asyncio_loop=loop))
    words = "the scheduler is gone" if workers else "all workers have died.*take fewer --workers"
    with pytest.raises(RunFailed, match=words), cluster._attended(made):
        assert closed.wait(0.5 if workers else 10.0) is not bool(workers)
        time.sleep(0.1)
        raise RunFailed("the scheduler is gone")  # as its client sees it
    closed.clear()
    with cluster._attended(made):
        pass
    assert not closed.wait(0.2)  # it looks no more
    loop.call_soon_threadsafe(loop.stop)


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
    assert not list(tmp_path.glob("warpdrape-study-*"))  # the keeper has tidied up


def test_workers_that_do_not_come_up_are_told_of():
    class Client:
        def wait_for_workers(self, count, timeout):
            raise TimeoutError("as told")

    with pytest.raises(RunFailed, match=r"not all of 3 workers .* take fewer --workers"):
        _wait(Client(), 3)


def test_what_a_study_took_is_said_in_tenths_where_it_is_short():
    cost = Cost(runs_s=86.0, own_start_s=0.25, own_s=0.75, children_s=88.0)
    cost.workers, cost.starts = {("h", 1): 86.03}, {("h", 1): 0.03}
    words = cost_text(cost, 1.25)  # what keeps workers counts: 88 s less runs and their start
    assert "0.3 s (0.3 %) to start, 2.5 s (2.9 %) for order" in words
    cost.children_s = 0.0  # where others made the workers
    assert "0.5 s (0.6 %) for order" in cost_text(cost, 1.25)


@LINUX
def test_no_fork_beside_threads_or_once_warp_has_begun(monkeypatch):
    """Whatever Warp keeps in itself: its library is loaded, or not."""
    monkeypatch.setattr(threading, "active_count", lambda: 1)
    wp.init()
    assert not may_fork()
    words = "from warpdrape.studies.forked import may_fork as may; import warp; print(may()); "
    words += "warp.init(); print(may())"
    done = subprocess.run(
        [sys.executable, "-c", words], env=ENVIRONMENT, capture_output=True, text=True, check=True
    )
    assert [line for line in done.stdout.split() if line in ("True", "False")] == ["True", "False"]


def test_where_it_is_not_known_what_is_loaded_workers_are_begun_anew(monkeypatch, tmp_path):
    monkeypatch.setattr(threading, "active_count", lambda: 1)
    monkeypatch.setattr(sys, "platform", "linux")
    mapped = tmp_path / "maps"
    monkeypatch.setattr(forked, "MAPPED", mapped)
    assert not may_fork()  # there is no such file
    mapped.write_text("7f00-7f10 r-xp 0000 08:01 42 /usr/lib/libc.so.6\n", encoding="utf-8")
    assert may_fork()
    own = os.path.realpath(os.path.dirname(wp.__file__))
    mapped.write_text(f"7f00-7f10 r-xp 0000 08:01 42 {own}/bin/warp.so\n", encoding="utf-8")
    assert not may_fork()
    mapped.write_text("7f00-7f10 r-xp 0 08:01 42 /usr/lib/libcuda.so.595.1\n", encoding="utf-8")
    assert not may_fork()
    mapped.write_text("7f00-7f10 r-xp 0000 08:01 42 /usr/lib/libc.so.6\n", encoding="utf-8")
    monkeypatch.setattr(threading, "active_count", lambda: 2)
    assert not may_fork()
    monkeypatch.setattr(threading, "active_count", lambda: 1)
    monkeypatch.setattr(sys, "platform", "darwin")
    assert not may_fork()


@pytest.mark.parametrize("name", ["SIGTERM", "SIGHUP"])
def test_a_signal_to_end_interrupts_with_its_reason(name):
    number = getattr(signal, name, None)
    if number is None:
        pytest.skip("no such signal here")
    with pytest.raises(KeyboardInterrupt, match=f"asked to end by {name}"), ends_as_interrupted():
        signal.raise_signal(number)
    assert signal.getsignal(number) is signal.SIG_DFL
    signal.signal(number, signal.SIG_IGN)  # as nohup does
    try:
        with ends_as_interrupted():
            signal.raise_signal(number)
        assert signal.getsignal(number) is signal.SIG_IGN
    finally:
        signal.signal(number, signal.SIG_DFL)
