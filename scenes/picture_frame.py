"""Picture frame: a square sample in a hinged frame that is pulled along its diagonal."""

import math

import numpy as np

from warpdrape import Clamp, Fabric, Ply, Scene
from warpdrape.coupons.closed_forms import (
    check_shear_angle,
    frame_angle,
    frame_force,
    frame_travel,
)
from warpdrape.coupons.coupon import (
    Curve,
    check_woven,
    coupon_files,
    coupon_mesh,
    coupon_numerics,
    process_rate,
    shear_curve,
    steady_pull,
)
from warpdrape.errors import positive
from warpdrape.units import deg


def build(
    *,
    fabric: str | Fabric = "carbon_interlock",
    side: float = 0.1,
    edge: float = 0.005,
    mesh: str = "aligned",
    mesh_angle_deg: float = 0.0,
    shear_angle_deg: float = 55.0,
    duration: float = 0.1,
    damping: float = 20.0,
    averaging: str = "pairs",
    process_duration: float = 0.0,
    temperature: float = 0.0,
    approach: str = "semi_discrete",
) -> Scene:
    """Build a picture-frame test; the sample fills the frame, yarns along its sides.

    Args:
        fabric: a fabric, or the name or file of one.
        side: of frame and sample [m].
        edge: mesh size [m].
        mesh: "aligned" to the yarns, "crossed", "diagonal", "grid" or "random".
        mesh_angle_deg: turn of a "grid" against the frame [deg].
        shear_angle_deg: shear angle at the end [deg].
        duration: of the pull; inertia bears little of the force from 3° on [s].
        damping: mass-proportional rate [1/s].
        averaging: "pairs" of triangles share yarn strains, or "plain".
        process_duration: time that the test takes for the pull, for a fabric with a viscous
            matrix; 0 for one without [s].
        temperature: of the sample, likewise; 0 for that at which its viscosity is given [K].
        approach: "semi_discrete"; stress as a state, "green_naghdi" or "fibre_frame"; or
            "yarns", chains of bars, or "sliding_yarns", not pinned.
    """
    parameters = {**locals(), "fabric": getattr(fabric, "name", fabric)}
    angle = check_shear_angle("shear_angle_deg", shear_angle_deg)
    positive("side", side, unit="m")
    flat = coupon_mesh(side, side, edge, mesh, warp_angle=0.0, mesh_angle=mesh_angle_deg * deg)
    ply = Ply(name="ply_0", fabric=fabric, mesh=flat, temperature=temperature or None)
    check_woven(ply.fabric)
    pull = steady_pull((float(frame_travel(side, angle)), 0.0, 0.0), duration)

    def travel(time: np.ndarray) -> np.ndarray:
        return pull.displacement(time)[..., 0]

    def hinge(time: np.ndarray) -> np.ndarray:
        half = frame_angle(side, travel(time)) / 2
        matrix = np.zeros((*np.shape(time), 3, 3))
        matrix[..., 0, 0] = matrix[..., 1, 1] = np.cos(half)
        matrix[..., 0, 1] = matrix[..., 1, 0] = np.sin(half)
        matrix[..., 2, 2] = 1.0
        return matrix

    def force(result, angles: np.ndarray) -> np.ndarray:
        times, pace = result.history["loading_time_s"], duration / (process_duration or np.inf)
        rate = process_rate(lambda time: frame_angle(side, travel(time)), times, pace)
        return frame_force(ply.fabric, side, angles, rate=rate, temperature=ply.temperature)

    def curve(result) -> Curve:
        return shear_curve(
            result,
            "frame",
            lambda d: frame_angle(side, d),
            lambda g: force(result, g),
            lambda centers: np.ones(len(centers), dtype=bool),
        )

    def on_border(points: np.ndarray) -> np.ndarray:
        return np.abs(points[:, :2]).max(axis=1) > (0.5 - 1e-6) * side

    frame = Clamp(
        name="frame",
        ply="ply_0",
        where=on_border,
        matrix=hinge,
        travel=travel,
        follow=(math.sqrt(0.5), math.sqrt(0.5), 0.0),
    )
    return Scene(
        name="picture_frame",
        plies=[ply],
        clamps=[frame],
        duration=duration,
        process_duration=process_duration or None,
        gravity=(0.0, 0.0, 0.0),
        self_contact=False,
        numerics=coupon_numerics(averaging, damping),
        approach=approach,
        parameters=parameters,
        **coupon_files(curve),
    )


if __name__ == "__main__":
    from warpdrape.cli import run_script

    run_script(__file__)
