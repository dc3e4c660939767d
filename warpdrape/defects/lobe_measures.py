"""Measures of the crests of wrinkles, as integrals over the part of a wave above its zero line.

Over half a wave of f = a cos kx, ∫|∇f|² = k² ∫f²: the wavelength needs nothing of the other half.
Integrals are exact for the linear field on triangles that the zero line cuts.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from warpdrape.defects.crest_lobes import Lobes
from warpdrape.defects.smoothing import Smoothing
from warpdrape.defects.wrinkle_field import WrinkleField, face_vectors

FACING = -0.8
"""Cosine between the normals of a wrinkle's two sides below which they face each other [-]."""


@dataclass(frozen=True, eq=False)
class LobeMeasures:
    """What is measured of each lobe.

    Attributes:
        crest: vertex of the largest height, shape [lobe].
        amplitude: half the height from the crest to the troughs beside it [m], shape [lobe].
        wavelength: on the formed ply, mean along the crest [m], shape [lobe].
        wavelength_flat: on the flat ply [m], shape [lobe].
        length: along the crest [m], shape [lobe].
        axis: unit direction of the crest on the flat ply, shape [lobe, 2].
        closed: whether the sides face each other, shape [lobe].
        gain: of the filter [-], shape [lobe].
        height: amplitude of the crest alone [m], shape [lobe].
        field: what is wrinkled.
        steepness: square of the slope of the filtered waves on the formed ply, shape [m].
        area: of the smooth shape's triangles [m²], shape [m].
        triangles: of the ply, shape [m, 3].
    """

    crest: np.ndarray
    amplitude: np.ndarray
    wavelength: np.ndarray
    wavelength_flat: np.ndarray
    length: np.ndarray
    axis: np.ndarray
    closed: np.ndarray
    gain: np.ndarray
    height: np.ndarray
    field: WrinkleField
    steepness: np.ndarray
    area: np.ndarray
    triangles: np.ndarray

    def kept(self, keep: np.ndarray) -> LobeMeasures:
        """Those of lobes that are kept, by a mask."""
        names = ("crest", "amplitude", "wavelength", "wavelength_flat", "length", "axis")
        names += ("closed", "gain", "height")
        return replace(self, **{name: getattr(self, name)[keep] for name in names})

    def excess_of(self, member: np.ndarray) -> np.ndarray:
        """Area that waves have over the smooth shape, for each lobe [m²], shape [lobe].

        Args:
            member: lobe that vertices belong to, −1 for none, shape [n].
        """
        total = np.zeros(len(self.crest))
        for corner in self.triangles.T:
            lobe = member[corner]
            inside = lobe >= 0
            gain = self.gain[lobe[inside]]
            more = np.sqrt(1.0 + self.steepness[inside] / gain**2) - 1.0
            share = more * self.area[inside] / 3.0
            total += np.bincount(lobe[inside], share, len(total))
        return total

    def local_amplitude(self, member: np.ndarray) -> np.ndarray:
        """Amplitude at vertices, the wrinkle's own at its crest [m], shape [n]."""
        waves = self.field.waves
        number = 2.0 * np.pi / self.wavelength_flat[member]
        local = np.hypot(waves.filtered, waves.slope / number) / self.gain[member]
        share = np.minimum(local / self.height[member], 1.0)
        return share * self.amplitude[member]


@dataclass(frozen=True, eq=False)
class _LobeWaves:
    """Waves of lobes: wave numbers on the flat and the formed ply [1/m], axis, gain; [lobe]."""

    number: np.ndarray
    number_now: np.ndarray
    axis: np.ndarray
    gain: np.ndarray

    def where(self, known: np.ndarray, other: _LobeWaves) -> _LobeWaves:
        """These where they are known, by a mask [lobe], else others."""
        return _LobeWaves(
            number=np.where(known, self.number, other.number),
            number_now=np.where(known, self.number_now, other.number_now),
            axis=np.where(known[:, None], self.axis, other.axis),
            gain=np.where(known, self.gain, other.gain),
        )


class _Sums:
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

    def waves(self, of: np.ndarray) -> _LobeWaves:
        """Wave number, axis and gain from the triangles that are given to each lobe."""
        flat, (x, y) = self._flat, self._slopes
        lumped = self.total(flat * (self._square + self._spread), of)
        both = self.total(flat * (self._square + 0.5 * self._spread), of)
        weight = flat * self.share
        xx, yy = self.total(weight * x * x, of), self.total(weight * y * y, of)
        inside = of >= 0
        xy = np.bincount(of[inside], (weight * x * y)[inside], self._count)
        angle = 0.5 * np.arctan2(2.0 * xy, xx - yy)
        return _LobeWaves(
            number=np.sqrt((xx + yy) / both),
            number_now=np.sqrt(self.total(weight * self._steepness, of) / both),
            axis=np.stack([-np.sin(angle), np.cos(angle)], axis=1),
            gain=self._smoothing.gain(np.sqrt((xx + yy) / lumped), angle),
        )


def measure_lobes(
    smoothing: Smoothing, points: np.ndarray, field: WrinkleField, lobes: Lobes
) -> LobeMeasures:
    """Measure every lobe.

    Args:
        smoothing: filters of the ply.
        points: formed positions [m], shape [n, 3].
        field: where it is wrinkled.
        lobes: its crests and troughs.
    """
    triangles = smoothing.mesh.triangles
    of = lobes.of_vertex[triangles].max(axis=1)
    area = np.linalg.norm(face_vectors(field.smooth, triangles), axis=1)
    slopes = (smoothing.gradient @ field.waves.filtered).reshape(2, -1)
    steepness, now = _on_surface(smoothing, field.smooth, slopes)
    sums = _Sums(smoothing, field, lobes, of, slopes, steepness)
    whole = sums.waves(of)
    crest = _crests(smoothing, field, lobes, whole.number)
    near = np.where(_is_near(smoothing, of, crest, whole), of, -1)
    here = sums.waves(near).where(sums.any(near), whole)
    amplitude, height = _heights(smoothing, field, lobes, crest, here)
    length = sums.total(area * sums.share, of) * whole.number_now / np.pi
    return LobeMeasures(
        crest=crest,
        amplitude=amplitude,
        wavelength=2.0 * np.pi / whole.number_now,
        wavelength_flat=2.0 * np.pi / whole.number,
        length=length,
        axis=whole.axis,
        closed=_closed(points, triangles, of, whole.axis, now),
        gain=here.gain,
        height=height,
        field=field,
        steepness=steepness,
        area=area,
        triangles=triangles,
    )


def _on_surface(
    smoothing: Smoothing, smooth: np.ndarray, slopes: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Square of slopes on the smooth shape [m], and its tangents along x and y [m, 3, 2]."""
    m = len(smoothing.mesh.triangles)
    tangents = np.stack([(smoothing.gradient @ smooth)[:m], (smoothing.gradient @ smooth)[m:]], 2)
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


def _crests(
    smoothing: Smoothing, field: WrinkleField, lobes: Lobes, number: np.ndarray
) -> np.ndarray:
    """Vertex of the largest height of each lobe, shape [lobe]."""
    waves, crests = field.waves, np.zeros(len(lobes), dtype=int)
    for k in range(len(lobes)):
        inside = np.flatnonzero(lobes.of_vertex == k)
        if lobes.folded[k]:
            height = field.away[inside]
        else:
            height = np.hypot(waves.filtered, waves.slope / number[k])[inside]
            height = height / waves.gain[inside]
        crests[k] = inside[np.argmax(height)]
    return crests


def _is_near(
    smoothing: Smoothing, of: np.ndarray, crest: np.ndarray, waves: _LobeWaves
) -> np.ndarray:
    """Which triangles lie within half a wavelength of their lobe's crest along it, shape [m]."""
    points = np.asarray(smoothing.mesh.vertices)
    if not len(crest):
        return np.zeros(len(of), dtype=bool)
    off = points[smoothing.mesh.triangles].mean(axis=1) - points[crest[of]]
    along = np.abs((off * waves.axis[of]).sum(axis=1))
    return (of >= 0) & (along * waves.number[of] <= np.pi)


def _heights(
    smoothing: Smoothing,
    field: WrinkleField,
    lobes: Lobes,
    crest: np.ndarray,
    lobe_waves: _LobeWaves,
) -> tuple[np.ndarray, np.ndarray]:
    """Amplitude from crest to troughs [m], and the crest's alone [m], by lobe."""
    points, waves = np.asarray(smoothing.mesh.vertices), field.waves
    amplitude, height = np.zeros(len(lobes)), np.zeros(len(lobes))
    for k, at in enumerate(crest):
        if lobes.folded[k]:
            amplitude[k] = height[k] = field.away[at]
            continue
        number, axis = lobe_waves.number[k], lobe_waves.axis[k]
        off = (points - points[at]) * (0.5 * number / np.pi)  # in wavelengths
        along, across = off @ axis, off @ [axis[1], -axis[0]]
        places = [np.array([at])]
        for way in (1.0, -1.0):
            beside = (np.abs(along) < 0.5) & (way * across > 0.2) & (way * across < 0.8)
            here = np.flatnonzero(beside)
            if len(here):
                places.append(here[[np.argmin(lobes.side[k] * waves.filtered[here])]])
        places = np.concatenate(places)
        local = np.hypot(waves.filtered[places], waves.slope[places] / number)
        local *= (
            np.where(lobes.side[k] * waves.filtered[places] < 0.0, 1.0, 0.0)
            + np.eye(1, len(places)).ravel()
        )
        height[k] = local[0] / lobe_waves.gain[k]
        depth = local[1:].mean() if len(places) > 1 else local[0]
        amplitude[k] = 0.5 * (height[k] + depth / lobe_waves.gain[k])
    return amplitude, height


def _closed(
    points: np.ndarray,
    triangles: np.ndarray,
    of: np.ndarray,
    axis: np.ndarray,
    tangents: np.ndarray,
) -> np.ndarray:
    """Whether the two sides of lobes face each other, shape [lobe]."""
    faces = face_vectors(points, triangles)
    faces /= np.maximum(np.linalg.norm(faces, axis=1, keepdims=True), 1e-300)
    closed = np.zeros(len(axis), dtype=bool)
    for k in range(len(axis)):
        mine = np.flatnonzero(of == k)
        if not len(mine):
            continue
        across = tangents[mine].mean(axis=0) @ [axis[k, 1], -axis[k, 0]]
        lean = faces[mine] @ across
        one, other = faces[mine[np.argmax(lean)]], faces[mine[np.argmin(lean)]]
        closed[k] = one @ other < FACING
    return closed
