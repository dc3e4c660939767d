"""Energy that came from nowhere: where it is now, what touches there, and what to do."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from warpdrape.dynamics.energy import Energies
from warpdrape.interaction import Measured
from warpdrape.setup import Setup

OF_CONTACTS = ("energy of contacts", "loss in contact damping", "loss in friction")


def why_it_grew(
    scene: Setup,
    grown: Mapping[str, float],
    measured: Sequence[Measured],
    ply: int,
    vertex: int,
) -> str:
    """Say what presses the fastest vertex, as what energy came most, and what may help.

    Args:
        scene: what is computed.
        grown: by how much `found` has grown since the frame before [J].
        measured: what forces and contacts show.
        ply: number of the ply of the fastest vertex.
        vertex: its number in the model.
    """
    most = max(grown, key=lambda words: grown[words])
    tools = [f"tool {scene.tools[row].name!r}" for row in _pressing(measured, "tool", vertex)]
    plies = ["a ply"] if _pressing(measured, "contact", vertex) else []
    where = f"pressed by {' and '.join(tools + plies)}" if tools + plies else "touching nothing"
    remedy = "lower safety"
    if tools or plies or most in OF_CONTACTS:
        finer = [*tools, f"ply {scene.plies[ply].name!r}"]
        remedy = f"lower safety or contact_share, or refine {' or '.join(finer)}"
    return f"what is fastest is {where}, and most of the energy came as {most}; {remedy}"


def found(energies: Energies) -> dict[str, float]:
    """All energy that there is, or was lost so far [J], by what it is in words."""
    contacts = (energies.contact, energies.contact_damping, energies.friction)
    return {
        "motion": energies.kinetic,
        **dict(zip(OF_CONTACTS, contacts, strict=True)),
        **{f"energy of the plies ({name})": each for name, each in energies.stored.items()},
        **{f"loss in the plies ({name})": each for name, each in energies.lost.items()},
        "loss in damping": energies.mass_damping + energies.tool_damping,
    }


def _pressing(measured: Sequence[Measured], what: str, vertex: int) -> list[int]:
    """Rows, tools or faces, of which a vertex feels a normal force."""
    name = f"{what}_pressure"
    forces = [each.pressing[name][:, vertex] for each in measured if name in each.pressing]
    return np.flatnonzero(np.sum(forces, axis=0)).tolist() if forces else []
