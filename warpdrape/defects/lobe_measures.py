"""Measures of the crests of wrinkles: amplitude, wavelength, length, direction, excess length."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from warpdrape.defects.crest_lobes import Lobes
from warpdrape.defects.lobe_sums import LobeSums, LobeWaves, on_surface
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
        names = ["crest", "amplitude", "wavelength", "wavelength_flat", "length", "axis"]
        names += ["closed", "gain", "height"]
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
    steepness, now = on_surface(smoothing, field.smooth, slopes)
    sums = LobeSums(smoothing, field, lobes, of, slopes, steepness)
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
    smoothing: Smoothing, of: np.ndarray, crest: np.ndarray, waves: LobeWaves
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
    lobe_waves: LobeWaves,
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
        found = [np.array([at])]
        for way in (1.0, -1.0):
            beside = (np.abs(along) < 0.5) & (way * across > 0.2) & (way * across < 0.8)
            here = np.flatnonzero(beside)
            if len(here):
                found.append(here[[np.argmin(lobes.side[k] * waves.filtered[here])]])
        places = np.concatenate(found)
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
