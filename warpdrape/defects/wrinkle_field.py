"""Where a formed ply is wrinkled: waves that neither its own smooth shape nor a tool explains.

Beside the height over its own smooth shape stands the gap to each tool that is near, less that
gap's smooth part. Where the ply lies on a tool, or a stack parallel to it, the gap has no waves
though a fillet bends the ply as sharply as a wrinkle; where it bridges, its own shape has none. At
each vertex the field with the least waves near by counts.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from dataclasses import fields as dataclass_fields

import numpy as np

from warpdrape.defects.smoothing import Smoothing
from warpdrape.defects.thresholds import DefectThresholds
from warpdrape.defects.waves import Waves, find_waves

NEAR_A_TOOL = 0.25
"""Gap to a tool over the longest wavelength up to which it may explain a wave [-]."""
OWN = -1
"""In place of a tool's number: the ply's own smooth shape."""


@dataclass(frozen=True, eq=False)
class WrinkleField:
    """What is wrinkled of a ply, at its n vertices.

    Attributes:
        waves: those of the field that counts; heights positive on the flat ply's upper side.
        high: whether they are high, steep and short enough for a wrinkle, shape [n].
        turned: whether the ply is turned over there, as in a fold that lies flat, shape [n].
        tool: number of the tool that explains most of the shape, `OWN` for none, shape [n].
        smooth: the smooth shape [m], shape [n, 3].
        away: from it [m], shape [n].
    """

    waves: Waves
    high: np.ndarray
    turned: np.ndarray
    tool: np.ndarray
    smooth: np.ndarray
    away: np.ndarray


def wrinkle_field(
    smoothing: Smoothing,
    thresholds: DefectThresholds,
    thickness: float,
    points: np.ndarray,
    ways: Callable[[], Sequence[np.ndarray]] | None = None,
) -> WrinkleField:
    """Find where a formed ply is wrinkled.

    Args:
        smoothing: filters of the flat ply.
        thresholds: what counts.
        thickness: of the ply [m].
        points: formed positions [m], shape [n, 3].
        ways: gives the ways from the nearest point of each tool to each vertex [m], each of shape
            [n, 3]; not asked where the ply's own shape is smooth.
    """
    smooth = smoothing.smooth(points)
    normals, turned = _sides(smoothing, points, smooth)
    away = points - smooth
    curved = [(each @ points * normals).sum(axis=1) for each in smoothing.mean_curvature]
    waves = find_waves(smoothing, (away * normals).sum(axis=1), np.column_stack(curved))
    high = _are_high(waves, smoothing.longest, thickness, thresholds)
    tool = np.full(len(points), OWN)
    if high.any() and ways is not None:
        waves, tool = _least_explained(smoothing, waves, ways(), normals)
        high = _are_high(waves, smoothing.longest, thickness, thresholds)
    return WrinkleField(
        waves=waves,
        high=high,
        turned=np.isin(np.arange(len(points)), smoothing.mesh.triangles[turned]),
        tool=tool,
        smooth=smooth,
        away=np.linalg.norm(away, axis=1),
    )


def _least_explained(
    smoothing: Smoothing, own: Waves, ways: Sequence[np.ndarray], normals: np.ndarray
) -> tuple[Waves, np.ndarray]:
    """At each vertex the waves of least energy near by, and the number of their tool."""
    if not len(ways):
        return own, np.full(len(normals), OWN)
    gaps = np.column_stack([np.linalg.norm(way, axis=1) for way in ways])
    filtered = gaps - smoothing.smooth(gaps)
    curved = [each @ gaps for each in smoothing.mean_curvature]
    fields, allowed = [own], [np.ones(len(gaps), dtype=bool)]
    for number, way in enumerate(ways):
        side = np.where((way * normals).sum(axis=1) < 0.0, -1.0, 1.0)
        of_gap = np.column_stack([each[:, number] for each in curved])
        fields.append(_turned_to(find_waves(smoothing, filtered[:, number], of_gap), side))
        allowed.append(gaps[:, number] < NEAR_A_TOOL * smoothing.longest)
    return _least(fields, np.array(allowed))


def _sides(
    smoothing: Smoothing, points: np.ndarray, smooth: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Unit normals of the smooth shape at vertices, and which triangles are turned over on it."""
    triangles = smoothing.mesh.triangles
    facing, own = face_vectors(smooth, triangles), face_vectors(points, triangles)
    return vertex_normals(smooth, triangles), (facing * own).sum(axis=1) < 0.0


def vertex_normals(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Unit normals at vertices, means of the triangles round them by area, shape [n, 3]."""
    faces, normals = face_vectors(points, triangles), np.zeros_like(points)
    for corner in triangles.T:
        for axis in range(3):
            normals[:, axis] += np.bincount(corner, faces[:, axis], len(points))
    return normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)


def face_vectors(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Normals of triangles, as long as their areas [m²], shape [m, 3]."""
    columns = np.ascontiguousarray(points.T)  # products of rows of three are slow in numpy
    a, b, c = (columns.take(corner, axis=1) for corner in triangles.T)
    (ux, uy, uz), (vx, vy, vz) = b - a, c - a
    return 0.5 * np.stack([uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx], axis=1)


def _turned_to(waves: Waves, side: np.ndarray) -> Waves:
    """The same waves, heights counted from the other side where ``side`` is −1."""
    return replace(waves, filtered=waves.filtered * side, curvature=waves.curvature * side[:, None])


def _least(fields: Sequence[Waves], allowed: np.ndarray) -> tuple[Waves, np.ndarray]:
    """At each vertex the field of least energy, and the number of its tool."""
    energy = np.where(allowed, np.array([field.energy for field in fields]), np.inf)
    best = np.argmin(energy, axis=0)
    every = np.arange(len(best))

    picked = {
        name.name: np.array([getattr(field, name.name) for field in fields])[best, every]
        for name in dataclass_fields(Waves)
    }
    return Waves(**picked), best - 1


def _are_high(
    waves: Waves, longest: float, thickness: float, thresholds: DefectThresholds
) -> np.ndarray:
    """Whether waves are wrinkles: high, steep and short enough, none longer than the longest."""
    least = thresholds.least_amplitude(thickness, waves.wavelength)
    return (waves.amplitude >= least) & (waves.wavelength <= longest)
