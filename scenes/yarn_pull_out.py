"""Yarn pull-out: a bundle of the warp drawn out of a patch of fabric by its end."""

from dataclasses import replace

import numpy as np

from warpdrape import Clamp, Crossover, Fabric, Numerics, Ply, Scene
from warpdrape.blanks.flat_mesh import FlatMesh
from warpdrape.blanks.meshing import squares
from warpdrape.coupons.coupon import Curve, check_woven, coupon_files, steady_pull
from warpdrape.coupons.pull_out import PullOut
from warpdrape.errors import InputError, one_of, positive
from warpdrape.forces.sliding_chains import crossover_of, is_coupled
from warpdrape.materials.fabric_library import with_bending
from warpdrape.results.quasi_static import calm_from

HELD = ("crossovers", "sides")


def build(
    *,
    fabric: str | Fabric = "carbon_interlock",
    slip_force: float = 0.1,
    stiffness: float = 2e4,
    length: float = 0.05,
    edge: float = 0.005,
    sides: int = 2,
    travel: float = 0.03,
    held: str = "crossovers",
    duration: float = 0.06,
    damping: float = 20.0,
) -> Scene:
    """Build a pull-out test along the warp, which lies along x.

    Args:
        fabric: a fabric, or the name or file of one, whose yarns have a tension of their own.
        slip_force: of a warp yarn at a crossing [N]; 0 takes the fabric's own crossover.
        stiffness: of a warp yarn at a crossing before it slips [N/m].
        length: of the patch along the warp, a multiple of ``edge`` [m].
        edge: mesh size [m]; a bundle is as wide.
        sides: squares on either side of the bundle.
        travel: of the bundle's end [m]; the closed form is for less than ``length``.
        held: "crossovers", so that nothing moves but the bundle, as in the closed form; or "sides":
            the ends of the weft, gripped, as in a test.
        duration: of the pull [s].
        damping: mass-proportional rate [1/s].
    """
    parameters = {**locals(), "fabric": getattr(fabric, "name", fabric)}
    one_of("held", held, HELD)
    positive("travel", travel, unit="m")
    if travel >= positive("length", length, unit="m"):
        raise InputError(
            f"travel = {travel:g} m draws the bundle out of a patch of {length:g} m: give less"
        )
    cloth = _cloth(fabric, slip_force, stiffness)
    ply = Ply(name="ply_0", fabric=cloth, mesh=_mesh(length, edge, sides))
    crossover_of(ply)  # refuses a card without
    if is_coupled(ply):
        raise InputError(
            f"the closed form of a pull-out is for yarns whose tension depends on their own strain,"
            f" and fabric {cloth.name!r} couples warp and weft: give it tension law 'linear'"
        )
    end, half = length + 0.25 * edge, (sides - 0.5) * edge
    where, yarns = {
        "crossovers": (lambda p: p[:, 0] < end, "free"),
        "sides": (lambda p: np.abs(p[:, 1]) > half, "held"),
    }[held]
    exact = closed_form(cloth, length, edge)

    def curve(result) -> Curve:
        history = result.history
        pulled = history["end_displacement_m"]
        at = 0.5 * (pulled[1:] + pulled[:-1])  # means over a frame, of both
        columns = {
            "pulled_m": at,
            "force_n": np.diff(history["end_work_j"]) / np.diff(pulled),
            "closed_form_force_n": exact.mean_force(pulled),
        }
        ends = {name: float(values[-1]) for name, values in columns.items()}
        ends["force_error"] = ends["force_n"] / ends["closed_form_force_n"] - 1.0
        ends["largest_force_n"] = float(columns["force_n"].max())
        ends["closed_form_largest_force_n"] = float(exact.curve[1].max())
        calm = calm_from(history)
        return Curve(columns, ends, None if calm is None else min(calm, len(at) - 1))

    return Scene(
        name="yarn_pull_out",
        plies=[ply],
        clamps=[
            Clamp(name="patch", ply="ply_0", where=where, yarns=yarns),
            Clamp(
                name="end",
                ply="ply_0",
                where=lambda p: p[:, 0] > end,
                motion=steady_pull((travel, 0.0, 0.0), duration),
                follow=(1.0, 0.0, 0.0),
            ),
        ],
        duration=duration,
        gravity=(0.0, 0.0, 0.0),
        self_contact=False,
        numerics=Numerics(damping=damping),
        approach="sliding_yarns",
        parameters=parameters,
        **coupon_files(curve),
    )


def closed_form(fabric: Fabric, length: float, edge: float) -> PullOut:
    """Of a bundle as wide as a square, in a patch that reaches half a square into its tab."""
    yarns = edge / fabric.yarn_width[0]
    law, per_length = fabric.crossover, yarns / fabric.cell_warp
    return PullOut(
        length=length + 0.5 * edge,
        stiffness=yarns * fabric.tension.warp,
        hold=per_length * law.stiffness_warp,
        limit=per_length * law.slip_force_warp,
    )


def _cloth(fabric: str | Fabric, slip_force: float, stiffness: float) -> Fabric:
    """A fabric without bending, which a bundle that grows out of a mesh would not obey."""
    cloth = with_bending(fabric, "none")
    check_woven(cloth)
    if positive("slip_force", slip_force, unit="N", zero=True) > 0.0:
        crossover = Crossover(
            slip_force_warp=slip_force,
            slip_force_weft=slip_force,
            stiffness_warp=stiffness,
            stiffness_weft=stiffness,
        )
        return replace(cloth, crossover=crossover)
    if cloth.crossover is None or cloth.crossover.slip_force_warp == 0.0:
        raise InputError(
            f"slip_force = 0 takes that of the fabric, and {cloth.name!r} has none: give one"
        )
    return cloth


def _mesh(length: float, edge: float, sides: int) -> FlatMesh:
    """Squares, and a tab of two triangles half a square long at the end of the middle bundle."""
    rows = round(length / positive("edge", edge, unit="m"))
    if rows < 1 or abs(rows * edge - length) > 1e-6 * length:
        raise InputError(f"length = {length:g} m must be a multiple of edge = {edge:g} m")
    if not isinstance(sides, int) or sides < 1:
        raise InputError(f"sides = {sides!r} must be a whole number, 1 or more")
    x, y = edge * np.arange(rows + 1), edge * np.arange(-sides, sides + 1)
    points, triangles = squares(x, y, crossed=False)
    mouth = sides * (rows + 1) + rows
    below, above, tip = mouth - rows - 1, mouth + rows + 1, len(points)
    tab = [(mouth, tip, above), (mouth, below, tip)]
    points = np.vstack([points, [[length + 0.5 * edge, 0.0]]])
    return FlatMesh(points, np.vstack([triangles, tab]).astype(np.int32))


if __name__ == "__main__":
    from warpdrape.cli import run_script

    run_script(__file__)
