"""Every launch of a step and of a search, for a part of the model or the whole."""

from __future__ import annotations

import math
from collections.abc import Sequence

import warp as wp

from warpdrape.dynamics.model import ASK_EVERY, Model, State, near_reach
from warpdrape.dynamics.partition import Part
from warpdrape.dynamics.timing import peak_speed
from warpdrape.forces.membrane import launch_loads
from warpdrape.kernels.contact.ply_contact import (
    PlySearch,
    add_ply_forces,
    compute_hollows,
    compute_vertex_normals,
    copy_to_single,
    find_ply_contacts,
)
from warpdrape.kernels.contact.tool_contact import add_tool_forces, find_tool_contacts
from warpdrape.kernels.dynamics.motion import (
    advance_clamped,
    advance_tools,
    advance_vertices,
    count_step,
)
from warpdrape.kernels.dynamics.parts import note_runaway, raise_to, take_over
from warpdrape.kernels.dynamics.selective_mass import drift_vertices, push_vertices, raise_power

FADING = 2e-4
"""Time in which a penetration that appeared by a jump of the gap is pushed out [s].

Pushing it out does work that nothing supplies: in the three-ply hemisphere about a hundredth of the
energy, at 4 ms a third of that, but then up to 0.2 mm are on their way out at a time, not 0.03 mm.
"""
PUSH_OUT = 0.1
"""… but no faster than at this share of the tools' speed [-]. A vertex that has slid over another
ply's border and back is found 2 mm deep; out in 0.2 ms it was thrown up at 40 m/s.
"""


def search_tools(part: Part) -> None:
    """Find which tools each vertex of a part may touch until the next search."""
    model, state = part.model, part.moving
    if not model.scene.tools:
        return
    for first, count in part.vertices:
        wp.launch(
            find_tool_contacts,
            count,
            inputs=[
                first,
                model.surfaces,
                model.search,
                model.offset,
                state.tool_shift,
                state.tool_velocity,
                state.x,
                state.v,
            ],
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


def search_plies(whole: Part, *, asking: bool = True) -> None:
    """Find which triangles of other plies each vertex may touch until the next search.

    Args:
        whole: a part that is the whole.
        asking: whether every vertex asks for the nearest one; else it walks from the one before.
    """
    if asking:
        copy_plies(whole)
        refit_plies(whole)
    measure_normals(whole)
    measure_hollows(whole)
    find_plies(whole, asking)


def copy_plies(part: Part) -> None:
    """Copy positions of a part's plies into their query meshes."""
    model = part.model
    for number in part.plies if model.ply_pairs else ():
        membrane = model.membranes[number]
        wp.launch(
            copy_to_single,
            membrane.vertex_count,
            inputs=[membrane.first_vertex, part.moving.x],
            outputs=[model.query_meshes[number].points],
            device=model.device,
        )


def measure_normals(part: Part) -> None:
    """Find the normals at a part's vertices."""
    model, state = part.model, part.moving
    for first, count in part.vertices if model.ply_pairs else ():
        wp.launch(
            compute_vertex_normals,
            count,
            inputs=[first, model.facets, state.x],
            outputs=[state.normals],
            device=model.device,
        )


def refit_plies(part: Part) -> None:
    """Refit the query meshes of a part's plies."""
    if part.model.ply_pairs:
        for number in part.plies:
            part.model.query_meshes[number].refit()


def measure_hollows(part: Part) -> None:
    """Find the room on the hollow sides at a part's vertices."""
    model, state = part.model, part.moving
    for first, count in part.vertices if model.ply_pairs else ():
        wp.launch(
            compute_hollows,
            count,
            inputs=[first, model.facets, state.x, state.normals],
            outputs=[state.hollows],
            device=model.device,
        )


def ply_search(model: Model, thickness: float, asking: bool) -> PlySearch:
    """How far a search looks for plies that touch at a thickness [m].

    What it does not see must not come near before it asks again.
    """
    search = PlySearch()
    search.asks = int(asking)
    search.reach = near_reach(model.scene)
    beyond = max(3.0 * thickness + 2.0 * search.reach, (1 + ASK_EVERY) * search.reach)
    search.radius = thickness + beyond
    interval = model.timing.search_every * model.timing.time_step
    search.keep = math.exp(-interval / FADING)
    search.ease = PUSH_OUT * peak_speed(model.scene) * interval
    return search


def find_plies(part: Part, asking: bool) -> None:
    """Find which triangles of other plies the vertices of a part may touch."""
    model, state = part.model, part.moving
    for look in part.contacts:
        wp.launch(
            find_ply_contacts,
            look.count,
            inputs=[
                model.contact,
                ply_search(model, look.pair.faces.thickness, asking),
                model.facets,
                look.pair.faces,
                look.number,
                look.first_vertex,
                look.first_slot,
                model.mass,
                state.x,
                state.normals,
                state.hollows,
                state.ply_springs,
                state.ply_stored,
            ],
            outputs=[
                state.ply_memory,
                state.ply_contacts,
                state.lost,
                state.ply_deepest,
                state.ply_jump,
            ],
            device=model.device,
        )


def add_element_forces(part: Part) -> None:
    """Add the forces of a part's triangles."""
    launch_loads(part.loads, part.scattering.x, part.scattering.f)


def add_ply_contact(part: Part) -> None:
    """Add the contact forces between plies that a part's vertices find."""
    model, state = part.model, part.scattering
    for look in part.contacts:
        wp.launch(
            add_ply_forces,
            look.count,
            inputs=[
                model.contact,
                model.scene.ply_friction,
                look.pair.faces.thickness,
                look.first_vertex,
                look.first_slot,
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
            device=model.device,
        )


def add_tool_contact(part: Part) -> None:
    """Add the contact forces of the tools on a part's vertices."""
    model, state = part.model, part.moving
    if not model.scene.tools:
        return
    for first, count in part.vertices:
        wp.launch(
            add_tool_forces,
            count,
            inputs=[
                first,
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


def advance_plies(part: Part) -> None:
    """Move a part's vertices; with selective mass scaling push them only, see `raise_power_of`."""
    model, state = part.model, part.moving
    if model.selective is not None:
        push_plies(part)
        return
    for first, count in part.vertices:
        if model.scene.clamps:
            wp.launch(
                advance_clamped,
                count,
                inputs=[
                    first,
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
                device=model.device,
            )
        wp.launch(
            advance_vertices,
            count,
            inputs=[first, model.medium, model.mass, model.added_mass, model.clamp],
            outputs=[state.x, state.v, state.f, state.lost, state.runaway],
            device=model.device,
        )


def push_plies(part: Part) -> None:
    """Advance the momenta of a part's vertices."""
    model, state = part.model, part.moving
    for first, count in part.vertices:
        wp.launch(
            push_vertices,
            count,
            inputs=[first, model.medium, model.selective.start, model.mass],
            outputs=[state.f, state.w, state.mean_w, state.power_now],
            device=model.device,
        )


def raise_power_of(part: Part, number: int) -> None:
    """Do a step of the recurrence from momenta to velocities; the last one moves the vertices.

    The terms change places at every step: a part reads those that its neighbours made in the one
    before.
    """
    model, state = part.model, part.moving
    matrix, powers = model.selective.matrix, model.selective.powers
    terms = [state.power_now, state.power_old]
    now, old = terms if number % 2 == 0 else reversed(terms)
    for first, count in part.vertices:
        if number < len(powers) - 1:
            wp.launch(
                raise_power,
                count,
                inputs=[first, matrix, powers[number], state.w, now],
                outputs=[old],
                device=model.device,
            )
            continue
        medium, mass = model.medium, model.mass
        wp.launch(
            drift_vertices,
            count,
            inputs=[first, medium, matrix, powers[number], mass, state.w, state.mean_w, now, old],
            outputs=[state.x, state.v, state.lost, state.runaway],
            device=model.device,
        )


def end_step(model: Model, state: State) -> None:
    """Move the tools, and go to the next step."""
    if model.scene.tools:
        wp.launch(
            advance_tools,
            len(model.scene.tools),
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
            device=model.device,
        )
    wp.launch(count_step, 1, outputs=[state.step], device=model.device)


def advance(part: Part) -> None:
    """Move vertices and tools, and go to the next step; for a part that is the whole."""
    advance_plies(part)
    if part.model.selective is not None:
        for number in range(len(part.model.selective.powers)):
            raise_power_of(part, number)
    end_step(part.model, part.moving)


def gather_forces(part: Part, parts: Sequence[Part]) -> None:
    """Add to a part's vertices the forces that the other parts have scattered there."""
    ours = part.moving.f
    for first, count in part.vertices:
        for other in parts:
            if other is part:
                continue
            inputs = [first, count, other.scattering.f]
            wp.launch(take_over, 1, inputs=inputs, outputs=[ours], device=ours.device)


def gather_totals(parts: Sequence[Part]) -> None:
    """Add the forces on tools and clamps that the parts have apart to those of part 0."""
    for other in parts[1:]:
        for name in ("reaction", "clamp_force"):
            ours, theirs = (getattr(part.moving, name) for part in (parts[0], other))
            if ours.size:
                inputs = [0, ours.size, theirs]
                wp.launch(take_over, 1, inputs=inputs, outputs=[ours], device=ours.device)


def gather_extremes(parts: Sequence[Part]) -> None:
    """Raise the extremes of part 0 to those that the other parts have seen."""
    for other in parts[1:]:
        for name in ("tool_deepest", "ply_deepest", "ply_jump"):
            ours, theirs = (getattr(part.moving, name) for part in (parts[0], other))
            if ours.size:
                wp.launch(raise_to, ours.size, inputs=[theirs], outputs=[ours], device=ours.device)
        ours, theirs = parts[0].moving.runaway, other.moving.runaway
        wp.launch(note_runaway, 1, inputs=[theirs], outputs=[ours], device=ours.device)
