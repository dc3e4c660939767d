"""The energy balance of a run: tool work and gravity in, everything stored and lost out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import warp as wp

from warpdrape.dynamics.model import Model, State


@dataclass(frozen=True)
class Energies:
    """Energies at one instant, and works done up to it [J]."""

    kinetic: float
    yarn: float
    shear: float
    stabiliser: float
    contact: float
    friction: float
    contact_damping: float
    mass_damping: float
    tool_damping: float
    tool_work: float
    clamp_work: float
    gravity_work: float
    added_mass_kinetic: float

    @property
    def internal(self) -> float:
        """Stored in the plies [J]."""
        return self.yarn + self.shear + self.stabiliser

    @property
    def damping(self) -> float:
        """Lost in all dashpots [J]."""
        return self.contact_damping + self.mass_damping + self.tool_damping

    @property
    def external_work(self) -> float:
        """Done on the plies and floating tools by tools, clamps and gravity [J]."""
        return self.tool_work + self.clamp_work + self.gravity_work

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


def measure_membranes(model: Model, state: State) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Yarn strains [-], line tensions [N/m] and (yarn, shear, stabiliser) energy [J].

    Returns:
        Shapes [triangle, 2], [triangle, 2] and [triangle, 3].
    """
    strains, tensions, energies = [], [], []
    for membrane in model.membranes:
        n = membrane.triangle_count
        strain = wp.empty(n, dtype=wp.vec2d, device=model.device)
        tension = wp.empty(n, dtype=wp.vec2d, device=model.device)
        energy = wp.empty(n, dtype=wp.vec3d, device=model.device)
        kernel, count, inputs = membrane.measurement
        wp.launch(
            kernel,
            count,
            inputs=[*inputs, state.x],
            outputs=[strain, tension, energy],
            device=model.device,
        )
        strains.append(strain.numpy())
        tensions.append(tension.numpy())
        energies.append(energy.numpy())
    return np.concatenate(strains), np.concatenate(tensions), np.concatenate(energies)


def kinetic_energy(model: Model, state: State) -> tuple[float, float]:
    """Of plies and floating tools, and what of it is owed to added mass [J].

    With selective mass scaling, momentum over lumped mass is w: ½ Σ m v·w.
    """
    v, mass = state.v.numpy(), model.masses.mass
    w = v if model.selective is None else state.w.numpy()
    plies = 0.5 * mass @ np.einsum("ij,ij->i", v, w)
    unscaled = 0.5 * (mass - model.masses.added) @ np.einsum("ij,ij->i", v, v)
    floats = model.floating.floats.numpy() == 1
    tool_speed = (state.tool_velocity.numpy() ** 2).sum(axis=1)
    tools = 0.5 * (model.floating.mass.numpy() * tool_speed)[floats].sum()
    return float(plies + tools), float(plies - unscaled)


def balance(model: Model, state: State, membrane_energy: np.ndarray) -> Energies:
    """Add up the energies.

    Args:
        model: the model.
        state: its state.
        membrane_energy: (yarn, shear, stabiliser) [J], shape [triangle, 3].
    """
    scene = model.scene
    x = state.x.numpy()
    kinetic, added = kinetic_energy(model, state)
    lost = np.einsum("ij->j", state.lost.numpy())
    gravity = np.asarray(scene.gravity, dtype=float)
    weighing = model.masses.mass - model.masses.added
    fallen = np.einsum("i,ij->j", weighing, x - model.rest.numpy())
    yarn, shear, stabiliser = np.einsum("ij->j", membrane_energy)
    return Energies(
        kinetic=kinetic,
        yarn=float(yarn),
        shear=float(shear),
        stabiliser=float(stabiliser),
        contact=float(state.tool_holds.numpy()["stored"].sum() + state.ply_stored.numpy().sum()),
        friction=float(lost[0]),
        contact_damping=float(lost[1]),
        mass_damping=float(lost[2]),
        tool_damping=float(state.tool_damped.numpy().sum()),
        tool_work=float(state.tool_work.numpy().sum()),
        clamp_work=float(state.clamp_work.numpy().sum()),
        gravity_work=float(fallen @ gravity),
        added_mass_kinetic=added,
    )
