"""How deep plies lie in tools and in each other: ``python bench/penetrations.py [--plies … …]``.

`stacked_hemisphere` with plies 0/45/0/… for several numbers of plies, cells and holder forces, each
run in a process of its own and on one thread. What contact says of the whole run (its vertices, its
edges, jumps of the gap) stands beside what plain geometry says of the last frame: how far vertices,
and places between them, lie within a thickness of the next ply, but for the room that contact gives
in hollows, where chords cut off arcs, and without it. Runs are kept in ``--runs`` and not done
again; the table is printed and written to ``--out``.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import warp as wp

from warpdrape.contact.face_depths import BETWEEN
from warpdrape.contact.ply_facets import build_facets
from warpdrape.interaction import Run, Swept
from warpdrape.kernels.contact.facets import PlyFacets, ask_for_nearest, facing, is_at_border
from warpdrape.kernels.contact.ply_surfaces import compute_hollows, compute_vertex_normals
from warpdrape.kernels.contact.surface import weighted
from warpdrape.scenes import stacked_hemisphere

CORNERS = np.eye(3)
"""Weights of a triangle's places that are its vertices."""
COLUMNS = {
    "plies": ("plies", "{}"),
    "cells": ("cells", "{}"),
    "force": ("holder", "{:g} N"),
    "energy_error": ("energy error", "{:.2%}"),
    "tool_vertex": ("tool: vertex", "{:.2f}"),
    "tool_face": ("face", "{:.2f}"),
    "vertex": ("plies: vertex", "{:.2f}"),
    "edge": ("edge", "{:.2f}"),
    "jump": ("jump", "{:.2f}"),
    "end_vertex": ("end: vertex", "{:.2f}"),
    "end_face": ("face", "{:.2f}"),
    "end_plain": ("room not counted", "{:.2f}"),
    "end_room": ("room", "{:.2f}"),
    "across": ("across: vertices", "{:g}"),
    "across_faces": ("places", "{:g}"),
}
"""Heading and format of the table's columns; depths in mm."""


@wp.kernel(enable_backward=False)
def find_heights(
    facets: PlyFacets,
    mesh: wp.uint64,
    first_triangle: int,
    radius: wp.float64,
    x: wp.array(dtype=wp.vec3d),
    hollows: wp.array(dtype=wp.vec2d),
    corners: wp.array(dtype=wp.vec3i),
    weights: wp.array(dtype=wp.vec3d),
    heights: wp.array(dtype=wp.float64),
    rooms: wp.array(dtype=wp.vec2d),
):
    """Find how high places lie over a ply; one thread a place.

    Args:
        facets: of all plies.
        mesh: of the ply.
        first_triangle: of the ply.
        radius: how far to look [m].
        x: positions [m], shape [vertex].
        hollows: room above and below [m], shape [vertex].
        corners: of the triangles on which the places are, shape [place].
        weights: of these, shape [place].
        heights: signed distance, NaN where none is near or beyond the border [m], shape [place];
            overwritten.
        rooms: above and below the nearest place [m], shape [place]; overwritten.
    """
    k = wp.tid()
    own = corners[k]
    place = weighted(weights[k], x[own[0]], x[own[1]], x[own[2]])
    nearest = ask_for_nearest(facets, mesh, first_triangle, radius, x, place)
    heights[k] = wp.float64(wp.nan)
    if nearest.facet < 0:
        return
    if is_at_border(facets, nearest):
        return
    side = wp.dot(nearest.offset, facing(facets, nearest, x))
    distance = wp.length(nearest.offset)
    heights[k] = wp.where(side < wp.float64(0.0), -distance, distance)
    at = facets.corners[nearest.facet]
    w = nearest.weights
    rooms[k] = w[0] * hollows[at[0]] + w[1] * hollows[at[1]] + w[2] * hollows[at[2]]


class Stack:
    """The plies of a result, the lowest first, as they lie at the end."""

    def __init__(self, points: Sequence[np.ndarray], triangles: Sequence[np.ndarray]) -> None:
        """Put them on the processor.

        Args:
            points: vertices of each ply [m], shape [n, 3] each.
            triangles: of each ply, numbered within it, shape [m, 3] each.
        """
        self.triangles = triangles
        self.first = np.cumsum([0, *map(len, points)])
        self.first_triangle = np.cumsum([0, *map(len, triangles)])
        x = np.concatenate(points)
        self.x = wp.array(x, dtype=wp.vec3d, device="cpu")
        self.facets = build_facets(triangles, self.first, "cpu")
        self.meshes = [
            wp.Mesh(
                wp.array(p, dtype=wp.vec3f, device="cpu"),
                wp.array(np.ravel(t), dtype=wp.int32, device="cpu"),
            )
            for p, t in zip(points, triangles, strict=True)
        ]
        normals = wp.zeros(len(x), dtype=wp.vec3d, device="cpu")
        self.hollows = wp.zeros(len(x), dtype=wp.vec2d, device="cpu")
        known, every = [self.facets, self.x], Run(0, len(x))
        Swept(compute_vertex_normals, every, known, [normals])("cpu")
        Swept(compute_hollows, every, [*known, normals], [self.hollows])("cpu")

    def heights(
        self, own: int, other: int, places: np.ndarray, radius: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """How high places of a ply's triangles lie over another [m], and the room there [m].

        Args:
            own: number of the ply whose places they are.
            other: number of the other one.
            places: weights of the triangles' corners, shape [place, 3].
            radius: how far to look [m].
        """
        corners = np.repeat(self.triangles[own] + self.first[own], len(places), axis=0)
        weights = np.tile(places, (len(self.triangles[own]), 1))
        heights = wp.zeros(len(corners), dtype=wp.float64, device="cpu")
        rooms = wp.zeros(len(corners), dtype=wp.vec2d, device="cpu")
        inputs = [self.facets, self.meshes[other].id, int(self.first_triangle[other]), radius]
        inputs += [self.x, self.hollows]
        inputs += [
            wp.array(corners, dtype=wp.vec3i, device="cpu"),
            wp.array(weights, dtype=wp.vec3d, device="cpu"),
        ]
        wp.launch(find_heights, len(corners), inputs, [heights, rooms], device="cpu")
        return heights.numpy(), rooms.numpy()


def depths_of(stack: Stack, thickness: float, places: np.ndarray) -> dict[str, float]:
    """How deep places of plies lie in the next ones [m], of those that are on their side.

    Past the mid-surface by more than the room and half a thickness a place counts as ``across``, as
    contact has those that went round a border.

    Args:
        stack: the plies.
        thickness: of each [m].
        places: weights of the triangles' corners, shape [place, 3].

    Returns:
        ``beyond``: deepest but for the room in hollows; ``plain``: deepest, room or not; ``room``:
        the largest used, all in m; ``across``: so many places.
    """
    plain, beyond = [], []
    for lower in range(len(stack.triangles) - 1):
        for own, other, side in ((lower + 1, lower, 1.0), (lower, lower + 1, -1.0)):
            heights, room = stack.heights(own, other, places, 3.0 * thickness)
            near = np.isfinite(heights)
            plain.append(thickness - side * heights[near])
            beyond.append(plain[-1] - room[near, 0 if side > 0.0 else 1])
    plain, beyond = np.concatenate(plain), np.concatenate(beyond)
    across = beyond > 1.5 * thickness
    beyond, plain = np.maximum(beyond[~across], 0.0), np.maximum(plain[~across], 0.0)
    return {
        "beyond": float(beyond.max(initial=0.0)),
        "plain": float(plain.max(initial=0.0)),
        "room": float((plain - beyond).max(initial=0.0)),
        "across": float(across.sum()),
    }


def run_here(case: Mapping[str, Any]) -> dict[str, Any]:
    """Compute a case in this process: a row of the table, depths in mm."""
    layup = "/".join(("0", "45")[n % 2] for n in range(case["plies"]))
    scene = stacked_hemisphere.build(
        layup=layup, cells=case["cells"], holder_force=case["force"], accuracy=case["accuracy"]
    )
    result = scene.run(threads=1)
    summary = result.summary
    stack = Stack([p.points for p in result.plies], [np.asarray(p.triangles) for p in result.plies])
    thickness = scene.plies[0].fabric.thickness
    vertices, faces = (depths_of(stack, thickness, places) for places in (CORNERS, BETWEEN))

    def largest(entries: str, key: str) -> float:
        return 1e3 * max((entry[key] for entry in summary[entries]), default=0.0)

    return {
        **case,
        "status": summary["status"],
        "message": summary["message"],
        "energy_error": summary["energy_error"],
        "tool_vertex": largest("tools", "max_penetration_m"),
        "tool_face": largest("tools", "max_face_penetration_m"),
        "vertex": largest("interfaces", "max_penetration_m"),
        "jump": max(largest(name, "max_gap_jump_m") for name in ("interfaces", "edge_contact")),
        "edge": largest("edge_contact", "max_penetration_m"),
        "end_vertex": 1e3 * vertices["beyond"],
        "end_face": 1e3 * faces["beyond"],
        "end_plain": 1e3 * faces["plain"],
        "end_room": 1e3 * faces["room"],
        "across": vertices["across"],
        "across_faces": faces["across"],
        "seconds": summary["wall_s"],
    }


def done(case: Mapping[str, Any], runs: Path) -> dict[str, Any]:
    """A row: from a file of an earlier run, or from a process of its own."""
    path = runs / ("_".join(f"{value}" for value in case.values()) + ".json")
    if not path.exists():
        command = [sys.executable, __file__, "--alone", json.dumps(case)]
        environment = {**os.environ, "OMP_NUM_THREADS": "1"}
        finished = subprocess.run(command, capture_output=True, text=True, env=environment)
        if finished.returncode:
            raise SystemExit(f"{case}: {finished.stderr.strip().splitlines()[-1]}")
        runs.mkdir(parents=True, exist_ok=True)
        path.write_text(finished.stdout.splitlines()[-1] + "\n", encoding="utf-8")
    return json.loads(path.read_text(encoding="utf-8"))


def markdown(rows: Sequence[Mapping[str, Any]]) -> str:
    """The table."""
    lines = [[heading for heading, _ in COLUMNS.values()], ["---"] * len(COLUMNS)]
    lines += [[form.format(row[name]) for name, (_, form) in COLUMNS.items()] for row in rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def main() -> int:
    """Compute what is missing, and print the table."""
    parser = argparse.ArgumentParser(
        prog="penetrations.py", description=__doc__.splitlines()[0].split(":")[0]
    )
    parser.add_argument("--plies", nargs="+", type=int, default=[2, 3, 8, 12])
    parser.add_argument("--cells", nargs="+", type=int, default=[8, 12, 20])
    parser.add_argument("--forces", nargs="+", type=float, default=[20.0, 100.0, 1000.0])
    parser.add_argument("--accuracy", default="standard", help="draft, standard or reference")
    parser.add_argument("--runs", type=Path, default=Path("penetration_runs"), help="folder")
    parser.add_argument("--out", type=Path, default=Path("penetrations.json"), help="for figures")
    parser.add_argument("--alone", help=argparse.SUPPRESS)
    chosen = parser.parse_args()
    if chosen.alone:
        print(json.dumps(run_here(json.loads(chosen.alone))))
        return 0
    rows = []
    for cells in chosen.cells:
        for plies in chosen.plies:
            for force in chosen.forces:
                case = {"plies": plies, "cells": cells, "force": force}
                rows.append(done({**case, "accuracy": chosen.accuracy}, chosen.runs))
                print(markdown(rows[-1:]).splitlines()[-1], flush=True)
    print(markdown(rows))
    chosen.out.write_text(json.dumps(rows, indent=2) + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
