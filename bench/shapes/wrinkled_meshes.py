"""Table of one wrinkled surface, of a real run, measured on meshes of several sizes."""

from __future__ import annotations

import numpy as np
from pages import markdown
from runs import FRAMES, Run, Runs
from scipy.interpolate import LinearNDInterpolator

from warpdrape.blanks.ply import Ply
from warpdrape.defects.gaps import ToolGaps
from warpdrape.defects.wrinkles import WrinkleSearch, Wrinkling
from warpdrape.tools.pose import pose_between

STIFFNESS, FORCE = 3e-3, 10
"""Bending of the ply [N·m] and force on the holder [N]: waves of many sides of triangles."""
FINE = 48
"""Squares of the run that is measured."""
COARSER = (40, 32, 24)
MIDDLE = 41
"""Frame at which its waves are many and of medium height; at the end they are steep folds."""
RUNS = (24, 32, 48)


def measured_on(run: Run, cells: int, mesh: str, frame: int = FRAMES) -> Wrinkling:
    """Wrinkles of a run's formed surface, carried over to another mesh of the same blank.

    Args:
        run: the run.
        cells: squares along a side of the other mesh.
        mesh: its kind.
        frame: of the run.
    """
    result = run.at(frame)
    (ply,), (formed,) = run.scene.plies, result.plies
    size = 2.0 * float(np.abs(formed.rest_points[:, 0]).max())
    other = Ply.rectangle("other", ply.fabric, size, cells=cells, mesh=mesh)
    flat = np.clip(np.asarray(other.mesh.vertices), -0.5 * size, 0.5 * size)
    points = LinearNDInterpolator(formed.rest_points[:, :2], formed.points)(flat * (1.0 - 1e-9))
    poses = [
        pose_between(tool.vertices, placed.vertices)
        for tool, placed in zip(run.scene.tools, result.tools, strict=True)
    ]
    gaps = ToolGaps(run.scene.tools)
    search = WrinkleSearch(other.mesh, ply.fabric.thickness, run.scene.defects)
    return search.look(points, lambda: gaps.ways(points, poses))


def _row(name: str, found: Wrinkling) -> list[str]:
    resolved = found.those(resolved=True)
    waves = np.array([each.wavelength for each in resolved])
    lengths = np.array([each.length for each in resolved])
    mean = f"{1e3 * np.average(waves, weights=lengths):.1f} mm" if len(waves) else "–"
    return [
        name,
        f"{len(resolved)}",
        f"{1e3 * found.largest(resolved=True):.2f} mm",
        mean,
        f"{100 * found.area_share[0]:.1f} %",
        f"{1e3 * sum(each.excess for each in resolved):.2f} mm",
        f"{len(found.those(resolved=False))}",
    ]


HEADINGS = (
    "wrinkles",
    "largest amplitude",
    "mean wavelength",
    "area",
    "excess length",
    "too short for the mesh",
)


def wrinkle_meshes(runs: Runs) -> str:
    """One run's surface on its own mesh and on others."""
    run = runs.run("hemisphere", cells=FINE, holder_force=FORCE, bending=STIFFNESS)
    rows = []
    for cells, mesh in ((FINE, "grid"), *((c, "grid") for c in COARSER), (COARSER[0], "random")):
        kind = "its own" if cells == FINE else mesh
        name = f"{300 / cells:.3g} mm squares, {kind}"
        rows.append(_row(name, measured_on(run, cells, mesh, MIDDLE)))
    return markdown(("measured on", *HEADINGS), rows)


def wrinkle_runs(runs: Runs) -> str:
    """The same scene run on three meshes: what forming, not measuring, makes of the mesh."""
    rows = []
    for cells in RUNS:
        run = runs.run("hemisphere", cells=cells, holder_force=FORCE, bending=STIFFNESS)
        rows.append(_row(f"{300 / cells:.3g} mm squares", measured_on(run, cells, "grid")))
    return markdown(("run with", *HEADINGS), rows)
