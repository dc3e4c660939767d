"""A picture of tools and blank before a run: in space, from above, and in two sections."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from warpdrape.blanks.ply import Ply
from warpdrape.errors import InputError, RunFailed
from warpdrape.results.picture import DEFAULT_VIEW
from warpdrape.results.picture_layout import DPI
from warpdrape.results.quantities import QUANTITIES
from warpdrape.results.raster import Camera
from warpdrape.results.rendering import SAMPLES, Paint, render
from warpdrape.results.run_folder import write_whole
from warpdrape.results.usd_reader import PlyView, Surface
from warpdrape.results.yarn_lines import round_spacing
from warpdrape.setup import Setup
from warpdrape.tools.floating import Float
from warpdrape.tools.mould_face import borders
from warpdrape.tools.tool import Tool

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH = 1600
"""Of the picture [pixels]."""
LIFTED = 0.25
"""How far tools above the plies are lifted in space, over the blank's width [-]."""
ARROW = 0.16
"""Length of the arrows along yarns, over the blank's width [-]."""
COLOURS = ("#1b6ca8", "#c2571a", "#2e8b57", "#8e44ad", "#8a6d1b", "#444b54")
PLY_COLOUR = "#b03060"
_FAINT = "#5b6470"


def draw_start(scene: Setup, out: Path) -> Path:
    """Draw tools and plies as they stand before a run, and where tools come to; return the file.

    Args:
        scene: what would be computed.
        out: the .png, .pdf or .svg.

    Raises:
        InputError: if it cannot be written.
    """
    figure = start_figure(scene)
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        write_whole(out, lambda partial: figure.savefig(partial, dpi=DPI, facecolor="white"))
    except (OSError, ValueError, RunFailed) as error:
        raise InputError(
            f"--out {out} cannot be written ({error}): give another place, ending in .png"
        ) from error
    return out


def start_figure(scene: Setup) -> Figure:
    """The figure: in space, from above, and two sections through the middle of the blank."""
    from warpdrape.results.figures import Figure

    figure = Figure(figsize=(WIDTH / DPI, 0.95 * WIDTH / DPI), dpi=DPI, layout="constrained")
    grid = figure.add_gridspec(3, 2, height_ratios=(2.4, 1.0, 1.0))
    figure.suptitle(f"{scene.name} before the run", x=0.01, ha="left", weight="bold")
    _draw_space(figure.add_subplot(grid[0, 0]), scene)
    _draw_plan(figure.add_subplot(grid[0, 1]), scene)
    for row, axis in ((1, 0), (2, 1)):
        _draw_section(figure.add_subplot(grid[row, :]), scene, axis)
    handles = [_handle(COLOURS[k % len(COLOURS)], t.name) for k, t in enumerate(scene.tools)]
    handles.append(_handle(PLY_COLOUR, "plies" if len(scene.plies) > 1 else scene.plies[0].name))
    figure.legend(handles=handles, loc="upper right", ncols=len(handles), frameon=False, fontsize=8)
    return figure


def _handle(colour: str, label: str) -> Any:
    from matplotlib.lines import Line2D

    return Line2D([], [], color=colour, label=label, linewidth=2)


def _draw_space(axes: Axes, scene: Setup) -> None:
    top = scene.plies[-1]
    points = top.rest_points
    width = float(np.ptp(points, axis=0).max())
    tools = [_lifted(tool, top, width) for tool in scene.tools]
    triangles = np.asarray(top.mesh.triangles, np.int64)
    warp, weft = (np.tile([*way, 0.0], (len(triangles), 1)) for way in top.yarn_directions)
    view = PlyView(top.name, points, points, triangles, warp, weft, np.zeros(len(triangles)))
    shown = np.concatenate([points, *(vertices for vertices, _ in tools)])
    camera = Camera.around(shown, *DEFAULT_VIEW, int(0.48 * WIDTH) * SAMPLES)
    spacing = round_spacing(points)
    image = render(view, tools, camera, Paint(QUANTITIES["shear"], -1.0, 1.0, False, spacing))
    axes.imshow(image, interpolation="none")
    axes.set_axis_off()
    axes.set_title(
        f"{top.name} with its yarns; tools above it are drawn {1e3 * LIFTED * width:.0f} mm higher",
        fontsize=8,
        color=_FAINT,
    )


def _lifted(tool: Tool, top: Ply, width: float) -> Surface:
    points = tool.pose(0.0).place(tool.vertices)
    above = 0.5 * (points[:, 2].min() + points[:, 2].max()) > top.z
    up = np.array([0.0, 0.0, LIFTED * width if above else 0.0])
    return points + up, np.asarray(tool.triangles)


def _draw_plan(axes: Axes, scene: Setup) -> None:
    """Outlines of tools and plies from above, and the directions of the yarns."""
    from matplotlib.collections import LineCollection

    for number, tool in enumerate(scene.tools):
        colour = COLOURS[number % len(COLOURS)]
        for loop in _borders(tool):
            axes.plot(*(1e3 * loop.T), color=colour, linewidth=1.0)
    for ply in scene.plies:
        points = 1e3 * np.asarray(ply.mesh.vertices)
        ends = points[np.asarray(ply.mesh.boundary_edges)]
        axes.add_collection(LineCollection(list(ends), colors=PLY_COLOUR, linewidths=1.6))
    alike: dict[tuple[float, ...], list[Ply]] = {}
    for ply in scene.plies:
        ways = np.round(np.concatenate(ply.yarn_directions), 6) + 0.0
        alike.setdefault(tuple(ways.tolist()), []).append(ply)
    for plies in alike.values():
        _draw_yarns(axes, plies)
    axes.set_aspect("equal")
    axes.autoscale_view()
    axes.tick_params(labelsize=7)
    axes.set_title(
        "from above, x and y in mm: outlines; arrows: warp (full) and weft (open)",
        fontsize=8,
        color=_FAINT,
    )


def _borders(tool: Tool) -> list[np.ndarray]:
    """Closed outlines of a tool from above [m]: its border; of a solid that of what faces up."""
    points = tool.pose(0.0).place(tool.vertices)[:, :2]
    facets = np.asarray(tool.triangles)
    if tool.surface.mesh.is_watertight:
        facets = facets[tool.surface.mesh.face_normals[:, 2] > 0.0]
    return [np.concatenate([points[loop], points[loop[:1]]]) for loop in borders(facets)]


def _draw_yarns(axes: Axes, plies: Sequence[Ply]) -> None:
    """Arrows of plies whose yarns lie alike."""
    ply = plies[0]
    points = 1e3 * np.asarray(ply.mesh.vertices)
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    length = ARROW * float(np.ptp(points, axis=0).max())
    for way, filled in zip(ply.yarn_directions, (True, False), strict=True):
        axes.annotate(
            "",
            middle + length * way,
            middle,
            arrowprops={
                "arrowstyle": "-|>",
                "color": PLY_COLOUR,
                "fc": PLY_COLOUR if filled else "white",
                "linewidth": 1.2,
            },
        )
    degrees = np.degrees(ply.warp_angle)
    x, y = middle + 1.15 * length * ply.yarn_directions[0]
    names = ", ".join(each.name for each in plies)
    axes.text(x, y, f"{names} {degrees:.4g}°", fontsize=7, color=PLY_COLOUR)


def _draw_section(axes: Axes, scene: Setup, axis: int) -> None:
    """Tools and plies in the plane along x (0) or y (1) through the middle of the blank."""
    from matplotlib.collections import LineCollection

    flat = np.concatenate([np.asarray(ply.mesh.vertices) for ply in scene.plies])
    middle = 0.5 * (flat.min(axis=0) + flat.max(axis=0))
    at = 1e-6 * round(1e6 * float(middle[1 - axis])) + 0.0
    for number, tool in enumerate(scene.tools):
        colour = COLOURS[number % len(COLOURS)]
        moments = [(0.0, "-", 1.2)]
        if not isinstance(tool.motion, Float) and tool.peak_speed > 0.0:
            moments.append((scene.duration, ":", 0.9))
        for time, style, width in moments:
            points = tool.pose(time).place(tool.vertices)
            cut = section(points[tool.triangles], 1 - axis, at)[:, :, [axis, 2]]
            axes.add_collection(
                LineCollection(list(1e3 * cut), colors=colour, linestyles=style, linewidths=width)
            )
    for ply in scene.plies:
        low = 1e3 * (ply.z - 0.5 * ply.fabric.thickness)
        high = low + 1e3 * ply.fabric.thickness
        for start, end in _spans(ply, axis, at):
            across = [1e3 * start, 1e3 * end]
            axes.fill_between(across, low, high, color=PLY_COLOUR, linewidth=0.6)
    axes.set_aspect("equal", adjustable="datalim")
    axes.autoscale_view()
    axes.tick_params(labelsize=7)
    other = "xy"[1 - axis]
    axes.set_title(
        f"section at {other} = {1e3 * at:.4g} mm, {'xy'[axis]} and z in mm; dotted: where tools "
        "come to",
        fontsize=8,
        color=_FAINT,
    )


def section(corners: np.ndarray, axis: int, at: float) -> np.ndarray:
    """Segments in which facets [m], shape [facet, 3, 3], meet a plane, shape [segment, 2, 3].

    A facet that has a corner in the plane counts as if that lay on its positive side.
    """
    above = corners[:, :, axis] >= at
    cut = corners[above.any(axis=1) & ~above.all(axis=1)]
    if not len(cut):
        return np.zeros((0, 2, 3))
    above = cut[:, :, axis] >= at
    ahead = np.roll(cut, -1, axis=1)
    crosses = above != np.roll(above, -1, axis=1)
    rise = ahead[:, :, axis] - cut[:, :, axis]
    share = (at - cut[:, :, axis]) / np.where(crosses, rise, 1.0)
    points = cut + share[:, :, None] * (ahead - cut)
    return points[crosses].reshape(-1, 2, 3)


def _spans(ply: Ply, axis: int, at: float) -> list[tuple[float, float]]:
    """Where a flat ply lies along x (0) or y (1) on a line [m]."""
    points = np.asarray(ply.mesh.vertices)
    ends = points[np.asarray(ply.mesh.boundary_edges)]
    above = ends[:, :, 1 - axis] >= at
    cut = ends[above[:, 0] != above[:, 1]]
    share = (at - cut[:, 0, 1 - axis]) / (cut[:, 1, 1 - axis] - cut[:, 0, 1 - axis])
    found = np.sort(cut[:, 0, axis] + share * (cut[:, 1, axis] - cut[:, 0, axis]))
    return list(zip(found[::2].tolist(), found[1::2].tolist(), strict=True))
