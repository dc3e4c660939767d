"""Which launches a thread makes: parts of the model that share nothing they write.

A part is a share of every ply's elements and of every ply's vertices. Elements and ply contacts
scatter into arrays of the part's own; tool contact and integration then work on its vertices, once
the forces that the others scattered there have been added. With one part nothing is doubled.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import warp as wp

from warpdrape.dynamics.model import Model, PlyPair, State
from warpdrape.forces.membrane import Membrane

MOST_RUNS = 8
"""Runs of consecutive vertices that a part of a ply may have, each a launch more. Where more would
be needed for vertices to lie beside their elements, a ply is cut by vertex number alone."""

SHORT = 16
"""A run goes to the part of the one before it where it has less than one in so many of a part."""
LARGEST = 1.15
"""Vertices of a part over the mean beyond which a ply is cut so too [-]."""


class Run(NamedTuple):
    """Consecutive entries of an array."""

    first: int
    count: int


class Contacts(NamedTuple):
    """Vertices of one ply that a part looks at for contact with another."""

    number: int
    """Of the pair of plies."""
    pair: PlyPair
    first_vertex: int
    first_slot: int
    count: int


@dataclass(frozen=True, eq=False)
class Part:
    """What one part of a model launches.

    Attributes:
        number: of the part; 0 also moves the tools and adds up what the parts have apart.
        model: the whole model.
        loads: the elements, as `Membrane.loads`.
        vertices: those that it moves.
        contacts: those that it looks at for contact between plies.
        plies: numbers of the plies whose query mesh it moves along.
        scattering: the state with this part's own array of forces.
        moving: likewise, and with its own tool reactions, clamp forces and extremes.
    """

    number: int
    model: Model
    loads: tuple[tuple[Any, int, list], ...]
    vertices: tuple[Run, ...]
    contacts: tuple[Contacts, ...]
    plies: tuple[int, ...]
    scattering: State
    moving: State


def split(model: Model, state: State, count: int) -> tuple[Part, ...]:
    """Cut a model into parts of about the same work.

    Args:
        model: the model.
        state: its state; part 0 works on it directly.
        count: number of parts.
    """
    owners = [_vertex_owners(model, membrane, count) for membrane in model.membranes]
    return tuple(_part(model, state, count, number, owners) for number in range(count))


def _part(
    model: Model, state: State, count: int, number: int, owners: Sequence[np.ndarray]
) -> Part:
    loads, contacts = [], []
    runs = []
    for membrane, owner in zip(model.membranes, owners, strict=True):
        for kernel, total, inputs in membrane.loads:
            first, n = _share(total, count, number)
            if n:
                loads.append((kernel, n, [inputs[0] + first, *inputs[1:]]))
        runs.append([Run(membrane.first_vertex + r.first, r.count) for r in _runs(owner == number)])
    for pair_number, pair in enumerate(model.ply_pairs):
        shift = pair.first_slot - model.membranes[pair.searching].first_vertex
        contacts += [
            Contacts(pair_number, pair, run.first, run.first + shift, run.count)
            for run in runs[pair.searching]
        ]
    own = (lambda array: array) if number == 0 else wp.zeros_like
    extremes = ("tool_deepest", "ply_deepest", "ply_jump", "reaction", "clamp_force")
    runaway = state.runaway if number == 0 else wp.clone(state.runaway)
    scattering = replace(state, f=own(state.f))
    return Part(
        number=number,
        model=model,
        loads=tuple(loads),
        vertices=_joined([run for of_ply in runs for run in of_ply]),
        contacts=tuple(contacts),
        plies=tuple(range(number, len(model.membranes), count)),
        scattering=scattering,
        moving=replace(
            scattering, runaway=runaway, **{k: own(getattr(state, k)) for k in extremes}
        ),
    )


def _share(total: int, count: int, number: int) -> Run:
    """Part ``number`` of ``total`` things cut into ``count`` runs."""
    first, last = total * number // count, total * (number + 1) // count
    return Run(first, last - first)


def _vertex_owners(model: Model, membrane: Membrane, count: int) -> np.ndarray:
    """Part of every vertex of a ply: that of the first element beside it, shape [vertex].

    By number alone where its vertices would lie scattered, or the parts differ too much.
    """
    n = membrane.vertex_count
    by_number = np.arange(n) * count // n
    if count == 1:
        return by_number
    position = np.empty(membrane.triangle_count, np.int64)
    position[membrane.order] = np.arange(membrane.triangle_count)
    part = position * count // membrane.triangle_count
    owner = np.full(n, count)
    corners = membrane.triangles.numpy() - membrane.first_vertex
    np.minimum.at(owner, corners, part[:, None])
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
