"""Tool surfaces swept round a plan outline: walls, rounded edges, flats inside and outside.

A profile (d, z) is drawn as for `revolve`, with d the distance outward from the outline in place of
the radius. Along a straight side it is extruded, round a corner revolved: the surface is exact, and
so are its normals.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import cast

import numpy as np
import trimesh

from warpdrape.errors import InputError
from warpdrape.errors import length as size
from warpdrape.tools.profile import (
    Arc,
    Piece,
    Surface,
    facets_between,
    refuse_too_many,
    sample_pieces,
)


def sweep(plan: list[Piece], pieces: list[Piece], facet: float) -> Surface:
    """Sweep a profile round a closed outline.

    Args:
        plan: outline in x, y, counter-clockwise; see `warpdrape.tools.plan`.
        pieces: profile of lines and arcs in (d, z), d outward from the outline [m].
        facet: facet size aimed at [m].

    Raises:
        InputError: if the outline does not close, or the profile reaches over the centre of one of
            its arcs.
    """
    at, out = sample_plan(plan, facet)
    ends, normals = sample_pieces(pieces, facet)
    _refuse_crossing(plan, ends[..., 0])
    refuse_too_many(len(ends) * len(at), facet)
    d, z = ends[..., 0, None, None], ends[..., 1, None]
    across, up = normals[..., 0, None, None], normals[..., 1, None]
    one = np.ones(len(at))
    points = np.concatenate([at + d * out, (z * one)[..., None]], axis=-1)
    directions = np.concatenate([across * out, (up * one)[..., None]], axis=-1)
    return facets_between(points, directions)


def sample_plan(plan: list[Piece], facet: float) -> tuple[np.ndarray, np.ndarray]:
    """Points of a closed outline [m] and its outward normals; the first point comes last again.

    Returns:
        Both of shape [n + 1, 2].
    """
    ends, left = sample_pieces(plan, facet)
    if np.linalg.norm(ends[-1, 1] - ends[0, 0]) > 1e-9:
        raise InputError("a plan outline must end where it starts")
    at = np.vstack([ends[:, 0], ends[:1, 0]])  # closes on the very same point
    return at, -np.vstack([left[:, 0], left[:1, 0]])


def flat_inside(plan: list[Piece], offset: float, z: float, up: bool, facet: float) -> Surface:
    """A flat that fills an outline.

    Args:
        plan: the outline, star-shaped about its middle.
        offset: of the flat's rim from it, outward [m].
        z: height [m].
        up: whether it faces up, else down.
        facet: facet size of the rim [m].
    """
    at, out = sample_plan(plan, facet)
    rim = at + offset * out
    middle = rim[:-1].mean(axis=0)
    _refuse_unless_round(rim - middle)
    shares = np.array([0.0, 1.0])[:, None, None]
    return _flat((middle + shares * (rim - middle))[None], z, up)


def flat_outside(
    plan: list[Piece], offset: float, radius: float, z: float, up: bool, facet: float
) -> Surface:
    """A flat between an outline and a circle about the origin.

    Args:
        plan: the outline, star-shaped about the origin.
        offset: of the flat's inner rim from it, outward [m].
        radius: of the circle [m].
        z: height [m].
        up: whether it faces up, else down.
        facet: facet size [m].
    """
    at, out = sample_plan(plan, facet)
    rim = at + offset * out
    _refuse_unless_round(rim)
    far = np.linalg.norm(rim, axis=1)
    if size("radius of the flat", radius) <= far.max():
        raise InputError(
            f"radius of the flat = {radius:.4g} m must exceed that of its hole, {far.max():.4g} m"
        )
    rows = math.ceil((radius - far.min()) / (4.0 * facet))  # flat, as `Line.sample`
    refuse_too_many(rows * len(at), facet)
    shares = np.linspace(0.0, 1.0, rows + 1)[:, None, None]
    rings = rim + shares * (rim * (radius / far)[:, None] - rim)
    return _flat(np.stack([rings[:-1], rings[1:]], axis=1), z, up)


def joined(parts: Sequence[Surface]) -> Surface:
    """Surfaces as one, connected where they have points in common."""
    mesh = cast(trimesh.Trimesh, trimesh.util.concatenate([part.mesh for part in parts]))
    mesh.merge_vertices()
    normals = np.concatenate([part.normals for part in parts])
    return Surface(mesh, normals, exact=all(part.exact for part in parts))


def turned_over(surface: Surface) -> Surface:
    """The surface that faces the other way."""
    mesh = trimesh.Trimesh(surface.mesh.vertices, surface.mesh.faces[:, ::-1], process=False)
    return Surface(mesh, -surface.normals[:, ::-1], surface.exact)


def _flat(rings: np.ndarray, z: float, up: bool) -> Surface:
    """Facets between pairs of rings [row, 2, position, 2], the inner first, going outward."""
    shape = (*rings.shape[:-1], 1)
    points = np.concatenate([rings, np.full(shape, z)], axis=-1)
    normals = np.concatenate([np.zeros_like(rings), np.full(shape, 1.0)], axis=-1)
    flat = facets_between(points, normals)
    return flat if up else turned_over(flat)


def _refuse_crossing(plan: list[Piece], distances: np.ndarray) -> None:
    """Raise `InputError` where the profile goes beyond the centre of an arc of the outline."""
    for arc in plan:
        if not isinstance(arc, Arc):
            continue
        hollow = arc.end < arc.start
        reach = float(distances.max()) if hollow else -float(distances.min())
        if reach > arc.radius * (1.0 + 1e-9):
            what = "hollow" if hollow else "corner"
            raise InputError(
                f"the profile reaches {reach:.4g} m over a {what} of radius {arc.radius:.4g} m of "
                "its outline: take a larger radius there, or a smaller one in the profile"
            )


def _refuse_unless_round(rim: np.ndarray) -> None:
    """Raise `InputError` unless an outline goes round the origin without turning back."""
    x, y = rim[:-1].T
    ahead, up = rim[1:].T
    if (x * up - y * ahead).min() < -1e-9 * np.abs(rim).max() ** 2:
        raise InputError(
            "the outline turns back as seen from its middle: make its waist wider, or its ends "
            "nearer to each other"
        )
