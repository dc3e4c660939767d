"""The face of a mould: what of a body is seen from above, and the flat rim round its shape."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import shapely
import trimesh
import warp as wp
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from warpdrape.blanks.loops import closed_loops, loop_area
from warpdrape.errors import InputError
from warpdrape.kernels.fishnet.heights import compute_heights
from warpdrape.tools.profile import Surface

STEEP = math.sin(math.radians(2.0))
"""Upward part of a facet's normal below which it is a wall; one that stands on what faces up and
ends at it is part of the face, one round the outside of a block is not."""
LEVEL = 1e-3
"""How far a flat rim may be from level, over the face's size [-]."""
FLAT = math.cos(math.radians(1.0))
"""Upward part of a normal from which on a facet is level."""
SEEN = 1e-5
"""How far below what is seen from above a facet may lie and count as seen, over the size [-]."""


@dataclass(frozen=True, eq=False)
class Face:
    """What a mould shows from above.

    Attributes:
        surface: its facets, facing up.
        rim: which of them are its flat rim, shape [facet].
        level: height of that rim; of the border's mean where there is none [m].
        hidden: area that faces up under something else, over that of the face [-].
        undercut: area that faces down with something of the body below it, likewise [-].
    """

    surface: Surface
    rim: np.ndarray
    level: float
    hidden: float
    undercut: float

    @property
    def hollow(self) -> bool:
        """Whether the shape lies below the rim, as in a female mould."""
        mesh = self.surface.mesh
        shape = ~self.rim
        areas, heights = _upward(mesh)[shape], mesh.triangles_center[shape, 2]
        return float(areas @ (heights - self.level)) <= 0.0

    @property
    def outline(self) -> shapely.Polygon | shapely.MultiPolygon:
        """All shapes within the rim as seen from above, their inner holes filled [m]."""
        parts = plans(self.surface.mesh, ~self.rim)
        return shapely.union_all(parts) if parts else shapely.Polygon()

    @property
    def outer(self) -> shapely.Polygon:
        """The whole face as seen from above, its inner holes filled [m]."""
        return plan(self.surface.mesh, np.ones(len(self.rim), dtype=bool))


def face_of(who: str, surface: Surface) -> Face:
    """Find the face of a body or an open surface.

    Args:
        who: for errors.
        surface: closed solids face outward; open ones either way.

    Raises:
        InputError: if nothing of it faces up.
    """
    if not surface.mesh.is_watertight and _upward(surface.mesh).sum() < 0.0:
        turned = trimesh.Trimesh(surface.mesh.vertices, surface.mesh.faces[:, ::-1], process=False)
        surface = replace(surface, mesh=turned, normals=-surface.normals[:, ::-1])
    mesh = surface.mesh
    up = mesh.face_normals[:, 2] > STEEP
    seen = up & _is_seen(mesh)
    if not seen.any():
        raise InputError(f"{who}: nothing of it faces up: turn it, or give up, such as '-z'")
    kept = seen | _inner_walls(mesh, seen)
    whole = mesh.area_faces[kept].sum()
    hidden = float(mesh.area_faces[up & ~seen].sum() / whole)
    undercut = float(mesh.area_faces[_undercut(mesh)].sum() / whole)
    faces = trimesh.Trimesh(mesh.vertices, mesh.faces[kept], process=False)
    faces.remove_unreferenced_vertices()
    found = replace(surface, mesh=faces, normals=surface.normals[kept])
    rim, level = _flat_rim(faces)
    return Face(found, rim, level, hidden, undercut)


def plan(mesh: trimesh.Trimesh, chosen: np.ndarray) -> shapely.Polygon:
    """The largest of `plans` [m]."""
    return max(plans(mesh, chosen), key=lambda part: part.area, default=shapely.Polygon())


def plans(mesh: trimesh.Trimesh, chosen: np.ndarray) -> list[shapely.Polygon]:
    """What the borders of chosen facets enclose as seen from above, without holes [m]."""
    size = max(float(np.ptp(mesh.vertices, axis=0).max()), 1e-300)
    parts = []
    for loop in borders(np.asarray(mesh.faces)[chosen]):
        flat = np.asarray(mesh.vertices)[loop, :2]
        if abs(loop_area(flat)) > (1e-6 * size) ** 2:  # one round a wall has none
            whole = shapely.Polygon(flat).buffer(0.0)  # in parts if it touches itself
            parts += shapely.get_parts(whole).tolist()
    simple = [shapely.Polygon(part.exterior).simplify(1e-6 * size) for part in parts]
    return [part for part in simple if not part.is_empty]


def borders(facets: np.ndarray) -> list[np.ndarray]:
    """Closed loops of vertices round facets, shape [facet, 3].

    An edge counts as often as more facets have it in one sense than in the other: so the loops
    close whatever the facets, also where three of them share an edge.
    """
    ends = facets[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    _, of = np.unique(np.sort(ends, axis=1), axis=0, return_inverse=True)
    of = of.reshape(-1)
    sense = np.where(ends[:, 0] < ends[:, 1], 1, -1)
    surplus = np.bincount(of, sense).astype(int)
    more = np.flatnonzero(sense * surplus[of] > 0)
    order = more[np.argsort(of[more], kind="stable")]
    first = np.flatnonzero(np.diff(of[order], prepend=-1))
    rank = np.arange(len(order)) - np.repeat(first, np.diff([*first, len(order)]))
    kept = np.sort(order[rank < abs(surplus[of[order]])])
    return closed_loops(map(tuple, ends[kept].tolist()))


def _upward(mesh: trimesh.Trimesh) -> np.ndarray:
    return mesh.face_normals[:, 2] * mesh.area_faces


def _is_seen(mesh: trimesh.Trimesh) -> np.ndarray:
    """Whether nothing lies over the middle of each facet, shape [facet]."""
    corners = np.asarray(mesh.triangles, dtype=float)
    query = wp.Mesh(
        wp.array(corners.reshape(-1, 3), dtype=wp.vec3f, device="cpu"),
        wp.array(np.arange(3 * len(corners)), dtype=wp.int32, device="cpu"),
    )
    middle = corners.mean(axis=1)
    size = float(np.abs(corners).max())
    heights = wp.empty(len(middle), dtype=wp.float64, device="cpu")
    asked: wp.array = wp.array(np.ascontiguousarray(middle[:, :2]), dtype=wp.vec2d, device="cpu")
    given = [query.id, wp.array(corners, dtype=wp.vec3d, device="cpu"), asked, 2.0 * size, 1.0]
    wp.launch(compute_heights, len(middle), given, outputs=[heights], device="cpu")
    return heights.numpy() - middle[:, 2] < SEEN * size


def _undercut(mesh: trimesh.Trimesh) -> np.ndarray:
    """Which facets look down on something of the body, shape [facet]; of a sheet all that do."""
    down = mesh.face_normals[:, 2] < -STEEP
    if not mesh.is_watertight or not down.any():
        return down
    turned = trimesh.Trimesh(mesh.vertices * (1.0, -1.0, -1.0), mesh.faces, process=False)
    return down & ~_is_seen(turned)


def _neighbours(mesh: trimesh.Trimesh, chosen: np.ndarray) -> np.ndarray:
    """Number of the connected piece that each chosen facet belongs to, −1 for others."""
    pairs = np.asarray(mesh.face_adjacency)
    pairs = pairs[chosen[pairs].all(axis=1)]
    size = (len(chosen), len(chosen))
    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=size)
    return np.where(chosen, connected_components(graph, directed=False)[1], -1)


def _inner_walls(mesh: trimesh.Trimesh, seen: np.ndarray) -> np.ndarray:
    """Upright facets that stand on seen ones and end at them all round, shape [facet]."""
    upright = ~seen & (np.abs(mesh.face_normals[:, 2]) <= STEEP)
    if not upright.any():
        return upright
    piece = _neighbours(mesh, upright)
    pairs = np.asarray(mesh.face_adjacency)
    count = np.bincount(pairs.ravel(), minlength=len(seen))
    bad = set(piece[upright & (count < 3)].tolist())
    for one, other in (pairs.T, pairs.T[::-1]):
        bad |= set(piece[one][upright[one] & ~upright[other] & ~seen[other]].tolist())
    return upright & ~np.isin(piece, list(bad))


def _flat_rim(mesh: trimesh.Trimesh) -> tuple[np.ndarray, float]:
    """Facets of a flat rim along the outer border, and its height [m]."""
    ends = np.sort(mesh.edges, axis=1)
    key, count = np.unique(ends, axis=0, return_counts=True)
    border = np.unique(key[count == 1])
    heights = mesh.vertices[border, 2]
    size = float(np.ptp(mesh.vertices, axis=0).max())
    # The border goes round outside: where the face has holes, the outermost vertices tell.
    on_hull = _outermost(mesh.vertices[border, :2])
    level = float(np.median(heights[on_hull]))
    none = np.zeros(len(mesh.faces), dtype=bool)
    if np.abs(heights[on_hull] - level).max() > LEVEL * size:
        return none, _border_height(mesh)
    at_level = np.abs(mesh.triangles[:, :, 2] - level).max(axis=1) <= LEVEL * size
    flat = at_level & (mesh.face_normals[:, 2] > FLAT)
    if not flat.any():
        return none, level
    piece = _neighbours(mesh, flat)
    at_border = np.isin(mesh.faces, border[on_hull]).any(axis=1)
    rim = flat & np.isin(piece, np.unique(piece[flat & at_border]))
    # Nor is a shape what tilts within the rim and stays at its level, such as a scan's noise.
    others = _neighbours(mesh, ~rim)
    rim |= ~rim & ~np.isin(others, others[~rim & ~at_level])
    return (none, level) if rim.all() else (rim, level)


def _border_height(mesh: trimesh.Trimesh) -> float:
    """Mean height along the outer border as seen from above [m]."""
    loops = [np.asarray(mesh.vertices)[loop] for loop in borders(np.asarray(mesh.faces))]
    if not loops:
        return float(mesh.vertices[:, 2].mean())
    outer = max(loops, key=lambda loop: abs(loop_area(loop[:, :2])))
    after = np.roll(outer, -1, axis=0)
    lengths = np.linalg.norm((after - outer)[:, :2], axis=1)
    return float(lengths @ (0.5 * (after + outer)[:, 2]) / lengths.sum())


def _outermost(points: np.ndarray) -> np.ndarray:
    """Which points lie on their convex hull, shape [n]."""
    hull = shapely.MultiPoint(points).convex_hull
    size = float(np.ptp(points, axis=0).max())
    return shapely.distance(shapely.points(points), hull.boundary) <= 1e-6 * size
