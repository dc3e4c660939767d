"""The cell as its yarns lie, and the curves that came of it."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from warpdrape.defects.wrinkle_field import vertex_normals
from warpdrape.results.figures import Figure
from warpdrape.results.raster import Camera, find_visible
from warpdrape.results.run_folder import write_whole
from warpdrape.unit_cell.cell import SECTIONS
from warpdrape.unit_cell.cell_file import Plan
from warpdrape.unit_cell.loading import ShearCurve, TensionTable
from warpdrape.unit_cell.model import Model
from warpdrape.unit_cell.sides import width
from warpdrape.unit_cell.splines import spline_value

COLOURS = ((0.20, 0.36, 0.60), (0.85, 0.55, 0.22))
"""Of warp and weft."""
ACROSS, ALONG = 20, 12
"""Points round a section, and along a yarn from crossover to crossover."""
PIXELS, FINER = 520, 2
"""Width of a view, and how many times finer it is drawn before it is averaged."""
LIGHT = (-0.35, -0.45, 0.82)


def draw_cell(plan: Plan, model: Model, curve: ShearCurve, path: Path) -> None:
    """Draw the yarns as woven, and at the end of shear."""
    shown = curve.states[-1]
    figure = Figure(figsize=(9.4, 4.0), dpi=130, layout="constrained")
    left, right = figure.subplots(1, 2)
    angle = math.degrees(shown.strain[2])
    for axes, view, title in (
        (left, _view(model, model.woven, np.zeros(5)), "as woven"),
        (right, _view(model, shown.state, shown.strain), f"sheared by {angle:.1f}°"),
    ):
        axes.imshow(view)
        axes.set_title(title)
        axes.axis("off")
    figure.suptitle(f"{plan.name}: {plan.cell.weave.name}, warp blue")
    write_whole(path, figure.savefig)


def yarn_surfaces(
    model: Model, state: NDArray, strain: NDArray
) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.int64]]:
    """Surfaces of all yarns over one repeat, and a little more.

    Args:
        model: the cell.
        state: coefficients of both paths [m].
        strain: as of an `Equilibrium`.

    Returns:
        Points [m], shape [point, 3]; triangles, shape [triangle, 3]; family of each point.
    """
    n = max(model.cell.weave.repeat, 3)
    points, triangles, families = [], [], []
    count = 0
    for family in (0, 1):
        for number in range(n):
            tube = _tube(model, state, strain, family, number, n)
            faces = _faces(*tube.shape[:2])
            points.append(tube.reshape(-1, 3))
            triangles.append(faces + count)
            families.append(np.full(tube.shape[0] * tube.shape[1], family))
            count += tube.shape[0] * tube.shape[1]
    return np.concatenate(points), np.concatenate(triangles), np.concatenate(families)


def _tube(model: Model, state, strain, family: int, number: int, n: int) -> NDArray[np.float64]:
    """Points of one yarn's surface, shape [along, across, 3]."""
    cell, weave, yarn = model.cell, model.cell.weave, model.yarns[family]
    length, angle = cell.cell[family], 0.5 * math.pi - strain[2]
    moved = (weave.move * number, weave.weft_offset(number % weave.repeat))[family]
    places = np.linspace(-0.5, n - 0.5, ALONG * n + 1) * length
    height = spline_value(model.parts(state)[family], places - moved * length, yarn.step)
    ways = np.array([[1.0, 0.0], [math.cos(angle), math.sin(angle)]])
    along, across = ways[family], ways[1 - family]
    stretch, other = 1.0 + strain[family], 1.0 + strain[1 - family]
    middle = np.outer(places * stretch, along) + number * cell.spacing[family] * other * across
    side = np.array([-along[1], along[0]])
    distance = cell.spacing[family] * other * math.sin(angle)
    turn = np.linspace(0.0, 2.0 * math.pi, ACROSS, endpoint=False)
    out = 0.5 * min(float(width(model, family, strain)), distance) * np.cos(turn)
    up = 0.5 * cell.height[family] * np.sign(np.sin(turn))
    up = up * np.abs(np.sin(turn)) ** (2.0 * SECTIONS[cell.section])
    tube = np.empty((len(places), ACROSS, 3))
    tube[:, :, :2] = middle[:, None] + out[:, None] * side
    tube[:, :, 2] = height[:, None] + up
    return tube


def _faces(rows: int, columns: int) -> NDArray[np.int64]:
    """Triangles of a tube of points, and of its two ends."""
    corner = np.arange(rows * columns).reshape(rows, columns)
    a, b = corner[:-1], np.roll(corner[:-1], -1, axis=1)
    c, d = corner[1:], np.roll(corner[1:], -1, axis=1)
    sides = [np.stack([a, c, b], -1).reshape(-1, 3), np.stack([b, c, d], -1).reshape(-1, 3)]
    ends = []
    for ring in (corner[0], corner[-1][::-1]):
        fan = np.stack([np.full(columns - 2, ring[0]), ring[1:-1], ring[2:]], -1)
        ends.append(fan)
    return np.concatenate(sides + ends)


def _view(model: Model, state, strain) -> NDArray[np.float64]:
    """An image of the yarns, shape [row, column, 3]."""
    points, triangles, families = yarn_surfaces(model, state, strain)
    camera = Camera.around(points, 38.0, -62.0, PIXELS * FINER)
    seen = find_visible(camera.project(points), triangles, camera.size)
    normals = vertex_normals(points, triangles)
    corners = triangles[seen.triangle]
    normal = seen.blend(normals[corners])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-9)
    light = 0.35 + 0.65 * np.abs(normal @ (np.array(LIGHT) / np.linalg.norm(LIGHT)))
    width, height = camera.size
    image = np.ones((height * width, 3))
    image[seen.pixel] = np.array(COLOURS)[families[corners[:, 0]]] * light[:, None]
    rows = height - height % FINER
    image = image.reshape(height, width, 3)[:rows]
    return image.reshape(rows // FINER, FINER, width // FINER, FINER, 3).mean(axis=(1, 3))


def draw_curves(plan: Plan, table: TensionTable, curve: ShearCurve, path: Path) -> None:
    """Draw tensions at several ratios of strain, and the shear couple with its parts."""
    figure = Figure(figsize=(11.0, 4.2), dpi=130, layout="constrained")
    pull, shear = figure.subplots(1, 2)
    _draw_tensions(pull, table)
    angles = np.degrees(curve.angles)
    for values, style, words in (
        (curve.couples, "-", "elastic and friction"),
        (curve.elastic, "--", "elastic"),
        (curve.friction, ":", "friction"),
    ):
        shear.plot(angles, 1e3 * values, style, color="C0" if style == "-" else "0.35", label=words)
    for at, style, words in ((curve.locking, "-", "locking"), (curve.touching, "--", "touching")):
        if at is not None:
            degrees = math.degrees(at)
            shear.axvline(degrees, color="C3", ls=style, lw=0.9, label=f"{words}, {degrees:.1f}°")
    held = " and ".join(f"{t:.3g}" for t in plan.loads.shear_tension)
    shear.set(
        xlabel="shear angle [°]",
        ylabel="couple C$_s$ [N·mm per cell]",
        title=f"Shear under {held} N per yarn",
    )
    for axes in (pull, shear):
        axes.grid(alpha=0.3)
        axes.legend(frameon=False, fontsize="small")
    figure.suptitle(f"{plan.name}: {plan.cell.weave.name}, simulated")
    write_whole(path, figure.savefig)


def _draw_tensions(axes, table: TensionTable) -> None:
    from scipy.interpolate import RegularGridInterpolator

    for family, name in enumerate(("warp", "weft")):
        tension = RegularGridInterpolator(table.strains, table.tensions[family])
        own, other = table.strains[family], table.strains[1 - family]
        for ratio, style in ((-1.0, ":"), (0.0, "-"), (1.0, "--")):
            low = max(own[0], -other[-1]) if ratio < 0 else max(own[0], other[0])
            reach = min(own[-1], other[-1] if ratio >= 0 else -other[0])
            strain = np.linspace(max(low, 0.0), reach, 60)
            pair = np.stack([strain, ratio * strain], axis=1)
            words = {-1.0: "opposite", 0.0: "0", 1.0: "equal"}[ratio]
            axes.plot(
                100 * strain,
                tension(pair[:, ::-1] if family else pair),
                style,
                color=f"C{family}",
                lw=1.2 if family else 2.6,
                label=f"{name}, other strain {words}",
            )
    axes.set(xlabel="strain [%]", ylabel="tension [N per yarn]", title="Tension")
