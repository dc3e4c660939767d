"""What is timed: the membrane alone, and whole steps of scenes with their contacts."""

from __future__ import annotations

import itertools
import resource
import statistics
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import warp as wp
from yardstick import Yardstick

import warpdrape as wd
from warpdrape import stepping
from warpdrape.model import Model, State, build_model, initial_state
from warpdrape.scenes import circular_table, hemisphere, three_ply_hemisphere

SECONDS = 2.0
"""Processor time that one repetition takes at least [s]."""


@dataclass(frozen=True)
class Measurement:
    """One row of the table.

    Attributes:
        case: its name.
        triangles: in all plies.
        rate: triangle-steps per second of processor time.
        ratio: to the yardstick, median of the repetitions' own ratios.
        peak_mb: largest memory of the process so far [MB].
        phases: share of each phase, where measured.
    """

    case: str
    triangles: int
    rate: float
    ratio: float
    peak_mb: float
    phases: dict[str, float] = field(default_factory=dict)


def membrane(cells: int) -> Callable[[str, Yardstick, int], Measurement]:
    """A sheet of 2 cells² triangles without tools, as the yardstick has."""

    def scene() -> wd.Scene:
        ply = wd.Ply.rectangle("sheet", "carbon_interlock", 0.4, cells=cells, mesh="diagonal")
        return wd.Scene(name="membrane", plies=[ply], duration=1e-3, gravity=(0.0, 0.0, 0.0))

    return lambda name, yardstick, repeat: measure(name, scene(), 0.0, yardstick, repeat)


def formed(build: Callable, part: float, **parameters) -> Callable:
    """A scene, timed once a part of its duration has been computed."""
    return lambda name, yardstick, repeat: measure(
        name, build(**parameters), part, yardstick, repeat
    )


def measure(
    name: str, scene: wd.Scene, part: float, yardstick: Yardstick, repeat: int
) -> Measurement:
    """Run a scene up to a part of its duration, then time whole steps."""
    model = build_model(scene, "cpu", frames=100)
    state = initial_state(model)
    blocks = march(model, state)
    per_frame = model.timing.steps_per_frame // model.timing.search_every
    for _ in range(max(1, int(part * 100 * per_frame))):
        next(blocks)
    triangles = sum(m.triangle_count for m in model.membranes)
    rates, ratios = [], []
    for _ in range(repeat):
        reference = yardstick.rate()
        steps, start = 0, time.process_time()
        while time.process_time() - start < SECONDS:
            next(blocks)
            steps += model.timing.search_every
        rates.append(triangles * steps / (time.process_time() - start))
        ratios.append(rates[-1] / reference)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    return Measurement(
        name,
        triangles,
        statistics.median(rates),
        statistics.median(ratios),
        peak,
        phases(model, state),
    )


def march(model: Model, state: State) -> Iterator[None]:
    """Do a run block by block; past its end, what is prescribed stands still."""
    stepper = stepping.Stepper(model, state)
    for frame in itertools.count(1):
        stepper.begin_frame(frame)
        for _ in range(model.timing.steps_per_frame // model.timing.search_every):
            stepper.block()
            yield


def phases(model: Model, state: State, count: int = 50) -> dict[str, float]:
    """Share of the step's phases, each captured alone and replayed."""
    timing = model.timing

    def cost(launch: Callable[[], None]) -> float:
        with wp.ScopedCapture(device="cpu") as capture:
            for _ in range(count):
                launch()
        wp.capture_launch(capture.graph)
        start = time.process_time()
        wp.capture_launch(capture.graph)
        return (time.process_time() - start) / count

    start = time.process_time()
    stepping.search_contacts(model, state)
    search = (time.process_time() - start) / timing.search_every

    def elements() -> None:
        for sheet in model.membranes:
            sheet.add_forces(state.x, state.f)

    whole = cost(lambda: stepping.step(model, state)) + search
    forces = cost(elements)
    return {
        "elements": forces / whole,
        "contact search": search / whole,
        "contact forces and integration": 1.0 - (forces + search) / whole,
    }


CASES: dict[str, Callable[[str, Yardstick, int], Measurement]] = {
    "membrane_5000": membrane(50),
    "membrane_80000": membrane(200),
    "membrane_320000": membrane(400),
    "hemisphere_1600": formed(hemisphere.build, 0.5),
    "hemisphere_6400": formed(hemisphere.build, 0.05, cells=40),
    "three_ply_4800": formed(three_ply_hemisphere.build, 0.5),
    "circular_table_20000": formed(circular_table.build, 0.1),
}
