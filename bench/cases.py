"""What is timed: the membrane alone, and whole steps of scenes.

The smallest scenes are timed in the middle of forming, larger ones earlier, and from 100,000
triangles on at their very start, where the ply already lies on die or table but the holder does not
press yet: the column of contacts tells.
"""

from __future__ import annotations

import itertools
import math
import resource
import statistics
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

import numpy as np
import warp as wp
from yardstick import Yardstick

import warpdrape as wd
from warpdrape.contact.tool_contact import ToolContact
from warpdrape.dynamics import energy, stepping
from warpdrape.dynamics.model import Model, build_model, initial_state
from warpdrape.dynamics.partition import split
from warpdrape.dynamics.phases import time_phases
from warpdrape.materials.fabric_library import load_fabric, with_bending
from warpdrape.results.snapshot import read_plies, shown_at_vertices
from warpdrape.results.usd import SAVE_EVERY, PlyShape, ToolShape, UsdWriter
from warpdrape.scenes import circular_table, hemisphere, stacked_hemisphere, three_ply_hemisphere
from warpdrape.state import State

FRAMES = 100
"""Frames into which runs are divided."""
SECONDS = 1.5
"""Processor time that one repetition takes at least [s]."""
STEP_BLOCK = 4_000_000
"""Triangle-steps after which a large mesh is searched, sooner than its run would."""
WRITTEN_TRIANGLES = 1_000_000
"""Triangles of all frames that are written to time them, for large models."""
USUAL_FRAMES = 60
"""Frames that a run writes unless told otherwise."""


@dataclass(frozen=True)
class Case:
    """One row to be.

    Attributes:
        build: builds the scene, given ``cells``.
        cells: along a side.
        part: of the scene's time at which it is timed.
        quick: whether it takes little time.
    """

    build: Callable[..., wd.Scene]
    cells: int
    part: float = 0.0
    quick: bool = False


@dataclass(frozen=True)
class Measurement:
    """One row of the table.

    Attributes:
        case: its name.
        triangles: in all plies.
        rate: triangle-steps per second of processor time.
        ratio: to the yardstick, median of the repetitions' own ratios.
        spread: smallest and largest of these ratios.
        peak_mb: largest memory of the process, which does this case alone [MB].
        contacts: contacts with tools that press, per vertex [-].
        output: time of writing 60 frames of USD over that of the run's steps [-].
        results: likewise of measuring what they show and ``history.csv`` holds, file or not [-].
        phases: share of each phase.
    """

    case: str
    triangles: int
    rate: float
    ratio: float
    spread: tuple[float, float]
    peak_mb: float
    contacts: float
    output: float
    results: float
    phases: dict[str, float] = field(default_factory=dict)


HOLD = wd.Crossover(
    slip_force_warp=0.01, slip_force_weft=0.01, stiffness_warp=2e3, stiffness_weft=2e3
)
"""Made up: what yarns that slide are timed with."""


def card() -> wd.Fabric:
    """The fabric that is timed."""
    return replace(load_fabric("carbon_interlock"), crossover=HOLD)


def membrane(cells: int, approach: str = "semi_discrete") -> wd.Scene:
    """A sheet of 2 cells² triangles without tools and bending, as the yardstick has."""
    cloth = with_bending(card(), "none")
    ply = wd.Ply.rectangle("sheet", cloth, 0.4, cells=cells, mesh="diagonal")
    still = (0.0, 0.0, 0.0)
    return wd.Scene(name="membrane", plies=[ply], duration=0.05, gravity=still, approach=approach)


def without_folds(cells: int) -> wd.Scene:
    """The hemisphere with bending, but without looking for folds, as a ply without bending is."""
    return replace(hemisphere.build(cells=cells), self_contact=False)


def _cases() -> dict[str, Case]:
    found = {}
    for cells in (28, 57, 113, 200, 707):
        found[f"membrane_{2 * cells**2}"] = Case(membrane, cells, quick=cells < 150)
    for approach in ("fibre_frame", "green_naghdi", "yarns", "sliding_yarns"):
        stressed = partial(membrane, approach=approach)
        for cells in (57, 200):
            quick = cells < 150
            found[f"membrane_{approach}_{2 * cells**2}"] = Case(stressed, cells, quick=quick)
        formed = partial(hemisphere.build, fabric=card(), approach=approach)
        found[f"hemisphere_{approach}_1600"] = Case(formed, 20, 0.5)
    one_ply = {20: 0.5, 40: 0.1, 80: 0.06, 158: 0.0, 500: 0.0}
    three_plies = {20: 0.1, 46: 0.05, 80: 0.02, 158: 0.0, 289: 0.0}
    table = {28: 0.1, 100: 0.05, 224: 0.0, 707: 0.0}
    for cells, part in one_ply.items():
        found[f"hemisphere_{4 * cells**2}"] = Case(hemisphere.build, cells, part, cells < 50)
    for cells in (20, 40, 80):
        unbent = partial(hemisphere.build, bending="none")
        found[f"hemisphere_unbent_{4 * cells**2}"] = Case(unbent, cells, one_ply[cells], cells < 50)
        case = Case(without_folds, cells, one_ply[cells], cells < 50)
        found[f"hemisphere_without_folds_{4 * cells**2}"] = case
    for cells, part in three_plies.items():
        case = Case(three_ply_hemisphere.build, cells, part, cells < 30)
        found[f"three_ply_{12 * cells**2}"] = case
    for count in (3, 8, 16, 32):
        layup = "/".join(["0", "45"][n % 2] for n in range(count))
        tall = partial(stacked_hemisphere.build, layup=layup)
        found[f"stack_of_{count}_{4 * count * 20**2}"] = Case(tall, 20, 0.05, count < 5)
    for cells, part in table.items():
        case = Case(circular_table.build, cells, part, cells < 150)
        found[f"circular_table_{2 * cells**2}"] = case
    return found


CASES = _cases()


def measure(name: str, yardstick: Yardstick, repeat: int) -> Measurement:
    """Time whole steps of a case, then its phases and its output.

    Args:
        name: of the case.
        yardstick: what it is compared with.
        repeat: so many times.
    """
    case = CASES[name]
    model = build_model(case.build(cells=case.cells), "cpu", FRAMES)
    state = initial_state(model)
    formed = round(case.part * FRAMES)
    run_to(model, state, formed)
    triangles = model.triangles
    every = model.timing.search_every
    count = max(1, min(every, STEP_BLOCK // triangles))
    blocks = march(model, state, formed + 1, count)
    next(blocks)
    rates, ratios = [], []
    for _ in range(repeat):
        reference = yardstick.rate()
        spent = steps = 0
        while spent < SECONDS:
            search, stepped = next(blocks)
            spent += search * count / every + stepped
            steps += count
        rates.append(triangles * steps / spent)
        ratios.append(rates[-1] / reference)
    rate = statistics.median(rates)
    step = triangles / rate
    pressing = sum(
        (memory.holds.numpy()["stored"] > 0.0).sum()
        for contact, memory in zip(model.interactions, state.memory, strict=True)
        if isinstance(contact, ToolContact)
    )
    if state.plies.runaway.numpy()[0] >= 0:
        raise SystemExit(f"{name} blew up while it was timed")
    # Before any frame is written: threads of the USD library idle on for a while, and count.
    phases = time_phases(model, state, time.process_time)
    shares = {phase: cost / step for phase, cost in phases.items()}
    shares["Python"] = max(1.0 - sum(shares.values()), 0.0)
    run = model.timing.steps * step
    output, results = (spent / run for spent in time_frames(model, state, run))
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    return Measurement(
        name,
        triangles,
        rate,
        statistics.median(ratios),
        (min(ratios), max(ratios)),
        peak,
        float(pressing / len(model.masses.mass)),
        output,
        results,
        shares,
    )


def run_to(model: Model, state: State, frames: int) -> None:
    """Do the first frames of a run."""
    stepper = stepping.Stepper(model, state)
    for frame in range(1, frames + 1):
        stepper.begin_frame(frame)
        for _ in range(model.timing.steps_per_frame // model.timing.search_every):
            stepper.block()


def march(model: Model, state: State, frame: int, count: int) -> Iterator[tuple[float, float]]:
    """Go on block by block; yields the processor time of search and steps [s].

    Past the scene's end, what is prescribed stands still.

    Args:
        model: the model.
        state: its state.
        frame: the first one to compute.
        count: steps of a block, fewer than a run's where a mesh is large.
    """
    stepper = stepping.Stepper(model, state)
    stepper.begin_frame(frame)
    whole = count == model.timing.search_every
    (whole_part,) = split(model, state, 1)
    with wp.ScopedCapture(device="cpu") as capture:
        for _ in range(count):
            stepping.step(whole_part)
    for number in itertools.count(frame):
        stepper.begin_frame(number)
        for _ in range(model.timing.steps_per_frame // count):
            start = searched = time.process_time()
            if whole:
                stepper.block()
            else:
                stepping.search_contacts(model, state)
                searched = time.process_time()
                wp.capture_launch(capture.graph)
            state.plies.runaway.numpy()
            yield searched - start, time.process_time() - searched


def time_frames(model: Model, state: State, run: float) -> tuple[float, float]:
    """Processor time of writing the usual frames of USD, and of measuring what they show [s].

    The profile of a run calls them output and results. Of large models only some are written. That
    the USD library has to start first is part of a run's start-up.

    Args:
        model: the model.
        state: its state.
        run: time of all steps [s]; says how many frames are saved together.
    """
    scene, writing, measuring = model.scene, [], []
    triangles = model.triangles
    written = min(USUAL_FRAMES, max(4, WRITTEN_TRIANGLES // triangles))
    together = math.ceil(SAVE_EVERY * USUAL_FRAMES / run)
    x, random = state.plies.x.numpy().copy(), np.random.default_rng(0)
    plies = [
        PlyShape(p.name, p.rest_points, p.mesh.triangles, shown_at_vertices(scene, p))
        for p in scene.plies
    ]
    tools = [ToolShape(t.name, t.vertices, t.triangles) for t in scene.tools]
    with tempfile.TemporaryDirectory() as folder:
        UsdWriter(Path(folder, "starts_the_library.usdc"), plies, tools).close()
        start = time.process_time()
        writer = UsdWriter(Path(folder, "scene.usdc"), plies, tools)
        opened = time.process_time() - start
        for frame in range(written):
            moved = x + 1e-6 * random.standard_normal(x.shape)  # equal frames are kept once
            state.plies.x.assign(moved)
            start = time.process_time()
            measured = energy.measure(model, state)
            energy.balance(model, state, measured)
            formed = read_plies(model, state, measured)
            read = time.process_time()
            now = frame * model.timing.steps_per_frame * model.timing.time_step
            shown = [ply.frame() for ply in formed]
            writer.write(frame, now, shown, state.tools.shift.numpy())
            if (frame + 1) % together == 0:
                writer.save()
            writing.append(time.process_time() - read)
            measuring.append(read - start)
        start = time.process_time()
        writer.close()
        closed = time.process_time() - start
    state.plies.x.assign(x)
    share = USUAL_FRAMES / written
    return opened + share * (sum(writing) + closed), share * sum(measuring)
