"""Where two tools press one ply from both sides closer together than it is thick."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from warpdrape.contact.tool_contact import ToolContact, ToolMemory
from warpdrape.interaction import Interaction
from warpdrape.state import State

OPPOSED = -0.5
"""Cosine between the tools' normals below which they press against each other [-]."""


@dataclass(frozen=True)
class Squeeze:
    """A vertex between two tools that leave it less room than its ply is thick.

    Attributes:
        vertex: its number in the model.
        tools: numbers of the tools.
        depth: by how much they are too close [m].
        thickness: of the ply [m].
    """

    vertex: int
    tools: tuple[int, int]
    depth: float
    thickness: float

    @property
    def share(self) -> float:
        """Depth over thickness [-]."""
        return self.depth / self.thickness


def worst_squeeze(interactions: Sequence[Interaction], state: State) -> Squeeze | None:
    """The deepest squeeze of now over the thickness of its ply; None where there is none.

    Args:
        interactions: forces and contacts of the model.
        state: its state.
    """
    for contact, memory in zip(interactions, state.memory, strict=True):
        if isinstance(contact, ToolContact):
            return _worst(state, contact, memory)
    return None


def _worst(state: State, contact: ToolContact, memory: ToolMemory) -> Squeeze | None:
    count, x = len(contact.meshes), state.plies.x.numpy()
    half, planes = contact.offset.numpy(), memory.planes.numpy().reshape(count, -1)
    pressed = (memory.holds.numpy()["stored"] > 0.0).reshape(count, -1)
    shift = state.tools.shift.numpy()
    worst, found = 0.0, None
    for one in range(count):
        for other in range(one):
            at = np.flatnonzero(pressed[one] & pressed[other])
            if not len(at):
                continue
            normals = [planes[tool]["normal"][at] for tool in (one, other)]
            against = (normals[0] * normals[1]).sum(axis=1) < OPPOSED
            depth = np.zeros(len(at))
            for tool, normal in zip((one, other), normals, strict=True):
                gap = (normal * (x[at] - shift[tool])).sum(axis=1) - planes[tool]["level"][at]
                depth += np.maximum(-gap, 0.0)
            share = np.where(against, depth / (2.0 * half[at]), 0.0)
            k = int(np.argmax(share))
            if share[k] > worst:
                worst = float(share[k])
                found = Squeeze(int(at[k]), (other, one), float(depth[k]), 2.0 * half[at[k]])
    return found
