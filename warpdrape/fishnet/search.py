"""``wd.best_fishnet``: the start and the warp direction from which a net shears least."""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np
import shapely
import shapely.affinity
from scipy.optimize import minimize

from warpdrape.errors import InputError, finite, one_of
from warpdrape.errors import length as size
from warpdrape.fishnet.drape import (
    SHEAR_LIMIT,
    as_surface,
    begin_at,
    counts_of,
    read_outline,
    wanted_nodes,
)
from warpdrape.fishnet.net import Net
from warpdrape.fishnet.solver import Begin, lay_out
from warpdrape.fishnet.surface import NetSurface

OBJECTIVES = ("largest", "past_locking")
COARSE = 1.0 / 30.0
"""Spacing of the nets that are tried, over the surface's size, where the asked one is finer [-]."""
STARTS = 64
"""Starts that are tried, spread over the surface."""
QUARTERS = (0.25, 0.5, 0.75)
"""Of the surface's width, at which more starts are tried: its middle and those of its halves."""
DIRECTIONS = 6
"""Warp directions that are tried at each, over a right angle."""
REFINED = 9
"""Best starts, with their best direction each, that are improved."""
STEPS = 60
"""Nets that are tried for each improvement, and once more for the best of them."""
ALIKE = 1e-6
"""Share of a blank's area that a turned one may not cover of it, for both to be one."""
UNCOVERED = 4.0
"""Cost of leaving the whole surface, or blank, uncovered [rad]: more than any shear."""


def best_fishnet(
    surface: Any,
    spacing: float,
    *,
    objective: str = "largest",
    locking: float | None = None,
    outline: Sequence[Sequence[float]] | None = None,
    yarn_angle: float = 0.5 * math.pi,
    shear_limit: float = SHEAR_LIMIT,
    holes: str = "span",
    scale: float = 1.0,
) -> Net:
    """Lay the net whose start and warp direction make it shear least; some seconds.

    Starts spread over the surface are tried with a few directions each on a coarse net, and the
    best of them improved by the simplex method of Nelder and Mead, which takes no slopes: the cost
    jumps wherever a crossover leaves the surface. What a net leaves uncovered counts too, so that a
    small net does not win.

    Args:
        surface: a mould, as for `drape_fishnet`.
        spacing: of the crossovers of the net returned [m].
        objective: "largest" makes the largest shear angle small, "past_locking" the share of the
            net that is sheared past locking.
        locking: angle of the fabric [rad], for "past_locking".
        outline: of the flat blank, as for `drape_fishnet`; its origin is put at the start.
        yarn_angle: from warp to weft in the flat ply [rad].
        shear_limit: shear angle at which a net ends [rad].
        holes: "span" or "end".
        scale: metres per unit of a mesh or file.

    Raises:
        InputError: as `drape_fishnet`, or where ``locking`` is missing.
    """
    mould = as_surface(surface, holes, scale)
    size("spacing", spacing)
    one_of("objective", objective, OBJECTIVES)
    if objective == "past_locking" and locking is None:
        raise InputError("objective = 'past_locking' needs locking = …, the fabric's angle [rad]")
    if locking is not None:
        finite("locking", locking, unit="rad")
    ring = None if outline is None else read_outline(outline)
    coarse = max(spacing, COARSE * mould.size)

    def net_from(begin: Begin, step: float) -> Net:
        counts = counts_of(mould, begin, step, ring)
        net = lay_out(mould, begin, step, counts, limit=shear_limit)
        return net if ring is None else net.within(wanted_nodes(net, ring))

    def cost(begin: Begin) -> float:
        return cost_of(net_from(begin, coarse), objective, locking, ring)

    turns = _turns(ring, yarn_angle)
    tried = [
        min(((cost(begin), begin) for begin in _turned(start, turns)), key=lambda pair: pair[0])
        for start in _starts(mould, yarn_angle)
    ]
    tried.sort(key=lambda pair: pair[0])
    wide = math.sqrt(mould.area / len(tried))
    turn = float(turns[1] - turns[0])
    better = [_improve(mould, begin, 0.5 * wide, 0.5 * turn, cost) for _, begin in tried[:REFINED]]
    better.append(_improve(mould, min(better, key=cost), 0.1 * wide, 0.1 * turn, cost))
    nets = [net_from(begin, spacing) for begin in (*better, tried[0][1])]
    return min(nets, key=lambda net: cost_of(net, objective, locking, ring))


def cost_of(net: Net, objective: str, locking: float | None, ring: np.ndarray | None) -> float:
    """What a net costs: its shear [rad], or share past locking [-], and what it leaves uncovered.

    Args:
        net: the net.
        objective: "largest" or "past_locking".
        locking: angle of the fabric [rad].
        ring: outline of the blank, None where the surface is to be covered.
    """
    shear = np.abs(net.shear_angle[net.cells])
    if not len(shear):
        return 2.0 * UNCOVERED
    if ring is None:
        covered = net.spacing**2 * np.cos(shear).sum() * math.sin(net.yarn_angle)
        whole = net.surface.area
    else:
        covered = len(shear) * net.spacing**2 * math.sin(net.yarn_angle)
        x, y = ring.T
        whole = 0.5 * abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1)))
    missing = max(0.0, 1.0 - covered / whole)
    value = float(shear.max()) if objective == "largest" else float((shear > locking).mean())
    return value + UNCOVERED * missing


def _turns(ring: np.ndarray | None, yarn_angle: float) -> np.ndarray:
    """Directions that are tried [rad]: over the angle by which a turned ply is the same again.

    A net that covers the surface is, turned by a right angle, the same with warp and weft
    exchanged, if they are at right angles; else by two. A blank that is cut to an outline is the
    same where the outline is.
    """
    quarter = 0.5 * math.pi
    square = math.isclose(yarn_angle, quarter, abs_tol=1e-9)
    if square and (ring is None or _same_turned(ring, 1)):
        right_angles = 1
    else:
        right_angles = 2 if ring is None or _same_turned(ring, 2) else 4
    count = right_angles * DIRECTIONS
    return right_angles * quarter / count * np.arange(count)


def _same_turned(ring: np.ndarray, right_angles: int) -> bool:
    """Whether an outline turned about its origin by right angles is itself."""
    blank = shapely.Polygon(ring)
    turned = shapely.affinity.rotate(blank, 90.0 * right_angles, origin=(0.0, 0.0))
    return blank.symmetric_difference(turned).area <= ALIKE * blank.area


def _turned(begin: Begin, turns: np.ndarray) -> list[Begin]:
    """One start in all directions."""
    return [replace(begin, warp=begin.warp + float(turn)) for turn in turns]


def _starts(surface: NetSurface, yarn_angle: float) -> list[Begin]:
    """Starts spread over the surface, each the farthest from all before it; and symmetric ones.

    Many parts are alike to both sides of their middle, or of that of each half: there, and along
    the part, a net fits a border as it does nowhere beside.
    """
    whole = np.flatnonzero(~surface.spanned)
    middles = surface.points[surface.facets[whole]].mean(axis=1)
    first = begin_at(surface, None, _any_along(surface), yarn_angle)
    far = np.linalg.norm(middles - surface.in_space(*_one(first))[0], axis=1)
    starts = [first]
    for _ in range(min(STARTS - 1, len(middles) - 1)):
        number = int(np.argmax(far))
        far = np.minimum(far, np.linalg.norm(middles - middles[number], axis=1))
        facet = int(whole[number])
        starts.append(Begin(facet, surface.in_facet(facet, middles[number]), 0.0, yarn_angle))
    return starts + _symmetric(surface, yarn_angle)


def _symmetric(surface: NetSurface, yarn_angle: float) -> list[Begin]:
    """The middle, and those of halves and quarters as seen from above, along x or y."""
    points = surface.points[np.unique(surface.facets)]
    low, wide = points.min(axis=0), np.ptp(points, axis=0)
    along = np.eye(3)[int(np.argmax(wide[:2]))]
    starts = []
    for x in QUARTERS:
        for y in QUARTERS:
            at = surface.top_at(low[:2] + wide[:2] * (x, y))
            with suppress(InputError):  # where the surface stands upright
                starts.append(begin_at(surface, at, along, yarn_angle))
    return starts


def _improve(surface: NetSurface, begin: Begin, step: float, turn: float, cost: Any) -> Begin:
    """Move start and direction to where the cost is least, by Nelder and Mead's simplex.

    Args:
        surface: to lie on.
        begin: where it begins.
        step: first step of the start [m].
        turn: first turn of the direction [rad].
        cost: of a start and direction.
    """
    at = surface.in_space(*_one(begin))[0]
    first, second, _ = surface.frames[begin.facet]
    warp = math.cos(begin.warp) * first + math.sin(begin.warp) * second

    def begun(numbers: np.ndarray) -> Begin:
        facets, places = surface.nearest((at + numbers[0] * first + numbers[1] * second)[None])
        facet = int(facets[0])
        frame = surface.frames[facet]
        flat = frame @ warp
        angle = math.atan2(flat[1], flat[0]) + numbers[2]
        return Begin(facet, surface.in_facet(facet, places[0]), angle, begin.yarn_angle)

    simplex = np.zeros((4, 3))
    simplex[1, 0] = simplex[2, 1] = step
    simplex[3, 2] = turn
    options = {"maxfev": STEPS, "initial_simplex": simplex, "xatol": 1e-6, "fatol": 1e-6}
    found = minimize(lambda n: cost(begun(n)), np.zeros(3), method="Nelder-Mead", options=options)
    return begun(found.x)


def _one(begin: Begin) -> tuple[np.ndarray, np.ndarray]:
    return np.array([begin.facet]), np.asarray(begin.place)[None]


def _any_along(surface: NetSurface) -> np.ndarray:
    """A direction that is hardly square to the surface anywhere near its top."""
    points = surface.points[np.unique(surface.facets)]
    return np.eye(3)[int(np.argmax(np.ptp(points, axis=0)))] + np.array([1e-3, 2e-3, 3e-3])
