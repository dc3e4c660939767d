"""``wd.drape_fishnet``: a net on a surface from a start point, a warp direction and a spacing."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from typing import Any

import numpy as np
import trimesh

from warpdrape.blanks.outlines import closed_segments, enclosed
from warpdrape.errors import InputError, one_of, positive, said
from warpdrape.errors import length as size
from warpdrape.fishnet.least_shear import least_shear_turns
from warpdrape.fishnet.net import Net
from warpdrape.fishnet.solver import Begin, lay_out
from warpdrape.fishnet.start_line import turns_along
from warpdrape.fishnet.surface import NetSurface
from warpdrape.tools.motion import vector
from warpdrape.tools.tool import Tool
from warpdrape.tools.tool_mesh import read_facets

GENERATORS = ("geodesic", "plane", "least_shear")
"""How the two generator yarns run."""
SHEAR_LIMIT = math.radians(85.0)
"""Shear angle at which a net ends where nothing else is asked [rad]: yarns lie on each other."""
MOST_NODES = 16_000_000
"""Nodes of a grid beyond which memory runs out; they take 200 bytes each."""
GIRTH = 1.6
"""Longest way over a surface of one bulge from its middle, over its size [-]."""


def drape_fishnet(
    surface: Tool | NetSurface | trimesh.Trimesh | str | os.PathLike,
    spacing: float,
    *,
    start: Sequence[float] | Sequence[Sequence[float]] | None = None,
    warp: Sequence[float] = (1.0, 0.0, 0.0),
    yarn_angle: float = 0.5 * math.pi,
    generators: str = "geodesic",
    outline: Sequence[Sequence[float]] | None = None,
    shear_limit: float = SHEAR_LIMIT,
    holes: str = "span",
    scale: float = 1.0,
) -> Net:
    """Lay a pin-jointed net of inextensible yarns on a surface.

    Two generator yarns run from the start along warp and weft. Every other crossover is the place
    on the facets at the spacing from both of its neighbours, measured along the facets: yarns
    between crossovers are geodesics.

    Args:
        surface: a mould: a tool, a mesh, or a mesh file (STL, OBJ, PLY, …); the ply lies on the
            outside of its facets.
        spacing: of the crossovers along the yarns [m].
        start: point of the surface where the generators cross [m], shape [3]; the nearest one to
            the top of its middle if None. Several points, shape [n, 3], are a start line: the
            generators cross at the first, and the warp passes through the others in order.
        warp: direction of the warp there, projected onto the surface, shape [3]; along a start
            line where there is one.
        yarn_angle: from warp to weft in the flat ply [rad].
        generators: "geodesic"; "plane", sections of the surface by planes through its normal at
            the start; or "least_shear", bent so that the cells shear least (seconds).
        outline: of the flat blank, the start at its origin and x along the warp [m], shape [n, 2];
            None grows the net to cover the surface.
        shear_limit: shear angle at which the net ends [rad].
        holes: "span" lets it lie straight across holes of the surface, "end" ends it there.
        scale: metres per unit of a mesh or file (1e-3 for millimetres).

    Returns:
        The net: crossovers, shear angles of its cells, and why it ends where it does.

    Raises:
        InputError: if the surface is none, the start lies off it, the warp is square to it, or the
            spacing is larger than the part.
    """
    mould = as_surface(surface, holes, scale)
    size("spacing", spacing)
    one_of("generators", generators, GENERATORS)
    positive("yarn_angle", yarn_angle, unit="rad")
    positive("shear_limit", shear_limit, unit="rad")
    if not 0.0 < yarn_angle < math.pi:
        raise InputError(f"yarn_angle = {yarn_angle:.4g} rad must lie between 0 and 180°")
    if shear_limit >= 0.5 * math.pi:
        raise InputError(
            f"shear_limit = {shear_limit:.4g} rad must be below 90°: give radians, as in 60 * deg"
        )
    if spacing > 0.5 * mould.size:
        raise InputError(
            f"spacing = {spacing:.4g} m is more than half of the surface, {mould.size:.4g} m: "
            "give metres, as in 5 * mm"
        )
    line = _line(start)
    if line is not None:
        for point in line:
            mould.locate(point)
        start, warp = line[0], line[1] - line[0]
        if generators != "geodesic":
            raise InputError(
                f"generators = {generators!r} and a start line: leave one of them out, as the line "
                "says where the warp runs"
            )
    begin = begin_at(mould, start, warp, yarn_angle)
    ring = None if outline is None else read_outline(outline)
    counts = counts_of(mould, begin, spacing, ring)
    turns = None
    if generators == "least_shear":
        turns = least_shear_turns(mould, begin, spacing, counts, shear_limit)
    if line is not None:
        turns = turns_along(mould, begin, spacing, counts, line[1:], shear_limit)
    planes = generators == "plane"
    net = lay_out(mould, begin, spacing, counts, limit=shear_limit, turns=turns, planes=planes)
    return net if ring is None else net.within(wanted_nodes(net, ring))


def _line(start: Any) -> np.ndarray | None:
    """Points of a start line [m], shape [n, 3]; None where a start is one point or none."""
    try:
        points = np.asarray(start, dtype=float)
    except (TypeError, ValueError):
        return None
    if points.ndim != 2:
        return None
    if points.shape[1:] != (3,) or len(points) < 2 or not np.isfinite(points).all():
        raise InputError("a start line must be two points (x, y, z) [m] or more, in order")
    if not (np.linalg.norm(np.diff(points, axis=0), axis=1) > 0.0).all():
        raise InputError("a start line has the same point twice in a row: leave one out")
    return points


def as_surface(surface: Any, holes: str = "span", scale: float = 1.0) -> NetSurface:
    """The surface for a net of whatever stands for one; raise `InputError` for what does not."""
    if isinstance(surface, NetSurface):
        return surface
    if isinstance(surface, Tool):
        return NetSurface.of_mesh(surface.surface.mesh, holes)
    if isinstance(surface, trimesh.Trimesh | str | os.PathLike):
        return NetSurface.of_mesh(read_facets("mould", surface, scale), holes)
    raise InputError(f"surface = {said(surface)} must be a Tool, a mesh or the path of a mesh file")


def begin_at(
    surface: NetSurface, start: Any, warp: Any, yarn_angle: float = 0.5 * math.pi
) -> Begin:
    """Where a net begins, from a point and a direction in space."""
    along = vector("warp", warp)
    if not np.linalg.norm(along) > 0.0:
        raise InputError("warp must not be the zero vector: give the direction of the warp")
    if start is None:
        points = surface.points[np.unique(surface.facets)]
        low, high = points.min(axis=0), points.max(axis=0)
        top = np.append(0.5 * (low + high)[:2], high[2])
        _, at = surface.nearest(top[None])
        start = at[0]
    facet, place = surface.locate(vector("start", start))
    return Begin(facet, place, surface.angle_in(facet, along), yarn_angle)


def counts_of(
    surface: NetSurface, begin: Begin, spacing: float, ring: np.ndarray | None
) -> tuple[int, int, int, int]:
    """Crossovers from the start, warp forth and back, weft forth and back.

    Args:
        surface: to be covered.
        begin: the start.
        spacing: of the net [m].
        ring: outline in the flat blank [m], shape [n, 2]; None grows over all of it.
    """
    if ring is not None:
        yarns = in_yarns(ring, begin.yarn_angle) / spacing
        low, high = np.floor(yarns.min(axis=0)), np.ceil(yarns.max(axis=0))
        ahead, left = (int(reached) for reached in np.maximum(high, 1))
        behind, right = (int(reached) for reached in np.maximum(-low, 1))
        counts = (ahead, behind, left, right)
    else:
        counts = _grown(surface, begin, spacing)
    if (counts[0] + counts[1] + 1) * (counts[2] + counts[3] + 1) > MOST_NODES:
        raise InputError(
            f"spacing = {spacing:.4g} m makes more than {MOST_NODES:.0e} crossovers: take a larger "
            "one"
        )
    return counts


def _grown(surface: NetSurface, begin: Begin, spacing: float) -> tuple[int, int, int, int]:
    """As far as a net could go; half-way round a closed surface, where its generators come back."""
    longest = max(1, math.ceil(GIRTH * surface.size / spacing))
    if (surface.twins < 0).any() or longest > MOST_NODES:
        return (longest,) * 4
    once = math.ceil(math.pi * surface.size / spacing)
    reach = []
    for first in (0, 2):
        counts = [0, 0, 0, 0]
        counts[first] = once
        line = lay_out(surface, begin, spacing, counts, limit=SHEAR_LIMIT).points.reshape(-1, 3)
        far = np.linalg.norm(line[3:] - line[0], axis=1)
        back = np.flatnonzero(far < 0.75 * spacing)
        reach += [int(back[0] + 3) // 2 if len(back) else longest] * 2
    return reach[0], reach[1], reach[2], reach[3]


def in_yarns(points: np.ndarray, yarn_angle: float) -> np.ndarray:
    """Flat coordinates [m] along warp and weft of flat points with x along the warp, [n, 2]."""
    across = points[:, 1] / math.sin(yarn_angle)
    return np.stack([points[:, 0] - across * math.cos(yarn_angle), across], axis=1)


def wanted_nodes(net: Net, ring: np.ndarray) -> np.ndarray:
    """Nodes of the cells that an outline touches, boolean."""
    flat = net.flat_points
    inside = enclosed(flat.reshape(-1, 2), closed_segments([ring])).reshape(flat.shape[:2])
    dense = _along(ring, 0.5 * net.spacing)
    at = np.floor(in_yarns(dense, net.yarn_angle) / net.spacing).astype(int) + net.middle
    cells = inside[:-1, :-1] | inside[1:, :-1] | inside[:-1, 1:] | inside[1:, 1:]
    ok = ((at >= 0) & (at < cells.shape)).all(axis=1)
    cells[tuple(at[ok].T)] = True
    wanted = np.zeros(flat.shape[:2], dtype=bool)
    for i in (0, 1):
        for j in (0, 1):
            wanted[i : i + cells.shape[0], j : j + cells.shape[1]] |= cells
    return wanted


def _along(ring: np.ndarray, step: float) -> np.ndarray:
    """Points along a closed line, no farther apart than a step [m]."""
    after = np.roll(ring, -1, axis=0)
    parts = np.maximum(1, np.ceil(np.linalg.norm(after - ring, axis=1) / step)).astype(int)
    return np.concatenate(
        [np.linspace(a, b, n, endpoint=False) for a, b, n in zip(ring, after, parts, strict=True)]
    )


def read_outline(outline: Any) -> np.ndarray:
    """Points of an outline [m], shape [n, 2]; raise `InputError` for what is none."""
    try:
        ring = np.asarray(outline, dtype=float)
    except (TypeError, ValueError):
        ring = np.zeros(0)
    if ring.ndim != 2 or ring.shape[1:] != (2,) or len(ring) < 3 or not np.isfinite(ring).all():
        raise InputError(
            f"outline = {said(outline)} must be three points (x, y) [m] or more, in order"
        )
    if not enclosed(np.zeros((1, 2)), closed_segments([ring]))[0]:
        raise InputError("outline must go round (0, 0), the start: shift it")
    return ring
