"""Where a formed ply is wrinkled: waves that neither its own smooth shape nor a tool explains.

Beside the height over its own smooth shape stands the gap to each tool that is near, less that
gap's smooth part. Where the ply lies on a tool, or a stack parallel to it, the gap has no waves
though a fillet bends the ply as sharply as a wrinkle; where it bridges, its own shape has none. At
each vertex the field with the least waves near by counts.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from warpdrape.blanks.triangles import cross, dot, two_sides
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
    curved = _along(np.swapaxes(smoothing.curvatures(points), 1, 2), normals[:, None])
    own = find_waves(smoothing, _along(away, normals)[:, None], curved[:, None])
    waves, tool = own.of(0), np.full(len(points), OWN)
    high = _are_high(waves, smoothing.longest, thickness, thresholds)
    if high.any() and ways is not None:
        waves, tool = _least_explained(smoothing, own, ways(), normals)
        high = _are_high(waves, smoothing.longest, thickness, thresholds)
    return WrinkleField(
        waves=waves,
        high=high,
        turned=turned,
        tool=tool,
        smooth=smooth,
        away=np.linalg.norm(away, axis=1),
    )


def _least_explained(
    smoothing: Smoothing, own: Waves, ways: Sequence[np.ndarray], normals: np.ndarray
) -> tuple[Waves, np.ndarray]:
    """At each vertex the waves of least energy near by, and the number of their tool."""
    if not len(ways):
        return own.of(0), np.full(len(normals), OWN)
    gaps = np.column_stack([np.linalg.norm(way, axis=1) for way in ways])
    of_gaps = find_waves(smoothing, gaps - smoothing.smooth(gaps), smoothing.curvatures(gaps))
    side = np.column_stack([np.where(_along(way, normals) < 0.0, -1.0, 1.0) for way in ways])
    fields = own.beside(
        replace(
            of_gaps,
            filtered=of_gaps.filtered * side,
            curvature=of_gaps.curvature * side[..., None],
        )
    )
    energy = fields.energy.copy()
    energy[:, 1:][gaps >= NEAR_A_TOOL * smoothing.longest] = np.inf
    best = np.argmin(energy, axis=1)
    return fields.of(best), best - 1


def _sides(
    smoothing: Smoothing, points: np.ndarray, smooth: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Unit normals of the smooth shape at vertices, and which lie where the ply is turned over."""
    triangles = smoothing.mesh.triangles
    facing, own = (cross(*two_sides(shape, triangles)) for shape in (smooth, points))
    turned = np.zeros(len(points), dtype=bool)
    turned[triangles[dot(facing, own) < 0.0]] = True
    return _means_at_vertices(facing, triangles, len(points)), turned


def _along(vectors: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Components of vectors along normals, shapes […, 3]; `dot` is faster than a sum over rows."""
    return dot(np.moveaxis(vectors, -1, 0), np.moveaxis(normals, -1, 0))


def vertex_normals(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Unit normals at vertices, means of the triangles round them by area, shape [n, 3]."""
    return _means_at_vertices(cross(*two_sides(points, triangles)), triangles, len(points))


def _means_at_vertices(faces: np.ndarray, triangles: np.ndarray, count: int) -> np.ndarray:
    """Unit means at vertices, shape [n, 3], of vectors in the triangles, shape [3, m]."""
    sums = np.zeros((3, count))
    for corner in triangles.T:
        for own, values in zip(sums, faces, strict=True):
            own += np.bincount(corner, values, count)
    return np.ascontiguousarray((sums / np.maximum(np.sqrt(dot(sums, sums)), 1e-300)).T)


def face_vectors(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Normals of triangles, as long as their areas [m²], shape [m, 3]."""
    return 0.5 * np.ascontiguousarray(cross(*two_sides(points, triangles)).T)


def _are_high(
    waves: Waves, longest: float, thickness: float, thresholds: DefectThresholds
) -> np.ndarray:
    """Whether waves are wrinkles: high, steep and short enough, none longer than the longest."""
    least = thresholds.least_amplitude(thickness, waves.wavelength)
    return (waves.amplitude >= least) & (waves.wavelength <= longest)
