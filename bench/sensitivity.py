"""Three plies under choices that should not matter: ``python bench/sensitivity.py [--ways …]``.

Noise of 10⁻⁹ in the flat plies' vertices, threads, and the step's safety. Prints each ply's largest
and 95th percentile of shear and its draw-in, and how far the central ply's percentile ranges.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from warpdrape import Scene
from warpdrape.blanks.flat_mesh import FlatMesh
from warpdrape.scenes import three_ply_hemisphere

WAYS: dict[str, dict[str, Any]] = {
    "as it is": {},
    "vertices by 1e-9": {"seed": 1},
    "vertices by 1e-9, others": {"seed": 2},
    "safety 0.7": {"safety": 0.7},
    "safety 0.5": {"safety": 0.5},
    "two threads": {"threads": 2},
    "stabiliser 1": {"stabiliser": 1.0},
}
"""What is changed: noise, threads, or a field of the numerics."""
NOISE = 1e-9
"""Of the vertices' places, relative [-]."""


def shaken(scene: Scene, seed: int) -> Scene:
    """A scene whose plies' vertices lie elsewhere by a share of ``NOISE``."""
    rng = np.random.default_rng(seed)
    plies = []
    for ply in scene.plies:
        points = np.asarray(ply.mesh.vertices)
        points = points * (1.0 + NOISE * rng.uniform(-1.0, 1.0, points.shape))
        plies.append(replace(ply, mesh=FlatMesh(points, ply.mesh.triangles)))
    return replace(scene, plies=plies)


def run(way: Mapping[str, Any], parameters: Mapping[str, Any]) -> dict[str, Any]:
    """Summary of one run."""
    changed = dict(way)
    seed, threads = changed.pop("seed", None), changed.pop("threads", 1)
    scene = three_ply_hemisphere.build(**parameters)
    scene = replace(scene, numerics=replace(scene.numerics, **changed))
    if seed is not None:
        scene = shaken(scene, seed)
    summary = scene.run(threads=threads, frames=12).summary
    if summary["status"] != "completed":
        raise SystemExit(summary["message"])
    return summary


def line(name: str, summary: Mapping[str, Any]) -> str:
    """A row of the table."""
    cells = [name]
    for ply in summary["plies"]:
        drawn = ply["draw_in_m"]
        along, between = 500.0 * (drawn["warp"] + drawn["weft"]), 1e3 * drawn["bias"]
        shear = f"{ply['max_shear_deg']:.1f}, {ply['p95_shear_deg']:.2f}°"
        cells.append(f"{shear}; {along:.1f}, {between:.1f} mm")
    cells += [f"{summary['energy_error']:.2%}", f"{1e3 * summary['max_penetration_m']:.2f} mm"]
    return f"| {' | '.join(cells)} |"


def main() -> int:
    """Run, and print the table."""
    parser = argparse.ArgumentParser(prog="sensitivity.py", description=__doc__.splitlines()[0])
    parser.add_argument("--ways", nargs="+", choices=WAYS, default=list(WAYS))
    parser.add_argument("--cells", type=int, default=20)
    chosen = parser.parse_args()
    central = []
    print("| changed | ply_0 | ply_1 | ply_2 | energy error | penetration |")
    for name in chosen.ways:
        summary = run(WAYS[name], {"cells": chosen.cells})
        central.append(summary["plies"][1]["p95_shear_deg"])
        print(line(name, summary), flush=True)
    print(f"95th percentile of the central ply: range {np.ptp(central):.2f}°")
    return 0


if __name__ == "__main__":
    sys.exit(main())
