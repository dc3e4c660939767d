"""A blank before forming: flat triangles that are known to be sound."""

from __future__ import annotations

import os
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from warpdrape.cad_file import is_cad
from warpdrape.errors import SIZES, InputError, numbers, positive
from warpdrape.mesh_file import fault_of, why_unreadable
from warpdrape.wording import surface

DEGENERATE = 1e-7
"""Smallest height over longest side below which a triangle counts as having no area."""
FLATNESS = 1e-6
"""Largest departure of z from one plane, over the size of the mesh."""


class Edges(NamedTuple):
    """The edges of a mesh, each once."""

    vertices: NDArray[np.int32]
    """End points, shape [edge, 2], the lower index first."""
    triangles: NDArray[np.int32]
    """The triangles on its sides, shape [edge, 2]; the second is -1 on the boundary."""
    corners: NDArray[np.int32]
    """In each of these, the corner (0, 1 or 2) that faces the edge, shape [edge, 2]; or -1."""


@dataclass(frozen=True, eq=False)
class FlatMesh:
    """A flat triangle mesh; what it holds is checked, counter-clockwise and read-only.

    Args:
        vertices: positions [m], shape [vertex, 2].
        triangles: vertex indices, shape [triangle, 3]; clockwise ones are turned round.

    Raises:
        InputError: where `check_mesh` finds a fault; a run also asks `check_one_sheet`.
    """

    vertices: NDArray[np.float64]
    triangles: NDArray[np.int32]

    def __repr__(self) -> str:
        return f"FlatMesh: {surface(self.vertices, self.triangles)}"

    def __post_init__(self) -> None:
        vertices, triangles = check_mesh(self.vertices, self.triangles)
        for name, array in (("vertices", vertices), ("triangles", triangles)):
            array.setflags(write=False)
            object.__setattr__(self, name, array)

    @classmethod
    def from_arrays(cls, vertices: ArrayLike, triangles: ArrayLike) -> FlatMesh:
        """Make a mesh from positions [m], shape [vertex, 2 or 3], and indices [triangle, 3]."""
        points = _numbers("vertices", vertices)
        if points.ndim == 2 and points.shape[1] == 3:
            points = _flatten(points, "vertices")
        return cls(points, cast(NDArray[np.int32], triangles))  # checked when it is made

    @classmethod
    def from_file(cls, path: str | os.PathLike[str], scale: float = 1.0) -> FlatMesh:
        """Read any file that trimesh reads (STL, OBJ, PLY, OFF, …).

        Args:
            path: the file; its triangles lie in one plane z = constant.
            scale: metres per unit of the file (1e-3 for a file in millimetres).
        """
        scale = positive("scale", scale, unit="m per unit of the file")
        points, triangles = _read(Path(path))
        return cls(scale * _flatten(points, f"mesh file '{path}'"), triangles)

    @cached_property
    def areas(self) -> NDArray[np.float64]:
        """Area of every triangle [m²], shape [triangle]."""
        return _signed_areas(self.vertices, self.triangles)

    @cached_property
    def heights(self) -> NDArray[np.float64]:
        """Smallest height of every triangle [m], shape [triangle]; it sets the time step."""
        return 2.0 * self.areas / _side_lengths(self.vertices, self.triangles).max(axis=1)

    @cached_property
    def vertex_areas(self) -> NDArray[np.float64]:
        """Each vertex' third of the triangles around it [m²], shape [vertex]."""
        shares = np.repeat(self.areas / 3.0, 3)
        around = np.bincount(self.triangles.ravel(), shares, len(self.vertices))
        return np.asarray(around, np.float64)

    @cached_property
    def edges(self) -> Edges:
        """Every edge once, with the triangles on its two sides."""
        return _edges(self.triangles)

    @cached_property
    def boundary_edges(self) -> NDArray[np.int32]:
        """Edges with one triangle, shape [edge, 2], in that triangle's (outer: ccw) sense."""
        at = self.edges.triangles[:, 1] < 0
        rows = self.triangles[self.edges.triangles[at, 0]]
        corner = self.edges.corners[at, 0]
        pick = np.arange(len(rows))
        return np.column_stack([rows[pick, (corner + 1) % 3], rows[pick, (corner + 2) % 3]])

    @cached_property
    def boundary_vertices(self) -> NDArray[np.int32]:
        """Vertices on the boundary, sorted."""
        return np.unique(self.boundary_edges)


def check_mesh(
    vertices: ArrayLike, triangles: ArrayLike
) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """Return copies of the arrays as float64 and int32, all triangles counter-clockwise.

    Raises:
        InputError: shapes or types are wrong, a number is not finite, an index is out of range,
            a triangle has no area or is there twice, an edge has more than two triangles or two on
            one side, or a vertex belongs to none.
    """
    points = _numbers("vertices", vertices)
    if points.ndim != 2 or points.shape[1] != 2:
        raise InputError(f"vertices have shape {points.shape}; a flat mesh needs (vertices, 2)")
    try:
        rows = np.array(triangles)
    except (TypeError, ValueError, OverflowError):
        rows = np.empty(0)
    if rows.ndim != 2 or rows.shape[1] != 3 or len(rows) == 0:
        raise InputError(f"triangles have shape {rows.shape}; need (triangles, 3), at least one")
    if not np.issubdtype(rows.dtype, np.integer):
        raise InputError(f"triangles hold {rows.dtype}; need vertex indices (whole numbers)")
    _refuse(
        ~np.all(np.isfinite(points), axis=1), "vertices {} are not finite: repair or remove them"
    )
    far = np.any(np.abs(points) > SIZES[1], axis=1)
    _refuse(far, f"vertices {{}} lie beyond {SIZES[1]:g} m: give metres")
    outside = np.any((rows < 0) | (rows >= len(points)), axis=1)
    _refuse(outside, f"triangles {{}} name vertices outside 0..{len(points) - 1}")
    rows = rows.astype(np.int32)
    area = _signed_areas(points, rows)
    longest = _side_lengths(points, rows).max(axis=1)
    flat = 2.0 * np.abs(area) <= DEGENERATE * longest**2
    _refuse(flat, "triangles {} have zero area: remove them")
    rows[area < 0.0, 1:] = rows[area < 0.0, :0:-1]
    _check_topology(rows, len(points))
    return points, rows


def _check_topology(rows: NDArray[np.int32], n_vertices: int) -> None:
    """Raise `InputError` for double triangles, crowded or folded edges, stray vertices."""
    same = np.sort(rows, axis=1)
    order = np.lexsort(same.T[::-1])
    twice = np.zeros(len(rows), bool)
    twice[order[1:]] = (same[order[1:]] == same[order[:-1]]).all(axis=1)
    _refuse(twice, "triangles {} repeat another triangle: remove them")
    keys, counts = np.unique(_edge_keys(rows), return_counts=True)
    crowded = keys[counts > 2]
    if len(crowded):
        pairs = [f"{key >> 32}-{key & 0xFFFFFFFF}" for key in crowded[:3].tolist()]
        raise InputError(
            f"edges {', '.join(pairs)}{' …' if len(crowded) > 3 else ''} (vertex-vertex) are "
            "shared by more than two triangles: a ply is a surface, remove the extra ones"
        )
    ends = rows[:, [[1, 2], [2, 0], [0, 1]]].reshape(-1, 2).astype(np.int64)
    _, first, counts = np.unique(
        (ends[:, 0] << 32) | ends[:, 1], return_index=True, return_counts=True
    )
    if (counts > 1).any():  # counter-clockwise neighbours run along their edge in opposite senses
        a, b = ends[first[counts > 1][0]]
        raise InputError(
            f"two triangles at edge {a}-{b} lie on the same side of it and overlap: remove one"
        )
    unused = np.bincount(rows.ravel(), minlength=n_vertices) == 0
    _refuse(unused, "vertices {} belong to no triangle: remove them")


def _refuse(bad: NDArray[np.bool_], message: str) -> None:
    """Raise `InputError` with the first few indices in place of {} if any entry is set."""
    found = np.flatnonzero(bad)
    if len(found):
        few = ", ".join(map(str, found[:5].tolist()))
        raise InputError(message.format(few + (f" … ({len(found)} in all)" * (len(found) > 5))))


def _numbers(name: str, values: ArrayLike) -> NDArray[np.float64]:
    try:
        return numbers(name, values)
    except InputError:
        raise InputError(f"{name} must be an array of numbers, all rows equally long") from None


def _signed_areas(points: NDArray[np.float64], rows: NDArray[np.int32]) -> NDArray[np.float64]:
    a, b, c = (points[rows[:, k]] for k in range(3))
    u, v = b - a, c - a
    return 0.5 * (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])


def _side_lengths(points: NDArray[np.float64], rows: NDArray[np.int32]) -> NDArray[np.float64]:
    """Length of the side that faces each corner [m], shape [triangle, 3]."""
    side = points[rows[:, [2, 0, 1]]] - points[rows[:, [1, 2, 0]]]
    return np.hypot(side[..., 0], side[..., 1])


def _edge_keys(rows: NDArray[np.int32]) -> NDArray[np.int64]:
    """One integer for the edge that faces each corner (lower vertex in the high half)."""
    ends = rows[:, [[1, 2], [2, 0], [0, 1]]].reshape(-1, 2).astype(np.int64)
    return (ends.min(axis=1) << 32) | ends.max(axis=1)


def _edges(rows: NDArray[np.int32]) -> Edges:
    keys = _edge_keys(rows)
    order = np.argsort(keys, kind="stable")
    keys = keys[order]
    first = np.flatnonzero(np.r_[True, keys[1:] != keys[:-1]])
    double = np.diff(np.r_[first, len(keys)]) == 2
    halves = np.full((len(first), 2), -1)
    halves[:, 0] = order[first]
    halves[double, 1] = order[first[double] + 1]
    unique = keys[first]
    return Edges(
        np.column_stack([unique >> 32, unique & 0xFFFFFFFF]).astype(np.int32),
        np.where(halves < 0, -1, halves // 3).astype(np.int32),
        np.where(halves < 0, -1, halves % 3).astype(np.int32),
    )


def _flatten(points: NDArray[np.float64], what: str) -> NDArray[np.float64]:
    """Drop z; raise `InputError` unless it is constant (not finite numbers pass through)."""
    if not np.isfinite(points).all() or len(points) == 0:
        return points[:, :2]
    spread = np.ptp(points, axis=0)
    if spread[2] > FLATNESS * spread.max():
        raise InputError(
            f"{what}: z varies by {spread[2]:.3g} over a size of {spread.max():.3g} (file units); "
            "a blank is flat at constant z: project or turn it first"
        )
    return points[:, :2]


def _read(path: Path) -> tuple[NDArray[np.float64], NDArray[Any]]:
    """Read vertices [file units] and triangles as they stand; join the corners of a soup."""
    import trimesh

    if not path.is_file():
        raise InputError(f"mesh file '{path}' does not exist")
    if is_cad(path):
        raise InputError(
            f"mesh file '{path}' has surfaces, not triangles of a size to compute with: draw the "
            "blank's outline as DXF, for warpdrape.Ply.from_dxf"
        )
    try:
        mesh = trimesh.load_mesh(path, process=False)
    except Exception as error:  # every reader raises its own kinds
        why = why_unreadable(path, error)
        raise InputError(f"mesh file '{path}' cannot be read: {why}") from error
    if not isinstance(mesh, trimesh.Trimesh) or len(mesh.faces) == 0:
        raise InputError(f"mesh file '{path}' holds no triangles")
    if fault := fault_of(mesh):
        raise InputError(f"mesh file '{path}' {fault}")
    if len(mesh.vertices) >= 3 * len(mesh.faces):
        mesh.merge_vertices()
    return np.asarray(mesh.vertices, np.float64), np.asarray(mesh.faces)
