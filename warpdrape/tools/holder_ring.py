"""A flat blank holder round openings of any outline, their edges rounded."""

from __future__ import annotations

import math

import numpy as np
import shapely
import trimesh

from warpdrape.errors import InputError
from warpdrape.tools.profile import Arc, Line, Surface, facets_between, sample_pieces
from warpdrape.tools.sweep import joined

EDGE = 2e-3
"""Radius of the rounding at the opening [m]."""
FINE = 5e-5
"""How far an opening's outline may be off the one asked for [m]."""


def holder_ring(
    who: str,
    opening: shapely.Polygon | shapely.MultiPolygon,
    outer: shapely.Polygon,
    *,
    up: bool,
) -> Surface:
    """Make the holder, its flat at z = 0.

    Args:
        who: for errors.
        opening: the outline that stays free, of one shape or several [m].
        outer: where the holder ends [m].
        up: whether it faces up, else down.

    Raises:
        InputError: if the opening leaves nothing of it, or parts of it only.
    """
    # Re-entrant corners get a radius of twice the rounding's, so that it goes round them.
    flat_from = opening.buffer(3.0 * EDGE, quad_segs=8).buffer(-2.0 * EDGE, quad_segs=8)
    parts = shapely.get_parts(flat_from.simplify(FINE))
    free = shapely.get_parts(shapely.union_all([shapely.Polygon(part.exterior) for part in parts]))
    flat = outer.difference(shapely.MultiPolygon(free.tolist()))
    if not isinstance(flat, shapely.Polygon) or len(flat.interiors) != len(free):
        raise InputError(
            f"{who}: the flat rim round the mould's shape is too narrow for a blank holder, or "
            "does not go all round: leave the holder out, or give the mould a wider rim"
        )
    side = 1.0 if up else -1.0
    made = joined([*(_rounding(_loop(hole), side) for hole in flat.interiors), _sheet(flat, side)])
    made.mesh.merge_vertices()
    return made


def _loop(hole: shapely.LinearRing) -> np.ndarray:
    """Corners of a hole, counter-clockwise [m], shape [n, 2]."""
    loop = np.array(shapely.Polygon(hole).normalize().exterior.coords)[:-1]
    return loop if shapely.LinearRing(loop).is_ccw else loop[::-1]


def _rounding(loop: np.ndarray, side: float) -> Surface:
    """From the flat's inner rim over a quarter of a circle into the opening.

    Args:
        loop: of the rim, counter-clockwise [m], shape [n, 2].
        side: 1 for a holder that faces up, −1 for one that faces down.
    """
    arc = Arc((0.0, EDGE), EDGE, -0.5 * math.pi, -math.pi)
    ends, normals = sample_pieces([arc, Line((-EDGE, EDGE), (-EDGE, 5.0 * EDGE))], EDGE)
    # Longer sides count more: plies feel a side bulge by its length times its normals' turn.
    mean = np.roll(loop, -1, axis=0) - np.roll(loop, 1, axis=0)
    mean /= np.linalg.norm(mean, axis=1, keepdims=True)
    out = np.stack([mean[:, 1], -mean[:, 0]], axis=1)
    loop, out = np.concatenate([loop, loop[:1]]), np.concatenate([out, out[:1]])

    def around(dz: np.ndarray, base: np.ndarray | float) -> np.ndarray:
        level = base + dz[..., None, :1] * out
        return np.concatenate(
            [level, np.broadcast_to(dz[..., None, 1:], (*level.shape[:-1], 1))], axis=-1
        )

    made = facets_between(around(ends, loop), around(normals, 0.0))
    return made if side < 0.0 else _mirrored(made)


def _sheet(flat: shapely.Polygon, side: float) -> Surface:
    """The flat itself."""
    pieces = shapely.get_parts(shapely.constrained_delaunay_triangles(flat))
    corners = shapely.get_coordinates(pieces).reshape(-1, 4, 2)[:, :3]
    a, b, c = np.moveaxis(corners, 1, 0)
    ccw = (b - a)[:, 0] * (c - a)[:, 1] > (b - a)[:, 1] * (c - a)[:, 0]
    corners = np.where((ccw == (side > 0.0))[:, None, None], corners, corners[:, ::-1])
    points = np.concatenate([corners, np.zeros((*corners.shape[:2], 1))], axis=2)
    mesh = trimesh.Trimesh(
        points.reshape(-1, 3), np.arange(3 * len(points)).reshape(-1, 3), process=False
    )
    normals = np.zeros((len(points), 3, 3))
    normals[..., 2] = side
    return Surface(mesh, normals, exact=True)


def _mirrored(surface: Surface) -> Surface:
    """A surface mirrored in z = 0, its outside still outside."""
    mirror = np.array([1.0, 1.0, -1.0])
    mesh = trimesh.Trimesh(
        surface.mesh.vertices * mirror, surface.mesh.faces[:, ::-1], process=False
    )
    return Surface(mesh, surface.normals[:, ::-1] * mirror, surface.exact)
