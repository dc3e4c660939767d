"""Drawings of the shapes: plan and sections of their tools at the end of the stroke.

``python bench/shapes/drawings.py [SHAPE ...]`` writes ``docs/benchmarks/SHAPE_drawing.png`` from
the scenes' own tools: no drawing by hand.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import trimesh
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from warpdrape import Scene
from warpdrape.commands.scene_library import find_script

SHAPES = ("hemisphere", "tetrahedron", "double_dome", "square_box", "prism")
COLORS = {"punch": "C3", "die": "C0", "holder": "C2"}
OUT = Path(__file__).parents[2] / "docs" / "benchmarks"
REACH = 40e-3
"""How far a section goes on beyond the tools' opening [m]."""


def placed(scene: Scene) -> dict[str, trimesh.Trimesh]:
    """Tools at the end, the holder where it stands at the start."""
    found = {}
    for tool in scene.tools:
        vertices = tool.pose(scene.duration).place(tool.vertices)
        found[tool.name] = trimesh.Trimesh(vertices, tool.triangles, process=False)
    return found


def section(at: Axes, tools: dict[str, trimesh.Trimesh], across: int, half: float) -> None:
    """Draw a section through the middle, ``across`` an axis (0: x, 1: y)."""
    along = 1 - across
    normal = np.eye(3)[across]
    for name, mesh in tools.items():
        lines = trimesh.intersections.mesh_plane(mesh, normal, 1e-6 * normal)
        near = np.abs(lines[:, :, along]).max(axis=1) <= half
        for k, (a, b) in enumerate(1e3 * lines[near]):
            label = name if k == 0 else None
            at.plot([a[along], b[along]], [a[2], b[2]], color=COLORS[name], lw=1.4, label=label)
    at.set(aspect="equal", xlabel=f"{'xy'[along]} [mm]", ylabel="z [mm]")
    at.set_title(f"section at {'xy'[across]} = 0", fontsize=9)
    at.grid(alpha=0.3)


def plan(at: Axes, scene: Scene, tools: dict[str, trimesh.Trimesh]) -> None:
    """Draw the blank, the die's opening, and level lines of the punch, 10 mm apart."""
    punch = tools["punch"]
    low = float(punch.vertices[:, 2].min())
    for height in np.arange(low + 1e-3, 0.0, 10e-3):
        lines = trimesh.intersections.mesh_plane(punch, (0, 0, 1), (0, 0, height))
        for a, b in 1e3 * lines:
            at.plot([a[0], b[0]], [a[1], b[1]], color=COLORS["punch"], lw=0.7)
    die = tools["die"]
    level = trimesh.intersections.mesh_plane(die, (0, 0, 1), (0, 0, -0.3 * abs(low)))
    for a, b in 1e3 * level:
        at.plot([a[0], b[0]], [a[1], b[1]], color=COLORS["die"], lw=1.2)
    for ply in scene.plies:
        flat = np.asarray(ply.mesh.vertices)
        for a, b in np.asarray(ply.mesh.boundary_edges):
            at.plot(*(1e3 * flat[[a, b]].T), color="0.4", lw=1.0)
    at.set(aspect="equal", xlabel="x [mm]", ylabel="y [mm]")
    at.set_title("plan: blank, die's opening, punch every 10 mm of height", fontsize=9)


def draw(name: str) -> Path:
    """Draw a shape's tools at their defaults."""
    scene = find_script(name).make()
    tools = placed(scene)
    punch = np.abs(tools["punch"].vertices)
    half = float(punch[:, :2].max()) + REACH
    figure = Figure(figsize=(11.0, 3.5), layout="constrained")
    FigureCanvasAgg(figure)
    left, middle, right = figure.subplots(1, 3)
    plan(left, scene, tools)
    section(middle, tools, 1, half)
    section(right, tools, 0, half)
    figure.legend(*middle.get_legend_handles_labels(), fontsize=8, loc="upper right", ncols=3)
    OUT.mkdir(exist_ok=True)
    path = OUT / f"{name}_drawing.png"
    figure.savefig(path, dpi=90)
    return path


if __name__ == "__main__":
    for shape in sys.argv[1:] or SHAPES:
        print(draw(shape))
