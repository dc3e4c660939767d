"""Waves of a field over a ply: their amplitude and wave number, and how the field is curved.

What a field of heights has beside its smooth shape is analysed as a wave f whose amplitude and
length change slowly: k² = ⟨|∇f|²⟩/⟨f²⟩ and a² = f² + |∇f|²/k², means over the neighbourhood. For
f = a cos kx both are exact at every phase. The mean of lumped and consistent mass in ⟨f²⟩ takes
the first error of linear elements out of k.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warpdrape.defects.smoothing import Smoothing

TINY = 1e-300


@dataclass(frozen=True, eq=False)
class Waves:
    """Waves of one field at vertices, shapes [n]; or of several, a column each, shapes [n, field].

    Attributes:
        filtered: what the filter has taken out of the field [m].
        slope: of that on the flat ply [-].
        wave_number: on the flat ply [1/m].
        gain: what the filter has left of the wave [-].
        energy: mean square of the filtered height near by [m²].
        curvature: of the field before any filter, xx, yy, xy [1/m], in an axis more.
    """

    filtered: np.ndarray
    slope: np.ndarray
    wave_number: np.ndarray
    gain: np.ndarray
    energy: np.ndarray
    curvature: np.ndarray

    @property
    def amplitude(self) -> np.ndarray:
        """Of the wave, as it was before the filter [m], likewise."""
        return np.hypot(self.filtered, self.slope / self.wave_number) / self.gain

    @property
    def wavelength(self) -> np.ndarray:
        """On the flat ply [m], likewise."""
        return 2.0 * np.pi / self.wave_number

    def beside(self, others: Waves) -> Waves:
        """These fields, and after them others."""
        return Waves(
            **{
                name: np.concatenate([own, getattr(others, name)], axis=1)
                for name, own in vars(self).items()
            }
        )

    def of(self, field: np.ndarray | int) -> Waves:
        """One field: the same everywhere, or each vertex its own, shape [n]."""
        every = np.arange(len(self.filtered))
        return Waves(**{name: values[every, field] for name, values in vars(self).items()})


def find_waves(smoothing: Smoothing, filtered: np.ndarray, curvature: np.ndarray) -> Waves:
    """Analyse what fields have beside their smooth shapes.

    Args:
        smoothing: filters of the ply.
        filtered: what the filter has taken out of each field [m], shape [n, field].
        curvature: of the fields themselves [1/m], shape [n, field, 3].
    """
    n, count = filtered.shape
    slopes = smoothing.gradient @ filtered
    x, y = slopes.reshape(2, -1, count)
    a, b, c = (filtered.take(corner, axis=0) for corner in smoothing.mesh.triangles.T)
    squares = a**2 + b**2 + c**2 + (a + b + c) ** 2
    at_vertices = smoothing.at_vertices @ np.hstack([squares, x**2 + y**2, x, y])
    squares, steepness, along, across = at_vertices.reshape(n, 4, count).swapaxes(0, 1)
    means = smoothing.around(np.hstack([filtered**2, squares / 12.0, steepness]))
    lumped, consistent, steepness = np.maximum(means, TINY).reshape(n, 3, count).swapaxes(0, 1)
    return Waves(
        filtered=filtered,
        slope=np.sqrt(along**2 + across**2),
        wave_number=np.sqrt(steepness / (0.5 * (lumped + consistent))),
        gain=smoothing.gain(np.sqrt(steepness / lumped)),
        energy=lumped,
        curvature=curvature,
    )
