"""Permeability of formed plies: of aligned fibres by Gebart or Kozeny-Carman, then of two families.

A sheet of woven yarns is taken as two layers of parallel fibres, along the warp and the weft as
they lie after forming, each as thick as its share of the fibres, at the local volume fraction.
Layers on each other share the pressure gradient in their plane, so that their tensors add by
thickness, and the flow through them, so that their resistances do: Darcy's law, no more. Channels
between yarns are not seen; where a measurement is at hand, fit the constants of Kozeny-Carman.

Along aligned fibres of radius R: K = 8 R²/c (1 − V)³/V². Across them: K = C (√(V_max/V) − 1)^{5/2}
R², a narrow gap's resistance. Source: B. R. Gebart, Permeability of unidirectional reinforcements
for RTM, Journal of Composite Materials 26 (1992) 1100-1133. Kozeny-Carman is K = R²/(4 k)
(1 − V)³/V² in either direction, with a k of its own in each.
"""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass

import numpy as np

from warpdrape.errors import InputError, finite, one_of, positive
from warpdrape.results.result import FormedPly

FULL = 0.98
"""Share of the densest packing that fibres are taken to reach at most: there K across vanishes."""
ISOTROPIC = 1e-9
"""Difference of the principal values, over their mean, below which there is no direction."""


@dataclass(frozen=True)
class Packing:
    """How aligned fibres lie beside each other.

    Attributes:
        along: c, of flow along the fibres.
        across: C, of flow across them.
        densest: V_max.
    """

    along: float
    across: float
    densest: float


PACKINGS = {
    "quadratic": Packing(57.0, 16.0 / (9.0 * math.pi * math.sqrt(2.0)), math.pi / 4.0),
    "hexagonal": Packing(
        53.0, 16.0 / (9.0 * math.pi * math.sqrt(6.0)), math.pi / (2.0 * math.sqrt(3.0))
    ),
}
"""Gebart's two arrangements."""


@dataclass(frozen=True)
class FibreModel:
    """Permeability of aligned fibres.

    Args:
        fibre_diameter: [m].
        packing: "hexagonal" or "quadratic", of Gebart's model.
        kozeny_along: k of Kozeny-Carman along the fibres; both k or neither.
        kozeny_across: k across them.
        warp_share: share of the fibres that are in the warp.

    Raises:
        InputError: if a value cannot be used.
    """

    fibre_diameter: float
    packing: str = "hexagonal"
    kozeny_along: float | None = None
    kozeny_across: float | None = None
    warp_share: float = 0.5

    def __post_init__(self) -> None:
        positive("fibre_diameter", self.fibre_diameter, unit="m")
        if self.fibre_diameter > 1e-3:
            raise InputError(
                f"fibre_diameter = {self.fibre_diameter:g} m must be 1 mm or less: give metres, or "
                "a unit as in 7um; it is a fibre's, not a yarn's"
            )
        one_of("packing", self.packing, PACKINGS)
        if (self.kozeny_along is None) != (self.kozeny_across is None):
            raise InputError("kozeny_along and kozeny_across go together: give both, or neither")
        if self.kozeny_along is not None:
            positive("kozeny_along", self.kozeny_along)
            positive("kozeny_across", self.kozeny_across)
        if not 0.0 <= finite("warp_share", self.warp_share) <= 1.0:
            raise InputError(
                f"warp_share = {self.warp_share:g} must lie in 0 … 1: 0.5 for balanced fabrics"
            )

    @property
    def densest(self) -> float:
        """Fibre volume fraction up to which the model says something."""
        return FULL * PACKINGS[self.packing].densest

    def along_and_across(self, fraction: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Permeabilities [m²] at fibre volume fractions below `densest`."""
        radius, packing = 0.5 * self.fibre_diameter, PACKINGS[self.packing]
        carman = radius**2 * (1.0 - fraction) ** 3 / fraction**2
        if self.kozeny_along is not None and self.kozeny_across is not None:
            return carman / (4.0 * self.kozeny_along), carman / (4.0 * self.kozeny_across)
        gap = np.sqrt(packing.densest / fraction) - 1.0
        return 8.0 * carman / packing.along, packing.across * gap**2.5 * radius**2


@dataclass(frozen=True)
class Permeability:
    """Permeability of triangles.

    Attributes:
        principal: in the plane, the larger first, and through it [m²], shape [triangle, 3].
        directions: unit vectors of these, shape [triangle, 3, 3].
    """

    principal: np.ndarray
    directions: np.ndarray

    def tensors(self) -> np.ndarray:
        """In the run's coordinates [m²], shape [triangle, 3, 3]."""
        return np.einsum("tk,tki,tkj->tij", self.principal, self.directions, self.directions)


def of_ply(ply: FormedPly, model: FibreModel) -> Permeability:
    """Permeability of a formed ply.

    Args:
        ply: the ply; it has a fibre volume fraction.
        model: of its fibres.

    Raises:
        InputError: if its fabric has no density of its fibres.
    """
    if ply.fibre_volume_fraction is None:
        raise InputError(
            f"{ply.name} has no fibre volume fraction: give its fabric a fibre_density, run again"
        )
    fraction = np.asarray(ply.fibre_volume_fraction, float)
    dense = fraction > model.densest
    if dense.any():
        warnings.warn(
            f"{ply.name}: {int(dense.sum())} triangles have a fibre volume fraction of up to "
            f"{fraction.max():.4g}, more than fibres pack in this model: {model.densest:.4g} is "
            "taken there; a fabric that thickens under shear needs a compaction law",
            stacklevel=2,
        )
    along, across = model.along_and_across(np.minimum(fraction, model.densest))
    first, second, normal = frames(ply)
    extra = np.zeros((len(fraction), 2, 2))
    for family, share in ((ply.warp, model.warp_share), (ply.weft, 1.0 - model.warp_share)):
        plane = np.stack([(family * axis).sum(axis=1) for axis in (first, second)], axis=1)
        plane /= np.linalg.norm(plane, axis=1, keepdims=True)
        extra += share * plane[:, :, None] * plane[:, None, :]
    tensor = across[:, None, None] * np.eye(2) + (along - across)[:, None, None] * extra
    return principal(tensor, across, first, second, normal)


def frames(ply: FormedPly) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Unit vectors of triangles: the warp in their plane, across it there, the normal."""
    corners = np.asarray(ply.points)[ply.triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    first = ply.warp - (ply.warp * normal).sum(axis=1, keepdims=True) * normal
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return first, np.cross(normal, first), normal


def principal(
    tensor: np.ndarray,
    through: np.ndarray,
    first: np.ndarray,
    second: np.ndarray,
    normal: np.ndarray,
) -> Permeability:
    """Principal values and directions of tensors in a plane.

    Args:
        tensor: symmetric [m²], shape [k, 2, 2], in the axes that follow.
        through: the third value [m²], shape [k].
        first: unit vectors, shape [k, 3].
        second: across them.
        normal: of the plane.
    """
    a, b, c = tensor[:, 0, 0], tensor[:, 0, 1], tensor[:, 1, 1]
    mean, half = 0.5 * (a + c), np.hypot(0.5 * (a - c), b)
    angle = 0.5 * np.arctan2(2.0 * b, a - c)
    angle = np.where(half > ISOTROPIC * mean, angle, 0.0)
    cos, sin = np.cos(angle)[:, None], np.sin(angle)[:, None]
    directions = np.stack([cos * first + sin * second, cos * second - sin * first, normal], axis=1)
    return Permeability(np.stack([mean + half, mean - half, through], axis=1), directions)
