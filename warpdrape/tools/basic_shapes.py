"""Surfaces of the tools that a press, a table or a roller is made of."""

from __future__ import annotations

import math

from warpdrape.errors import InputError, positive, said
from warpdrape.errors import length as size
from warpdrape.tools.profile import Arc, Line, Piece, Surface, extrude, revolve


def punch(radius: float, height: float | None, facet: float) -> Surface:
    """Hemisphere on a cylinder, pole at the origin, pointing down."""
    size("punch radius", radius)
    top = 1.5 * radius if height is None else size("punch height", height)
    if top <= radius:
        raise InputError(f"punch height = {top} m must exceed its radius {radius} m")
    pieces: list[Piece] = [
        Line((radius, top), (radius, radius)),
        Arc((0.0, radius), radius, 0.0, -math.pi / 2),
    ]
    return revolve(pieces, facet)


def die(hole: float, edge: float, outer: float, depth: float, facet: float) -> Surface:
    """Flat ring facing up at z = 0, its hole's edge rounded."""
    _check_ring("die", hole, edge, outer)
    bottom = -max(positive("die depth", depth, unit="m"), 1.1 * edge)
    pieces: list[Piece] = [
        Line((hole, bottom), (hole, -edge)),
        Arc((hole + edge, -edge), edge, math.pi, math.pi / 2),
        Line((hole + edge, 0.0), (outer, 0.0)),
    ]
    return revolve(pieces, facet)


def blank_holder(
    hole: float, edge: float, outer: float, facet: float, sector: tuple[float, float] | None
) -> Surface:
    """Flat ring facing down at z = 0, or a sector of one, its hole's edge rounded."""
    _check_ring("holder", hole, edge, outer)
    pieces: list[Piece] = [
        Line((outer, 0.0), (hole + edge, 0.0)),
        Arc((hole + edge, edge), edge, -math.pi / 2, -math.pi),
        Line((hole, edge), (hole, 5.0 * edge)),
    ]
    return revolve(pieces, facet, sector)


def table(radius: float, edge_radius: float, depth: float, facet: float) -> Surface:
    """Round table facing up at z = 0, its rim rounded."""
    size("table radius", radius)
    size("edge_radius", edge_radius)
    if edge_radius >= radius:
        raise InputError(f"edge_radius = {edge_radius} m must be below the table's {radius} m")
    size("depth", depth)
    flat, bottom = radius - edge_radius, -max(depth, 1.1 * edge_radius)
    pieces: list[Piece] = [
        Line((0.0, 0.0), (flat, 0.0)),
        Arc((flat, -edge_radius), edge_radius, math.pi / 2, 0.0),
        Line((radius, -edge_radius), (radius, bottom)),
    ]
    return revolve(pieces, facet)


def sphere(radius: float, facet: float) -> Surface:
    """Upper three quarters of a sphere, its pole at the origin, pointing up."""
    size("sphere radius", radius)
    return revolve([Arc((0.0, -radius), radius, math.pi / 2, -math.pi / 4)], facet)


def plate(width: float, height: float, facing: str, facet: float) -> Surface:
    """Flat plate at z = 0, centred at the origin, facing up or down."""
    size("plate width", width)
    if not isinstance(facing, str) or facing not in ("up", "down"):
        raise InputError(f"plate facing = {said(facing)} must be 'up' or 'down'")
    side = 0.5 * width if facing == "up" else -0.5 * width
    return extrude([Line((-side, 0.0), (side, 0.0))], height, facet)


def drum(radius: float, length: float, facet: float) -> Surface:
    """Cylinder about the y axis, centred at the origin."""
    size("drum radius", radius)
    return extrude([Arc((0.0, 0.0), radius, math.pi, -math.pi)], length, facet)


def _check_ring(kind: str, hole: float, edge: float, outer: float) -> None:
    size(f"{kind} hole_radius", hole)
    size(f"{kind} edge_radius", edge)
    if size(f"{kind} outer_radius", outer) <= hole + edge:
        raise InputError(
            f"{kind} outer_radius = {outer} m must exceed hole and edge radius, {hole + edge} m"
        )
