"""Whether a ply rises and falls again: what tells the crest of a wave from a bend.

Across a crest the slope turns by C; beside it, on either side, a wave turns its slope back, a
bend over an edge does not. For f = a cos kx the turn is C = 2ak, and each side turns as much back;
for a single ridge half of it.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from warpdrape.blanks.flat_mesh import FlatMesh
from warpdrape.blanks.triangles import longest_sides
from warpdrape.defects.waves import Waves

TURNED_BACK = 0.2
"""Least turn back on either side of a crest over the turn at the crest [-]: a wave has 1, a single
ridge 0.5, a bend 0."""
OF_A_WAVE = 0.3
"""Least turn at a crest over that of a sine of its amplitude and length [-]; what the filter makes
beside a bend has next to none."""
REACH, SAMPLES = 0.75, 12
"""How far to either side of a crest its turns are asked for over the wavelength, in how many
steps."""


class Neighbourhood:
    """Vertices by place on the flat ply.

    Args:
        mesh: the flat blank.
    """

    def __init__(self, mesh: FlatMesh) -> None:
        self._points = np.asarray(mesh.vertices)
        self._sides = longest_sides(self._points, mesh.triangles)
        self._corner = self._points.min(axis=0)
        self._spacing = 0.5 * float(np.sqrt(np.asarray(mesh.areas).mean()))

    @cached_property
    def _nearest(self) -> np.ndarray:
        """Number of the vertex nearest to each point of a grid, −1 off the ply."""
        size = self._points.max(axis=0) - self._corner
        counts = np.ceil(size / self._spacing).astype(int) + 1
        grid = np.indices(counts).reshape(2, -1).T * self._spacing + self._corner
        distance, vertex = cKDTree(self._points).query(grid)
        return np.where(distance <= 0.75 * self._sides.max(), vertex, -1).reshape(counts)

    def vertices_at(self, places: np.ndarray) -> np.ndarray:
        """Vertices nearest to places on the flat ply [m], shape […, 2]; −1 off it."""
        nearest = self._nearest
        at = np.rint((places - self._corner) / self._spacing).astype(int)
        inside = ((at >= 0) & (at < nearest.shape)).all(axis=-1)
        at = np.where(inside[..., None], at, 0)
        return np.where(inside, nearest[at[..., 0], at[..., 1]], -1)

    def are_crests(self, waves: Waves, vertices: np.ndarray) -> np.ndarray:
        """Whether the ply turns back on both sides of vertices, shape [v].

        Args:
            waves: of a field.
            vertices: near a crest or the bottom of a trough, shape [v].
        """
        wavelength = waves.wavelength[vertices]
        across = _across(waves.curvature[vertices])
        step = REACH * wavelength / SAMPLES
        ways = step[:, None] * np.arange(-SAMPLES, SAMPLES + 1)
        places = self._points[vertices][:, None] + ways[..., None] * across[:, None]
        found = self.vertices_at(places)
        x, y = across.T[..., None]
        xx, yy, xy = (each.take(found) for each in np.ascontiguousarray(waves.curvature.T))
        along = xx * x**2 + yy * y**2 + 2.0 * xy * x * y
        outward = -np.where(found >= 0, along, 0.0) * np.sign(waves.filtered[vertices])[:, None]
        turns = outward * step[:, None]
        turn = _turn_at_crest(turns)
        back = np.minimum(
            np.maximum(-turns[:, :SAMPLES], 0.0).sum(axis=1),
            np.maximum(-turns[:, SAMPLES + 1 :], 0.0).sum(axis=1),
        )
        expected = 2.0 * waves.amplitude[vertices] * waves.wave_number[vertices]
        return (turn >= OF_A_WAVE * expected) & (back >= TURNED_BACK * turn)


def _across(curvature: np.ndarray) -> np.ndarray:
    """Unit direction in which a field is curved most, of its second derivatives, shape [v, 2]."""
    xx, yy, xy = curvature.T
    half, mean = 0.5 * (xx - yy), 0.5 * (xx + yy)
    angle = 0.5 * np.arctan2(xy, half)
    angle = np.where(mean < 0.0, angle + 0.5 * np.pi, angle)
    return np.stack([np.cos(angle), np.sin(angle)], axis=1)


def _turn_at_crest(turns: np.ndarray) -> np.ndarray:
    """Sum of the turns around the middle, on either side up to the first that turns back."""
    middle = turns.shape[1] // 2
    sides = turns[:, middle + 1 :], turns[:, :middle][:, ::-1]
    total = np.maximum(turns[:, middle], 0.0)
    for side in sides:
        still = np.cumsum(side < 0.0, axis=1) == 0
        total = total + np.where(still, side, 0.0).sum(axis=1)
    return total
