"""Which runs are best: feasible before infeasible, by one objective or by Pareto's order of two."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from warpdrape.optimisation.aims import Score


def dominates(one: Sequence[float], other: Sequence[float]) -> bool:
    """Whether one is no worse in anything and better in something; small is good."""
    pairs = list(zip(one, other, strict=True))
    return all(a <= b for a, b in pairs) and any(a < b for a, b in pairs)


def front_of(points: Sequence[Sequence[float]]) -> list[int]:
    """Which points no other one dominates; of equal ones the first."""
    return [
        k
        for k, one in enumerate(points)
        if not any(dominates(other, one) for other in points)
        and not any(tuple(other) == tuple(one) for other in points[:k])
    ]


def ranked(scores: Sequence[Score]) -> list[int]:
    """All runs from the best to the worst.

    Feasible ones come first, by their front and within it those with most room about them; then
    those that violate constraints, by how much, each measured by its largest violation; then those
    that do not count.
    """
    feasible = [k for k, score in enumerate(scores) if score.feasible]
    violating = [k for k, score in enumerate(scores) if score.counts and not score.feasible]
    rest = [k for k, score in enumerate(scores) if not score.counts]
    order: list[int] = []
    while feasible:
        points = [scores[k].objectives for k in feasible]
        front = front_of(points)
        room = _room([points[k] for k in front])
        order += [feasible[front[k]] for k in np.argsort(-room, kind="stable")]
        feasible = [k for place, k in enumerate(feasible) if place not in set(front)]
    beyond = np.array([[max(e, 0.0) for e in scores[k].excess] for k in violating])
    if len(violating):
        largest = beyond.max(axis=0)
        sums = (beyond / np.where(largest > 0.0, largest, 1.0)).sum(axis=1)
        order += [violating[k] for k in np.argsort(sums, kind="stable")]
    return order + rest


def _room(points: Sequence[Sequence[float]]) -> np.ndarray:
    """Distance between the neighbours of each point of a front; the ends have most, shape [n]."""
    array = np.asarray(points, dtype=float)
    room = np.zeros(len(array))
    for column in array.T:
        order = np.argsort(column, kind="stable")
        width = column[order[-1]] - column[order[0]]
        room[order[[0, -1]]] = np.inf
        if width > 0.0 and len(order) > 2:
            room[order[1:-1]] += (column[order[2:]] - column[order[:-2]]) / width
    return room


def area_dominated(points: Sequence[Sequence[float]], corner: Sequence[float]) -> float:
    """Area between a front of two objectives and a corner that is worse than all of it.

    Args:
        points: objectives, small is good; those beyond the corner add nothing.
        corner: worst of both.
    """
    inside = [p for p in points if p[0] < corner[0] and p[1] < corner[1]]
    steps = sorted((inside[k] for k in front_of(inside)), key=tuple)
    area, height = 0.0, corner[1]
    for first, second in steps:
        area += (corner[0] - first) * (height - second)
        height = second
    return area
