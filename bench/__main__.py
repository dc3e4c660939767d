"""Time warpdrape against a plain C loop on the same machine: ``python bench [CASE ...]``.

Every figure is triangle-steps per second of processor time, and also its ratio to `calib.c` (double
precision, with shear) measured just before, so that it survives a noisy machine. Each case runs in
a process of its own, so that its memory is its own. The table is printed, and written with the
machine's particulars to ``bench.json`` (``--out``). ``python bench threads`` shows what of a step
does not get faster with threads (`scaling.py`), ``python bench whole`` the time of a whole run,
``python bench measuring`` that of a frame on finer meshes.
"""

from __future__ import annotations

import argparse
import dataclasses
import importlib
import json
import os
import platform
import subprocess
import sys
from pathlib import Path

OTHERS = {"threads": "scaling", "whole": "whole", "measuring": "measuring"}
"""Modules here that have a command line of their own, by its name."""
HEAD = f"{'case':24}{'triangles':>10}{'Mtri-steps/s':>13}{'ratio':>7}{'least':>7}{'most':>7}"
HEAD += f"{'peak MB':>9}{'contacts':>10}{'60 frames':>11}{'measured':>10}"


def line(row: dict) -> str:
    """A row for a terminal, and the shares of its phases below it."""
    least, most = row["spread"]
    figures = f"{row['case']:24}{row['triangles']:10,}{row['rate'] / 1e6:13.2f}"
    figures += f"{row['ratio']:7.3f}{least:7.3f}{most:7.3f}{row['peak_mb']:9.0f}"
    figures += f"{row['contacts']:10.2f}{100 * row['output']:9.2f} %{100 * row['results']:8.2f} %"
    shares = [f"{name} {100 * share:.0f} %" for name, share in row["phases"].items()]
    return f"{figures}\n    {', '.join(shares)}"


def alone(name: str, repeat: int, program: Path) -> dict:
    """Measure one case in a process of its own."""
    command = [sys.executable, str(Path(__file__).parent), name, "--repeat", str(repeat)]
    command += ["--alone", str(program)]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"{name}: {done.stderr.strip().splitlines()[-1]}")
    return json.loads(done.stdout.splitlines()[-1])


def measure_here(name: str, repeat: int, program: Path) -> None:
    """Measure one case in this process and print it as JSON."""
    from cases import measure
    from yardstick import Yardstick

    row = measure(name, Yardstick(program), repeat)
    print(json.dumps(dataclasses.asdict(row)))


def main() -> int:
    """Run the chosen cases."""
    if sys.argv[1:2] and sys.argv[1] in OTHERS:
        return importlib.import_module(OTHERS[sys.argv[1]]).main(sys.argv[2:])
    from cases import CASES
    from startup import start_up
    from yardstick import Yardstick

    parser = argparse.ArgumentParser(prog="python bench", description=__doc__.splitlines()[0])
    parser.add_argument("cases", nargs="*", help=f"of: {', '.join(CASES)}; all if none is named")
    parser.add_argument("--quick", action="store_true", help="the small cases only")
    parser.add_argument("--out", type=Path, default=Path("bench.json"), help="file for the figures")
    parser.add_argument("--repeat", type=int, default=3, help="medians over so many")
    parser.add_argument("--alone", type=Path, help=argparse.SUPPRESS)
    chosen = parser.parse_args()
    unknown = sorted(set(chosen.cases) - set(CASES))
    if unknown:
        parser.error(f"unknown case {unknown[0]!r}; known: {', '.join(CASES)}")
    if chosen.alone:
        measure_here(chosen.cases[0], chosen.repeat, chosen.alone)
        return 0
    names = chosen.cases or [n for n, case in CASES.items() if case.quick or not chosen.quick]
    yardstick, rows = Yardstick.build(), []
    seconds = {} if chosen.cases else start_up()
    print(HEAD)
    for name in names:
        rows.append(alone(name, chosen.repeat, yardstick.program))
        print(line(rows[-1]), flush=True)
    if seconds:
        print(
            f"start to first step: {seconds['cold']:.1f} s with no kernels cached, "
            f"{seconds['warm']:.1f} s with them"
        )
    record = {
        "machine": platform.machine(),
        "cores": os.cpu_count(),
        "python": platform.python_version(),
        "start_up_s": seconds,
        "rows": rows,
    }
    chosen.out.write_text(json.dumps(record, indent=2) + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
