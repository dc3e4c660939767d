"""Bias extension: a strip with yarns at ±45° to the pull, clamped at its ends."""

import numpy as np

from warpdrape import Clamp, Fabric, InputError, Ply, Scene, Stroke
from warpdrape.coupons.closed_forms import (
    bias_angle,
    bias_force,
    bias_travel,
    check_shear_angle,
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
    width: float = 0.1,
    height: float = 0.2,
    edge: float = 0.005,
    mesh: str = "aligned",
    mesh_angle_deg: float = 0.0,
    shear_angle_deg: float = 40.0,
    duration: float = 0.15,
    damping: float = 20.0,
    averaging: str = "pairs",
    process_duration: float = 0.0,
    temperature: float = 0.0,
    approach: str = "semi_discrete",
) -> Scene:
    """Build a bias-extension test, pulled along ``height``.

    Args:
        fabric: a fabric, or the name or file of one.
        width: of the strip [m].
        height: of the strip between the clamps [m], at least twice the width.
        edge: mesh size [m].
        mesh: "aligned" to the yarns, "crossed", "diagonal", "grid" or "random".
        mesh_angle_deg: turn of a "grid" against the strip [deg].
        shear_angle_deg: shear angle in the middle zone at the end, of inextensible yarns [deg].
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
    positive("width", width, unit="m")
    if positive("height", height, unit="m") < 2.0 * width:
        raise InputError(
            f"height = {height} m over width = {width} m is below 2: the yarns of the middle zone "
            f"would reach the clamps; give a height of at least {2.0 * width:.7g} m"
        )
    angle = check_shear_angle("shear_angle_deg", shear_angle_deg)
    flat = coupon_mesh(
        width, height, edge, mesh, warp_angle=45 * deg, mesh_angle=mesh_angle_deg * deg
    )
    ply = Ply(
        name="ply_0",
        fabric=fabric,
        mesh=flat,
        warp_angle=45 * deg,
        temperature=temperature or None,
    )
    check_woven(ply.fabric)
    pull = steady_pull((0.0, float(bias_travel(width, height, angle)), 0.0), duration)

    def angle_at(time: np.ndarray) -> np.ndarray:
        return bias_angle(width, height, pull.displacement(time)[..., 1])

    def force(result, angles: np.ndarray) -> np.ndarray:
        times, pace = result.history["loading_time_s"], duration / (process_duration or np.inf)
        wet = {"rate": process_rate(angle_at, times, pace), "temperature": ply.temperature}
        return bias_force(ply.fabric, width, height, angles, **wet)

    def curve(result) -> Curve:
        return shear_curve(
            result,
            "upper",
            lambda d: bias_angle(width, height, d),
            lambda g: force(result, g),
            lambda centers: np.abs(centers).sum(axis=1) < 0.5 * (height - width) - edge,
        )

    return Scene(
        name="bias_extension",
        plies=[ply],
        clamps=[_clamp("lower", -0.5 * height), _clamp("upper", 0.5 * height, pull)],
        duration=duration,
        process_duration=process_duration or None,
        gravity=(0.0, 0.0, 0.0),
        self_contact=False,
        numerics=coupon_numerics(averaging, damping),
        approach=approach,
        parameters=parameters,
        **coupon_files(curve),
    )


def _clamp(name: str, level: float, motion: Stroke | None = None) -> Clamp:
    def at_level(points: np.ndarray) -> np.ndarray:
        return np.abs(points[:, 1] - level) < 1e-6 * abs(level)

    options = {} if motion is None else {"motion": motion}
    return Clamp(name=name, ply="ply_0", where=at_level, follow=(0.0, 1.0, 0.0), **options)


if __name__ == "__main__":
    from warpdrape.cli import run_script

    run_script(__file__)
