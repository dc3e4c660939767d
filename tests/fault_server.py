"""Runs commands in forks of one warm interpreter, with faults of `faults.c`; for `fault_checks`.

Reads a job a line from standard input, as JSON, and answers each with a line.
"""

import ctypes
import json
import os
import signal
import sys
import time

import warpdrape.simulation  # noqa: F401
from warpdrape.cli import main
from warpdrape.warp_start import start_warp

WARM = ["run", "hemisphere", "--set=cells=4", "--frames=1", "--quiet", "--overwrite"]


def child(job) -> None:
    """Run a command with its faults, or in an interpreter of its own without any, and end."""
    said = os.open(job["said"], os.O_CREAT | os.O_WRONLY | os.O_TRUNC)
    os.dup2(said, 1)
    os.dup2(said, 2)
    if job.get("cold"):
        os.execv(sys.executable, [sys.executable, "-m", "warpdrape", *job["argv"]])
    signal.signal(signal.SIGINT, signal.default_int_handler)
    library = ctypes.CDLL(None)
    library.fault_arm(job["folder"].encode(), job.get("at", 0), job.get("kind", 0))
    status = main(job["argv"])
    sys.stdout.flush()
    os.write(said, f"\ncalls {library.fault_count()}\n".encode())
    os._exit(status)


def serve(job) -> dict:
    """Do a job in a fork; kill it, or send another signal, after a time if it says so."""
    start = time.perf_counter()
    process = os.fork()
    if process == 0:
        try:
            child(job)
        finally:
            os._exit(99)
    if "after" in job:
        while "when" in job and not os.path.exists(job["when"]):
            time.sleep(1e-3)
        until = time.perf_counter() + job["after"]
        while time.perf_counter() < until:
            time.sleep(min(5e-3, max(until - time.perf_counter(), 0.0)))
            ended, status = os.waitpid(process, os.WNOHANG)
            if ended:
                return answer(job, status, start)
        os.kill(process, job.get("signal", signal.SIGKILL))
    _, status = os.waitpid(process, 0)
    return answer(job, status, start)


def answer(job, status: int, start: float) -> dict:
    """How a job ended."""
    ended = os.waitstatus_to_exitcode(status)
    with open(job["said"], encoding="utf-8", errors="replace") as file:
        said = file.read()
    return {"status": ended, "seconds": time.perf_counter() - start, "said": said}


def start(folder: str) -> None:
    """Load all that a run needs, once."""
    start_warp()
    sys.stdout = open(os.devnull, "w")
    main([*WARM, "--out", folder])


if __name__ == "__main__":
    out = os.fdopen(os.dup(1), "w")
    start(sys.argv[1])
    print("ready", file=out, flush=True)
    for line in sys.stdin:
        print(json.dumps(serve(json.loads(line))), file=out, flush=True)
