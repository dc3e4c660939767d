"""Which launches a thread makes: parts of the model that share nothing they write.

A part is a share of every ply's elements and of every ply's vertices. Elements and ply contacts
scatter into arrays of the part's own; tool contact and integration then work on its vertices, once
the forces that the others scattered there have been added. With one part nothing is doubled.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from warpdrape.dynamics.model import Model
from warpdrape.interaction import Launches, Run, Share, bodies_of
from warpdrape.state import State, with_own

MOST_RUNS = 8
"""Runs of consecutive vertices that a part of a ply may have, each a launch more. Where more would
be needed for vertices to lie beside their elements, a ply is cut by vertex number alone."""

SHORT = 16
"""A run goes to the part of the one before it where it has less than one in so many of a part."""
LARGEST = 1.15
"""Vertices of a part over the mean beyond which a ply is cut so too [-]."""


@dataclass(frozen=True, eq=False)
class Part:
    """What one part of a model launches.

    Attributes:
        number: of the part; 0 also moves the tools and adds up what the parts have apart.
        model: the whole model.
        vertices: those that it moves.
        launches: of all forces and contacts, in their order.
        state: the state, with this part's own arrays where parts have them apart.
    """

    number: int
    model: Model
    vertices: tuple[Run, ...]
    launches: Launches
    state: State


def split(model: Model, state: State, count: int) -> tuple[Part, ...]:
    """Cut a model into parts of about the same work.

    Args:
        model: the model.
        state: its state; part 0 works on it directly.
        count: number of parts.
    """
    parts = []
    for number, share in enumerate(shares(model, count)):
        own = state if number == 0 else with_own(state)
        every = launches_of(model, share, own)
        parts.append(Part(number, model, share.vertices, sum(every, Launches()), own))
    return tuple(parts)


def launches_of(model: Model, share: Share, state: State) -> list[Launches]:
    """What a part launches for each force and contact, in the model's order."""
    bodies = bodies_of(state)
    return [
        thing.launches(share, bodies, memory)
        for thing, memory in zip(model.interactions, state.memory, strict=True)
    ]


def shares(model: Model, count: int) -> tuple[Share, ...]:
    """Which vertices each of so many parts moves."""
    by_part: list[list[tuple[Run, ...]]] = [[] for _ in range(count)]
    order = model.forces[0].order  # the membrane's elements are most of the work
    for number, span in enumerate(model.spans):
        owner = _vertex_owners(model, number, order[number], count)
        for part, runs in enumerate(by_part):
            own = [Run(span.first_vertex + r.first, r.count) for r in _runs(owner == part)]
            runs.append(tuple(own))
    return tuple(
        Share(part, count, _joined([run for of_ply in runs for run in of_ply]), tuple(runs))
        for part, runs in enumerate(by_part)
    )


def _vertex_owners(model: Model, number: int, order: np.ndarray, count: int) -> np.ndarray:
    """Part of every vertex of a ply: that of the first element beside it, shape [vertex].

    By number alone where its vertices would lie scattered, or the parts differ too much.
    """
    span = model.spans[number]
    n, m = span.vertex_count, span.triangle_count
    by_number = np.arange(n) * count // n
    if count == 1:
        return by_number
    position = np.empty(m, np.int64)
    position[order] = np.arange(m)
    part = position * count // m
    owner = np.full(n, count)
    np.minimum.at(owner, np.asarray(model.scene.plies[number].mesh.triangles), part[:, None])
    for run in _runs_alike(owner):
        if run.count * SHORT < n / count and run.first > 0:  # a ragged end: not worth a launch
            owner[run.first : sum(run)] = owner[run.first - 1]
    runs = len(_runs_alike(owner))
    largest = np.bincount(owner, minlength=count).max() * count / n
    return owner if runs <= MOST_RUNS * count and largest <= LARGEST else by_number


def _runs_alike(values: np.ndarray) -> list[Run]:
    """Runs of equal values."""
    edges = np.flatnonzero(np.r_[True, np.diff(values) != 0, True])
    return [Run(int(a), int(b - a)) for a, b in pairwise(edges)]


def _runs(mask: np.ndarray) -> list[Run]:
    """Runs of the true entries of a mask."""
    edges = np.flatnonzero(np.diff(np.r_[False, mask, False]))
    return [Run(int(a), int(b - a)) for a, b in edges.reshape(-1, 2)]


def _joined(runs: Sequence[Run]) -> tuple[Run, ...]:
    """Runs, those that follow each other made one."""
    joined: list[Run] = []
    for run in runs:
        if joined and sum(joined[-1]) == run.first:
            joined[-1] = Run(joined[-1].first, joined[-1].count + run.count)
        elif run.count:
            joined.append(run)
    return tuple(joined)
