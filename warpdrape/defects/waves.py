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
    """Waves of one field at vertices.

    Attributes:
        filtered: what the filter has taken out of the field [m], shape [n].
        slope: of that on the flat ply [-], shape [n].
        wave_number: on the flat ply [1/m], shape [n].
        gain: what the filter has left of the wave [-], shape [n].
        energy: mean square of the filtered height near by [m²], shape [n].
        curvature: of the field before any filter, xx, yy, xy [1/m], shape [n, 3].
    """

    filtered: np.ndarray
    slope: np.ndarray
    wave_number: np.ndarray
    gain: np.ndarray
    energy: np.ndarray
    curvature: np.ndarray

    @property
    def amplitude(self) -> np.ndarray:
        """Of the wave, as it was before the filter [m], shape [n]."""
        return np.hypot(self.filtered, self.slope / self.wave_number) / self.gain

    @property
    def wavelength(self) -> np.ndarray:
        """On the flat ply [m], shape [n]."""
        return 2.0 * np.pi / self.wave_number


def find_waves(smoothing: Smoothing, filtered: np.ndarray, curvature: np.ndarray) -> Waves:
    """Analyse what a field has beside its smooth shape.

    Args:
        smoothing: filters of the ply.
        filtered: what the filter has taken out of the field [m], shape [n].
        curvature: of the field itself [1/m], shape [n, 3].
    """
    m = len(smoothing.mesh.triangles)
    slopes = (smoothing.gradient @ filtered).reshape(2, m)
    at = smoothing.at_vertices
    lumped = filtered**2
    a, b, c = (filtered[corner] for corner in smoothing.mesh.triangles.T)  # faster than by rows
    consistent = at @ (a**2 + b**2 + c**2 + (a + b + c) ** 2) / 12.0
    steepness = at @ (slopes[0] ** 2 + slopes[1] ** 2)
    along, across = (at @ slopes.T).T
    means = smoothing.around(np.column_stack([lumped, consistent, steepness]))
    lumped_energy, consistent_energy, steepness = np.maximum(means, TINY).T
    return Waves(
        filtered=filtered,
        slope=np.sqrt(along**2 + across**2),
        wave_number=np.sqrt(steepness / (0.5 * (lumped_energy + consistent_energy))),
        gain=smoothing.gain(np.sqrt(steepness / lumped_energy)),
        energy=lumped_energy,
        curvature=curvature,
    )
