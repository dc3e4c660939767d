"""The tests run again by the simulator with the new card: coupons of the laboratory's own sizes."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import cast

import numpy as np

from warpdrape.calibration.fits import Fits
from warpdrape.calibration.shear import ShearFit
from warpdrape.calibration.tests_file import Plan, Test
from warpdrape.commands.scene_library import find_script
from warpdrape.materials.bending import Bending, BendingCurve
from warpdrape.materials.fabric import Fabric
from warpdrape.results.run_folder import COUPON

CELLS = 14
"""Edges of the mesh along a specimen's shorter side."""
MOST_SHEAR = math.radians(60.0)
"""Shear angle at which a coupon ends, whatever its test [rad]."""
FRAMES = 60


@dataclass(frozen=True, eq=False)
class CouponRun:
    """A coupon's curve beside its test.

    Attributes:
        test: name of the test.
        at: shear angle [rad] or strain [-]; of a cantilever the family's index, shape [n].
        values: force [N], tension per yarn [N] or stiffness [N·m], shape [n].
        calm_from: value of ``at`` from which on inertia bears little of it; None if never.
        wrong: why there is no curve; "" if there is one.
    """

    test: str
    at: np.ndarray
    values: np.ndarray
    calm_from: float | None = 0.0
    wrong: str = ""


def run_coupons(
    plan: Plan, fits: Fits, fabric: Fabric, say: Callable[[str], None], cells: int = CELLS
) -> list[CouponRun]:
    """Run the coupon of every test that has one, and say which is next.

    Picture frame (the sample fills it), bias extension, biaxial tension to its farthest point, and
    cantilever. Kawabata's loops, strips, sleds and plates have no coupon. A bending curve is
    replaced by its stiffness in the plane, and then a cantilever has none either.

    Args:
        plan: the tests.
        fits: where their data end.
        fabric: of the new card.
        say: takes a line of progress.
        cells: edges of the mesh along a specimen's shorter side.
    """
    found = []
    if isinstance(fabric.bending, BendingCurve):  # the frame's clamps turn, which a curve forbids
        warp, weft = cast(tuple[float, float], fabric.bending.in_plane)  # filled where not given
        fabric = replace(fabric, bending=Bending(warp=warp, weft=weft, twist=fabric.bending.twist))
        by_curve = True
    else:
        by_curve = False
    for test in plan.tests:
        if test.kind in ("picture_frame", "bias_extension"):
            run: Callable = _shear
        elif test.kind == "biaxial_tension":
            run = _biaxial
        elif test.kind == "cantilever" and not by_curve:
            run = _cantilever
        else:
            continue
        say(f"coupon of {test.name} ({test.about.words}) …")
        found += run(test, fits, fabric, cells)
    return found


def _shear(test: Test, fits: Fits, fabric: Fabric, cells: int) -> list[CouponRun]:
    values = test.values
    own = [s for s in fits.shear_apart[test.kind].specimens if s.test == test.name]
    reached = cast(ShearFit, fits.shear).basis.end  # as there is a test of it
    end = min(float(np.median([s.angle[-1] for s in own])), reached, MOST_SHEAR)
    sizes = {"width": values["width"], "height": values["height"]} if "height" in values else {}
    short = values.get("width") or values.get("sample", values.get("side"))
    if not sizes:
        sizes = {"side": short}
    scene = find_script(test.kind).build(
        fabric=fabric, edge=short / cells, shear_angle_deg=math.degrees(end), **sizes
    )
    table, wrong, calm = _run(scene)
    if table is None:
        return [CouponRun(test.name, np.zeros(0), np.zeros(0), None, wrong)]
    force = table["force_n"]
    if test.kind == "picture_frame":  # the frame is longer than its sample
        force = force * short / values["side"]
    angles = np.radians(table["shear_angle_deg"])
    return [CouponRun(test.name, angles, force, None if calm is None else math.radians(calm))]


def _biaxial(test: Test, fits: Fits, fabric: Fabric, cells: int) -> list[CouponRun]:
    own = [b for b in fits.biaxial if b.test == test.name]
    ends = np.mean([b.strains[np.argmax(b.strains.sum(axis=1))] for b in own], axis=0)
    warp, weft = np.maximum(ends, 0.0)
    side = test.values["width"]
    scene = find_script("biaxial_tension").build(
        fabric=fabric, side=side, edge=side / cells, warp_strain=warp, weft_strain=weft
    )
    table, wrong, calm = _run(scene)
    if table is None:
        return [CouponRun(test.name, np.zeros(0), np.zeros(0), None, wrong)]
    width = np.array(fabric.yarn_width) / side
    runs = []
    for number, family in enumerate(("warp", "weft")):
        runs.append(
            CouponRun(
                f"{test.name}, {family}",
                table[f"{family}_strain"],
                table[f"{family}_force_n"] * width[number],
                calm,
            )
        )
    return runs


def _cantilever(test: Test, fits: Fits, fabric: Fabric, cells: int) -> list[CouponRun]:
    scene = find_script("cantilever").build(
        fabric=fabric, family=test.values["family"], cells=max(16, cells)
    )
    result = scene.run(quiet=True, frames=20)
    if not result.completed:
        return [CouponRun(test.name, np.zeros(0), np.zeros(0), None, result.summary["message"])]
    stiffness = result.summary["cantilever"]["bending_stiffness_n_m"]
    return [CouponRun(test.name, np.zeros(1), np.array([stiffness]))]


def _run(scene) -> tuple[np.ndarray | None, str, float | None]:
    """The curve of a coupon, what went wrong, and from where on it is quasi-static."""
    with tempfile.TemporaryDirectory() as folder:
        result = scene.run(folder, frames=FRAMES, quiet=True, overwrite=True)
        if not result.completed:
            return None, result.summary["message"], None
        table = np.genfromtxt(Path(folder) / COUPON, delimiter=",", names=True)
    entries = result.summary["coupon"]
    calm = next(v for k, v in entries.items() if k.startswith("quasi_static_from"))
    return table, "", calm
