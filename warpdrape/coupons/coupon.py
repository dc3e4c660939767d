"""What the virtual coupon tests share: specimen meshes, clamps' motion, curves and their files."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from warpdrape.blanks.flat_mesh import FlatMesh
from warpdrape.blanks.meshing import mesh_outline
from warpdrape.blanks.outlines import Rectangle
from warpdrape.coupons.closed_forms import yarn_tensions
from warpdrape.errors import InputError, finite, one_of, positive
from warpdrape.materials.fabric import Fabric
from warpdrape.materials.laws import Unwoven
from warpdrape.numerics import Numerics
from warpdrape.results.quasi_static import calm_from
from warpdrape.results.run_folder import COUPON, COUPON_PLOT, RunFolder
from warpdrape.tools.motion import Stroke

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from warpdrape.results.result import Result

MESHES = ("aligned", "crossed", "diagonal", "grid", "random")
SPEED_UP = 0.4
"""Share of a pull in which its speed rises; after that it is steady to the end [-]."""
INSTANT = 1e-6
"""Half of the time over which a rate is taken [s]."""
BARELY_TURNED = 1e-5
"""Turn [rad] that keeps a lattice at 45° from being replaced by the rectangle's own grid."""
COLUMN_LABELS = {
    "shear_angle_deg": "shear angle [°]",
    "warp_strain": "warp strain [-]",
    "pulled_m": "drawn out [m]",
}


def check_woven(fabric: Fabric) -> None:
    """Refuse a fabric for which the coupons' closed forms do not hold.

    Raises:
        InputError: if it has no yarns, or they are not at right angles.
    """
    if isinstance(fabric.tension, Unwoven):
        raise InputError(f"fabric {fabric.name!r} has no yarns: give a woven one")
    if abs(fabric.yarn_angle - 0.5 * math.pi) > 1e-9:
        raise InputError(
            f"fabric {fabric.name!r} has {math.degrees(fabric.yarn_angle):.4g}° from warp to weft, "
            "and the closed forms of coupons hold for 90° only: give one with yarns at right angles"
        )


def coupon_mesh(
    width: float,
    height: float,
    edge: float,
    mesh: str,
    *,
    warp_angle: float,
    mesh_angle: float = 0.0,
) -> FlatMesh:
    """Mesh a rectangular specimen, centred at the origin.

    Args:
        width: along x [m].
        height: along y [m].
        edge: mesh size [m].
        mesh: one of ``MESHES``; "grid" and "diagonal" may be turned.
        warp_angle: from x to the warp [rad], for "aligned".
        mesh_angle: turn of a "grid" against the specimen [rad].
    """
    one_of("mesh", mesh, MESHES)
    outline = Rectangle(positive("width", width, unit="m"), positive("height", height, unit="m"))
    if finite("mesh_angle", mesh_angle, unit="rad") == 0.0:
        return mesh_outline(outline, edge=edge, pattern=mesh, warp_angle=warp_angle)
    if mesh not in ("grid", "crossed"):
        raise InputError(f"mesh_angle turns a 'grid' only, not {mesh!r}: leave it at 0")
    turned = mesh_angle + BARELY_TURNED
    return mesh_outline(outline, edge=edge, pattern="aligned", warp_angle=turned)


def steady_pull(travel: np.ndarray, duration: float) -> Stroke:
    """A stroke that has ``travel`` [m] behind it at ``duration`` [s], and then its full speed.

    The speed rises smoothly and then stays, so that no deceleration falls into the curve's end.
    """
    positive("duration", duration, unit="s")
    slow_down = SPEED_UP / (1.0 + SPEED_UP)  # as a share of the whole stroke, like the speed-up
    travelled = (1.0 - 1.5 * slow_down) / (1.0 - slow_down)
    whole = np.asarray(travel, dtype=float) / travelled
    return Stroke(travel=whole.tolist(), duration=duration * (1.0 + SPEED_UP), ramp=slow_down)


def process_rate(
    angle: Callable[[np.ndarray], np.ndarray], times: np.ndarray, pace: float
) -> np.ndarray:
    """Rates of the shear angle in the test [1/s], by central differences.

    Args:
        angle: time of the pull [s] → shear angle [rad].
        times: of the pull [s], shape [n].
        pace: rates in the test over those of the simulation [-].
    """
    return pace * (angle(times + INSTANT) - angle(times - INSTANT)) / (2.0 * INSTANT)


STABILISER = 1.0
"""κ of a coupon's pairs [-], on any mesh: shear jumps from zone to zone there, for which pairs want
to be free in strain, and no compression drives their free mode."""


def coupon_numerics(averaging: str, damping: float) -> Numerics:
    """Numerics of a coupon without contacts: no search slows its frames.

    Args:
        averaging: "pairs" or "plain".
        damping: mass-proportional rate [1/s].
    """
    return Numerics(averaging=averaging, damping=damping, stabiliser=STABILISER)


@dataclass(frozen=True)
class Curve:
    """A force curve beside its closed form.

    Attributes:
        columns: name → values, shape [n]; the first is the abscissa. A measured ``…_n`` stands
            beside its ``closed_form_…_n``.
        ends: the values at the end of the pull.
        calm_from: row from which on inertia bears little of the force; None if it always does.
    """

    columns: Mapping[str, np.ndarray]
    ends: Mapping[str, float]
    calm_from: int | None

    def entries(self) -> dict[str, Any]:
        """What ``summary.json`` holds under ``coupon``."""
        abscissa, values = next(iter(self.columns.items()))
        calm = None if self.calm_from is None else float(values[self.calm_from])
        ends = {name: float(value) for name, value in self.ends.items()}
        return ends | {f"quasi_static_from_{abscissa}": calm}

    def figure(self) -> Figure:
        """Measured forces and closed forms over the abscissa."""
        from matplotlib.figure import Figure

        abscissa, values = next(iter(self.columns.items()))
        figure = Figure(figsize=(6.4, 4.4), dpi=150, layout="constrained")
        axes = figure.add_subplot()
        forces = [name for name in self.columns if f"closed_form_{name}" in self.columns]
        for number, name in enumerate(forces):
            word = name.removesuffix("_n").replace("_", " ")
            color = f"C{number}"
            exact = self.columns[f"closed_form_{name}"]
            axes.plot(values, exact, color=color, lw=3, alpha=0.35, label=f"{word}, closed form")
            axes.plot(values, self.columns[name], "+x"[number], color=color, ms=5, label=word)
        if self.calm_from != 0:
            until = values[-1 if self.calm_from is None else self.calm_from]
            axes.axvspan(values[0], until, color="0.92", lw=0, label="inertia bears part")
        axes.set_xlabel(COLUMN_LABELS.get(abscissa, abscissa))
        axes.set_ylabel("force [N]")
        axes.grid(alpha=0.3)
        axes.legend(frameon=False)
        return figure


def shear_curve(
    result: Result,
    clamp: str,
    angle: Callable[[np.ndarray], np.ndarray],
    force: Callable[[np.ndarray], np.ndarray],
    zone: Callable[[np.ndarray], np.ndarray],
) -> Curve:
    """Force over shear angle of a pulled specimen: F = dW/dδ by the clamp's work W.

    Slopes are those of splines through the frames: exact where a mean force over a frame is not.

    Args:
        result: the finished run.
        clamp: name of the clamp that pulls.
        angle: travel δ [m] → shear angle [rad] of inextensible yarns.
        force: shear angle [rad] → closed-form force [N].
        zone: centres of triangles in the flat ply [m], shape [n, 2], to a mask of those whose mean
            shear is to be compared with that angle.
    """
    travel = result.history[f"{clamp}_displacement_m"]
    work = result.history[f"{clamp}_work_j"]
    angles = np.asarray(angle(travel))
    columns = {
        "shear_angle_deg": np.degrees(angles),
        "travel_m": travel,
        "force_n": slopes(angles, work) / slopes(angles, travel),
        "closed_form_force_n": np.asarray(force(angles)),
    }
    ply = result.plies[0]
    inside = zone(ply.rest_points[ply.triangles, :2].mean(axis=1))
    ends = {name: float(values[-1]) for name, values in columns.items()}
    ends |= _force_errors(ends)
    if inside.any():  # a mesh may be too coarse to have one
        ends["measured_shear_angle_deg"] = float(np.abs(ply.shear_angle_deg[inside].mean()))
    return Curve(columns, ends, calm_from(result.history))


def slopes(at: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Slope at each of n rising points of a spline through them, quintic where they suffice.

    In the shear angle, work and travel are so smooth that a dozen frames do up to 55°; a cubic
    spline in the travel is 4 % off at 55° with twenty, as the couple rises steeply there.
    """
    from scipy.interpolate import make_interp_spline

    return make_interp_spline(at, values, k=min(5, len(at) - 1))(at, 1)


def stretch_curve(
    result: Result, fabric: Fabric, side: float, strains: Callable[[np.ndarray], np.ndarray]
) -> Curve:
    """Forces over warp strain of a biaxial test: those on the right side and on the upper one.

    A frame's mean force belongs to its middle; the last frame is at rest.

    Args:
        result: the finished run; its clamps "right" and "upper" share their "corner".
        fabric: of the sample.
        side: of the sample [m].
        strains: times [s], shape [n], to (warp, weft) strains, shape [n, 2].
    """
    history = result.history
    middle = 0.5 * (history["loading_time_s"][1:] + history["loading_time_s"][:-1])
    warp_strain, weft_strain = strains(middle).T
    columns = {"warp_strain": warp_strain, "weft_strain": weft_strain}
    exact = yarn_tensions(fabric, strains(middle)) * side / np.array(fabric.yarn_width)
    for family, (name, clamp, axis) in enumerate((("warp", "right", "x"), ("weft", "upper", "y"))):
        on_side = history[f"{clamp}_force_{axis}_n"] + history[f"corner_force_{axis}_n"]
        columns[f"{name}_force_n"] = on_side[1:]
        columns[f"closed_form_{name}_force_n"] = exact[:, family]
    ends = {name: float(values[-1]) for name, values in columns.items()}
    calm = calm_from(history)
    row = None if calm is None else min(calm, len(middle) - 1)
    return Curve(columns, {**ends, **_force_errors(ends)}, row)


def _force_errors(ends: Mapping[str, float]) -> dict[str, float]:
    """Relative error of every force at the end that is not zero in closed form."""
    pairs = {n: ends.get(f"closed_form_{n}", 0.0) for n in ends}
    return {
        f"{n.removesuffix('_n')}_error": ends[n] / exact - 1.0
        for n, exact in pairs.items()
        if exact != 0.0
    }


def coupon_files(curve_of: Callable[[Result], Curve]) -> dict[str, Callable]:
    """``report`` and ``write`` of a coupon's scene.

    Args:
        curve_of: makes the curve of a finished run.
    """

    def report(result: Result) -> dict[str, Any]:
        return {"coupon": curve_of(result).entries()}

    def write(result: Result, folder: RunFolder) -> None:
        curve = curve_of(result)
        folder.write_table(COUPON, curve.columns)
        folder.write_figure(COUPON_PLOT, curve.figure())

    return {"report": report, "write": write}
