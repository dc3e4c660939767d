"""The part between two tools that close on a stack: how thick it gets, and how full of fibres.

Where one tool lies under a ply and another over it, both facing it, the room between them is what a
filled cavity makes of the stack: the sum of the ways to the nearest point of each. A ply's share of
it is that of its own thickness in the stack, t = g t_0/Σ t_0, and V_f = m/(ρ t) · A0/A.

Nothing of it is a force: a room wider than the stack is filled by resin, one narrower by squeezing
it. What a ply's compaction law makes of pressures stands beside it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

FACING = math.cos(math.radians(30.0))
"""Cosine of the largest angle between a ply's normal and the way to a tool that faces it [-]."""


@dataclass(frozen=True, eq=False)
class Cavity:
    """What two tools make of a ply between them.

    Attributes:
        below: number of the tool on the ply's lower side.
        above: number of the tool on its upper side.
        inside: mask of the triangles between them, shape [m].
        room: between them, at the triangles inside [m], shape [inside].
    """

    below: int
    above: int
    inside: np.ndarray
    room: np.ndarray


def find_cavities(
    ways: np.ndarray, normals: np.ndarray, triangles: np.ndarray, widest: float
) -> list[Cavity]:
    """Find where pairs of tools close on a ply, those of the lowest numbers first.

    Args:
        ways: from the nearest point of each tool to each vertex [m], shape [tool, n, 3].
        normals: of the ply, unit, shape [n, 3].
        triangles: vertices, shape [m, 3].
        widest: room from which on tools make no cavity [m].
    """
    if len(ways) < 2:
        return []
    off = np.linalg.norm(ways, axis=2)
    along = (ways * normals).sum(axis=2)
    facing = np.abs(along) >= FACING * off
    sides = [np.where(facing & (side * along > 0.0), off, np.inf) for side in (1.0, -1.0)]
    room = sum(side.min(axis=0) for side in sides)
    pair = np.stack([side.argmin(axis=0) for side in sides], axis=1)
    at = pair[triangles]
    whole = (room[triangles] <= widest).all(axis=1) & (at == at[:, :1]).all(axis=(1, 2))
    cavities = []
    for below, above in np.unique(at[whole, 0], axis=0):
        inside = whole & (at[:, 0] == (below, above)).all(axis=1)
        rooms = room[triangles[inside]].mean(axis=1)
        cavities.append(Cavity(int(below), int(above), inside, rooms))
    return cavities
