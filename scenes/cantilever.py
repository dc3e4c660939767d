"""A strip hangs over an edge under its own weight: Peirce's cantilever test (ASTM D1388)."""

import math

import numpy as np

from warpdrape import Clamp, Numerics, Ply, Result, Scene
from warpdrape.coupons.closed_forms import flexural_length
from warpdrape.errors import InputError, one_of
from warpdrape.materials.bending import BendingCurve, from_flexural_length
from warpdrape.materials.fabric_library import with_bending
from warpdrape.units import mm

GRAVITY = 9.81
SOFTENING = 36.0
"""Divides the yarns' tensions: they carry a strip's weight, and set the step."""
SETTLED = 10.0
"""Time for which the strip settles, critically damped, in units of 1/ω of its lowest mode [-]."""


def build(
    *,
    fabric: str = "carbon_interlock",
    bending: str = "fabric",
    family: str = "warp",
    overhang: float = 0.0,
    width: float = 25 * mm,
    cells: int = 24,
    mesh: str = "diagonal",
) -> Scene:
    """Build the strip, held along the platform's edge.

    Args:
        fabric: name or file of a fabric.
        bending: "fabric" for its own, "none", or a stiffness in all directions [N·m].
        family: "warp" or "weft", the yarns along the strip.
        overhang: length that hangs over [m]; 0 for that at which the chord should fall to 41.5°.
        width: of the strip [m].
        cells: squares of two triangles along the overhang.
        mesh: "diagonal", "grid" or "random".
    """
    parameters = dict(locals())
    one_of("family", family, ("warp", "weft"))
    cloth = with_bending(fabric, bending)
    if not cloth.bends:
        raise InputError("a cantilever test needs a fabric that resists bending: give bending")
    if isinstance(cloth.bending, BendingCurve):
        stiffness = cloth.bending.in_plane[family == "weft"]  # of yarns whose fibres have slid
    else:
        stiffness = getattr(cloth.bending, family)
    if stiffness == 0.0:
        raise InputError(
            f"family = {family}: bending.{family} of {cloth.name!r} is 0 N·m, and a strip without "
            "stiffness hangs straight down; take the other family, or give bending"
        )
    length = overhang or 2.0 * (stiffness / (GRAVITY * cloth.areal_density)) ** (1.0 / 3.0)
    angle = 0.0 if family == "warp" else -0.5 * math.pi
    strip = Ply.rectangle(
        "strip", cloth, length, width, edge=length / cells, mesh=mesh, warp_angle=angle
    )
    lowest = 3.516 * math.sqrt(stiffness / cloth.areal_density) / length**2
    softest = min(SOFTENING, 1.0 / cloth.compressive_factor)
    return Scene(
        name="cantilever",
        plies=[strip],
        clamps=[Clamp(name="platform", ply="strip", where=lambda p: p[:, 0] < -0.4999 * length)],
        duration=SETTLED / lowest,
        gravity=(0.0, 0.0, -GRAVITY),
        self_contact=False,
        numerics=Numerics(damping=2.0 * lowest, yarn_softening=softest),
        parameters=parameters,
        report=lambda result: {"cantilever": read_strip(result, length, cloth.areal_density)},
    )


def read_strip(result: Result, overhang: float, areal_density: float) -> dict[str, float]:
    """Angle of the chord, and the flexural length and bending stiffness that it tells."""
    strip = result.plies[0]
    tip = strip.points[strip.rest_points[:, 0] > 0.4999 * overhang].mean(axis=0)
    angle = math.atan2(-float(tip[2]), float(tip[0]) + 0.5 * overhang)
    length = flexural_length(overhang, angle)
    return {
        "overhang_m": overhang,
        "chord_angle_deg": float(np.degrees(angle)),
        "flexural_length_m": length,
        "bending_stiffness_n_m": from_flexural_length(length, areal_density),
    }


if __name__ == "__main__":
    from warpdrape.cli import run_script

    run_script(__file__)
