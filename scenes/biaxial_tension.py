"""Biaxial tension: a square sample stretched along warp and weft at once."""

import numpy as np

from warpdrape import Clamp, Fabric, InputError, Ply, Scene, Stroke
from warpdrape.coupons.coupon import (
    check_woven,
    coupon_files,
    coupon_mesh,
    coupon_numerics,
    stretch_curve,
)
from warpdrape.errors import positive

STRETCHING = 0.9
"""Share of the run in which the sample is stretched; then it is held and comes to rest [-]."""


def build(
    *,
    fabric: str | Fabric = "synthetic_plain_crimp",
    side: float = 0.1,
    edge: float = 0.005,
    mesh: str = "aligned",
    warp_strain: float = 0.01,
    weft_strain: float = 0.01,
    duration: float = 0.02,
    damping: float = 1e5,
    averaging: str = "pairs",
    approach: str = "semi_discrete",
) -> Scene:
    """Build a biaxial test of a square held at its whole border, warp along x.

    Args:
        fabric: a fabric, or the name or file of one; it must have yarns.
        side: of the sample [m].
        edge: mesh size [m].
        mesh: "aligned" to the yarns, "crossed", "diagonal", "grid" or "random".
        warp_strain: at the end [-].
        weft_strain: at the end, reached together with it [-].
        duration: of the run, the last tenth at rest [s].
        damping: mass-proportional rate [1/s].
        averaging: "pairs" of triangles share yarn strains, or "plain".
        approach: "semi_discrete", or "yarns", chains of bars.
    """
    parameters = {**locals(), "fabric": getattr(fabric, "name", fabric)}
    ends = np.array(
        [
            positive("warp_strain", warp_strain, zero=True),
            positive("weft_strain", weft_strain, zero=True),
        ]
    )
    if not 0.0 < ends.max() <= 0.5:
        raise InputError(
            f"warp_strain = {warp_strain} and weft_strain = {weft_strain}: the larger must lie "
            "above 0 and not above 0.5 (a fraction, 0.01 for 1 %)"
        )
    positive("side", side, unit="m")
    flat = coupon_mesh(side, side, edge, mesh, warp_angle=0.0)
    ply = Ply(name="ply_0", fabric=fabric, mesh=flat)
    check_woven(ply.fabric)
    rise = Stroke(travel=(1.0, 0.0, 0.0), duration=STRETCHING * duration)

    def strains(time: np.ndarray) -> np.ndarray:
        return rise.displacement(time)[..., :1] * ends

    def stretch(time: np.ndarray) -> np.ndarray:
        matrix = np.zeros((*np.shape(time), 3, 3))
        matrix[..., [0, 1], [0, 1]] = 1.0 + strains(time)
        matrix[..., 2, 2] = 1.0
        return matrix

    def clamp(name: str, where) -> Clamp:
        return Clamp(name=name, ply="ply_0", where=where, matrix=stretch)

    last = (0.5 - 1e-6) * side
    return Scene(
        name="biaxial_tension",
        plies=[ply],
        clamps=[
            clamp("rest", lambda p: np.abs(p[:, :2]).max(axis=1) > last),
            clamp("right", lambda p: p[:, 0] > last),
            clamp("upper", lambda p: p[:, 1] > last),
            clamp("corner", lambda p: p[:, :2].min(axis=1) > last),
        ],
        duration=duration,
        gravity=(0.0, 0.0, 0.0),
        self_contact=False,
        numerics=coupon_numerics(averaging, damping),
        approach=approach,
        parameters=parameters,
        **coupon_files(lambda result: stretch_curve(result, ply.fabric, side, strains)),
    )


if __name__ == "__main__":
    from warpdrape.cli import run_script

    run_script(__file__)
