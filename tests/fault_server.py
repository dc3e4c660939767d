"""Runs commands in forks of one warm interpreter, with faults of `faults.c`; for `fault_checks`.

Reads a job a line from standard input, as JSON, and answers each with a line.
"""

import ctypes
import json
import os
import random
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
    """Do a job in a fork; kill it, or send another signal, after a time if it says so.

    Times are those of the processor: others may have it now and then.
    """
    process = os.fork()
    if process == 0:
        try:
            child(job)
        finally:
            os._exit(99)
    if "after" in job:
        while "when" in job and not os.path.exists(job["when"]):
            time.sleep(1e-3)
        until, tick = spent(process) + job["after"], 1.0 / os.sysconf("SC_CLK_TCK")
        while spent(process) + tick < until:
            time.sleep(2e-3)
            ended, status, use = os.wait4(process, os.WNOHANG)
            if ended:
                return answer(job, status, use)
        time.sleep(random.uniform(0.0, tick))
        os.kill(process, job.get("signal", signal.SIGKILL))
    _, status, use = os.wait4(process, 0)
    return answer(job, status, use)


def spent(process: int) -> float:
    """Time that a process has had the processor [s], in whole ticks."""
    with open(f"/proc/{process}/stat", encoding="utf-8") as file:
        words = file.read().rpartition(")")[2].split()
    return (int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK")


def answer(job, status: int, use) -> dict:
    """How a job ended."""
    ended = os.waitstatus_to_exitcode(status)
    with open(job["said"], encoding="utf-8", errors="replace") as file:
        said = file.read()
    return {"status": ended, "seconds": use.ru_utime + use.ru_stime, "said": said}


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
