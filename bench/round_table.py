"""The sheet on a round table over its bending stiffness: ``python bench/round_table.py``.

Prints what docs/results.md shows of `circular_table`: its cases; and case a with one bending
stiffness in all directions, on two regular meshes and a random one. Runs are kept in ``--runs``
and not done again.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.interpolate import LinearNDInterpolator

from warpdrape.blanks.meshing import mesh_outline
from warpdrape.blanks.outlines import Rectangle
from warpdrape.results.result import FormedPly
from warpdrape.scenes import circular_table, cusick_drape

SIZE, RADIUS, BEYOND = 0.5, 0.2, 0.045
"""Side of the sheet, radius of the table, and how far beyond it folds are counted [m]."""
CASES = (
    ("a, `fabric`", {"case": "fabric"}),
    ("b, `no_shear`", {"case": "no_shear"}),
    ("c, `isotropic`", {"case": "isotropic"}),
    ("c without bending", {"case": "isotropic", "bending": "none"}),
)
STIFFNESSES = ("1e-5", "1e-4", "3e-4", "1e-3")
"""Of bending in all directions [N·m]."""
MESHES = {"100 cells": 100, "141 cells": 141, "random": 0}
"""Squares of two triangles along a side; 0 for a random mesh as dense as 100."""
TRIANGLES = 20_000
ROUND = 1440


def run_here(cells: int, parameters: Mapping[str, Any]) -> dict[str, float]:
    """Let a sheet drape, on one thread.

    Args:
        cells: as in ``MESHES``.
        parameters: of the scene.

    Returns:
        The scene's own measures, and ``folds``; the run's energy error.
    """
    scene = circular_table.build(
        sheet_size=SIZE, table_radius=RADIUS, cells=cells or 4, **parameters
    )
    if not cells:
        edge = SIZE * math.sqrt(4.0 / (math.sqrt(3.0) * TRIANGLES))
        mesh = mesh_outline(Rectangle(SIZE, SIZE), edge=edge, pattern="random")
        scene = replace(scene, plies=[replace(scene.plies[0], mesh=mesh)])
    result = scene.run(threads=1, frames=2, quiet=True)
    if not result.completed:
        raise SystemExit(result.summary["message"])
    return {
        **circular_table.drape_measures(result, RADIUS),
        "folds": folds(result.plies[0], RADIUS + BEYOND),
        "triangles": len(result.plies[0].triangles),
        "energy_error": result.summary["energy_error"],
    }


def folds(ply: FormedPly, circle: float) -> int:
    """Folds round a circle on the flat sheet [m], by how far it is from the middle in plan.

    What counts as one is as in the drape test.
    """
    angle = np.linspace(0.0, 2.0 * math.pi, ROUND, endpoint=False)
    on_circle = circle * np.column_stack([np.cos(angle), np.sin(angle)])
    formed = LinearNDInterpolator(ply.rest_points[:, :2], ply.points[:, :2])(on_circle)
    return cusick_drape.count_folds(np.hypot(formed[:, 0], formed[:, 1]), circle - RADIUS)


def done(cells: int, parameters: Mapping[str, Any], runs: Path) -> dict[str, float]:
    """A run's figures: from a file of an earlier one, or from a run."""
    name = "-".join(map(str, (cells, *parameters.values()))) + ".json"
    path = runs / name
    if not path.exists():
        runs.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(run_here(cells, parameters)) + "\n", encoding="utf-8")
    return json.loads(path.read_text(encoding="utf-8"))


def cell(row: Mapping[str, float]) -> str:
    """Folds and drops of a run."""
    drops = 1e3 * row["corner_drop_m"], 1e3 * row["side_drop_m"]
    return f"{row['folds']:.0f}; {drops[0]:.1f}, {drops[1]:.1f} mm"


def markdown(lines: Sequence[Sequence[str]]) -> str:
    """A table, its first line the header."""
    ruled = [lines[0], ["---"] * len(lines[0]), *lines[1:]]
    return "\n".join(f"| {' | '.join(line)} |" for line in ruled)


def main() -> int:
    """Compute what is missing, and print both tables."""
    parser = argparse.ArgumentParser(prog="round_table.py", description=__doc__.splitlines()[0])
    parser.add_argument("--meshes", nargs="+", choices=MESHES, default=list(MESHES))
    parser.add_argument("--stiffnesses", nargs="*", default=list(STIFFNESSES), help="[N·m]")
    parser.add_argument("--cases", nargs="*", choices=["a", "b", "c"], default=["a", "b", "c"])
    parser.add_argument(
        "--runs", type=Path, default=Path("runs/round_table"), help="folder of runs"
    )
    chosen = parser.parse_args()
    lines = [["bending [N·m]", *chosen.meshes]]
    for stiffness in chosen.stiffnesses:
        given = {"case": "fabric", "bending": stiffness}
        found = [done(MESHES[mesh], given, chosen.runs) for mesh in chosen.meshes]
        lines.append([stiffness, *map(cell, found)])
        print(" ".join(lines[-1]), flush=True)
    print(markdown(lines))
    lines = [["case", "folds", "corners, sides", "shear in the corners", "between triangles"]]
    for name, given in CASES:
        if name[0] in chosen.cases:
            row = done(MESHES["100 cells"], given, chosen.runs)
            angles = f"{row['corner_shear_deg']:.2g}°", f"{row['wrinkle_angle_deg']:.1f}°"
            lines.append([name, *cell(row).split("; "), *angles])
            print(" ".join(lines[-1]), flush=True)
    print(markdown(lines))
    return 0


if __name__ == "__main__":
    sys.exit(main())
