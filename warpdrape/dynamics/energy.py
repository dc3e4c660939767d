"""The energy balance of a run: outside work in, everything stored and lost out."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from warpdrape.dynamics.model import Model
from warpdrape.interaction import Measured, bodies_of
from warpdrape.state import State


@dataclass(frozen=True)
class Energies:
    """Energies at one instant, and works done up to it [J].

    ``stored`` in the plies and ``lost`` by their forces are by name.
    """

    kinetic: float
    stored: Mapping[str, float]
    lost: Mapping[str, float]
    contact: float
    friction: float
    contact_damping: float
    mass_damping: float
    tool_damping: float
    tool_work: float
    clamp_work: float
    gravity_work: float
    load_work: float
    added_mass_kinetic: float

    @property
    def internal(self) -> float:
        """Stored in the plies [J]."""
        return sum(self.stored.values())

    @property
    def damping(self) -> float:
        """Lost in all dashpots [J]."""
        dashpots = self.contact_damping + self.mass_damping + self.tool_damping
        return dashpots + sum(self.lost.values())

    @property
    def external_work(self) -> float:
        """Done on the plies and floating tools by tools, clamps, gravity and loads [J]."""
        return self.tool_work + self.clamp_work + self.gravity_work + self.load_work

    @property
    def unbalanced(self) -> float:
        """Energy found over energy supplied [J]; positive where it came from nowhere."""
        found = self.kinetic + self.internal + self.contact + self.friction + self.damping
        return found - self.external_work

    @property
    def largest(self) -> float:
        """Size of the largest term [J]."""
        return max(
            abs(self.external_work), self.internal, self.kinetic, self.friction, self.damping
        )


def measure(model: Model, state: State) -> tuple[Measured, ...]:
    """What every force and contact shows now, in the model's order."""
    bodies = bodies_of(state)
    return tuple(
        thing.measure(bodies, memory)
        for thing, memory in zip(model.interactions, state.memory, strict=True)
    )


def internal_energy(model: Model, state: State) -> float:
    """Stored in the plies [J]."""
    return sum(_total(of_forces(model, measure(model, state))).values())


def taken_energy(model: Model, state: State) -> float:
    """Stored in the plies, and lost where they flow: what deforming them took [J]."""
    shown = of_forces(model, measure(model, state))
    return sum(_total(shown).values()) + sum(each.flowed for each in shown)


def of_forces(model: Model, measured: Sequence[Measured]) -> Sequence[Measured]:
    """What forces show, without contacts."""
    return measured[: len(model.forces)]


def _total(measured: Iterable[Measured], what: str = "stored") -> dict[str, float]:
    """Energies stored, or lost, by name [J]."""
    total: dict[str, float] = {}
    for each in measured:
        for name, energy in getattr(each, what).items():
            total[name] = total.get(name, 0.0) + energy
    return total


def kinetic_energy(model: Model, state: State) -> tuple[float, float]:
    """Of plies and floating tools, and what of it is owed to added mass [J].

    With selective mass scaling, momentum over lumped mass is w: ½ Σ m v·w.
    """
    v, mass = state.plies.v.numpy(), model.masses.mass
    w = v if model.selective is None else state.scaled.w.numpy()
    plies = 0.5 * mass @ np.einsum("ij,ij->i", v, w)
    unscaled = 0.5 * (mass - model.masses.added) @ np.einsum("ij,ij->i", v, v)
    floats = model.floating.floats.numpy() == 1
    tool_speed = (state.tools.velocity.numpy() ** 2).sum(axis=1)
    tools = 0.5 * (model.floating.mass.numpy() * tool_speed)[floats].sum()
    return float(plies + tools), float(plies - unscaled)


def gravity_work(model: Model, state: State) -> float:
    """Work of gravity on the plies up to the time of the velocities, half a step ago [J].

    Each kick is m g Δt and works at the mean of the velocities before and after: m g (x − Δt v / 2)
    in all, to the last bit of the kinetic energy that it makes.
    """
    gravity = np.asarray(model.scene.gravity, dtype=float)
    weighing = model.masses.mass - model.masses.added
    half_ago = state.plies.x.numpy() - 0.5 * model.timing.time_step * state.plies.v.numpy()
    return float(weighing @ (half_ago - model.rest.numpy()) @ gravity)


def balance(model: Model, state: State, measured: Sequence[Measured]) -> Energies:
    """Add up the energies: works as kinetic energy, half a step ago; what is stored, now.

    Args:
        model: the model.
        state: its state.
        measured: from `measure`.
    """
    kinetic, added = kinetic_energy(model, state)
    lost = np.einsum("ij->j", state.plies.lost.numpy())
    contacts = measured[len(model.forces) :]
    in_contact = _total(contacts, "lost")
    return Energies(
        kinetic=kinetic,
        stored=_total(of_forces(model, measured)),
        lost=_total(of_forces(model, measured), "lost"),
        contact=_total(contacts).get("contact", 0.0),
        friction=float(lost[0]) + in_contact.get("friction", 0.0),
        contact_damping=float(lost[1]) + in_contact.get("contact damping", 0.0),
        mass_damping=float(lost[2]),
        tool_damping=float(state.tools.damped.numpy().sum()),
        tool_work=float(state.tools.work.numpy().sum()),
        clamp_work=float(state.clamps.work.numpy().sum()),
        gravity_work=gravity_work(model, state),
        load_work=sum(each.work for each in measured),
        added_mass_kinetic=added,
    )
