"""Wrinkles of a stretched sheet, against their closed form and by their least energy."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import cast

import numpy as np

from warpdrape import (
    Bending,
    Clamp,
    Fabric,
    Numerics,
    Ply,
    Pressure,
    Result,
    Scene,
    Stroke,
)
from warpdrape.materials.laws import IsotropicMembrane, NoShear
from warpdrape.verification.case import CaseResult, relative
from warpdrape.verification.fully_wrinkled import SqueezedSheet


def sheet(stiffness: float, bending: float, areal_density: float) -> Fabric:
    """An isotropic sheet that does not contract across a pull.

    Args:
        stiffness: Young's modulus times thickness [N/m].
        bending: flexural stiffness [N·m].
        areal_density: [kg/m²].
    """
    return Fabric(
        name="sheet",
        areal_density=areal_density,
        thickness=1e-4,
        tension=IsotropicMembrane(stiffness, 0.0),
        shear=NoShear(),
        bending=Bending.isotropic(bending),
    )


PULL, SQUEEZE = 0.01, 1.2e-3
"""Strain of a stretched sheet along its length; by how much its ends are squeezed across it [-].

It wrinkles at a squeeze of 5.7e-4. The closed form is for one half sine along the length, the
shape near the threshold.
"""
FAR = 4e-3
"""A squeeze far beyond that, where waves are shorter [-]."""
LENGTH = 0.09
"""Of a stretched sheet [m]."""


def wavelength(bending: float, tension: float, length: float) -> float:
    """λ = 2√π (B/T)^¼ √L of a sheet stretched over a length (Cerda and Mahadevan 2003) [m].

    A wave sin(πx/L) cos(ky) of amplitude a stores ¼ a² (B k⁴ + T π²/L²) per area, and takes up the
    squeeze ¼ a² k²: energy at a given squeeze is least where B k⁴ = T π²/L².

    Args:
        bending: B [N·m].
        tension: T [N/m].
        length: L [m].
    """
    return 2.0 * math.sqrt(math.pi) * (bending / tension) ** 0.25 * math.sqrt(length)


def stretched_sheet(
    wave: float,
    *,
    width: float,
    edge: float,
    stiffness: float = 1e4,
    duration: float = 0.15,
    squeeze: float = SQUEEZE,
) -> Scene:
    """A sheet pulled along x between two hinges, which are then squeezed along y until it wrinkles.

    A weak pressure of air on strips of random widths starts the waves, and is gone before the
    squeeze comes to its end.

    Args:
        wave: wavelength that its bending stiffness is chosen for [m].
        width: along y [m].
        edge: of the mesh [m].
        stiffness: Young's modulus times thickness [N/m].
        duration: of the run [s].
        squeeze: of the ends, at the end [-].
    """
    tension = stiffness * PULL
    bending = tension * wave**4 / (16.0 * math.pi**2 * LENGTH**2)
    ply = Ply.rectangle(
        "sheet", sheet(stiffness, bending, 0.1), LENGTH, width, edge=edge, mesh="diagonal"
    )
    waves = np.random.default_rng(0).uniform((0.0, 0.0), (500.0, 2.0 * math.pi), (40, 2))

    def strips(points: np.ndarray) -> np.ndarray:
        return np.cos(np.outer(points[:, 1], waves[:, 0]) + waves[:, 1]).sum(axis=1) > 0.0

    def squeezed(times: np.ndarray) -> np.ndarray:
        share = np.clip((np.asarray(times) / duration - 0.2) / 0.6, 0.0, 1.0)
        matrix = np.zeros((*np.shape(times), 3, 3))
        matrix[..., [0, 1, 2], [0, 1, 2]] = 1.0
        matrix[..., 1, 1] -= squeeze * share
        return matrix

    def hinge(name: str, side: float, **motion) -> Clamp:
        def end(points: np.ndarray) -> np.ndarray:
            return side * points[:, 0] > 0.5 * LENGTH - 1e-9

        return Clamp(name=name, ply="sheet", where=end, slope="free", matrix=squeezed, **motion)

    pull = Stroke(travel=(PULL * LENGTH, 0.0, 0.0), duration=0.2 * duration)
    air = [(0.0, 0.0), (0.1 * duration, 0.5), (0.25 * duration, 0.0)]
    return Scene(
        name="stretched_sheet",
        plies=[ply],
        clamps=[hinge("left", -1.0), hinge("right", 1.0, motion=pull, follow=(1.0, 0.0, 0.0))],
        pressures=[Pressure(name="air", ply="sheet", pressure=air, where=strips)],
        duration=duration,
        gravity=(0.0, 0.0, 0.0),
        self_contact=False,
        numerics=Numerics(damping=100.0),
    )


def waves_across(result: Result) -> tuple[float, int]:
    """Mean wavelength [m] in the inner half of a stretched sheet's middle line, and half waves."""
    formed = result.plies[0]
    flat = formed.rest_points
    middle = np.abs(flat[:, 0]).min()  # half a cell off, where their number is odd
    line = np.flatnonzero(np.abs(flat[:, 0] - middle) < 1e-9)
    line = line[np.argsort(flat[line, 1])]
    y, z = formed.points[line, 1], formed.points[line, 2]
    inner = np.abs(y) < 0.25 * np.ptp(y)
    height = z - z[inner].mean()
    crossed = np.flatnonzero((height[:-1] * height[1:] < 0.0) & inner[:-1])
    share = height[crossed] / (height[crossed] - height[crossed + 1])
    at = y[crossed] + share * (y[crossed + 1] - y[crossed])
    return 2.0 * float((at[-1] - at[0]) / (len(at) - 1)), len(at) - 1


def stretched_sheets(quick: bool) -> Iterator[CaseResult]:
    """Wavelengths of stretched sheets, near the threshold and far beyond it.

    The tension is that of the run, the force at the end over the width. The inner half of the width
    is counted, away from the free sides; the waves there have room to shift, so that their number
    need not be whole.
    """
    waves, edges = (7.0, 6.0) if quick else (10.0, 10.0)
    cases = ((0.03, SQUEEZE),) if quick else ((0.03, SQUEEZE), (0.02, SQUEEZE), (0.03, FAR))
    for wave, squeeze in cases:
        width = waves * wave
        scene = stretched_sheet(wave, width=width, edge=wave / edges, squeeze=squeeze)
        result = scene.run(frames=4, threads=1)
        tension = float(result.history["right_force_n"][-1]) / width
        fabric, length = scene.plies[0].fabric, LENGTH * (1.0 + PULL)
        membrane, bending = cast(IsotropicMembrane, fabric.tension), cast(Bending, fabric.bending)
        pulled = SqueezedSheet(
            bending=bending.warp,
            tension=tension,
            stiffness=membrane.stiffness,
            length=length,
        )
        found, halves = waves_across(result)
        times = squeeze / pulled.threshold
        name = f"stretched sheet, L/λ = {LENGTH / wave:.3g}"
        if squeeze == SQUEEZE:
            exact = wavelength(bending.warp, tension, length)
            case = f"{name}: wavelength, {halves} half waves"
            yield relative(case, found, exact, 0.1, unit="m")
        exact = pulled.wavelength(squeeze)
        case = f"… by the least energy at {times:.2g} times the threshold"
        if squeeze != SQUEEZE:
            case = f"{name}, squeezed to {times:.2g} times the threshold: by the least energy"
        yield relative(case, found, exact, 0.1 if quick else 0.05, unit="m")
