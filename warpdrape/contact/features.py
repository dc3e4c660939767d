"""Where a tool is finer than the plies' meshes, so that it could pass between their vertices.

Such features are its sharp edges, what bends round by more than a right angle within a triangle's
side (pins, tips, blades), and the rims of open surfaces that plies may bend over. They are points
here, dense against the plies' triangles.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from scipy.spatial import cKDTree

from warpdrape.blanks.triangles import longest_sides
from warpdrape.contact.adjacency import across_edges
from warpdrape.contact.rims import exposed_rims
from warpdrape.distinct import distinct_rows
from warpdrape.setup import Setup
from warpdrape.tools.tool import Tool

SHARP = np.cos(np.radians(35.0))
"""Cosine between facets that stick out below which their edge is sharp [-]."""
ROUND = np.cos(np.radians(100.0))
"""Cosine between normals within a side of a ply's triangle from which a tool is finer [-]."""
TIP = np.cos(np.radians(50.0))
"""Cosine between a facet and the mean of those round a vertex below which that is a tip [-]."""
SPACING = 0.25
"""Distance of points along edges over the side of the finest ply's triangles [-]."""
MOST_POINTS = 200_000
"""Points along the edges of a tool, about."""
GRAIN = 0.02
"""Distance over that side below which points are one [-]."""
BINS = 5
"""Cells of a grid along the coarsest side, in which facets of one direction count as one [-]."""
DIRECTIONS = 2.0
"""Steps of a normal's components by which directions differ [-]."""


def points_of(scene: Setup) -> list[np.ndarray]:
    """Points [m] of each tool that the plies' vertices could miss, shape [n, 3] each."""
    _, fine = _sides(scene)
    found = []
    for tool, points in zip(scene.tools, finer_points(scene), strict=True):
        on_rims = along(exposed_rims(tool, scene), SPACING * fine)
        found.append(_thinned(np.vstack([points, on_rims]), fine))
    return found


def finer_points(scene: Setup) -> list[np.ndarray]:
    """Those of `points_of` that are not on rims: where the tools stick out."""
    return [feature_points(tool, *_sides(scene)) for tool in scene.tools]


def _sides(scene: Setup) -> tuple[float, float]:
    """Longest side of all triangles, and usual one of the finest ply [m]."""
    sides = [longest_sides(ply.rest_points, ply.mesh.triangles) for ply in scene.plies]
    coarse = max(float(of_ply.max()) for of_ply in sides)
    return coarse, min(float(np.median(of_ply)) for of_ply in sides)


def has_features(scene: Setup) -> bool:
    """Whether a tool is somewhere finer than the plies' meshes."""
    return any(len(points) for points in points_of(scene))


@lru_cache(maxsize=32)
def feature_points(tool: Tool, coarse: float, fine: float) -> np.ndarray:
    """Points of a tool that ply triangles have to feel, where the tool stands at first.

    Args:
        tool: the tool.
        coarse: longest side of the plies' triangles [m].
        fine: usual side of those of the finest ply [m].

    Returns:
        Points [m], shape [n, 3]; none where the plies' vertices feel all of it.
    """
    edges, sharp, bent = _outer_edges(tool, coarse)
    bent &= _turns_round(tool, edges, bent & ~sharp, coarse)
    on_edges = along(tool.vertices[edges[sharp | bent]], SPACING * fine)
    return _thinned(np.vstack([on_edges, _tips(tool)]), fine)


def _thinned(points: np.ndarray, fine: float) -> np.ndarray:
    """One of all points [m] that are the same but for a grain."""
    return points[_first_of_each(np.round(points / (GRAIN * fine)))]


def _outer_edges(tool: Tool, coarse: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Edges that stick out [e, 2]; which are sharp; which are of radii below ``coarse`` [m]."""
    triangles, points = tool.triangles, tool.vertices
    area = np.cross(*(points[triangles[:, k]] - points[triangles[:, 0]] for k in (1, 2)))
    twice = np.linalg.norm(area, axis=1)
    normal = area / np.maximum(twice, np.finfo(float).tiny)[:, None]
    beside = across_edges(triangles)
    one, corner = np.nonzero(beside > np.arange(len(triangles))[:, None])
    other = beside[one, corner]
    edges = np.stack([triangles[one, (corner + k) % 3] for k in (1, 2)], axis=1)
    length = np.linalg.norm(points[edges[:, 1]] - points[edges[:, 0]], axis=1)
    width = 0.5 * (twice[one] + twice[other]) / np.maximum(length, np.finfo(float).tiny)
    cosine = np.clip((normal[one] * normal[other]).sum(axis=1), -1.0, 1.0)
    middle = points[triangles].mean(axis=1)
    out = ((middle[other] - middle[one]) * (normal[other] - normal[one])).sum(axis=1) > 0.0
    sharp = out & (cosine < SHARP)
    bent = out & (width < np.arccos(cosine) * coarse)
    kept = sharp | bent
    return edges[kept], sharp[kept], bent[kept]


def _tips(tool: Tool) -> np.ndarray:
    """Vertices round which facets turn as far, such as that of a cone [m], shape [n, 3]."""
    triangles, points = tool.triangles, tool.vertices
    normals = tool.surface.mesh.face_normals
    fan, corner = np.divmod(np.argsort(triangles.ravel(), kind="stable"), 3)
    vertex = triangles[fan, corner]
    first = np.flatnonzero(np.diff(vertex, prepend=-1))
    mean = np.add.reduceat(normals[fan], first)
    mean /= np.maximum(np.linalg.norm(mean, axis=1), np.finfo(float).tiny)[:, None]
    each = np.repeat(np.arange(len(first)), np.diff([*first, len(fan)]))
    aligned = np.minimum.reduceat((normals[fan] * mean[each]).sum(axis=1), first)
    inward = points[triangles].mean(axis=1)[fan] - points[vertex]
    deepest = np.maximum.reduceat((inward * mean[each]).sum(axis=1), first)
    return points[vertex[first[(aligned < TIP) & (deepest < 0.0)]]]


def _turns_round(tool: Tool, edges: np.ndarray, asked: np.ndarray, coarse: float) -> np.ndarray:
    """Whether the tool bends round within ``coarse`` [m] of an edge, shape [e].

    Asked once for all edges of a cell of a grid, with one facet of each cell and direction.
    """
    found = np.zeros(len(edges), dtype=bool)
    if not asked.any():
        return found
    size = coarse / BINS
    middles, normals = _spots(tool, size)
    of_facet = np.hstack([np.floor(middles / size), np.round(DIRECTIONS * normals)])
    kept = _first_of_each(of_facet)
    middles, normals = middles[kept], normals[kept]
    near = cKDTree(middles)
    ends = tool.vertices[edges[asked]]
    places = np.stack([ends[:, 0], ends.mean(axis=1), ends[:, 1]], axis=1)
    of_place = np.floor(places / size).reshape(-1, 3)
    first, cell = distinct_rows(of_place)
    cells = of_place[first]
    round_there = np.zeros(len(cells), dtype=bool)
    for k, here in enumerate(near.query_ball_point((cells + 0.5) * size, 0.5 * coarse)):
        n = normals[here]
        apart = n @ n.T < ROUND
        if apart.any():
            across = n @ middles[here].T  # n_i · x_j: of convex surfaces n_i·(x_i − x_j) and
            own = across.diagonal()  # n_j·(x_j − x_i) > 0
            outward = own[:, None] + own[None] - across - across.T > 0.0
            round_there[k] = (apart & outward).any()
    found[asked] = round_there[cell.reshape(-1, 3)].any(axis=1)
    return found


def _spots(tool: Tool, size: float) -> tuple[np.ndarray, np.ndarray]:
    """Places on facets [m] and their normals: the middles, and of long facets near the corners."""
    corners = tool.vertices[tool.triangles]
    middles, normals = corners.mean(axis=1), tool.surface.mesh.face_normals
    inward = middles[:, None] - corners
    way = np.linalg.norm(inward, axis=2)
    long = way > size
    near = corners[long] + inward[long] * (0.5 * size / way[long])[:, None]
    return np.vstack([middles, near]), np.vstack([normals, normals[np.nonzero(long)[0]]])


def _first_of_each(rows: np.ndarray) -> np.ndarray:
    """Indices of the first of each kind of rows, in their order."""
    return np.sort(distinct_rows(rows.astype(np.int64))[0]) if len(rows) else np.zeros(0, int)


def along(edges: np.ndarray, spacing: float) -> np.ndarray:
    """Points on edges [m, 2 ends, 3], their ends among them, no farther apart than ``spacing``.

    But no more than `MOST_POINTS`, or the ends alone where these are more.
    """
    run = edges[:, 1] - edges[:, 0]
    parts = np.maximum(np.ceil(np.linalg.norm(run, axis=1) / spacing).astype(int), 1)
    if parts.sum() > MOST_POINTS:
        parts = np.maximum((parts * (MOST_POINTS / parts.sum())).astype(int), 1)
    each = np.repeat(np.arange(len(edges)), parts + 1)
    first = np.cumsum(parts + 1) - (parts + 1)
    share = (np.arange(len(each)) - first[each]) / parts[each]
    return edges[each, 0] + share[:, None] * run[each]
