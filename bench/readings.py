"""What of meshes' scatter is reading, and what deformation: ``python bench/readings.py``.

A triangle's shear is that of the plane through its corners: a mean over a few millimetres of a
field that rises by a degree and more per millimetre, and meshes take it at other places. So the
formed plies that bench/meshes.py keeps are read here in three ways: triangle by triangle, as in all
results; by the means of the pairs that share a strain; and from a cubic through the vertices round
each triangle, which sees the field between them. And so is *one* deformation, the smooth one that
lies nearest to all the plies of a size, at each mesh's vertices: what its readings differ by is no
difference of results.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
from meshes import MESHES, SIZE, given, kept
from scipy.interpolate import LSQBivariateSpline
from scipy.spatial import cKDTree

from warpdrape.blanks.flat_mesh import FlatMesh
from warpdrape.blanks.pairing import pair_triangles
from warpdrape.blanks.triangles import area_percentile, yarn_gradients

NEAREST, DEGREE = 20, 3
"""Vertices round a place, and the polynomial fitted to them: twice as many as its coefficients."""
PIECES, ENOUGH = 30, 4
"""Pieces of the smooth deformation along each side, 10 mm, a third of the bands' width; and the
vertices that each needs."""
FIGURES = ("largest", "p99", "p95")

Map = Callable[[np.ndarray], np.ndarray]
"""Flat places [m], shape [n, 2], to places on the formed ply [m], shape [n, 3]."""


def shear_of(gradients: np.ndarray, angle: float) -> np.ndarray:
    """Shear angle [deg], shape [n].

    Args:
        gradients: ∂x/∂X and ∂x/∂Y of the formed ply, shape [n, 2, 3].
        angle: from the X axis to the warp [rad].
    """
    warp, weft = (
        cos * gradients[:, 0] + sin * gradients[:, 1]
        for cos, sin in ((np.cos(angle), np.sin(angle)), (-np.sin(angle), np.cos(angle)))
    )
    lengths = np.linalg.norm(warp, axis=1) * np.linalg.norm(weft, axis=1)
    return np.degrees(np.arcsin(np.clip((warp * weft).sum(axis=1) / lengths, -1.0, 1.0)))


def by_triangle(mesh: FlatMesh, points: np.ndarray, angle: float) -> np.ndarray:
    """Shear of every triangle as results have it [deg], shape [triangle]."""
    rows = mesh.triangles
    slopes, _ = yarn_gradients(mesh.vertices, rows, np.array([1.0, 0.0]), np.array([0.0, 1.0]))
    sides = points[rows[:, 1:]] - points[rows[:, :1]]
    return shear_of(slopes.reshape(-1, 2, 2) @ sides, angle)


def by_pair(mesh: FlatMesh, points: np.ndarray, angle: float) -> np.ndarray:
    """Mean shear of every triangle's patch [deg], shape [triangle]."""
    patch = pair_triangles(mesh).patch_of()
    sums = np.bincount(patch, mesh.areas * by_triangle(mesh, points, angle))
    return (sums / np.bincount(patch, mesh.areas))[patch]


def smoothly(mesh: FlatMesh, points: np.ndarray, angle: float) -> np.ndarray:
    """Shear at every triangle's middle, of a cubic through vertices round it [deg], [triangle].

    Least squares over the nearest, weighted by a bell that falls to exp(−3/2) at the last.
    """
    middles = mesh.vertices[mesh.triangles].mean(axis=1)
    distance, nearest = cKDTree(mesh.vertices).query(middles, NEAREST)
    unit = distance[:, -1:]
    u, v = np.moveaxis((mesh.vertices[nearest] - middles[:, None]) / unit[..., None], -1, 0)
    powers = [(n - j, j) for n in range(DEGREE + 1) for j in range(n + 1)]
    terms = np.stack([u**i * v**j for i, j in powers], axis=-1)
    bell = np.exp(-1.5 * (distance / unit) ** 2)[..., None]
    found = np.linalg.pinv(bell * terms) @ (bell * points[nearest])
    slopes = [powers.index((1, 0)), powers.index((0, 1))]
    return shear_of(found[:, slopes], angle)


READINGS = {"triangles": by_triangle, "pairs": by_pair, "smooth": smoothly}


def nearest_smooth(flat: np.ndarray, points: np.ndarray) -> Map:
    """The cubic spline that lies nearest to formed vertices of all meshes.

    Args:
        flat: vertices before forming [m], shape [n, 2].
        points: and after [m], shape [n, 3].
    """
    pieces = min(PIECES, int(np.sqrt(len(flat) / ENOUGH)))
    inner = np.linspace(-0.5 * SIZE, 0.5 * SIZE, pieces + 1)[1:-1]
    box = [-0.5 * SIZE, 0.5 * SIZE] * 2
    splines = [LSQBivariateSpline(*flat.T, values, inner, inner, bbox=box) for values in points.T]
    return lambda at: np.stack([spline.ev(*at.T) for spline in splines], axis=1)


def figures(mesh: FlatMesh, points: np.ndarray, angle: float, reading: str) -> dict[str, float]:
    """``FIGURES`` of a formed ply [deg], by one of the ``READINGS``."""
    shear, areas = np.abs(READINGS[reading](mesh, points, angle)), np.asarray(mesh.areas)
    high, higher = (area_percentile(shear, areas, share) for share in (0.95, 0.99))
    return {"largest": float(shear.max()), "p99": higher, "p95": high}


def table(plies: Mapping[str, tuple[FlatMesh, np.ndarray]], angle: float) -> str:
    """Meshes down; across, readings of each mesh's own result and of one deformation on it.

    Args:
        plies: mesh and formed vertices [m] by kind of mesh.
        angle: from the X axis to the warp [rad].
    """
    smooth = nearest_smooth(
        np.concatenate([mesh.vertices for mesh, _ in plies.values()]),
        np.concatenate([points for _, points in plies.values()]),
    )
    found = {
        kind: [
            figures(mesh, formed, angle, reading)
            for formed in (points, smooth(mesh.vertices))
            for reading in READINGS
        ]
        for kind, (mesh, points) in plies.items()
    }
    ranges = [
        {name: float(np.ptp([row[name] for row in column])) for name in FIGURES}
        for column in zip(*found.values(), strict=True)
    ]
    heads = [f"{whose}, {reading}" for whose in ("own", "one") for reading in READINGS]
    lines = [["mesh", *heads], ["---"] * (len(heads) + 1)]
    lines += [[kind, *map(_cell, row)] for kind, row in found.items()]
    lines += [["range", *map(_cell, ranges)]]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def _cell(row: Mapping[str, float]) -> str:
    return "{largest:.1f}, {p99:.1f}, {p95:.2f}°".format_map(row)


def main() -> int:
    """Read the plies of every size, which are formed first if bench/meshes.py has not."""
    parser = argparse.ArgumentParser(prog="readings.py", description=__doc__.splitlines()[0])
    parser.add_argument("--angle", type=float, default=0.0, help="[deg]")
    parser.add_argument("--cells", nargs="+", type=int, default=[28, 40])
    parser.add_argument("--meshes", nargs="+", choices=MESHES, default=list(MESHES))
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE")
    parser.add_argument("--runs", type=Path, default=Path("mesh_runs"), help="folder of runs")
    chosen = parser.parse_args()
    parameters = {"angle_deg": chosen.angle, **given(chosen.set)}
    for cells in chosen.cells:
        plies = {}
        for kind in chosen.meshes:
            with np.load(kept(kind, cells, parameters, chosen.runs)) as formed:
                flat = FlatMesh(formed["rest_points"][:, :2], formed["triangles"])
                plies[kind] = flat, formed["points"]
        print(f"{cells} cells\n{table(plies, np.radians(chosen.angle))}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
