"""The surface that a net lies on: facets of one sense, each joined to its neighbours."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import trimesh
import warp as wp

from warpdrape.errors import InputError, said
from warpdrape.fishnet.edges import ends_of, twins_of
from warpdrape.fishnet.holes import span_holes
from warpdrape.kernels.fishnet.facets import Facets
from warpdrape.kernels.fishnet.heights import compute_heights
from warpdrape.kernels.fishnet.nearest import compute_nearest
from warpdrape.tools.orientation import oriented, without_doubles

FARTHEST_START = 0.05
"""How far a start may lie off the surface, over the surface's size [-]: it is put onto it."""
SLIVER = 1e-12
"""Area of a facet over its longest side squared below which it has no direction [-]."""


@dataclass(frozen=True, eq=False)
class NetSurface:
    """Facets that a net can lie on.

    Attributes:
        points: vertices [m], shape [vertex, 3].
        facets: vertices, counter-clockwise seen from outside, shape [facet, 3].
        spanned: facets that span holes, shape [facet].
    """

    points: np.ndarray
    facets: np.ndarray
    spanned: np.ndarray

    @classmethod
    def of_mesh(cls, mesh: trimesh.Trimesh, holes: str = "span") -> NetSurface:
        """Make a surface of a mesh: double vertices and facets merged, facets of one sense.

        Args:
            mesh: its facets' outside is the side on which the ply lies.
            holes: "span" to let the ply lie straight across them, or "end" to end the net there.

        Raises:
            InputError: if it has no facets, or more than two meet in an edge, or it has one side
                only, as a Möbius strip.
        """
        if len(mesh.faces) == 0:
            raise InputError("the surface has no facets: give a mesh of triangles")
        if not np.isfinite(mesh.vertices).all():
            raise InputError("the surface holds NaN or infinite vertices: repair it")
        if holes not in ("span", "end"):
            raise InputError(f"holes = {said(holes)} must be 'span' or 'end'")
        merged = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
        merged.merge_vertices(merge_tex=True, merge_norm=True)
        points = np.asarray(merged.vertices, dtype=float)
        facets = _with_area(points, without_doubles(np.asarray(merged.faces, dtype=np.int64)))
        if len(facets) == 0:
            raise InputError("all facets of the surface have zero area: give a mesh of triangles")
        facets, _ = oriented(points, facets)
        _check_edges(points, facets)
        spanned = np.zeros(len(facets), dtype=bool)
        if holes == "span":
            added = span_holes(points, facets)
            facets = np.concatenate([facets, added])
            spanned = np.arange(len(facets)) >= len(facets) - len(added)
        return cls(points, facets, spanned)

    @cached_property
    def size(self) -> float:
        """Diagonal of the box round it [m]."""
        return float(np.linalg.norm(np.ptp(self.points[np.unique(self.facets)], axis=0)))

    @cached_property
    def area(self) -> float:
        """Area of its facets but those that span holes [m²]."""
        a, b, c = np.moveaxis(self.points[self.facets[~self.spanned]], 1, 0)
        return float(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())

    @cached_property
    def edge(self) -> float:
        """Mean side of its facets [m]."""
        corners = self.points[self.facets]
        return float(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).mean())

    @cached_property
    def twins(self) -> np.ndarray:
        """Half-edge on the other side of each, −1 at a border, shape [3 facet]."""
        return twins_of(self.facets, len(self.points))

    @cached_property
    def frames(self) -> np.ndarray:
        """Unit vectors in each facet, and its normal, shape [facet, 3, 3]."""
        a, b, c = np.moveaxis(self.points[self.facets], 1, 0)
        normal = _unit(np.cross(b - a, c - a))
        first = _unit(b - a)
        return np.stack([first, np.cross(normal, first), normal], 1)

    @cached_property
    def arrays(self) -> Facets:
        """The same for kernels."""
        return _arrays(self)

    def in_space(self, facets: np.ndarray, places: np.ndarray) -> np.ndarray:
        """Places as points [m], shape [n, 3].

        Args:
            facets: shape [n].
            places: in the facets [m], shape [n, 2].
        """
        frames = self.frames[facets]
        base = self.points[self.facets[facets, 0]]
        return base + places[:, :1] * frames[:, 0] + places[:, 1:] * frames[:, 1]

    def nearest(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Facets nearest to points, shape [n], and the nearest points there [m], shape [n, 3]."""
        mesh, corners = self._query
        asked: wp.array = wp.array(points, dtype=wp.vec3d, device="cpu")
        facets = wp.empty(len(points), dtype=wp.int32, device="cpu")
        at = wp.empty(len(points), dtype=wp.vec3d, device="cpu")
        far = np.abs(points).max() + np.abs(self.points).max()
        given = [mesh.id, corners, asked, 2.0 * float(far)]
        wp.launch(compute_nearest, len(points), given, outputs=[facets, at], device="cpu")
        return facets.numpy(), at.numpy()

    @cached_property
    def _query(self) -> tuple[wp.Mesh, wp.array]:
        mesh = wp.Mesh(
            wp.array(self.points, dtype=wp.vec3f, device="cpu"),
            wp.array(self.facets.ravel(), dtype=wp.int32, device="cpu"),
        )
        return mesh, wp.array(self.points[self.facets], dtype=wp.vec3d, device="cpu")

    def top_at(self, at: np.ndarray) -> np.ndarray:
        """The highest point over x and y [m], shape [3]; the nearest one where none lies there."""
        mesh, corners = self._query
        heights = wp.empty(1, dtype=wp.float64, device="cpu")
        asked: wp.array = wp.array(np.asarray(at, dtype=float)[None], dtype=wp.vec2d, device="cpu")
        far = 2.0 * float(np.abs(self.points).max() + np.abs(at).max())
        wp.launch(compute_heights, 1, [mesh.id, corners, asked, far, 1.0], [heights], device="cpu")
        height = float(heights.numpy()[0])
        if height < far:
            return np.append(at, height)
        return self.nearest(np.append(at, self.points[:, 2].max())[None])[1][0]

    def offset(self, distance: float) -> NetSurface:
        """The surface moved along its normals, to the outside where above zero [m]."""
        if distance == 0.0:
            return self
        normals = np.zeros_like(self.points)
        corners = self.points[self.facets]
        twice = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        for k in range(3):
            np.add.at(normals, self.facets[:, k], twice)
        length = np.linalg.norm(normals, axis=1, keepdims=True)
        moved = self.points + distance * normals / np.maximum(length, 1e-300)
        return NetSurface(moved, self.facets, self.spanned)

    def locate(self, start: Any) -> tuple[int, np.ndarray]:
        """Facet and place in it [m], shape [2], of a start point.

        Raises:
            InputError: if it lies off the surface.
        """
        facets, at = self.nearest(np.asarray(start, dtype=float)[None])
        far = float(np.linalg.norm(at[0] - start))
        if far > FARTHEST_START * self.size:
            near = ", ".join(f"{v:.4g}" for v in at[0])
            raise InputError(
                f"start = {_said_point(start)} m lies {far:.4g} m off the surface: give a point of "
                f"it, such as the nearest, ({near})"
            )
        if self.spanned[facets[0]]:
            raise InputError(
                f"start = {_said_point(start)} m lies in a hole of the surface: give a point of it"
            )
        return int(facets[0]), self.in_facet(int(facets[0]), at[0])

    def in_facet(self, facet: int, point: np.ndarray) -> np.ndarray:
        """Place in a facet of a point of it [m], shape [2]."""
        way = point - self.points[self.facets[facet, 0]]
        return self.frames[facet, :2] @ way

    def angle_in(self, facet: int, direction: Any) -> float:
        """Angle in a facet of a direction in space, projected onto it [rad].

        Raises:
            InputError: if it is square to the facet.
        """
        along = np.asarray(direction, dtype=float)
        flat = self.frames[facet] @ along
        if np.hypot(flat[0], flat[1]) < 1e-3 * np.linalg.norm(along):
            raise InputError(
                f"warp = {_said_point(direction)} is square to the surface at the start: give a "
                "direction along the surface"
            )
        return math.atan2(flat[1], flat[0])


def _said_point(point: Any) -> str:
    try:
        return "(" + ", ".join(f"{float(v):.4g}" for v in point) + ")"
    except (TypeError, ValueError):
        return said(point)


def _unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def _with_area(points: np.ndarray, facets: np.ndarray) -> np.ndarray:
    """The facets that have an area."""
    a, b, c = np.moveaxis(points[facets], 1, 0)
    longest = np.max([np.linalg.norm(s, axis=1) for s in (b - a, c - b, a - c)], axis=0)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return facets[area > SLIVER * longest**2]


def _check_edges(points: np.ndarray, facets: np.ndarray) -> None:
    """Raise `InputError` where facets do not lie side by side."""
    ends = ends_of(facets)
    for sides, words, remedy in (
        (
            np.sort(ends, axis=1),
            "{} facets of the surface meet in one edge",
            "leave one sheet on which the ply lies",
        ),
        (ends, "the surface has one side only, as a Möbius strip; its facets clash", "cut it open"),
    ):
        keys = sides[:, 0] * len(points) + sides[:, 1]
        _, first, shared = np.unique(keys, return_index=True, return_counts=True)
        if shared.max() > (2 if sides is not ends else 1):
            at = _said_point(points[ends[first[np.argmax(shared)]]].mean(axis=0))
            raise InputError(f"{words.format(shared.max())} at {at} m: {remedy}")


def _arrays(surface: NetSurface) -> Facets:
    points, facets, twins = surface.points, surface.facets, surface.twins
    local = np.zeros((len(facets), 3, 2))
    corners = points[facets]
    for k in (1, 2):
        way = corners[:, k] - corners[:, 0]
        local[:, k] = np.einsum("fij,fj->fi", surface.frames[:, :2], way)
    local[:, 1, 1] = 0.0
    sides = np.roll(local, -1, axis=1) - local
    heads = np.arctan2(sides[..., 1], sides[..., 0]).reshape(-1)
    third = np.roll(local, -2, axis=1) - local
    squared = (sides**2).sum(-1)
    along = (third * sides).sum(-1) / squared
    across = (sides[..., 0] * third[..., 1] - sides[..., 1] * third[..., 0]) / squared
    before = -np.roll(sides, 1, axis=1)
    inner = np.arctan2(
        sides[..., 0] * before[..., 1] - sides[..., 1] * before[..., 0], (sides * before).sum(-1)
    )
    around = np.bincount(facets.ravel(), inner.ravel(), len(points))
    around[ends_of(facets)[twins < 0].ravel()] = -1.0
    turned = np.where(twins < 0, 0.0, heads[twins] + math.pi - heads)
    made = Facets()
    made.corners = wp.array(facets, dtype=wp.vec3i, device="cpu")
    made.bases = wp.array(corners[:, 0], dtype=wp.vec3d, device="cpu")
    made.firsts = wp.array(surface.frames[:, 0], dtype=wp.vec3d, device="cpu")
    made.seconds = wp.array(surface.frames[:, 1], dtype=wp.vec3d, device="cpu")
    made.sides = wp.array(local[:, 1, 0], dtype=wp.float64, device="cpu")
    made.tips = wp.array(local[:, 2], dtype=wp.vec2d, device="cpu")
    made.twins = wp.array(twins, dtype=wp.int32, device="cpu")
    made.turns = wp.array(turned, dtype=wp.float64, device="cpu")
    made.apexes = wp.array(
        np.stack([along, across], -1).reshape(-1, 2), dtype=wp.vec2d, device="cpu"
    )
    made.around = wp.array(around, dtype=wp.float64, device="cpu")
    return made
