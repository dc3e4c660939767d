"""Waves of a flange between a flat die and a blank holder, against their least energy."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, cast

import numpy as np

from warpdrape import Clamp, Float, Numerics, Ply, Pressure, Scene, Stroke, Tool, lay_up, stack_top
from warpdrape.materials.laws import IsotropicMembrane
from warpdrape.verification.case import CaseResult, relative
from warpdrape.verification.wrinkling import sheet

FOLD = {"bending": 1e-3, "pressure": 100.0, "shortening": 0.01}
"""Of a flange: flexural stiffness [N·m], holder's pressure [Pa], shortening [-]."""


def flange_wavelength(bending: float, pressure: float, shortening: float) -> float:
    """λ = π (4 B √e/p)^⅓ of waves between a flat die and a rigid holder [m].

    A wave of amplitude a = λ√e/π takes up the shortening e. It stores 4π²B e/λ² per area in
    bending, and lifts the holder by 2a against its pressure, 2pλ√e/π: the sum is least there.
    Bending alone makes waves long, the holder makes them short. Derived here; Cao and Wang (2000)
    balance energies for a plate under a normal pressure likewise.

    Args:
        bending: B [N·m].
        pressure: p of the holder on the flat flange [Pa].
        shortening: e [-].
    """
    return math.pi * (4.0 * bending * math.sqrt(shortening) / pressure) ** (1.0 / 3.0)


def flange_force(bending: float, pressure: float, shortening: float) -> float:
    """Compression along a flange of such waves, 2 p λ/(π √e) [N/m]: its energy's slope by e.

    Of 4π²B e/λ² + 2pλ√e/π, whose parts give half of it each. Arguments as for
    `flange_wavelength`.
    """
    wave = flange_wavelength(bending, pressure, shortening)
    return 2.0 * pressure * wave / (math.pi * math.sqrt(shortening))


def longest_wave_by_friction(friction: float, reach: float, shortening: float) -> float:
    """½ π √e μ L, the longest wave that friction between two plies can raise under a holder [m].

    Another ply drags a flange along with μ p at most: μ p L over a reach. `flange_force` asks for
    2 p λ/(π √e), so that the holder's pressure is in both and falls out. Derived here.

    Args:
        friction: μ between the plies [-].
        reach: L, over which one slides on the other [m].
        shortening: e of the flange [-].
    """
    return 0.5 * math.pi * math.sqrt(shortening) * friction * reach


def flange_scene(length: float, cells: int, duration: float = 0.2) -> Scene:
    """One wave of a flange: a strip held in two troughs, which come nearer to each other.

    The holder weighs little until the wave stands, raised by air from below; then it has its force.

    Args:
        length: of the strip, a wavelength before shortening [m].
        cells: squares along it; a sixth of that across.
        duration: of the run [s].
    """
    width = length / 6.0
    whole = FOLD["pressure"] * length * width
    fabric = sheet(1e5, FOLD["bending"], 0.3)
    edge = length / cells
    (ply,) = lay_up([Ply.rectangle("strip", fabric, length, width, edge=edge, mesh="diagonal")])
    top = (0.0, 0.0, stack_top([ply]))
    times = (0.0, 0.4 * duration, 0.7 * duration)
    press = Float(
        force=list(zip(times, (0.02 * whole, 0.02 * whole, whole), strict=True)),
        mass=0.3 * length * width,
        damping=2.0 * whole,
    )
    plate: dict[str, Any] = {"width": 2.0 * length, "height": 2.0 * width}
    holder = Tool.plate("holder", facing="down", motion=press, **plate).moved(top)

    def end(name: str, side: float) -> Clamp:
        way = (-0.5 * side * FOLD["shortening"] * length, 0.0, 0.0)
        return Clamp(
            name=name,
            ply="strip",
            where=lambda p: side * p[:, 0] > 0.5 * length - 1e-9,
            motion=Stroke(travel=way, duration=0.4 * duration),
            follow=(1.0, 0.0, 0.0),
        )

    rise = 0.3 * FOLD["pressure"]
    air = [(0.0, 0.0), (0.02 * duration, rise), (0.1 * duration, rise), (0.2 * duration, 0.0)]
    return Scene(
        name="flange",
        plies=[ply],
        tools=[Tool.plate("die", **plate), holder],
        clamps=[end("left", -1.0), end("right", 1.0)],
        pressures=[Pressure(name="air", ply="strip", pressure=air, side="lower")],
        duration=duration,
        gravity=(0.0, 0.0, 0.0),
        friction=0.0,
        self_contact=False,
        numerics=Numerics(damping=150.0),
    )


def flange(quick: bool) -> Iterator[CaseResult]:
    """Waves of several lengths under a holder: which costs least, and what it does to the holder.

    Waves of any length stand between die and holder, and which of them a flange takes depends on
    how it came there. The closed form says which one is cheapest.
    """
    exact = flange_wavelength(**FOLD)
    lengths, cells = exact * np.array([0.8, 1.0, 1.25]), 16 if quick else 32
    if not quick:
        lengths = exact * np.array([0.7, 0.8, 0.9, 1.0, 1.1, 1.25, 1.4])
    energies, forces, lifts = np.array([_wave(length, cells) for length in lengths]).T
    fit = np.polynomial.Polynomial.fit(np.log(lengths), energies, 2 if quick else 4)
    fine = np.linspace(math.log(lengths[0]), math.log(lengths[-1]), 2001)
    cheapest = math.exp(fine[np.argmin(fit(fine))])
    yield relative("flange under a holder: wavelength of least energy", cheapest, exact, 0.1, "m")
    middle = int(np.argmin(np.abs(lengths - exact)))
    yield relative("… force along it", forces[middle], flange_force(**FOLD), 0.1, unit="N/m")
    high = 2.0 * exact * math.sqrt(FOLD["shortening"]) / math.pi
    yield relative("… way of the holder", lifts[middle], high, 0.1, unit="m")


def _wave(length: float, cells: int) -> tuple[float, float, float]:
    """Energy per area [J/m²], compression [N/m] and height [m] of a wave under the holder."""
    scene = flange_scene(length, cells)
    result = scene.run(frames=4, threads=1)
    width = length / 6.0
    bent = float(result.history["bending_j"][-1]) / (length * width)
    force = -float(result.history["right_force_n"][-1]) / width
    z = result.plies[0].points[:, 2]
    high = float(z.max() - z.min())
    membrane = cast(IsotropicMembrane, scene.plies[0].fabric.tension)  # of `sheet`
    squeezed = 0.5 * force**2 / membrane.stiffness
    return bent + squeezed + FOLD["pressure"] * high, force, high
