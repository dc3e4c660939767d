"""The hemisphere on meshes of every kind and size: ``python bench/meshes.py [--cells … --set …]``.

What should not depend on a mesh: the largest shear angle, its 99th and 95th percentile by area, and
draw-in along the yarns and between them; and how much the blank's edge goes to and fro. Meshes that
are no parameter of the scene, random ones of other seeds and lattices turned against the blank, are
put into it here; so is, with ``--set in_plane=0.02``, a stiffness of its own [N·m] that yarns have
against bending in the plane. Runs are kept in ``--runs`` with the formed plies, and not done again;
tables are printed as in docs/results.md.
"""

from __future__ import annotations

import argparse
import hashlib
import inspect
import json
import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import radians
from pathlib import Path
from typing import Any

import numpy as np

from warpdrape.blanks.flat_mesh import FlatMesh
from warpdrape.blanks.meshing import mesh_outline
from warpdrape.blanks.outlines import Rectangle
from warpdrape.blanks.triangles import area_percentile
from warpdrape.materials.bending import Bending, BendingCurve
from warpdrape.scenes import hemisphere

SIZE = 0.3
"""Side of the blank [m]."""
MESHES: dict[str, dict[str, Any]] = {
    "grid": {"pattern": "grid"},
    "diagonal": {"pattern": "diagonal"},
    "random, seed 0": {"pattern": "random", "seed": 0},
    "random, seed 1": {"pattern": "random", "seed": 1},
    "random, seed 2": {"pattern": "random", "seed": 2},
    "lattice turned by 15°": {"pattern": "aligned", "warp_angle": radians(15.0)},
    "lattice turned by 30°": {"pattern": "aligned", "warp_angle": radians(30.0)},
}
FINER = {"diagonal": np.sqrt(2.0), "random": np.sqrt(np.sqrt(3.0))}
"""Cells over those of a grid with as many triangles: squares of two, and equilateral triangles."""
FIGURES = ("largest", "p99", "p95", "along", "between")
"""Shear angles [deg], mean draw-in along the yarns and between them [mm]: a cell of the table."""
FIELDS = ("rest_points", "points", "triangles", "shear_angle", "strain", "tool_pressure")
ENERGIES = ("yarn_j", "shear_j", "stabiliser_j", "bending_j", "friction_j", "tool_work_j")
FRAMES = 12
IN_PLANE = "in_plane"
"""Among the parameters: B_g of both yarns [N·m], that of the fabric without it."""


def mesh(kind: str, cells: int, size: float = SIZE) -> FlatMesh:
    """A mesh of the blank.

    Each has about as many triangles as a grid of so many squares of four.
    """
    options = MESHES[kind]
    edge = size / (cells * FINER.get(options["pattern"], 1.0))
    return mesh_outline(Rectangle(size, size), edge=edge, **options)


def run_here(
    kind: str, cells: int, parameters: Mapping[str, Any], formed: Path | None = None
) -> dict[str, float]:
    """Form the ply once, on one thread.

    Args:
        kind: of mesh.
        cells: squares of four triangles along a side, or a mesh as dense.
        parameters: of the scene, or fields of its numerics; or ``IN_PLANE``.
        formed: file for the formed ply's ``FIELDS``, to look into later.

    Returns:
        ``FIGURES``, draw-in place by place [mm], and what tells whether the run is to be trusted.
    """
    known = inspect.signature(hemisphere.build).parameters
    tuned = {name: value for name, value in parameters.items() if name not in known}
    given = {name: value for name, value in parameters.items() if name in known}
    in_plane = tuned.pop(IN_PLANE, None)
    scene = hemisphere.build(blank_size=SIZE, **given)
    cloth = scene.plies[0].fabric
    if in_plane is not None:
        cloth = replace(cloth, bending=held_together(cloth.bending, in_plane))
    scene = replace(
        scene,
        plies=[replace(scene.plies[0], fabric=cloth, mesh=mesh(kind, cells))],
        numerics=replace(scene.numerics, **tuned),
    )
    result = scene.run(threads=1, frames=FRAMES)
    summary, history, ply = result.summary, result.history, result.plies[0]
    if summary["status"] != "completed":
        raise SystemExit(f"{kind}, {cells} cells: {summary['message']}")
    if formed is not None:
        np.savez_compressed(formed, **{name: getattr(ply, name) for name in FIELDS})
    shear, areas = np.abs(ply.shear_angle_deg), np.asarray(scene.plies[0].mesh.areas)
    drawn = {name: 1e3 * value for name, value in summary["plies"][0]["draw_in_m"].items()}
    return {
        "largest": float(shear.max()),
        "p99": area_percentile(shear, areas, 0.99),
        "p95": area_percentile(shear, areas, 0.95),
        "along": 0.5 * (drawn["warp"] + drawn["weft"]),
        "between": drawn["bias"],
        "triangles": len(areas),
        "energy_error": summary["energy_error"],
        "kinetic": summary["kinetic_ratio_loaded"],
        **{name: float(history[name][-1]) for name in ENERGIES if name in history},
        **{f"draw_in_{name}": value for name, value in drawn.items()},
    }


def held_together(bending: Bending, in_plane: float) -> BendingCurve:
    """Bending that is as it was out of the plane, and has a stiffness of its own [N·m] within."""
    curvatures = np.array([0.0, 50.0, 100.0])  # 1/m; beyond the last it goes on as it was
    return BendingCurve(
        curvatures=curvatures,
        moments_warp=bending.warp * curvatures,
        moments_weft=bending.weft * curvatures,
        in_plane=(in_plane, in_plane),
        twist=bending.twist,
    )


def done(kind: str, cells: int, parameters: Mapping[str, Any], runs: Path) -> dict[str, float]:
    """A run's figures: from a file of an earlier one, or from a run."""
    path = kept(kind, cells, parameters, runs)
    found = json.loads(path.with_suffix(".json").read_text(encoding="utf-8"))
    with np.load(path) as formed:
        found["zigzag"] = zigzag(formed["rest_points"], formed["points"])
    return found


def kept(kind: str, cells: int, parameters: Mapping[str, Any], runs: Path) -> Path:
    """The file of a formed ply's ``FIELDS``, its figures beside it; the run is made if need be."""
    asked = json.dumps([kind, MESHES[kind], cells, parameters], sort_keys=True)
    path = runs / f"{hashlib.sha1(asked.encode()).hexdigest()[:12]}.npz"
    if not path.with_suffix(".json").exists():
        runs.mkdir(parents=True, exist_ok=True)
        found = run_here(kind, cells, parameters, path)
        text = json.dumps({"asked": asked, **found}) + "\n"
        path.with_suffix(".json").write_text(text, encoding="utf-8")
    return path


def zigzag(flat: np.ndarray, points: np.ndarray, size: float = SIZE) -> float:
    """How far a blank's edge goes in and out from vertex to vertex [mm], root mean square.

    That is how far a vertex has moved across its side beside what its two neighbours have; a smooth
    side has some tenths of a millimetre by its curvature.
    """
    found = []
    for axis in (0, 1):
        for side in (-0.5 * size, 0.5 * size):
            on_side = np.flatnonzero(np.abs(flat[:, axis] - side) < 1e-9)
            on_side = on_side[np.argsort(flat[on_side, 1 - axis])]
            at, moved = flat[on_side, 1 - axis], (points - flat)[on_side, axis]
            share = (at[1:-1] - at[:-2]) / (at[2:] - at[:-2])
            found.append(moved[1:-1] - (1.0 - share) * moved[:-2] - share * moved[2:])
    return float(1e3 * np.sqrt(np.mean(np.concatenate(found) ** 2)))


def ranges(rows: Sequence[Mapping[str, float]]) -> dict[str, float]:
    """Largest less smallest of each figure."""
    return {name: float(np.ptp([row[name] for row in rows])) for name in FIGURES}


def cell(row: Mapping[str, float]) -> str:
    """A cell of the table."""
    return "{largest:.1f}, {p99:.1f}, {p95:.1f}°; {along:.1f}, {between:.1f}".format_map(row)


def markdown(angle: float, table: Mapping[int, Mapping[str, Mapping[str, float]]]) -> str:
    """The table of an angle: sizes across, meshes down, ranges last."""
    kinds = list(next(iter(table.values())))
    lines = [[f"{angle:g}°", *(f"{cells} cells" for cells in table)], ["---"] * (len(table) + 1)]
    lines += [[kind, *(cell(column[kind]) for column in table.values())] for kind in kinds]
    lines += [["range", *(cell(ranges(list(column.values()))) for column in table.values())]]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def main() -> int:
    """Compute what is missing, and print the tables."""
    parser = argparse.ArgumentParser(prog="meshes.py", description=__doc__.splitlines()[0])
    parser.add_argument("--angles", nargs="+", type=float, default=[0.0, 45.0], help="[deg]")
    parser.add_argument("--cells", nargs="+", type=int, default=[20, 28, 40])
    parser.add_argument("--meshes", nargs="+", choices=MESHES, default=list(MESHES))
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE")
    parser.add_argument("--runs", type=Path, default=Path("mesh_runs"), help="folder of runs")
    chosen = parser.parse_args()
    for angle in chosen.angles:
        parameters = {"angle_deg": angle, **given(chosen.set)}
        table: dict[int, dict[str, dict[str, float]]] = {}
        for cells in chosen.cells:
            table[cells] = {}
            for kind in chosen.meshes:
                row = done(kind, cells, parameters, chosen.runs)
                table[cells][kind] = row
                print(f"{angle:g}°, {cells}, {kind}: {cell(row)}; zigzag {row['zigzag']:.2f} mm")
        print(markdown(angle, table), flush=True)
    return 0


def given(pairs: Sequence[str]) -> dict[str, Any]:
    """What ``--set NAME=VALUE`` says, numbers as numbers."""
    return {name: _read(value) for name, value in (pair.split("=", 1) for pair in pairs)}


def _read(text: str) -> Any:
    try:
        return json.loads(text)
    except ValueError:
        return text


if __name__ == "__main__":
    sys.exit(main())
