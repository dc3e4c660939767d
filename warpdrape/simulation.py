"""A run from start to end: checks, frames, results, and what happens when it goes wrong."""

from __future__ import annotations

import os
import time

import numpy as np
import warp as wp

from warpdrape.energy import Energies, balance, measure_membranes
from warpdrape.errors import InputError, RunFailed
from warpdrape.model import Model, State, build_model, check_device, initial_state
from warpdrape.progress import Progress
from warpdrape.result import FormedPly, Result, read_plies
from warpdrape.run_folder import RUN, SUMMARY, HistoryWriter, RunFolder
from warpdrape.scene import Scene
from warpdrape.stepping import Stepper, search_contacts
from warpdrape.summary import ENERGY_FAILURE, history_row, run_record, summarise
from warpdrape.usd import PlyShape, ToolShape, UsdWriter

START_TOLERANCE = 0.01
"""Share of the ply thickness by which things may overlap at the start [-]."""


def run_scene(
    scene: Scene,
    out: str | os.PathLike | None,
    *,
    device: str,
    frames: int,
    overwrite: bool,
    quiet: bool,
) -> Result:
    """Compute a scene; see `Scene.run`."""
    if isinstance(frames, bool) or not isinstance(frames, int) or frames < 1:
        raise InputError(f"frames = {frames!r} must be a whole number above zero")
    check_device(device)
    folder = None if out is None else RunFolder(out, overwrite)
    model = build_model(scene, device, frames)
    state = initial_state(model)
    check_start(model, state)
    recorder = Recorder(model, folder)
    with Progress(scene.duration, quiet=quiet) as progress:
        failure = _march(model, state, recorder, progress)
    return recorder.finish(state, failure)


def check_start(model: Model, state: State) -> None:
    """Refuse plies and tools that overlap before anything moves.

    Raises:
        InputError: naming the tool and the ply, or the two plies, and by how much they overlap.
    """
    scene = model.scene
    thinnest = min(ply.fabric.thickness for ply in scene.plies)
    Stepper(model, state).begin_frame(1)
    if scene.tools:  # a path may start away from zero
        start = state.tool_path.numpy()[:, 0]
        state.tool_shift.assign(start)
    search_contacts(model, state)
    for tool, depth in zip(scene.tools, state.tool_deepest.numpy(), strict=True):
        if depth > START_TOLERANCE * thinnest:
            raise InputError(
                f"tool {tool.name!r} starts {1e3 * depth:.4g} mm inside a ply: move it away by that"
            )
    for pair, depth in zip(model.ply_pairs, state.ply_deepest.numpy(), strict=True):
        if depth > START_TOLERANCE * thinnest:
            names = scene.plies[pair.searching].name, scene.plies[pair.searched].name
            raise InputError(
                f"plies {names[0]!r} and {names[1]!r} overlap by {1e3 * depth:.4g} mm at the start: "
                "lay them up with warpdrape.lay_up"
            )


def _march(model: Model, state: State, recorder: "Recorder", progress: Progress) -> str:
    """Step through all frames; return why it stopped early, or an empty text."""
    timing = model.timing
    stepper = Stepper(model, state)
    try:
        recorder.record(state, 0, 0)
        for frame in range(1, timing.frames + 1):
            stepper.begin_frame(frame)
            for block in range(timing.steps_per_frame // timing.search_every):
                stepper.block()
                recorder.steps += timing.search_every
                if state.runaway.numpy()[0] >= 0:
                    done = (frame - 1) * timing.steps_per_frame + (block + 1) * timing.search_every
                    raise RunFailed(where_it_blew_up(model, state, done * timing.time_step))
            row = recorder.record(state, frame, timing.steps_per_frame)
            words = f"max shear {row['max_shear_deg']:.1f}°"
            progress.update(row["time_s"], words, steps=recorder.steps)
    except RunFailed as reason:
        return str(reason)
    except KeyboardInterrupt:
        return "interrupted by the user"
    return ""


def where_it_blew_up(model: Model, state: State, when: float) -> str:
    """Name the ply and triangle where a vertex ran away."""
    vertex = int(state.runaway.numpy()[0])
    for ply, membrane in zip(model.scene.plies, model.membranes, strict=True):
        local = vertex - membrane.first_vertex
        if 0 <= local < membrane.vertex_count:
            triangle = int(np.argmax((np.asarray(ply.mesh.triangles) == local).any(axis=1)))
            return (
                f"blew up at {1e3 * when:.4g} ms in ply {ply.name!r}, triangle {triangle} "
                f"(vertex {local}): a vertex is faster than {model.medium.speed_limit:.4g} m/s; "
                "lower safety or contact_share, or refine the mesh there"
            )
    return f"blew up at {1e3 * when:.4g} ms"


class Recorder:
    """Keeps history and last good frame, and writes the run folder as the run goes."""

    def __init__(self, model: Model, folder: RunFolder | None) -> None:
        """Open the run folder, if there is one."""
        self.steps = 0
        self._model, self._folder = model, folder
        self._rows: list[dict[str, float]] = []
        self._plies: tuple[FormedPly, ...] = ()
        self._started = time.perf_counter()
        self._usd: UsdWriter | None = None
        self._history: HistoryWriter | None = None
        if folder is not None:
            scene = model.scene
            folder.begin()
            folder.write_json(RUN, run_record(scene, model, model.timing.frames))
            self._history = folder.history()
            self._usd = UsdWriter(
                folder.scene_path,
                [PlyShape(p.name, p.rest_points, p.mesh.triangles) for p in scene.plies],
                [ToolShape(t.name, t.vertices, t.triangles) for t in scene.tools],
            )

    def record(self, state: State, frame: int, steps: int) -> dict[str, float]:
        """Take down a frame.

        Args:
            state: the state now.
            frame: its number.
            steps: steps since the one before.

        Returns:
            The row of the history.

        Raises:
            RunFailed: if a number is not finite, or energy came from nowhere; nothing is kept then.
        """
        model = self._model
        strains, tensions, energy = measure_membranes(model, state)
        energies = balance(model, state, energy)
        now = frame * model.timing.steps_per_frame * model.timing.time_step
        plies = read_plies(model, state, strains, tensions)
        self._refuse_nonsense(plies, energies, now)
        before = self._rows[-1] if self._rows else None
        row = history_row(model, state, now, steps, energies, plies, before)
        state.impulse.zero_()
        state.clamp_force.zero_()
        self._rows.append(row)
        self._plies = plies
        if self._history is not None:
            self._history.append(row)
            shifts = state.tool_shift.numpy()
            self._usd.write(frame, now, [ply.frame() for ply in plies], shifts)
        return row

    def _refuse_nonsense(self, plies, energies: Energies, now: float) -> None:
        for ply in plies:
            bad = ~np.isfinite(ply.points).all(axis=1)
            bad_triangle = bad[ply.triangles].any(axis=1) | ~np.isfinite(ply.shear_angle)
            if bad_triangle.any():
                raise RunFailed(
                    f"blew up at {1e3 * now:.4g} ms in ply {ply.name!r}, triangle "
                    f"{int(np.argmax(bad_triangle))}: positions are not finite; lower safety"
                )
        model = self._model
        speed = model.medium.speed_limit / 100.0
        scale = max(energies.largest, 0.5 * float(model.masses.mass.sum()) * speed**2)
        if not energies.unbalanced <= ENERGY_FAILURE * scale:
            raise RunFailed(
                f"energy grew without work at {1e3 * now:.4g} ms: {energies.unbalanced:.4g} J of "
                f"{scale:.4g} J came from nowhere; lower safety or contact_share, or refine the tools"
            )

    def finish(self, state: State, failure: str) -> Result:
        """Close the files and say how it went."""
        wall = time.perf_counter() - self._started
        history = {name: np.array([row[name] for row in self._rows]) for name in self._rows[0]}
        model = self._model
        summary = summarise(
            model, state, history, self._plies, failure=failure, steps=self.steps, wall=wall
        )
        result = Result(self._plies, summary, history)
        if model.scene.report is not None and not failure:
            summary.update(model.scene.report(result))
        if self._folder is not None:
            self._usd.close()
            self._history.close()
            if model.scene.write is not None and not failure:
                model.scene.write(result, self._folder)
            self._folder.write_json(SUMMARY, summary)
        return result


def warm_up() -> None:
    """Start Warp without its banner."""
    wp.config.quiet = True
    wp.init()
