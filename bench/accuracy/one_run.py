"""One run of a case, in a process of its own and on one thread, and what is kept of it."""

from __future__ import annotations

import hashlib
import inspect
import json
import os
import subprocess
import sys
import time
from collections.abc import Mapping
from dataclasses import fields, replace
from importlib import import_module
from pathlib import Path
from typing import Any

from ways import CASES, TUNED

from warpdrape import simulation
from warpdrape.numerics import Numerics

NUMERICS = frozenset(field.name for field in fields(Numerics))
NOISE = 1e-9
"""By which friction changes from one run of a way to the next, as a share of itself."""
FRAMES = 60


def run_here(case: str, changes: Mapping[str, Any], number: int) -> dict[str, Any]:
    """Compute a case once, in this process.

    Args:
        case: its name.
        changes: of the scene's parameters and its numerics.
        number: of the run, which changes nothing but rounding.

    Returns:
        What a `Row` is made of.
    """
    scene_name, parameters = CASES[case]
    build = import_module(f"warpdrape.scenes.{scene_name}").build
    known = set(_parameters(build)) - set(TUNED)
    given = {k: v for k, v in changes.items() if k not in NUMERICS or k in known}
    tuned = {k: v for k, v in changes.items() if k not in given}
    parameters = {**parameters, **given}
    parameters.setdefault("friction", _parameters(build)["friction"])
    parameters["friction"] *= 1.0 + NOISE * number
    scene = build(**parameters)
    scene = replace(scene, numerics=replace(scene.numerics, **tuned))
    spent = _time_steps()
    result = scene.run(threads=1, frames=FRAMES)
    summary, history = result.summary, result.history
    if summary["status"] != "completed":
        raise SystemExit(f"{case} {dict(changes)}: {summary['message']}")
    found = {
        "seconds": sum(spent),
        "steps": summary["steps"],
        "p95": [ply["p95_shear_deg"] for ply in summary["plies"]],
        "largest": [ply["max_shear_deg"] for ply in summary["plies"]],
        "draw_in": [1e3 * v for ply in summary["plies"] for v in ply["draw_in_m"].values()],
        "wrinkle": 1e3 * max(history[f"{ply['name']}_wrinkle_m"].max() for ply in summary["plies"]),
        "penetration": 1e3 * summary["max_penetration_m"],
        "kinetic": summary["kinetic_ratio_loaded"],
        "strain": max(
            summary[n] for n in ("softening_strain", "mean_softening_strain") if n in summary
        ),
        "said": said_of(summary["numerical_error"]),
    }
    if "punch_force_n" in history:
        found["way"] = history["punch_displacement_m"].tolist()
        found["force"] = history["punch_force_n"].tolist()
    return found


def said_of(entry: Mapping[str, Any]) -> list[float] | None:
    """What a run says that its numerics may have cost [deg], [mm]; None where it says nothing."""
    if "not_known" in entry:
        return None
    return [entry["p95_shear_deg"], 1e3 * entry["draw_in_m"]]


def _parameters(build: Any) -> dict[str, Any]:
    return {name: p.default for name, p in inspect.signature(build).parameters.items()}


def _time_steps() -> list[float]:
    """Have the steps of runs timed: the list gets the processor time of each frame's [s]."""
    spent: list[float] = []
    inner = simulation._Run._step_frame

    def timed(run: Any, *rest: Any) -> None:
        start = time.process_time()
        inner(run, *rest)
        spent.append(time.process_time() - start)

    simulation._Run._step_frame = timed
    return spent


def place_of(case: str, changes: Mapping[str, Any], number: int, runs: Path) -> tuple[str, Path]:
    """What a run is asked for by, and the file in which its figures are kept."""
    asked = json.dumps([case, CASES[case], changes, number], sort_keys=True)
    return asked, runs / f"{case}_{hashlib.sha1(asked.encode()).hexdigest()[:12]}.json"


def done(case: str, changes: Mapping[str, Any], number: int, runs: Path) -> dict[str, Any]:
    """A run's figures: from a file of an earlier one, or from a process of its own."""
    asked, path = place_of(case, changes, number, runs)
    if not path.exists():
        command = [sys.executable, os.path.dirname(__file__), "--alone", asked]
        environment = {**os.environ, "OMP_NUM_THREADS": "1"}
        finished = subprocess.run(command, capture_output=True, text=True, env=environment)
        if finished.returncode:
            raise SystemExit(f"{case} {changes}: {finished.stderr.strip().splitlines()[-1]}")
        runs.mkdir(parents=True, exist_ok=True)
        path.write_text(finished.stdout.splitlines()[-1] + "\n", encoding="utf-8")
    return json.loads(path.read_text(encoding="utf-8"))
