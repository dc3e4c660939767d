"""The steps of a run: every launch is here, eager or replayed from a captured graph."""

from __future__ import annotations

import math

import numpy as np
import warp as wp

from warpdrape.kernels.motion import (
    advance_clamped,
    advance_tools,
    advance_vertices,
    count_step,
)
from warpdrape.kernels.ply_contact import (
    add_ply_forces,
    add_vertex_normals,
    copy_to_single,
    find_ply_contacts,
    raise_hollows,
)
from warpdrape.kernels.tool_contact import add_tool_forces, find_tool_contacts
from warpdrape.model import Model, State, near_reach
from warpdrape.motion import Float

FADING = 2e-4
"""Time in which a penetration that appeared by a jump of the gap is pushed out [s].

Pushing it out does work that nothing supplies: in the three-ply hemisphere about a hundredth of the
energy, at 4 ms a third of that, but then up to 0.2 mm are on their way out at a time, not 0.03 mm.
"""


def search_contacts(model: Model, state: State) -> None:
    """Find what each vertex may touch until the next search."""
    search_tools(model, state)
    search_plies(model, state)


def search_tools(model: Model, state: State) -> None:
    """Find which tools each vertex may touch until the next search."""
    if not model.scene.tools:
        return
    wp.launch(
        find_tool_contacts,
        model.mass.shape[0],
        inputs=[model.surfaces, model.search, model.offset, state.tool_shift, state.x],
        outputs=[
            state.tool_planes,
            state.tool_queries,
            state.tool_touching,
            state.tool_holds,
            state.lost,
            state.tool_deepest,
        ],
        device=model.device,
    )


def search_plies(model: Model, state: State) -> None:
    """Find which triangles of other plies each vertex may touch until the next search."""
    scene, device = model.scene, model.device
    if not model.ply_pairs:
        return
    state.normals.zero_()
    wp.launch(
        add_vertex_normals,
        model.triangles.shape[0],
        inputs=[model.triangles, state.x],
        outputs=[state.normals],
        device=device,
    )
    state.hollows.zero_()
    wp.launch(
        raise_hollows,
        model.triangles.shape[0],
        inputs=[model.triangles, state.x, state.normals],
        outputs=[state.hollows],
        device=device,
    )
    for membrane, mesh in zip(model.membranes, model.query_meshes, strict=True):
        wp.launch(
            copy_to_single,
            membrane.vertex_count,
            inputs=[membrane.first_vertex, state.x],
            outputs=[mesh.points],
            device=device,
        )
        mesh.refit()
    reach = near_reach(scene)
    keep = math.exp(-model.timing.search_every * model.timing.time_step / FADING)
    for number, pair in enumerate(model.ply_pairs):
        searching = model.membranes[pair.searching]
        radius = 4.0 * pair.faces.thickness + 2.0 * reach
        wp.launch(
            find_ply_contacts,
            searching.vertex_count,
            inputs=[
                model.contact,
                pair.faces,
                number,
                searching.first_vertex,
                pair.first_slot,
                reach,
                radius,
                keep,
                model.triangles,
                model.open_edges,
                model.mass,
                state.x,
                state.normals,
                state.hollows,
                state.ply_springs,
                state.ply_stored,
            ],
            outputs=[state.ply_contacts, state.lost, state.ply_deepest, state.ply_jump],
            device=device,
        )


def step(model: Model, state: State) -> None:
    """Advance everything by one step."""
    add_element_forces(model, state)
    add_ply_contact(model, state)
    add_tool_contact(model, state)
    advance(model, state)


def add_element_forces(model: Model, state: State) -> None:
    """Add the forces of the plies' triangles."""
    for membrane in model.membranes:
        membrane.add_forces(state.x, state.f)


def add_ply_contact(model: Model, state: State) -> None:
    """Add the contact forces between plies."""
    scene, device = model.scene, model.device
    for pair in model.ply_pairs:
        searching = model.membranes[pair.searching]
        wp.launch(
            add_ply_forces,
            searching.vertex_count,
            inputs=[
                model.contact,
                scene.ply_friction,
                pair.faces.thickness,
                searching.first_vertex,
                pair.first_slot,
                model.mass,
                state.x,
                state.v,
                state.ply_contacts,
            ],
            outputs=[
                state.ply_springs,
                state.ply_dashpots,
                state.f,
                state.lost,
                state.ply_stored,
                state.ply_slip,
            ],
            device=device,
        )


def add_tool_contact(model: Model, state: State) -> None:
    """Add the contact forces of the tools."""
    if not model.scene.tools:
        return
    wp.launch(
        add_tool_forces,
        model.mass.shape[0],
        inputs=[
            model.contact,
            model.surfaces.friction,
            model.mass,
            state.tool_shift,
            state.tool_velocity,
            state.x,
            state.v,
            state.tool_planes,
            state.tool_touching,
        ],
        outputs=[state.tool_holds, state.f, state.reaction, state.lost],
        device=model.device,
    )


def advance(model: Model, state: State) -> None:
    """Move vertices and tools, and go to the next step."""
    scene, device = model.scene, model.device
    if scene.clamps:
        wp.launch(
            advance_clamped,
            model.mass.shape[0],
            inputs=[
                model.medium,
                model.mass,
                model.added_mass,
                model.clamp,
                model.rest,
                state.clamp_matrix,
                state.clamp_shift,
                state.step,
            ],
            outputs=[state.x, state.v, state.f, state.clamp_work, state.clamp_force],
            device=device,
        )
    wp.launch(
        advance_vertices,
        model.mass.shape[0],
        inputs=[model.medium, model.mass, model.added_mass, model.clamp],
        outputs=[state.x, state.v, state.f, state.lost, state.runaway],
        device=device,
    )
    if scene.tools:
        wp.launch(
            advance_tools,
            len(scene.tools),
            inputs=[
                model.timing.time_step,
                model.floating,
                state.tool_path,
                state.tool_force,
                state.step,
            ],
            outputs=[
                state.tool_shift,
                state.tool_velocity,
                state.reaction,
                state.impulse,
                state.tool_work,
                state.tool_damped,
            ],
            device=device,
        )
    wp.launch(count_step, 1, outputs=[state.step], device=device)


class Stepper:
    """Runs blocks of a search and the steps up to the next one, from a captured graph.

    The search between plies stays outside the graph: Warp 1.19 does not record `Mesh.refit` on the
    CPU, so that a replay would query a stale hierarchy. Tools are rigid and need no refit.
    """

    def __init__(self, model: Model, state: State) -> None:
        """Keep model and state; a graph is captured at the first block."""
        self._model, self._state = model, state
        self._graph = None

    def begin_frame(self, frame: int) -> None:
        """Put the prescribed motions of a frame's steps on the device.

        Args:
            frame: number of the frame that these steps lead to, from 1.
        """
        model, state = self._model, self._state
        scene, timing = model.scene, model.timing
        steps = np.arange(timing.steps_per_frame + 1) + (frame - 1) * timing.steps_per_frame
        time = steps * timing.time_step
        if scene.tools:
            shape = (len(scene.tools), len(time))
            path, force = np.zeros((*shape, 3)), np.zeros(shape)
            for k, tool in enumerate(scene.tools):
                if isinstance(tool.motion, Float):
                    force[k] = tool.motion.force_at(time)
                else:
                    path[k] = tool.motion.displacement(time)
            state.tool_path.assign(path)
            state.tool_force.assign(force)
        if scene.clamps:
            shift = np.stack([clamp.motion.displacement(time) for clamp in scene.clamps])
            eye = np.broadcast_to(np.eye(3), (len(time), 3, 3))
            matrix = [clamp.matrix(time) if clamp.matrix else eye for clamp in scene.clamps]
            state.clamp_shift.assign(shift.reshape(-1, 3))
            state.clamp_matrix.assign(np.concatenate(matrix))
        state.step.zero_()

    def block(self) -> None:
        """Search once and do the steps up to the next search."""
        search_plies(self._model, self._state)
        if not self._model.scene.numerics.graph:
            self._launch_steps()
            return
        if self._graph is None:
            with wp.ScopedCapture(device=self._model.device) as capture:
                self._launch_steps()
            self._graph = capture.graph
        wp.capture_launch(self._graph)

    def _launch_steps(self) -> None:
        search_tools(self._model, self._state)
        for _ in range(self._model.timing.search_every):
            step(self._model, self._state)
