"""Temperatures of prepregs between plates, on each other and in the air, against closed forms."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from scipy.integrate import solve_ivp

from warpdrape import Air, Fabric, Float, Heat, Matrix, Ply, Result, Scene, Tool, lay_up
from warpdrape.materials.viscosity import Arrhenius, Newtonian
from warpdrape.verification.case import CaseResult, relative
from warpdrape.verification.strip import yarn_fabric

LIMIT = 0.01
HOT = 520.0
"""Temperature of a ply at the start [K]."""
SIDE, DURATION = 0.04, 0.02
"""Of the plies [m]; simulated time [s]."""
STEFAN_BOLTZMANN = 5.670374419e-8
"""σ [W/(m²·K⁴)]."""


def warm_fabric(name: str, **heat: float) -> Fabric:
    """A fabric whose matrix holds heat: 900 J/(m²·K), 300 W/(m²·K) to a tool, or as given."""
    shift = Arrhenius(activation_energy=5e4, reference_temperature=HOT, lowest_temperature=300.0)
    held = Heat(**({"capacity": 900.0, "conductance": 300.0} | heat))
    matrix = Matrix(viscosity=Newtonian(1e4), shift=shift, heat=held)
    return replace(yarn_fabric(1e5, 0.6), name=name, matrix=matrix)


def plate(name: str, fabric: Fabric, temperature: float = HOT, *, cells: int = 4) -> Ply:
    """A flat square ply at a temperature [K]."""
    return Ply.rectangle(name, fabric, SIDE, cells=cells, mesh="grid", temperature=temperature)


def pressed(
    plies: Sequence[Ply], process: float, *, tools: Sequence[float | None], air: Air | None = None
) -> Result:
    """Plies between two plates of given temperatures, None for one that passes no heat.

    Args:
        plies: to be laid up, all of one thickness.
        process: time of it all in the process [s].
        tools: temperatures of the lower and the upper plate [K]; of one, there is no upper plate,
            and the plies weigh enough to lie on it.
        air: round them.
    """
    press = Float(force=20.0, mass=0.05, ramp=2e-4)
    top = Tool.plate("top", width=0.1, height=0.1, facing="down", motion=press)
    bottom = Tool.plate("bottom", width=0.1, height=0.1)
    thickness = sum(ply.fabric.thickness for ply in plies)
    pair = [bottom, top.moved((0.0, 0.0, thickness))]
    scene = Scene(
        name="plates",
        plies=lay_up(plies),
        tools=[replace(t, temperature=k) for t, k in zip(pair, tools, strict=False)],
        duration=DURATION,
        process_duration=process,
        air=air,
        gravity=(0.0, 0.0, -50.0 if len(tools) == 1 else 0.0),
    )
    return scene.run(frames=10)


def passed(result: Result, process: float) -> np.ndarray:
    """Time of the process at the frames [s]."""
    return result.history["time_s"] / DURATION * process


def between_plates(process: float = 3.0, *, tools: tuple[float, float] = (360.0, 400.0)):
    """Mean temperature over time of a ply pressed between two plates, and the closed form [K].

    Args:
        process: time of it all in the process [s].
        tools: temperatures of the lower and the upper plate [K].
    """
    result = pressed([plate("ply", warm_fabric("warm"))], process, tools=tools)
    rate, goal = 2.0 * 300.0 / 900.0, 0.5 * sum(tools)
    exact = goal + (HOT - goal) * np.exp(-rate * passed(result, process))
    return result.history["ply_mean_temperature_k"], exact


def on_each_other(process: float = 2.0, *, cells: tuple[int, int] = (4, 4)):
    """Difference of two plies' temperatures over time, and the closed form [K]; plies, result.

    They hold 900 and 600 J/(m²·K) and meet with 500 and 1000 W/(m²·K), 667 together: the difference
    falls at the rate H (1/C₁ + 1/C₂), and heat is kept.

    Args:
        process: time of it all in the process [s].
        cells: of their meshes.
    """
    lower = plate("lower", warm_fabric("one", between=500.0), HOT, cells=cells[0])
    other = warm_fabric("other", capacity=600.0, between=1000.0)
    upper = plate("upper", other, 400.0, cells=cells[1])
    result = pressed([lower, upper], process, tools=(None, None))
    means = [result.history[f"{name}_mean_temperature_k"] for name in ("lower", "upper")]
    rate = 2.0 / (1.0 / 500.0 + 1.0 / 1000.0) * (1.0 / 900.0 + 1.0 / 600.0)
    exact = (HOT - 400.0) * np.exp(-rate * passed(result, process))
    return means[0] - means[1], exact, (lower, upper), result


def in_the_air(air: Air, process: float, *, emissivity: float, tools: Sequence[float | None] = ()):
    """Mean temperature over time of a ply in the air, and the answer of another program [K].

    Args:
        air: round it.
        process: time of it all in the process [s].
        emissivity: of its faces [-].
        tools: temperatures of the plates on which it lies; with one a face is covered.
    """
    result = pressed(
        [plate("ply", warm_fabric("warm", emissivity=emissivity))], process, tools=tools, air=air
    )
    faces = 2 - len(tools)
    known = [kelvin for kelvin in tools if kelvin is not None]

    def fall(_: float, kelvin: np.ndarray) -> np.ndarray:
        out = air.convection * (kelvin - air.temperature)
        out += emissivity * STEFAN_BOLTZMANN * (kelvin**4 - air.temperature**4)
        return -(faces * out + sum(300.0 * (kelvin - tool) for tool in known)) / 900.0

    times = passed(result, process)
    solved = solve_ivp(fall, (0.0, process), [HOT], t_eval=times, rtol=1e-9, atol=1e-9)
    return result.history["ply_mean_temperature_k"], solved.y[0]


def fall_of(words: str, found: np.ndarray, exact: np.ndarray) -> CaseResult:
    """Fall of a temperature, or of a difference, in half of the time."""
    fall = float(found[0] - found[5]), float(exact[0] - exact[5])
    return relative(words, *fall, LIMIT, "K")


def heat_cases() -> Iterator[CaseResult]:
    """All cases of this file."""
    yield fall_of("prepreg between two plates: fall of its temperature", *between_plates())
    found, exact, *_ = on_each_other()
    yield fall_of("two prepregs on each other: fall of their difference", found, exact)
    still = Air(temperature=300.0, convection=20.0)
    found, exact = in_the_air(still, 20.0, emissivity=0.0)
    yield fall_of("prepreg in the air, by convection: fall of its temperature", found, exact)
    found, exact = in_the_air(still, 20.0, emissivity=0.9)
    yield fall_of("… and radiation", found, exact)
