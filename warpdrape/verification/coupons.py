"""The coupon tests against their closed forms."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import cast

import numpy as np

from warpdrape.commands.scene_library import find_script
from warpdrape.materials.fabric_library import load_fabric
from warpdrape.materials.laws import CrimpInterchange
from warpdrape.results.run_folder import COUPON
from warpdrape.verification.case import CaseResult, absolute, relative
from warpdrape.verification.locking import MESHES, measure_locking

LIMITS = (0.05, 1.0, 1.5)
"""Bias extension: force [-], mean shear of the middle zone [deg] and its scatter [deg]."""
KNOWN_ERRORS = {
    ("grid", 15.0): (0.05, 1.1, 1.9),
    ("grid", 22.5): (0.05, 1.0, 2.3),
    ("grid", 30.0): (0.05, 1.0, 3.0),
}
"""The same for meshes that are known to miss ``LIMITS``: they must not get worse than this."""
FINENESS = (0.01, 0.005, 0.0025)
"""Mesh sizes of the convergence study [m]."""
RMS_LIMIT = 1.0
"""Largest rms error of the shear angle on the finest of them [deg]; in proportion on the others."""


def picture_frame(quick: bool, folder: Path) -> list[CaseResult]:
    """Force from 10° to 55°, at the angle where it is farthest off; also on a random mesh."""
    cases = []
    for mesh in ("random",) if quick else ("aligned", "diagonal", "random"):
        run = folder / f"picture_frame_{mesh}"
        edge = 0.02 if quick else 0.005
        built = find_script("picture_frame").build(mesh=mesh, edge=edge, duration=0.08)
        built.run(run, frames=110, overwrite=True)
        name = f"picture frame, {mesh}: force from 10° to 55°, at its worst"
        cases.append(relative(name, *worst_force(run, 10.0), 0.01, "N"))
    return cases


def worst_force(run: Path, least: float) -> tuple[float, float]:
    """Force of a coupon where it is farthest from its closed form, and that [N].

    Args:
        run: its folder.
        least: shear angle from which on they are compared [deg].
    """
    curve = np.genfromtxt(run / COUPON, delimiter=",", names=True)
    wanted = curve[curve["shear_angle_deg"] >= least]
    off = np.abs(wanted["force_n"] / wanted["closed_form_force_n"] - 1.0)
    worst = wanted[np.argmax(off)]
    return float(worst["force_n"]), float(worst["closed_form_force_n"])


def bias_extension(quick: bool) -> Iterator[CaseResult]:
    """Force and middle zone at 20° and 40°, with yarns that do not shorten either."""
    meshes = (("aligned", 0.0),) if quick else MESHES
    for mesh, turn in meshes:
        rows = measure_locking(
            mesh, turn, edge=0.0125 if quick else 0.005, duration=0.04 if quick else 0.06
        )
        known = KNOWN_ERRORS.get((mesh, turn), LIMITS)
        where = mesh + (f" turned {turn:g}°" if turn else "")
        for row in rows:
            name = f"bias extension, {where}, {row.angle_deg:g}°"
            mean, spread = row.shear_mean_deg, row.shear_scatter_deg
            force = f"{name}: force over closed form"
            yield relative(force, row.force_ratio, 1.0, LIMITS[0], known=known[0])
            zone = f"{name}: middle zone, mean shear"
            yield absolute(zone, mean, row.angle_deg, LIMITS[1], "°", known[1])
            yield absolute(f"{name}: … scatter", spread, 0.0, LIMITS[2], "°", known[2])


def convergence() -> Iterator[CaseResult]:
    """Bias extension on ever finer random meshes: the middle zone's deviation and its rate."""
    off = []
    for edge in FINENESS:
        row = measure_locking("random", 0.0, edge=edge, duration=0.03)[-1]
        off.append(row.shear_rms_deg)
        name = f"bias extension, random, {1e3 * edge:g} mm, {row.angle_deg:g}°"
        limit = RMS_LIMIT * edge / FINENESS[-1]
        yield absolute(f"{name}: rms of shear error", row.shear_rms_deg, 0.0, limit, "°")
    finest = f"{name}: force over closed form"
    yield relative(finest, row.force_ratio, 1.0, LIMITS[0])
    rate = float(np.polyfit(np.log(FINENESS), np.log(off), 1)[0])
    yield absolute("bias extension, random: rate of the rms error", rate, 1.0, 0.6)


def biaxial_tension(quick: bool, folder: Path) -> list[CaseResult]:
    """Crimp interchange: warp and weft force at equal and at unequal strains."""
    cases = []
    fabric = load_fabric("synthetic_plain_crimp")
    law = cast(CrimpInterchange, fabric.tension)
    uneven = replace(fabric, tension=replace(law, crimp_weft=0.012))
    for name, cloth, weft in (
        ("equal strains", fabric, 0.01),
        ("weft held", fabric, 0.0),
        ("unequal crimp", uneven, 0.004),
    ):
        run = folder / f"biaxial_{name.replace(' ', '_')}"
        built = find_script("biaxial_tension").build(
            fabric=cloth,
            weft_strain=weft,
            edge=0.02 if quick else 0.005,
            mesh="random",
            duration=0.01,
        )
        coupon = built.run(run, overwrite=True).summary["coupon"]
        for family in ("warp", "weft"):
            cases.append(
                relative(
                    f"biaxial tension, {name}: {family} force",
                    coupon[f"{family}_force_n"],
                    coupon[f"closed_form_{family}_force_n"],
                    1e-6,
                    "N",
                )
            )
    return cases
