"""Error against time of ways to compute a scene: ``python bench/accuracy.py [--cases … --ways …]``.

Every case is computed in the ways asked for, each run in a process of its own and on one thread,
and once as the reference. Errors are differences to that. Each way runs several times with friction
changed by 10⁻⁹ of itself: the scatter of these says below which size an error is none. Time is
processor time of the steps. Runs are kept in ``--runs`` and not done again; the table is printed,
written to ``--out``, and drawn to ``--plot``.
"""

from __future__ import annotations

import argparse
import hashlib
import inspect
import json
import os
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from warpdrape import simulation
from warpdrape.numerics import Numerics

CASES: dict[str, tuple[str, dict[str, Any]]] = {
    "hemisphere_0": ("hemisphere", {}),
    "hemisphere_45": ("hemisphere", {"angle_deg": 45.0}),
    "three_plies": ("three_ply_hemisphere", {}),
    "eight_plies": ("stacked_hemisphere", {"cells": 12}),
    "double_dome": ("double_dome", {"cells": 20}),
    "tetrahedron": ("tetrahedron", {"cells": 20, "holder_force": 20.0}),
    "circular_table": ("circular_table", {"cells": 32, "bending": "0.0003"}),
}
"""Scene and parameters of each case: as coarse as their errors still mean something."""
CONVERGED: dict[str, Any] = {"accuracy": "reference"}
"""The reference of presses."""
CONVERGED_DRAPE: dict[str, Any] = {"safety": 0.45}
"""The reference of a scene in which nothing is pressed: its time is its own."""
WAYS: dict[str, dict[str, Any]] = {
    "reference": {"accuracy": "reference"},
    "standard": {"accuracy": "standard"},
    "draft": {"accuracy": "draft"},
    "full stiffness, 80 ms, brake 0.3": {
        "accuracy": "reference",
        "duration": 0.08,
        "brake": 0.3,
    },
    "brake 0.3": {"brake": 0.3},
    "softening 4": {"yarn_softening": 4.0},
    "softening 16": {"yarn_softening": 16.0},
    "softening 64": {"yarn_softening": 64.0},
    "softening 100": {"yarn_softening": 100.0},
    "softening 64, 40 ms": {"yarn_softening": 64.0, "duration": 0.04},
    "40 ms": {"duration": 0.04},
    "20 ms": {"duration": 0.02},
    "share 0.02": {"contact_share": 0.02},
    "share 0.2": {"contact_share": 0.2},
    "slide 0.04 mm": {"search_slide": 4e-5},
    "slide 0.25 mm": {"search_slide": 2.5e-4},
    "selective": {"mass_scaling": "selective", "minimum_time_step": 7e-6},
}
"""Parameters of the scene, and fields of its numerics, of each way, where they are not the standard
accuracy's; the first sets the time."""
TUNED = ("contact_share", "yarn_softening", "search_slide")
"""Of those, what is set beside the accuracy's own, whatever the scene makes of its parameters."""
NUMERICS = frozenset(field.name for field in fields(Numerics))
NOISE = 1e-9
"""By which friction changes from one run of a way to the next, as a share of itself."""
FRAMES = 60


@dataclass(frozen=True)
class Row:
    """Errors of a way of computing a case, largest of its runs' mean over all plies and places.

    Attributes:
        case: its name.
        way: its name.
        runs: so many, for mean and scatter.
        seconds: processor time of the steps, median [s].
        ratio: to that of the first way.
        steps: of a run.
        p95_deg: change of the 95th percentile of shear [deg].
        largest_deg: change of the largest shear [deg].
        draw_in_mm: change of the draw-in, in any of eight directions [mm].
        end_force: change of the punch's force while it stands at the end [-].
        force: root mean square change of the punch's force over its way, over the largest [-].
        wrinkle_mm: change of the largest wrinkle amplitude of the run [mm].
        scatter_deg: largest less smallest 95th percentile of one ply among the runs [deg].
        scatter_mm: likewise of one draw-in [mm].
        penetration_mm: deepest [mm].
        kinetic: over internal energy while loaded [-].
        softening_strain: strain owed to softer yarns [-].
    """

    case: str
    way: str
    runs: int
    seconds: float
    ratio: float
    steps: int
    p95_deg: float
    largest_deg: float
    draw_in_mm: float
    end_force: float
    force: float
    wrinkle_mm: float
    scatter_deg: float
    scatter_mm: float
    penetration_mm: float
    kinetic: float
    softening_strain: float


COLUMNS = {
    "case": ("case", "{}"),
    "way": ("way", "{}"),
    "runs": ("runs", "{}"),
    "seconds": ("s", "{:.1f}"),
    "ratio": ("ratio", "{:.2f}"),
    "steps": ("steps", "{:,}"),
    "p95_deg": ("95 %", "{:.2f}°"),
    "largest_deg": ("largest", "{:.2f}°"),
    "draw_in_mm": ("draw-in", "{:.2f} mm"),
    "end_force": ("end force", "{:+.1%}"),
    "force": ("force", "{:.1%}"),
    "wrinkle_mm": ("wrinkle", "{:.2f} mm"),
    "scatter_deg": ("scatter", "{:.2f}°"),
    "scatter_mm": ("", "{:.2f} mm"),
    "penetration_mm": ("deepest", "{:.3f} mm"),
    "kinetic": ("kinetic", "{:.2%}"),
    "softening_strain": ("strain", "{:.3%}"),
}
"""Heading and format of the table's columns."""


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
        "strain": summary["softening_strain"],
    }
    if "punch_force_n" in history:
        found["way"] = history["punch_displacement_m"].tolist()
        found["force"] = history["punch_force_n"].tolist()
    return found


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


def done(case: str, changes: Mapping[str, Any], number: int, runs: Path) -> dict[str, Any]:
    """A run's figures: from a file of an earlier one, or from a process of its own."""
    asked = json.dumps([case, CASES[case], changes, number], sort_keys=True)
    path = runs / f"{case}_{hashlib.sha1(asked.encode()).hexdigest()[:12]}.json"
    if not path.exists():
        command = [sys.executable, __file__, "--alone", asked]
        environment = {**os.environ, "OMP_NUM_THREADS": "1"}
        finished = subprocess.run(command, capture_output=True, text=True, env=environment)
        if finished.returncode:
            raise SystemExit(f"{case} {changes}: {finished.stderr.strip().splitlines()[-1]}")
        runs.mkdir(parents=True, exist_ok=True)
        path.write_text(finished.stdout.splitlines()[-1] + "\n", encoding="utf-8")
    return json.loads(path.read_text(encoding="utf-8"))


def reference_of(case: str) -> dict[str, Any]:
    """How a case is computed as its reference."""
    return CONVERGED_DRAPE if CASES[case][0] == "circular_table" else CONVERGED


def row_of(
    case: str, way: str, runs: Sequence[Mapping], exact: Sequence[Mapping], full: float
) -> Row:
    """Errors of the mean of some runs against the mean of others."""

    def mean(of: Sequence[Mapping], name: str) -> np.ndarray:
        return np.mean([run[name] for run in of], axis=0)

    def error(name: str) -> float:
        return float(np.abs(mean(runs, name) - mean(exact, name)).max())

    def scatter(name: str) -> float:
        return float(np.ptp([run[name] for run in runs], axis=0).max())

    seconds = float(np.median([run["seconds"] for run in runs]))
    end, over = force_errors(runs, exact) if "force" in runs[0] else (0.0, 0.0)
    return Row(
        case=case,
        way=way,
        runs=len(runs),
        seconds=seconds,
        ratio=seconds / full,
        steps=runs[0]["steps"],
        p95_deg=error("p95"),
        largest_deg=error("largest"),
        draw_in_mm=error("draw_in"),
        end_force=end,
        force=over,
        wrinkle_mm=error("wrinkle"),
        scatter_deg=scatter("p95"),
        scatter_mm=scatter("draw_in"),
        penetration_mm=float(mean(runs, "penetration")),
        kinetic=float(mean(runs, "kinetic")),
        softening_strain=float(mean(runs, "strain")),
    )


def force_errors(runs: Sequence[Mapping], exact: Sequence[Mapping]) -> tuple[float, float]:
    """Change of the punch's force at the end, and root mean square over its way [-].

    Forces tremble from frame to frame: over the way both are means over a twentieth of it.
    """
    ends, curves = [], []
    for group in (runs, exact):
        ends.append(np.mean([np.mean(run["force"][-FRAMES // 12 :]) for run in group]))
        curves.append(np.mean([over_way(run) for run in group], axis=0))
    rms = np.sqrt(np.nanmean((curves[0] - curves[1]) ** 2)) / np.nanmax(curves[1])
    return float(ends[0] / ends[1] - 1.0), float(rms)


def over_way(run: Mapping) -> np.ndarray:
    """A punch's force at the middles of twentieths of its way [N], shape [20]."""
    way, force = np.asarray(run["way"]), np.asarray(run["force"])
    moving = np.flatnonzero(way < way[-1] * (1.0 - 1e-6))[-1] + 2
    fine = np.linspace(0.0, way[-1], 401)
    smooth = np.interp(fine, way[:moving], force[:moving])
    return smooth[:-1].reshape(20, 20).mean(axis=1)


def markdown(rows: Sequence[Row]) -> str:
    """The table."""
    lines = [[heading for heading, _ in COLUMNS.values()], ["---"] * len(COLUMNS)]
    lines += [[form.format(getattr(row, n)) for n, (_, form) in COLUMNS.items()] for row in rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def draw(rows: Sequence[Row], path: Path) -> None:
    """Errors of shear and draw-in over the ratio of times: a colour a case, a mark a way."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.ticker import NullFormatter

    figure = Figure(figsize=(11.0, 5.5), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(1, 2)
    cases, ways = (list(dict.fromkeys(getattr(row, n) for row in rows)) for n in ("case", "way"))
    kinds = (("p95_deg", "scatter_deg", "95th percentile of shear [°]"),)
    kinds += (("draw_in_mm", "scatter_mm", "draw-in, any place [mm]"),)
    for axis, (error, scatter, words) in zip(axes, kinds, strict=True):
        for row in rows:
            if getattr(row, error) > LEAST_DRAWN:
                color, mark = f"C{cases.index(row.case)}", MARKS[ways.index(row.way) % len(MARKS)]
                axis.plot(row.ratio, getattr(row, error), mark, color=color, alpha=0.8)
        for number, case in enumerate(cases):
            widest = max(getattr(row, scatter) for row in rows if row.case == case)
            if widest > LEAST_DRAWN:
                axis.axhline(widest, color=f"C{number}", linestyle=":", linewidth=0.9)
        axis.axhline(0.3, color="black", linewidth=0.8)
        axis.set(xscale="log", yscale="log", xlabel="time over that of the first way", ylabel=words)
        axis.set_xticks(TICKS, [f"{tick:g}" for tick in TICKS])
        axis.xaxis.set_minor_formatter(NullFormatter())
        axis.grid(alpha=0.3)
    for number, case in enumerate(cases):
        axes[0].plot([], [], "s", color=f"C{number}", label=case.replace("_", " "))
    for number, way in enumerate(ways):
        axes[0].plot([], [], MARKS[number % len(MARKS)], color="grey", label=way)
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside right upper", fontsize=8)
    figure.suptitle("Errors; dotted what rounding alone does; black 0.3° and 0.3 mm")
    figure.savefig(path, dpi=110)


MARKS = "oXD^v<>Phd*p1234"
"""Of the ways, in the picture."""
TICKS = (0.05, 0.1, 0.2, 0.5, 1.0)
"""Of the ratios of times."""
LEAST_DRAWN = 3e-3
"""Errors below which there is nothing to draw [deg], [mm]."""


def main() -> int:
    """Compute what is missing, and print the table."""
    parser = argparse.ArgumentParser(prog="accuracy.py", description=__doc__.splitlines()[0])
    parser.add_argument("--cases", nargs="+", choices=CASES, default=list(CASES))
    parser.add_argument("--ways", nargs="+", choices=WAYS, default=list(WAYS))
    parser.add_argument("--noise", type=int, default=2, help="runs of each way")
    parser.add_argument("--runs", type=Path, default=Path("accuracy_runs"), help="folder of runs")
    parser.add_argument("--out", type=Path, default=Path("accuracy.json"), help="for the figures")
    parser.add_argument("--plot", type=Path, help="picture of errors over time")
    parser.add_argument("--alone", help=argparse.SUPPRESS)
    chosen = parser.parse_args()
    if chosen.alone:
        case, _, changes, number = json.loads(chosen.alone)
        print(json.dumps(run_here(case, changes, number)))
        return 0
    rows = []
    for case in chosen.cases:
        drape = CASES[case][0] == "circular_table"
        exact = [done(case, reference_of(case), n, chosen.runs) for n in range(chosen.noise)]
        first = None
        for way in chosen.ways:
            changes = {k: v for k, v in WAYS[way].items() if not drape or k == "yarn_softening"}
            if drape and first and not changes:
                continue  # a drape has neither a stroke nor an accuracy
            found = [done(case, changes, n, chosen.runs) for n in range(chosen.noise)]
            first = first or float(np.median([run["seconds"] for run in found]))
            rows.append(row_of(case, way, found, exact, first))
            print(markdown(rows[-1:]).splitlines()[-1], flush=True)
    print(markdown(rows))
    text = json.dumps([asdict(row) for row in rows], indent=2)
    chosen.out.write_text(text + "\n", encoding="utf-8")
    if chosen.plot:
        draw(rows, chosen.plot)
    return 0


if __name__ == "__main__":
    sys.exit(main())
