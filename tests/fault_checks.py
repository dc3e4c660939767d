"""A warm interpreter whose forks run commands that are killed, or whose disk fails."""

import json
import math
import os
import random
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from pxr import Usd
from resume_checks import assert_same_folder

from warpdrape.restart import read_restart

HERE = Path(__file__).parent
SCENE = ["hemisphere", "--set=cells=4", "--set=duration=0.01"]
FRAMES = 6
AT_BLOCKS = "0s"
"""How often a checkpoint is kept at every block of steps."""


class Server:
    """Runs commands in forks; see `fault_server`."""

    def __init__(self, folder: Path) -> None:
        compiler = shutil.which("cc")
        if sys.platform != "linux" or compiler is None:
            pytest.skip("needs Linux and a C compiler")
        library = folder / "faults.so"
        build = [compiler, "-shared", "-fPIC", "-o", str(library), str(HERE / "faults.c"), "-ldl"]
        subprocess.run(build, check=True)
        self._folder = folder
        self._process = subprocess.Popen(
            [sys.executable, str(HERE / "fault_server.py"), str(folder / "warm")],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            cwd=HERE.parent,
            env={**os.environ, "LD_PRELOAD": str(library), "PXR_WORK_THREAD_LIMIT": "1"},
        )
        assert self._process.stdout.readline() == "ready\n"

    def __call__(self, folder: Path, *argv, **faults) -> dict:
        """Run a command: its status, time taken [s], what it said, and calls counted."""
        job = {"said": str(self._folder / "said"), "folder": str(folder), **faults}
        job["argv"] = list(map(str, argv))
        self._process.stdin.write(json.dumps(job) + "\n")
        self._process.stdin.flush()
        done = json.loads(self._process.stdout.readline())
        done["said"], _, calls = done["said"].partition("\ncalls ")
        done["calls"] = int(calls or 0)
        return done

    def run(self, folder: Path, every=1, **faults) -> dict:
        """Run the scene that is killed again and again."""
        argv = ["run", *SCENE, f"--frames={FRAMES}", "--quiet", f"--checkpoint={every}"]
        return self(folder, *argv, "--out", folder, "--overwrite", **faults)

    def resume(self, folder: Path, **faults) -> dict:
        """Go on with it; from its start, where that was all."""
        done = self(folder, "resume", folder, "--quiet", "--checkpoint=1", **faults)
        if done["status"] == 2:
            assert "anew" in done["said"] or "give the folder of" in done["said"], done
            assert not (folder / "checkpoint.npz").exists()
            return self.run(folder)
        return done

    def close(self) -> None:
        """End it."""
        self._process.stdin.close()
        self._process.wait()


def assert_whole_files(folder: Path) -> None:
    """What has its final name is whole; a checkpoint is of the last frame but one, or later."""
    for name in ("run.json", "summary.json"):
        if (folder / name).exists():
            json.loads((folder / name).read_text("utf-8"))
    restart = read_restart(folder) if folder.exists() else None
    if (folder / "scene.usdc").exists():
        assert Usd.Stage.Open(str(folder / "scene.usdc")).GetEndTimeCode() >= 0
    for name in ("history.csv", ".history.partial.csv"):
        if (folder / name).exists():
            rows = (folder / name).read_text().splitlines()[1:]
            if len(rows) > 2:  # the last may be half, and its checkpoint be due
                assert restart is not None and restart.frame >= len(rows) - 3


def kill_and_resume(
    server: Server, folder: Path, whole: Path, every=1, **faults
) -> tuple[str, float]:
    """Kill a run, look at what is left, go on.

    Args:
        server: runs it.
        folder: of the run.
        whole: of the run that nothing happened to.
        every: how often it keeps checkpoints.
        faults: that kill it.

    Returns:
        What the kill had left, and how long the run took if it came to its end before [s], else
        infinity.
    """
    shutil.rmtree(folder, ignore_errors=True)
    done = server.run(folder, every, **faults)
    assert done["status"] in (-signal.SIGKILL, 0), done
    assert_whole_files(folder)
    left = ", ".join(sorted(f.name for f in folder.iterdir())) if folder.exists() else ""
    ended = server.resume(folder)
    assert ended["status"] == 0, (faults, left, ended)
    assert_same_folder(folder, whole)
    return left, done["seconds"] if done["status"] == 0 else math.inf


def kill_at_random(server: Server, folder: Path, whole: Path, count: int, seed: int):
    """Kill runs at so many random moments, up to just after their end; what each had left.

    Every other one keeps checkpoints between frames, and every tenth is an interpreter of its own,
    killed from its start on.
    """
    kinds = {
        (every, cold): server.run(folder, every, cold=cold)["seconds"]
        for every in (1, AT_BLOCKS)
        for cold in (False, True)
    }
    chance, killed = random.Random(seed), 0
    while killed < count:
        every, cold = kind = AT_BLOCKS if killed % 2 else 1, killed % 10 > 7
        after = chance.uniform(0.0, 1.05 * kinds[kind])
        left, took = kill_and_resume(server, folder, whole, every, after=after, cold=cold)
        killed += took == math.inf
        kinds[kind] = min(kinds[kind], took)  # other work may have slowed it when it was measured
        yield left, took == math.inf
