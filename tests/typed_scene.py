"""A user's scene, all of it typed: what the public API promises must satisfy a type checker."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import warpdrape as wd
from warpdrape.laws import LinearTension, ShearPolynomial, ShearTable
from warpdrape.units import deg, kN, mm


def fabric() -> wd.Fabric:
    return wd.Fabric(
        name="mine",
        areal_density=0.6,
        thickness=0.6 * mm,
        cell_warp=2.0 * mm,
        cell_weft=2.0 * mm,
        tension=LinearTension(30.0 * kN, 30.0 * kN),
        shear=ShearPolynomial((1e-4, 0.0, 2e-4)),
        bending=wd.Bending(warp=1e-3, weft=1e-3),
    )


def left(points: NDArray[np.float64]) -> NDArray[np.bool_]:
    return points[:, 0] < 0.0


def build(*, cells: int = 8, angle_deg: float = 0.0, cloth: str = "carbon_interlock") -> wd.Scene:
    low = wd.Ply.rectangle("low", cloth, 200 * mm, cells=cells, warp_angle=angle_deg * deg)
    high = wd.Ply.polygon("high", fabric(), [(0.0, 0.0), (0.1, 0.0), (0.0, 0.1)], edge=10 * mm)
    disc = wd.Ply.disc("disc", fabric(), 90 * mm, edge=10 * mm)
    plies = wd.lay_up([low, high, disc])
    punch = wd.Tool.punch(radius=75 * mm, motion=wd.Stroke(travel=(0.0, 0.0, -0.05), duration=0.05))
    holder = wd.Tool.blank_holder(
        hole_radius=88 * mm, outer_radius=0.2, motion=wd.Float(force=100.0, mass=1.0)
    )
    top: float = wd.stack_top(plies)
    return wd.Scene(
        name="typed",
        plies=plies,
        tools=[punch.moved((0.0, 0.0, top)), holder],
        clamps=[wd.Clamp(name="edge", ply="low", where=left)],
        pressures=[wd.Pressure(name="air", ply="high", pressure=[(0.0, 0.0), (0.01, 1e3)])],
        springs=[wd.Spring(name="s", ply="low", where=left, to=(0.1, 0.0, 0.0), stiffness=100.0)],
        duration=0.06,
        friction=0.2,
        ply_friction=wd.Friction(coefficient=0.3),
        numerics=wd.Numerics(yarn_softening=36.0),
    )


def run(folder: Path) -> float:
    result = build().run(folder, frames=5, threads=1, device="cpu", quiet=True)
    if not result.completed:
        raise SystemExit(result.summary["message"])
    ply = result.ply("low")
    thickness: float = build().plies[0].fabric.thickness
    largest = float(np.degrees(np.abs(ply.shear_angle).max()))
    points: NDArray[np.float64] = ply.points
    force: NDArray[np.float64] = result.history["punch_force_z_n"]
    again = wd.read_run(folder)
    again.plot()
    return largest + thickness + float(points[0, 2]) + float(force[-1])


def refuse() -> str:
    try:
        ShearTable(angles=[0.0, 0.1], couples=[0.0, 1.0])
        LinearTension(30.0 * kN, 30.0 * kN)
    except wd.InputError as error:
        return str(error)
    except wd.RunFailed as error:
        return str(error)
    return ""
