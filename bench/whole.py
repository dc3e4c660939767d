"""Processor time of a whole run, from starting Python on: ``python bench whole [SCENE]``."""

from __future__ import annotations

import argparse
import json
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from yardstick import Yardstick

RUN = """
import json, sys, time
from types import SimpleNamespace
from warpdrape.cli import main
from warpdrape.dynamics import phases
phases.time = SimpleNamespace(perf_counter=time.process_time)
from warpdrape.recorder import Recorder
begin, spent = Recorder.__init__, {}
def begun(recorder, *arguments, **options):
    spent["start"] = time.process_time()
    begin(recorder, *arguments, **options)
    spent["recorder"] = recorder
Recorder.__init__ = begun
status = main(sys.argv[2:])
seconds = spent.pop("recorder").profile.seconds()
for part, name in (("steps", "Python"), ("measuring", "results"), ("writing", "output")):
    spent[part] = seconds[name]
whole = time.process_time()
spent |= {"whole": whole, "end": whole - sum(spent.values())}
with open(sys.argv[1], "w", encoding="utf-8") as file:
    json.dump(spent, file)
sys.exit(status)
"""
"""The command line with the clock of its profile exchanged; writes what it took [s]."""
PARTS = ("whole", "start", "steps", "measuring", "writing", "end")


def spent_by(scene: str, settings: Sequence[str]) -> dict[str, float]:
    """Processor time of a run on one thread, and of its parts [s].

    Args:
        scene: its name.
        settings: NAME=VALUE each.
    """
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder, "spent.json")
        command = [sys.executable, "-c", RUN, str(out), "run", scene, "--threads", "1", "--quiet"]
        for setting in settings:
            command += ["--set", setting]
        command += ["--out", str(Path(folder, "run"))]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode:
            raise SystemExit(f"{scene}: {done.stderr.strip().splitlines()[-1]}")
        return json.loads(out.read_text(encoding="utf-8"))


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a scene so many times and print medians."""
    parser = argparse.ArgumentParser(prog="python bench whole", description=__doc__)
    parser.add_argument("scene", nargs="?", default="three_ply_hemisphere")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE")
    parser.add_argument("--repeat", type=int, default=3, help="medians over so many")
    chosen = parser.parse_args(arguments)
    yardstick = Yardstick.build()
    rates, runs = [], []
    for _ in range(chosen.repeat):
        rates.append(yardstick.rate())
        runs.append(spent_by(chosen.scene, chosen.set))
    print("processor time [s]: " + ", ".join(PARTS) + "; yardstick [Mtri-steps/s]")
    figures = [statistics.median(run[part] for run in runs) for part in PARTS]
    print(f"{', '.join(f'{s:.2f}' for s in figures)}; {statistics.median(rates) / 1e6:.1f}")
    return 0
