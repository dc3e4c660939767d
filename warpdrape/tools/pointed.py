"""Punches whose flat faces rise from a point or a ridge: tetrahedron, prism; edges rounded.

The surface is all that lies one radius outside a sharp core: flats over its faces, cylinders round
its edges, spheres round its points. It is exact, and tangent everywhere.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
import trimesh

from warpdrape.errors import InputError
from warpdrape.errors import length as size
from warpdrape.tools.profile import FACET_ANGLE, Surface, refuse_too_many


@dataclass(frozen=True, eq=False)
class Pointed:
    """A sharp core that points down, and the radius of the rounding round it.

    Attributes:
        tips: its lowest points, one or two [m], shape [tip, 3].
        rim: corners of its open top, counter-clockwise seen from above [m], shape [corner, 3].
        roots: tip from which the edge to each corner rises, shape [corner].
        radius: of the rounding [m].
    """

    tips: np.ndarray
    rim: np.ndarray
    roots: Sequence[int]
    radius: float

    @cached_property
    def faces(self) -> list[np.ndarray]:
        """Corners of the face between each corner of the rim and the next [m], [n, 3] each."""
        loops = []
        for k, j in self._sides():
            ends = [self.tips[self.roots[j]]] if self.roots[k] != self.roots[j] else []
            loops.append(np.array([self.tips[self.roots[k]], self.rim[k], self.rim[j], *ends]))
        return loops

    @cached_property
    def normals(self) -> np.ndarray:
        """Outward unit normals of the faces, shape [corner, 3]."""
        found = np.array([np.cross(f[1] - f[0], f[2] - f[1]) for f in self.faces])
        found /= np.linalg.norm(found, axis=1, keepdims=True)
        inside = self.rim.mean(axis=0)
        sign = [np.sign(n @ (f[0] - inside)) for n, f in zip(found, self.faces, strict=True)]
        return found * np.array(sign)[:, None]

    def _sides(self) -> Iterator[tuple[int, int]]:
        return pairwise([*range(len(self.rim)), 0])

    def section(self, height: float, clearance: float) -> tuple[np.ndarray, float]:
        """Corners of the rounded core's section, grown by a clearance, and a radius for them.

        The rounding's section is an ellipse at each corner, of semi-axes r and r/sin(e) with e the
        edge's slope: its least radius of curvature is r sin(e), and an arc of that radius lies
        outside it.

        Args:
            height: of the section [m].
            clearance: by which its sides move out [m].

        Returns:
            Corners before rounding [m], shape [corner, 2], and their radius [m].
        """
        horizontal = np.linalg.norm(self.normals[:, :2], axis=1)
        out = self.normals[:, :2] / horizontal[:, None]
        along = self.rim - self.tips[list(self.roots)]
        share = (height - self.tips[list(self.roots), 2]) / along[:, 2]
        core = (self.tips[list(self.roots)] + share[:, None] * along)[:, :2]
        reach = (out * core).sum(axis=1) + self.radius / horizontal + clearance
        corners = [
            np.linalg.solve([out[k - 1], out[k]], [reach[k - 1], reach[k]])
            for k in range(len(reach))
        ]
        slope = np.abs(along[:, 2]) / np.linalg.norm(along, axis=1)
        return np.array(corners), self.radius * float(slope.min()) + clearance

    def surface(self, facet: float) -> Surface:
        """Facets of the rounded core, open at the top.

        Args:
            facet: facet size [m].
        """
        size("facet", facet)
        around = self._pieces(facet)
        refuse_too_many(around * float(np.linalg.norm(np.ptp(self.rim, axis=0))) / facet, facet)
        parts = [*self._flats(facet), *self._edges(facet, around), *self._points(around)]
        corners = np.concatenate([part[0].reshape(-1, 3, 3) for part in parts])
        normals = np.concatenate([part[1].reshape(-1, 3, 3) for part in parts])
        area = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        back = (area * normals.sum(axis=1)).sum(axis=1) < 0.0
        corners[back], normals[back] = corners[back][:, ::-1], normals[back][:, ::-1]
        mesh = trimesh.Trimesh(
            corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3), process=False
        )
        mesh.merge_vertices()
        return Surface(mesh, normals, exact=True)

    def _flats(self, facet: float) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Each face, moved out by the radius: a fan about its middle."""
        for face, normal in zip(self.faces, self.normals, strict=True):
            loop = pairwise([*face, face[0]])
            border = np.concatenate([_straight(a, b, facet)[:-1] for a, b in loop])
            border = border + self.radius * normal
            middle = np.broadcast_to(face.mean(axis=0) + self.radius * normal, border.shape)
            fan = np.stack([middle, border, np.roll(border, -1, axis=0)], axis=1)
            yield fan, np.broadcast_to(normal, fan.shape)

    def _edges(self, facet: float, pieces: int) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """A part of a cylinder round each edge between two faces."""
        for a, b, one, other in self._creases():
            turned = np.array([_slerp(one, other, t) for t in np.linspace(0.0, 1.0, pieces + 1)])
            at = _straight(a, b, facet)
            points = at[:, None] + self.radius * turned
            normals = np.broadcast_to(turned, points.shape)
            yield _quads(points), _quads(normals)

    def _creases(self) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]]:
        """Ends of each edge between two faces [m], and the normals of these."""
        for k, root in enumerate(self.roots):
            yield self.tips[root], self.rim[k], self.normals[k - 1], self.normals[k]
        if len(self.tips) == 2:
            one, other = (
                self.normals[k] for k, j in self._sides() if self.roots[k] != self.roots[j]
            )
            yield self.tips[0], self.tips[1], one, other

    def _points(self, pieces: int) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """A part of a sphere round each tip."""
        for tip, fan in zip(self.tips, self._fans(), strict=True):
            middle = _unit(fan.sum(axis=0))
            for one, other in pairwise([*fan, fan[0]]):
                out = _spherical(middle, one, other, pieces)
                yield tip + self.radius * out, out

    def _fans(self) -> list[np.ndarray]:
        """Normals of the faces that meet at each tip, in their order, shape [face, 3] each."""
        fans = []
        for tip in range(len(self.tips)):
            meet = [k for k, j in self._sides() if tip in (self.roots[k], self.roots[j])]
            fans.append(self.normals[meet])
        return fans

    def _pieces(self, facet: float) -> int:
        """Parts of every rounding, the same for all so that they meet."""
        turns = [math.acos(np.clip(a @ b, -1.0, 1.0)) for _, _, a, b in self._creases()]
        for fan in self._fans():
            turns += [math.acos(np.clip(n @ _unit(fan.sum(axis=0)), -1.0, 1.0)) for n in fan]
        parts = max(max(turns) / FACET_ANGLE, max(turns) * self.radius / facet)
        refuse_too_many(parts**2, facet)
        return math.ceil(parts)


def tetrahedron(slope: float, radius: float, height: float) -> Pointed:
    """Three faces that rise from a point, its rounding's lowest point at z = 0, one edge along +x.

    Args:
        slope: of the faces against the horizontal [rad]; 70.53° for a regular tetrahedron.
        radius: of the rounding of its edges and its point [m].
        height: of its top [m].
    """
    rise = _rise("height", height, radius)
    reach = 2.0 * rise / math.tan(_slope("slope", slope))  # corners lie twice as far as the sides
    angles = 2.0 * math.pi / 3.0 * np.arange(3)
    rim = np.stack([reach * np.cos(angles), reach * np.sin(angles), np.full(3, height)], axis=1)
    return Pointed(np.array([[0.0, 0.0, radius]]), rim, (0, 0, 0), radius)


def prism(length: float, slope: float, end_slope: float, radius: float, height: float) -> Pointed:
    """A roof that points down: a ridge along x, two sides, two steeper ends; lowest at z = 0.

    Args:
        length: of the ridge's straight part [m].
        slope: of the sides against the horizontal [rad].
        end_slope: of the ends [rad].
        radius: of the rounding of ridge, edges and corners [m].
        height: of its top [m].
    """
    rise = _rise("height", height, radius)
    x = 0.5 * size("ridge length", length)
    far = x + rise / math.tan(_slope("end_slope", end_slope))
    wide = rise / math.tan(_slope("slope", slope))
    rim = np.array([(far, -wide), (far, wide), (-far, wide), (-far, -wide)])
    tips = np.array([(x, 0.0, radius), (-x, 0.0, radius)])
    return Pointed(tips, np.column_stack([rim, np.full(4, height)]), (0, 0, 1, 1), radius)


def _rise(name: str, height: float, radius: float) -> float:
    """Height of the core [m]."""
    size("edge_radius", radius)
    if size(name, height) <= radius:
        raise InputError(f"{name} = {height:.4g} m must exceed the edge_radius {radius:.4g} m")
    return height - radius


def _slope(name: str, angle: float) -> float:
    if not 0.0 < angle < 0.5 * math.pi:
        raise InputError(
            f"{name} = {math.degrees(angle):.4g}° must lie between 0° and 90°: it is against the "
            "horizontal"
        )
    return angle


def _straight(a: np.ndarray, b: np.ndarray, facet: float) -> np.ndarray:
    """Points from one end to the other [m], as those of `Line`, shape [n, 3]."""
    parts = max(1, math.ceil(np.linalg.norm(b - a) / (4.0 * facet) - 1e-9))
    return np.linspace(a, b, parts + 1)


def _unit(vector: np.ndarray) -> np.ndarray:
    return vector / np.linalg.norm(vector)


def _slerp(a: np.ndarray, b: np.ndarray, share: float) -> np.ndarray:
    """Unit vector a share of the way from one to another along their great circle."""
    turn = math.acos(np.clip(a @ b, -1.0, 1.0))
    if turn < 1e-12:
        return a
    return (math.sin((1.0 - share) * turn) * a + math.sin(share * turn) * b) / math.sin(turn)


def _spherical(a: np.ndarray, b: np.ndarray, c: np.ndarray, parts: int) -> np.ndarray:
    """Facets of a spherical triangle as unit vectors, rows from a to the side bc, [n, 3, 3]."""
    rows = []
    for row in range(parts + 1):
        low, high = _slerp(a, b, row / parts), _slerp(a, c, row / parts)
        rows.append([_slerp(low, high, k / max(row, 1)) for k in range(row + 1)])
    found = []
    for inner, outer in pairwise(rows):
        found += [(inner[k], outer[k], outer[k + 1]) for k in range(len(inner))]
        found += [(inner[k], outer[k + 1], inner[k + 1]) for k in range(len(inner) - 1)]
    return np.array(found)


def _quads(grid: np.ndarray) -> np.ndarray:
    """Triangles of a grid of points, [row, column, 3] → [n, 3, 3]."""
    p, q, r, s = grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]
    both = np.stack([np.stack([p, q, r], axis=2), np.stack([p, r, s], axis=2)], axis=2)
    return both.reshape(-1, 3, 3)
