"""Tool surfaces from profiles of lines and arcs: revolved round z, or extruded along y.

A profile is drawn with the material on its right: its left side is the outward normal. The
facets' corner normals come from the lines and arcs themselves, so contact sees the true surface to
second order and the fillets' ends stay flat.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import trimesh

from warpdrape.errors import InputError, finite, said
from warpdrape.errors import length as size
from warpdrape.wording import surface

FACET_ANGLE = math.radians(6.0)
"""Largest turn of an arc per facet [rad]."""

MOST_FACETS = 1e7
"""Facets of a tool beyond which a facet size is a slip of the pen, and memory runs out."""


@dataclass(frozen=True)
class Line:
    """A straight piece of a profile, from (r, z) to (r, z) [m]."""

    start: tuple[float, float]
    end: tuple[float, float]

    def sample(self, facet: float) -> np.ndarray:
        """Points [m], shape [n, 2]."""
        n = max(1, _parts(math.dist(self.start, self.end), 4.0 * facet))  # straight
        return np.linspace(self.start, self.end, n + 1)

    def normals(self, points: np.ndarray) -> np.ndarray:
        """Unit normals at points of the piece, shape [n, 2]."""
        along = np.subtract(self.end, self.start)
        normal = np.array([-along[1], along[0]]) / np.linalg.norm(along)
        return np.broadcast_to(normal, points.shape)


@dataclass(frozen=True)
class Arc:
    """A circular piece, from angle to angle [rad] about a centre (r, z) [m]."""

    center: tuple[float, float]
    radius: float
    start: float
    end: float

    def sample(self, facet: float) -> np.ndarray:
        """Points [m], shape [n, 2]."""
        turn = abs(self.end - self.start)
        n = max(2, math.ceil(turn / FACET_ANGLE), _parts(turn * self.radius, facet))
        angle = np.linspace(self.start, self.end, n + 1)
        return np.asarray(self.center) + self.radius * np.stack([np.cos(angle), np.sin(angle)], 1)

    def normals(self, points: np.ndarray) -> np.ndarray:
        """Unit normals at points of the piece, shape [n, 2]."""
        outward = points - np.asarray(self.center)
        length = np.linalg.norm(outward, axis=1, keepdims=True)
        # Clockwise arcs have their left side outside.
        return (1.0 if self.end < self.start else -1.0) * outward / length


Piece = Line | Arc


@dataclass(frozen=True, eq=False)
class Surface:
    """Facets with a normal at each corner.

    Attributes:
        mesh: the facets as trimesh holds them [m].
        normals: unit outward normals, shape [facet, 3, 3].
        exact: whether the normals are those of the true surface, or estimated from facets.
        source: the file that it comes from, and its unit, in words; "" if it is made here.
    """

    mesh: trimesh.Trimesh
    normals: np.ndarray
    exact: bool
    source: str = ""

    def __repr__(self) -> str:
        return f"Surface: {surface(self.mesh.vertices, self.mesh.faces, 'facets')}"

    def moved(self, way: np.ndarray) -> Surface:
        """The surface elsewhere, by a translation [m], shape [3]."""
        mesh = self.mesh.copy()
        mesh.apply_translation(way)
        return replace(self, mesh=mesh)

    def turned(self, rotation: np.ndarray) -> Surface:
        """The surface turned about the origin by a matrix, shape [3, 3]."""
        mesh, matrix = self.mesh.copy(), np.eye(4)
        matrix[:3, :3] = rotation
        mesh.apply_transform(matrix)
        return replace(self, mesh=mesh, normals=self.normals @ rotation.T)

    def flipped(self) -> Surface:
        """The surface with its facets facing the other way."""
        mesh = trimesh.Trimesh(self.mesh.vertices, self.mesh.faces[:, ::-1], process=False)
        return replace(self, mesh=mesh, normals=-self.normals[:, ::-1])


def revolve(
    pieces: Sequence[Piece], facet: float, sector: tuple[float, float] | None = None
) -> Surface:
    """Revolve a profile in (r, z) round the z axis.

    Args:
        pieces: lines and arcs, one after the other; r ≥ 0.
        facet: facet size aimed at [m].
        sector: angles from and to which it goes, counter-clockwise from x [rad]; None all round.

    Raises:
        InputError: if the profile crosses the axis or does not hang together, or the sector is
            none.
    """
    first, turn = _sector(sector)
    ends, normals = sample_pieces(pieces, facet)
    radius = ends[..., 0].max()
    if ends[..., 0].min() < -1e-12:
        raise InputError("a revolved profile must not cross the axis (r < 0)")
    turns = max(turn / FACET_ANGLE, turn * radius / facet)
    refuse_too_many(len(ends) * turns, facet)
    angle = np.linspace(first, first + turn, 4 * math.ceil(turns / 4) + 1)
    if sector is None:
        angle[-1] = first  # closes on the very same points

    def spin(rz: np.ndarray) -> np.ndarray:
        r, z = rz[..., 0, None], rz[..., 1, None]
        return np.stack([r * np.cos(angle), r * np.sin(angle), z + 0 * angle], -1)

    return facets_between(spin(ends), spin(normals))


def _sector(sector: tuple[float, float] | None) -> tuple[float, float]:
    """Where a revolution begins, and by how much it turns [rad]."""
    if sector is None:
        return 0.0, 2 * math.pi
    try:
        first, last = (finite("sector", angle, unit="rad") for angle in sector)
    except (TypeError, ValueError) as error:
        raise InputError(f"sector = {said(sector)} must be two angles [rad]") from error
    if not 0.0 < last - first < 2 * math.pi:
        raise InputError(
            f"sector = {said(sector)} must rise by less than a whole turn, in radians: leave it "
            "out for all round"
        )
    return first, last - first


def extrude(pieces: list[Piece], length: float, facet: float) -> Surface:
    """Extrude a profile in (x, z) along y, from −length/2 to length/2 [m].

    Raises:
        InputError: if the profile does not hang together or the length is not positive.
    """
    size("length", length)
    ends, normals = sample_pieces(pieces, facet)
    count = max(1, _parts(length, facet)) + 1
    refuse_too_many(len(ends) * count, facet)
    along = np.linspace(-0.5 * length, 0.5 * length, count)

    def pull(rz: np.ndarray, y: np.ndarray) -> np.ndarray:
        x, z = rz[..., 0, None], rz[..., 1, None]
        return np.stack([x + 0 * y, 0 * x + y, z + 0 * y], -1)

    return facets_between(pull(ends, along), pull(normals, 0 * along))


def _parts(way: float, facet: float) -> int:
    """Facets along a way [m]."""
    refuse_too_many(way / facet, facet)
    return math.ceil(way / facet)


def refuse_too_many(quads: float, facet: float) -> None:
    """Raise `InputError` where a facet size would fill the memory."""
    if 2.0 * quads > MOST_FACETS:
        raise InputError(
            f"facet = {facet:.4g} m makes {2.0 * quads:.2g} facets, more than {MOST_FACETS:.0e}: "
            "take a larger one"
        )


def sample_pieces(pieces: Sequence[Piece], facet: float) -> tuple[np.ndarray, np.ndarray]:
    """Ends of the profile's facets and the normals there, both shape [facet, 2, 2]."""
    size("facet", facet)
    ends: list[np.ndarray] = []
    normals: list[np.ndarray] = []
    for piece in pieces:
        points = piece.sample(facet)
        if ends and np.linalg.norm(points[0] - ends[-1][-1, 1]) > 1e-9:
            raise InputError(f"profile piece {piece} does not start where the one before it ends")
        across = np.asarray(piece.normals(points))
        ends.append(np.stack([points[:-1], points[1:]], 1))
        normals.append(np.stack([across[:-1], across[1:]], 1))
    return np.concatenate(ends), np.concatenate(normals)


def facets_between(points: np.ndarray, normals: np.ndarray) -> Surface:
    """Facets between neighbouring positions of profile facets, [facet, 2, position, 3]."""

    def triangles(a: np.ndarray) -> np.ndarray:
        low, high = a[:, 0], a[:, 1]
        p, q, r, s = low[:, :-1], high[:, :-1], high[:, 1:], low[:, 1:]
        both = np.stack([np.stack([p, q, r], 2), np.stack([p, r, s], 2)], 2)
        return both.reshape(-1, 3, 3)

    corners, directions = triangles(points), triangles(normals)
    area = np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    solid = area > 1e-9 * area.max()  # facets that end on the axis have no area
    corners, directions = corners[solid], directions[solid]
    mesh = trimesh.Trimesh(
        corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3), process=False
    )
    mesh.merge_vertices()
    return Surface(mesh, directions, exact=True)
