"""What the report plots over time: the columns of the history by kind, and the draw-in."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warpdrape.blanks.flat_mesh import FlatMesh
from warpdrape.defects.outline import outline_draw_in
from warpdrape.errors import InputError
from warpdrape.report.run_data import PlyFrames, RunFrames

DIGITS = 6
"""Significant digits of a plotted number."""
_MAIN = ("internal", "kinetic", "friction", "damping", "contact", "external_work")
_OF_PARTS = ("_j",)
_KINDS = (
    # title, unit, factor, endings of the columns
    ("Forces", "N", 1.0, ("_force_n", "_force_z_n")),
    ("Ways of the tools", "mm", 1e3, ("_displacement_m",)),
    ("Angles of tools that turn", "°", 1.0, ("_angle_deg",)),
    ("Torques of tools that turn", "N·m", 1.0, ("_torque_nm",)),
    ("Largest shear angle", "°", 1.0, ("_max_shear_deg",)),
    ("Wrinkles: largest amplitude", "mm", 1e3, ("_short_wrinkle_m", "_wrinkle_m")),
    ("Pressures", "kPa", 1e-3, ("_pressure_pa",)),
    ("Temperatures: mean of the ply", "K", 1.0, ("_mean_temperature_k",)),
    ("Slip of springs", "mm", 1e3, ("_slip_m",)),
    ("Springs that let go", "%", 100.0, ("_broken",)),
    ("Energies", "J", 1.0, tuple(f"{name}_j" for name in _MAIN)),
    ("Energies: parts", "J", 1.0, _OF_PARTS),
)
_SUMMED_UP = ("max_shear_deg", "time_s", "loading_time_s")
"""Columns that are no curve of their own."""


def curves(history: Mapping[str, NDArray[np.float64]], run: RunFrames) -> list[dict[str, Any]]:
    """Plots of a run, each with title, unit and its curves over time [ms].

    Args:
        history: column name → values over the frames.
        run: the frames shown; draw-in is found at these.
    """
    times = np.asarray(history["time_s"], float)
    left = [name for name in history if name not in _SUMMED_UP]
    plots = []
    for title, unit, factor, endings in _KINDS:
        main = endings[0] == f"{_MAIN[0]}_j"
        mine = [n for n in left if (n in endings if main else n.endswith(endings))]
        left = [name for name in left if name not in mine]
        if endings == _OF_PARTS:  # of which a run has few
            mine = [n for n in mine if np.any(history[n])]
        lines = [
            {"name": _name(n, endings, main), "values": _rounded(factor * history[n])} for n in mine
        ]
        if lines:
            plots.append(_plot(title, unit, times, lines))
    drawn = _draw_in_lines(run)
    if drawn:
        plots.insert(
            min(2, len(plots)), _plot("Draw-in of the edge", "mm", times[run.frames], drawn)
        )
    return plots


def _plot(title: str, unit: str, times: NDArray[np.float64], lines: list) -> dict[str, Any]:
    return {"title": title, "unit": unit, "times": _rounded(1e3 * times), "lines": lines}


def _name(column: str, endings: tuple[str, ...], main: bool) -> str:
    """Name of a curve: the column without what the plot's title says."""
    if main or endings == _OF_PARTS:
        return column.removesuffix("_j").replace("_", " ")
    ending = next(e for e in endings if column.endswith(e))
    short = ", too short for the mesh" if ending.startswith("_short") else ""
    along = ", along z" if ending == "_force_z_n" else ""
    return column.removesuffix(ending) + short + along


def _draw_in_lines(run: RunFrames) -> list[dict[str, Any]]:
    lines = []
    for ply in run.plies:
        drawn = _draw_in(ply)
        for name, column in (("largest", 0), ("mean", 1)):
            if drawn is not None:
                lines.append({"name": f"{ply.name}, {name}", "values": _rounded(drawn[:, column])})
    return lines


def _draw_in(ply: PlyFrames) -> NDArray[np.float64] | None:
    """Largest and mean draw-in along the outline at each frame [mm]; None where it has none."""
    try:
        mesh = FlatMesh(ply.rest[:, :2], ply.triangles.astype(np.int32))
        found = [outline_draw_in(mesh, points) for points in ply.points]
    except (InputError, KeyError, ValueError):  # a mesh that no run would have begun with
        return None
    return 1e3 * np.array([[each["max_m"], each["mean_m"]] for each in found])


def _rounded(values: NDArray[np.float64]) -> list[float | None]:
    return [float(f"{v:.{DIGITS}g}") if np.isfinite(v) else None for v in np.asarray(values)]
