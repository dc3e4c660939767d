"""Prepregs: forces by rate and temperature, and what is left when motion stops.

The picture frame is the bundled scene. After a stop the work of a frame tells no force: another one
creeps on at a hundredth of its rate.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicHermiteSpline

from warpdrape import Clamp, Fabric, Matrix, Numerics, Ply, Scene
from warpdrape.commands.scene_library import find_script
from warpdrape.coupons.closed_forms import couple_per_area, wet_couple
from warpdrape.materials.fabric_library import load_fabric
from warpdrape.materials.viscosity import Newtonian
from warpdrape.units import celsius
from warpdrape.verification.case import CaseResult, relative
from warpdrape.verification.coupons import worst_force
from warpdrape.verification.heat import heat_cases

CARD = "synthetic_prepreg"
TESTS = ((0.5, 260.0), (5.0, 260.0), (50.0, 260.0), (0.5, 220.0), (5.0, 220.0), (50.0, 220.0))
"""Times of the pull [s] and temperatures [°C] of the picture frames."""
LEAST_ANGLE = 10.0
"""Shear angle from which on their forces are compared [deg]."""
LIMIT = 0.01
SIDE = 0.06
"""Of the frame that stops [m]."""
ANGLE, STOP, CREEP = 0.6, 0.6, 0.01
"""Shear angle at which it stops [rad], share of its run until then, rate after that over the
one before [-]."""
FRAMES = 100
GOING, AFTER = 54, 64
"""Frames of the steady rate, and after it."""


def frame_case(process: float, degrees: float, folder: Path, *, quick: bool) -> CaseResult:
    """Force of a picture frame where it is farthest from the closed form.

    Args:
        process: time of the pull in the test [s].
        degrees: temperature [°C].
        folder: for the run.
        quick: whether the mesh is coarse.
    """
    run = folder / f"prepreg_frame_{process:g}s_{degrees:g}C"
    built = find_script("picture_frame").build(
        fabric=CARD,
        edge=0.025 if quick else 0.01,
        duration=0.08,
        process_duration=process,
        temperature=celsius(degrees),
    )
    built.run(run, frames=60, overwrite=True)
    name = f"prepreg in a picture frame, {process:g} s, {degrees:g} °C: force from 10°"
    return relative(name, *worst_force(run, LEAST_ANGLE), LIMIT, "N")


class Turned(NamedTuple):
    """A ply in a hinged frame that turns at a steady rate, and then hardly at all.

    Attributes:
        times: of the process [s], shape [frame]: the middles of what couples are means of.
        angle: γ then [rad], shape [frame].
        rate: of the angle [1/s], shape [frame].
        couple: per area, by the work of the frame [N/m], shape [frame].
        profile: time in the process [s] → rate [1/s].
    """

    times: np.ndarray
    angle: np.ndarray
    rate: np.ndarray
    couple: np.ndarray
    profile: Callable[[np.ndarray], np.ndarray]


def turn_frame(
    fabric: Fabric, process: float, *, duration: float = 0.06, **numerics: Any
) -> Turned:
    """Turn a frame to `ANGLE` by `STOP`, and creep on so that its work goes on telling the couple.

    Args:
        fabric: with a matrix.
        process: time of it all in the process [s].
        duration: simulated time of it all [s].
        numerics: of the run.
    """
    share = np.array([0.0, 0.2 * STOP, 0.96 * STOP, STOP, 1.0])
    rates = np.array([0.0, 1.0, 1.0, CREEP, CREEP])
    gone = np.concatenate([[0.0], np.cumsum(0.5 * (rates[1:] + rates[:-1]) * np.diff(share))])
    scale = ANGLE / gone[3]
    turned = CubicHermiteSpline(share * duration, scale * gone, scale / duration * rates)

    def hinge(time: np.ndarray) -> np.ndarray:
        half = 0.5 * turned(time)
        matrix = np.zeros((*np.shape(time), 3, 3))
        matrix[..., 0, 0] = matrix[..., 1, 1] = np.cos(half)
        matrix[..., 0, 1] = matrix[..., 1, 0] = np.sin(half)
        matrix[..., 2, 2] = 1.0
        return matrix

    border = 0.5 * SIDE - 1e-9
    scene = Scene(
        name="turned_frame",
        plies=[Ply.rectangle("ply", fabric, SIDE, edge=0.012, mesh="random")],
        clamps=[
            Clamp(
                name="frame",
                ply="ply",
                where=lambda p: np.abs(p[:, :2]).max(axis=1) > border,
                matrix=hinge,
            )
        ],
        duration=duration,
        process_duration=process,
        gravity=(0.0, 0.0, 0.0),
        self_contact=False,
        numerics=Numerics(damping=10.0, **numerics),
    )
    history = scene.run(frames=FRAMES).history
    time = history["time_s"]
    middle, gamma = 0.5 * (time[1:] + time[:-1]), turned(time)
    couple = np.diff(history["frame_work_j"]) / (np.diff(gamma) * SIDE**2)
    slower = duration / process

    def profile(at: np.ndarray) -> np.ndarray:
        return turned(at * slower, 1) * slower

    times = middle / slower
    return Turned(times, turned(middle), profile(times), couple, profile)


def stopped() -> Iterator[CaseResult]:
    """A liquid without a spring: the couple is that of the rate, also once that is a hundredth."""
    fabric = load_fabric(CARD)
    found = turn_frame(fabric, 6.0)
    exact = wet_couple(fabric, found.angle, found.rate)
    words = "prepreg in a frame at a steady rate: couple"
    yield relative(words, float(found.couple[GOING]), float(exact[GOING]), LIMIT, "N/m")
    words = "… just after it has slowed to a hundredth"
    yield relative(words, float(found.couple[AFTER]), float(exact[AFTER]), LIMIT, "N/m")


def relaxing() -> CaseResult:
    """With a spring in series Ċ = G γ̇ − C G/(h η), solved by another program."""
    viscosity, modulus = 2e6, 4e6
    matrix = Matrix(viscosity=Newtonian(viscosity), modulus=modulus)
    fabric = replace(load_fabric(CARD), matrix=matrix)
    found = turn_frame(fabric, 5.0)
    stiffness = modulus * fabric.thickness
    solved = solve_ivp(
        lambda t, c: stiffness * found.profile(t) - c * modulus / viscosity,
        (0.0, 5.0),
        [0.0],
        t_eval=found.times,
        rtol=1e-9,
        max_step=0.01,
    )
    exact = solved.y[0] + couple_per_area(fabric, found.angle)
    off = np.abs(found.couple / exact - 1.0)
    worst = GOING + int(np.argmax(off[GOING:]))
    words = "prepreg with a spring in series: couple as it relaxes, at its worst"
    return relative(words, float(found.couple[worst]), float(exact[worst]), LIMIT, "N/m")


def other_clocks() -> Iterator[CaseResult]:
    """The same process in half of the simulated time, and with mass added: the same couple."""
    fabric = load_fabric(CARD)
    one = float(turn_frame(fabric, 6.0).couple[GOING])
    fast = float(turn_frame(fabric, 6.0, duration=0.03).couple[GOING])
    yield relative("the same, simulated twice as fast: couple", fast, one, LIMIT, "N/m")
    heavy = float(turn_frame(fabric, 6.0, minimum_time_step=1.5e-6).couple[GOING])
    yield relative("the same, with mass for a longer step: couple", heavy, one, LIMIT, "N/m")


def prepreg(quick: bool, folder: Path) -> Iterator[CaseResult]:
    """All cases of this file."""
    for process, degrees in (TESTS[0], TESTS[-1]) if quick else TESTS:
        yield frame_case(process, degrees, folder, quick=quick)
    yield from stopped()
    yield relaxing()
    yield from other_clocks()
    yield from heat_cases()
