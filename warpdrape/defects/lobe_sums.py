"""Integrals over the crests of wrinkles, by lobe, over the part of a wave above its zero line.

Over half a wave of f = a cos kx, ∫|∇f|² = k² ∫f²: the wavelength needs nothing of the other half.
Integrals are exact for the linear field on triangles that the zero line cuts.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warpdrape.defects.crest_lobes import Lobes
from warpdrape.defects.smoothing import Smoothing
from warpdrape.defects.wrinkle_field import WrinkleField


@dataclass(frozen=True, eq=False)
class LobeWaves:
    """Waves of lobes: wave numbers on the flat and the formed ply [1/m], axis, gain; [lobe]."""

    number: np.ndarray
    number_now: np.ndarray
    axis: np.ndarray
    gain: np.ndarray

    def where(self, known: np.ndarray, other: LobeWaves) -> LobeWaves:
        """These where they are known, by a mask [lobe], else others."""
        return LobeWaves(
            number=np.where(known, self.number, other.number),
            number_now=np.where(known, self.number_now, other.number_now),
            axis=np.where(known[:, None], self.axis, other.axis),
            gain=np.where(known, self.gain, other.gain),
        )


class LobeSums:
    """Integrals over triangles by lobe, above the zero line."""

    def __init__(
        self,
        smoothing: Smoothing,
        field: WrinkleField,
        lobes: Lobes,
        of: np.ndarray,
        slopes: np.ndarray,
        steepness: np.ndarray,
    ) -> None:
        side = np.append(lobes.side, 1.0)[of]
        self._smoothing, self._count = smoothing, len(lobes)
        self._flat = np.asarray(smoothing.mesh.areas)
        self._slopes, self._steepness = slopes, steepness
        heights = side[:, None] * field.waves.filtered[smoothing.mesh.triangles]
        self.share, self._square, self._spread = _above(heights)

    def total(self, values: np.ndarray, of: np.ndarray) -> np.ndarray:
        """Sums of values over the triangles of each lobe; ``of`` is −1 where there is none."""
        inside = of >= 0
        return np.maximum(np.bincount(of[inside], values[inside], self._count), 1e-300)

    def any(self, of: np.ndarray) -> np.ndarray:
        """Whether lobes have a triangle with anything above the zero line, shape [lobe]."""
        inside = of >= 0
        return np.bincount(of[inside], (self._flat * self._square)[inside], self._count) > 0.0

    def waves(self, of: np.ndarray) -> LobeWaves:
        """Wave number, axis and gain from the triangles that are given to each lobe."""
        flat, (x, y) = self._flat, self._slopes
        lumped = self.total(flat * (self._square + self._spread), of)
        both = self.total(flat * (self._square + 0.5 * self._spread), of)
        weight = flat * self.share
        xx, yy = self.total(weight * x * x, of), self.total(weight * y * y, of)
        inside = of >= 0
        xy = np.bincount(of[inside], (weight * x * y)[inside], self._count)
        angle = 0.5 * np.arctan2(2.0 * xy, xx - yy)
        return LobeWaves(
            number=np.sqrt((xx + yy) / both),
            number_now=np.sqrt(self.total(weight * self._steepness, of) / both),
            axis=np.stack([-np.sin(angle), np.cos(angle)], axis=1),
            gain=self._smoothing.gain(np.sqrt((xx + yy) / lumped), angle),
        )


def on_surface(
    smoothing: Smoothing, smooth: np.ndarray, slopes: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Square of slopes on the smooth shape [m], and its tangents along x and y [m, 3, 2]."""
    tangents = np.stack(np.split(smoothing.gradient @ smooth, 2), axis=2)
    xx, yy = (tangents[..., 0] ** 2).sum(1), (tangents[..., 1] ** 2).sum(1)
    xy = (tangents[..., 0] * tangents[..., 1]).sum(1)
    x, y = slopes
    return (yy * x**2 - 2.0 * xy * x * y + xx * y**2) / np.maximum(xx * yy - xy**2, 1e-12), tangents


def _above(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of linear fields on triangles the part above zero, per area.

    Args:
        corners: values [m], shape [m, 3].

    Returns:
        Share of the area, ∫f² over it, and what lumping adds to that, each of shape [m].
    """
    least, middle, most = np.sort(corners, axis=1).T
    mean_square = ((corners**2).sum(axis=1) + corners.sum(axis=1) ** 2) / 12.0
    lumped = (corners**2).mean(axis=1)
    up = most**2 / np.maximum((most - least) * (most - middle), 1e-300)
    down = least**2 / np.maximum((most - least) * (middle - least), 1e-300)
    share = np.select([least >= 0.0, most <= 0.0, middle <= 0.0], [1.0, 0.0, up], 1.0 - down)
    only_top = up * most**2 / 6.0
    but_bottom = mean_square - down * least**2 / 6.0
    square = np.select(
        [least >= 0.0, most <= 0.0, middle <= 0.0], [mean_square, 0.0, only_top], but_bottom
    )
    return share, square, share * (lumped - mean_square)
