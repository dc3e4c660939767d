"""Wrinkles of a formed ply: each with its place, amplitude, wavelength, length and direction."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse

from warpdrape.blanks.flat_mesh import FlatMesh
from warpdrape.defects.crest_lobes import (
    Lobes,
    belonging,
    edge_graph,
    find_lobes,
    of_one_side,
)
from warpdrape.defects.crests import Neighbourhood
from warpdrape.defects.lobe_measures import LobeMeasures, measure_lobes
from warpdrape.defects.smoothing import Smoothing
from warpdrape.defects.thresholds import DefectThresholds
from warpdrape.defects.wrinkle_field import WrinkleField, wrinkle_field

SIDES_PER_WAVE = 4.0
"""Sides of triangles that a wave must be long for the mesh to carry it as the fabric would [-]."""
LEAST_LENGTH = 1.0
"""Length of a wrinkle over its wavelength, at least [-]: twice as long as it is wide; less is
a dimple."""


@dataclass(frozen=True)
class Wrinkle:
    """One wrinkle.

    Attributes:
        vertex: of its crest.
        amplitude: half the height from the crest to the troughs beside it [m].
        wavelength: on the formed ply [m].
        length: of its crest [m].
        axis: direction of its crest on the flat ply, unit, shape [2].
        excess: length that a line across it has over one on the smooth shape [m].
        closed: whether its sides face each other: a fold.
        resolved: whether it is long enough for the mesh; a shorter one may be the mesh's own.
        tool: number of the tool that it lies on, −1 where it lies free.
    """

    vertex: int
    amplitude: float
    wavelength: float
    length: float
    axis: tuple[float, float]
    excess: float
    closed: bool
    resolved: bool
    tool: int


@dataclass(frozen=True, eq=False)
class Wrinkling:
    """The wrinkles of a ply.

    Attributes:
        wrinkles: the largest first.
        amplitude: local amplitude of the wrinkle that a vertex belongs to, 0 for none [m], [n].
        area_share: of the flat ply that is wrinkled: by resolved ones, and by others [-].
    """

    wrinkles: tuple[Wrinkle, ...]
    amplitude: np.ndarray
    area_share: tuple[float, float]

    def those(self, *, resolved: bool) -> tuple[Wrinkle, ...]:
        """The wrinkles that the mesh resolves, or the others."""
        return tuple(wrinkle for wrinkle in self.wrinkles if wrinkle.resolved is resolved)

    def largest(self, *, resolved: bool) -> float:
        """Largest amplitude of those [m], 0 where there is none."""
        return max((wrinkle.amplitude for wrinkle in self.those(resolved=resolved)), default=0.0)


@dataclass(frozen=True, eq=False)
class WrinkleSearch:
    """Finds the wrinkles of one ply.

    Attributes:
        mesh: of the flat blank.
        thickness: of the ply [m].
        thresholds: what counts.
    """

    mesh: FlatMesh
    thickness: float
    thresholds: DefectThresholds

    @cached_property
    def smoothing(self) -> Smoothing:
        """Filters of the ply."""
        size = math.sqrt(float(np.sum(self.mesh.areas)))
        return Smoothing(self.mesh, self.thresholds.longest_wrinkle * size)

    @cached_property
    def _side(self) -> float:
        """Mean side of the triangles [m]."""
        ends = np.asarray(self.mesh.vertices)[self.mesh.edges.vertices]
        return float(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).mean())

    @cached_property
    def _near(self) -> Neighbourhood:
        return Neighbourhood(self.mesh)

    @cached_property
    def _graph(self) -> sparse.csr_matrix:
        return edge_graph(self.mesh)

    def look(
        self, points: np.ndarray, ways: Callable[[], Sequence[np.ndarray]] | None = None
    ) -> Wrinkling:
        """Find the wrinkles of the formed ply.

        Args:
            points: formed positions [m], shape [n, 3].
            ways: gives the ways from the nearest point of each tool to each vertex [m], each of
                shape [n, 3]; asked where the ply is not smooth. None where there are no tools.
        """
        smoothing, thresholds = self.smoothing, self.thresholds
        field = wrinkle_field(smoothing, thresholds, self.thickness, points, ways)
        if not (field.high.any() or field.turned.any()):
            return Wrinkling((), np.zeros(len(points)), (0.0, 0.0))
        lobes = find_lobes(smoothing, self._near, self._graph, field)
        if len(lobes):
            lobes, found = self._kept(points, field, lobes)
        if not len(lobes):
            return Wrinkling((), np.zeros(len(points)), (0.0, 0.0))
        member = belonging(smoothing, lobes, field.high, found.wavelength_flat)
        excess = found.excess_of(member)
        wrinkles = [
            Wrinkle(
                vertex=int(found.crest[k]),
                amplitude=float(found.amplitude[k]),
                wavelength=float(found.wavelength[k]),
                length=float(found.length[k]),
                axis=(float(found.axis[k, 0]), float(found.axis[k, 1])),
                excess=float(excess[k] / found.length[k]),
                closed=bool(found.closed[k] or lobes.folded[k]),
                resolved=bool(found.wavelength_flat[k] >= SIDES_PER_WAVE * self._side),
                tool=int(field.tool[found.crest[k]]),
            )
            for k in range(len(lobes))
        ]
        resolved = np.array([wrinkle.resolved for wrinkle in wrinkles])
        there = member >= 0
        local = np.where(there, found.local_amplitude(member), 0.0)
        seen, unseen = (self._share(there & (resolved[member] == one)) for one in (True, False))
        wrinkles.sort(key=lambda wrinkle: -wrinkle.amplitude)
        return Wrinkling(tuple(wrinkles), local, (seen, unseen))

    def _share(self, vertices: np.ndarray) -> float:
        """Share of the flat ply's area round vertices, by a mask [-]."""
        masses = self.smoothing.masses
        return float(masses[vertices].sum() / masses.sum())

    def _kept(
        self, points: np.ndarray, field: WrinkleField, lobes: Lobes
    ) -> tuple[Lobes, LobeMeasures]:
        """Lobes that are wrinkles, one for each, and their measures."""
        found = measure_lobes(self.smoothing, points, field, lobes)
        least = self.thresholds.least_amplitude(self.thickness, found.wavelength)
        short = found.wavelength <= self.smoothing.longest
        long = found.length >= LEAST_LENGTH * found.wavelength
        keep = (found.amplitude >= least) & ((short & long) | lobes.folded)
        lobes, found = lobes.kept(keep), found.kept(keep)
        if not len(lobes):
            return lobes, found
        keep = of_one_side(self._graph, lobes, found.amplitude * found.length)
        return lobes.kept(keep), found.kept(keep)
