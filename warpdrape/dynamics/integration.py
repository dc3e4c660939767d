"""The launches that move plies and tools, and that add up what parts have apart."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import warp as wp

from warpdrape.dynamics.model import Model
from warpdrape.dynamics.partition import Part
from warpdrape.dynamics.selective_mass import SelectiveMass
from warpdrape.interaction import Swept
from warpdrape.kernels.dynamics.motion import (
    advance_clamped,
    advance_tools,
    advance_vertices,
    count_step,
)
from warpdrape.kernels.dynamics.parts import note_runaway, raise_to, take_over, take_over_each
from warpdrape.kernels.dynamics.selective_mass import drift_vertices, push_vertices, raise_power
from warpdrape.state import Across, State, all_arrays


def advance_plies(part: Part) -> None:
    """Move a part's vertices; with selective mass scaling push them only, see `raise_power_of`."""
    model, state = part.model, part.state
    if model.selective is not None:
        push_plies(part, model.selective)
        return
    plies, device = state.plies, model.device
    masses = [model.medium, model.mass, model.added_mass, model.clamp]
    for run in part.vertices:
        if model.scene.clamps:
            clamps = [model.rest, state.clamps.matrix, state.clamps.shift, state.step]
            outputs = [plies.x, plies.v, plies.f, state.clamps.work, state.clamps.force]
            Swept(advance_clamped, run, [*masses, *clamps], outputs)(device)
        outputs = [plies.x, plies.v, plies.f, plies.lost, plies.runaway]
        inputs = [*masses, state.loads.damping, state.step]
        Swept(advance_vertices, run, inputs, outputs)(device)


def push_plies(part: Part, scaling: SelectiveMass) -> None:
    """Advance the momenta of a part's vertices."""
    model, state = part.model, part.state
    for first, count in part.vertices:
        wp.launch(
            push_vertices,
            count,
            inputs=[
                first,
                model.medium,
                scaling.start,
                model.mass,
                state.loads.damping,
                state.step,
            ],
            outputs=[state.plies.f, state.scaled.w, state.scaled.mean_w, state.scaled.power_now],
            device=model.device,
        )


def raise_power_of(part: Part, scaling: SelectiveMass, number: int) -> None:
    """Do a step of the recurrence from momenta to velocities; the last one moves the vertices.

    The terms change places at every step: a part reads those that its neighbours made in the one
    before.
    """
    model, state = part.model, part.state
    matrix, powers = scaling.matrix, scaling.powers
    terms = [state.scaled.power_now, state.scaled.power_old]
    now, old = terms if number % 2 == 0 else reversed(terms)
    for first, count in part.vertices:
        if number < len(powers) - 1:
            wp.launch(
                raise_power,
                count,
                inputs=[first, matrix, powers[number], state.scaled.w, now],
                outputs=[old],
                device=model.device,
            )
            continue
        rates = [state.loads.damping, state.step]
        carried = [model.mass, *rates, state.scaled.w, state.scaled.mean_w, now, old]
        wp.launch(
            drift_vertices,
            count,
            inputs=[first, model.medium, matrix, powers[number], *carried],
            outputs=[state.plies.x, state.plies.v, state.plies.lost, state.plies.runaway],
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
                model.turning,
                state.tools.path,
                state.tools.force,
                state.tools.angle,
                state.step,
            ],
            outputs=[
                state.tools.turned,
                state.tools.shift,
                state.tools.velocity,
                state.tools.spin,
                state.tools.reaction,
                state.tools.moment,
                state.tools.impulse,
                state.tools.twist,
                state.tools.work,
                state.tools.damped,
            ],
            device=model.device,
        )
    wp.launch(count_step, 1, outputs=[state.step], device=model.device)


def advance(part: Part) -> None:
    """Move vertices and tools, and go to the next step; for a part that is the whole."""
    advance_plies(part)
    scaling = part.model.selective
    if scaling is not None:
        for number in range(len(scaling.powers)):
            raise_power_of(part, scaling, number)
    end_step(part.model, part.state)


def gather_forces(part: Part, parts: Sequence[Part]) -> None:
    """Add to a part's vertices what the others have scattered there: forces, heat, pressing."""
    ours, heat, pressing = part.state.plies.f, part.state.heat, part.state.pressing
    for first, count in part.vertices:
        for other in parts:
            if other is part:
                continue
            inputs = [first, count, other.state.plies.f]
            wp.launch(take_over, 1, inputs=inputs, outputs=[ours], device=ours.device)
            if heat is not None:
                inputs, outputs = [first, other.state.heat.power], [heat.power]
                wp.launch(take_over_each, count, inputs=inputs, outputs=outputs, device=ours.device)
            if pressing is not None:
                inputs, outputs = [first, other.state.pressing.pressing], [pressing.pressing]
                wp.launch(take_over_each, count, inputs=inputs, outputs=outputs, device=ours.device)


def gather_totals(parts: Sequence[Part]) -> None:
    """Add the forces on tools and clamps that the parts have apart to those of part 0."""
    for ours, theirs in _apart(parts, Across.SUMMED):
        inputs = [0, ours.size, theirs]
        wp.launch(take_over, 1, inputs=inputs, outputs=[ours], device=ours.device)


def gather_extremes(parts: Sequence[Part]) -> None:
    """Raise the extremes of part 0 to those that the other parts have seen."""
    for ours, theirs in _apart(parts, Across.LARGEST):
        wp.launch(raise_to, ours.size, inputs=[theirs], outputs=[ours], device=ours.device)
    for ours, theirs in _apart(parts, Across.FIRST):
        wp.launch(note_runaway, 1, inputs=[theirs], outputs=[ours], device=ours.device)


def _apart(parts: Sequence[Part], across: Across) -> Iterator[tuple[wp.array, wp.array]]:
    """Arrays of part 0, with those of each other part, that parts hold in one way."""
    for other in parts[1:]:
        both = zip(all_arrays(parts[0].state), all_arrays(other.state), strict=True)
        for (_, ours, held), (_, theirs, _) in both:
            if held is across and ours.size:
                yield ours, theirs
