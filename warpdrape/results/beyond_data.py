"""Where a formed ply has gone beyond the data of its fabric, whose laws are extrapolated there."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from warpdrape.blanks.ply import Ply
from warpdrape.blanks.triangles import yarn_gradients
from warpdrape.materials.bending import BendingCurve
from warpdrape.materials.laws import MooneyRivlin, ShearTable, TabulatedTension
from warpdrape.results.result import FormedPly

LEAST_SHARE = 1e-3
"""Share of a ply beyond its data from which on that is said [-]."""


@dataclass(frozen=True)
class Beyond:
    """A quantity that has left the range of a law's data.

    Attributes:
        quantity: in words.
        largest: that it came to.
        last: of the data.
        unit: of both.
        share: of the ply's area, at vertices of their number, where it is beyond [-].
    """

    quantity: str
    largest: float
    last: float
    unit: str
    share: float

    def words(self, ply: str) -> str:
        """One line for a summary."""
        unit = self.unit if self.unit in ("", "°") else f" {self.unit}"
        return (
            f"ply {ply!r}: {self.quantity} comes to {self.largest:.3g}{unit}, beyond the last of "
            f"its fabric's data, {self.last:.3g}{unit}, on {100 * self.share:.2g} % of the ply: "
            "extrapolated there; measure so far"
        )


def beyond_data(ply: Ply, formed: FormedPly) -> list[Beyond]:
    """What of a formed ply lies beyond its fabric's data.

    Args:
        ply: as it was laid up.
        formed: as it is.
    """
    _, areas = yarn_gradients(ply.mesh.vertices, ply.mesh.triangles, *ply.yarn_directions)
    found = (
        Beyond(quantity, float(values.max()), last, unit, float(weights[values > last].sum()))
        for quantity, values, last, unit, weights in _ranges(ply, formed, areas / areas.sum())
    )
    return [each for each in found if each.share > LEAST_SHARE]


def largest_stretches(ply: Ply, formed: FormedPly) -> np.ndarray:
    """Larger principal stretch of each triangle [-], shape [m]."""
    gradients, _ = yarn_gradients(ply.mesh.vertices, ply.mesh.triangles, *ply.yarn_directions)
    a, b, c = (formed.points[formed.triangles[:, k]] for k in range(3))
    first = gradients[:, :1] * (b - a) + gradients[:, 1:2] * (c - a)
    second = gradients[:, 2:3] * (b - a) + gradients[:, 3:] * (c - a)
    return np.linalg.svd(np.stack([first, second], axis=2), compute_uv=False)[:, 0]


def _ranges(
    ply: Ply, formed: FormedPly, areas: np.ndarray
) -> Iterator[tuple[str, np.ndarray, float, str, np.ndarray]]:
    """Quantity, its values, the last of the data, their unit, and weights that sum to 1."""
    fabric = ply.fabric
    if isinstance(fabric.shear, ShearTable):
        last = float(np.degrees(fabric.shear.angles[-1]))
        yield "shear angle", np.abs(formed.shear_angle_deg), last, "°", areas
    if isinstance(fabric.tension, TabulatedTension):
        for family, name in enumerate(("warp", "weft")):
            last = float(getattr(fabric.tension, f"strain_{name}")[-1])
            yield f"{name} strain", formed.strain[:, family], last, "", areas
    if isinstance(fabric.tension, MooneyRivlin):
        last = fabric.tension.largest_stretch
        yield "stretch", largest_stretches(ply, formed), last, "", areas
    if fabric.compaction is not None:
        even = np.full(len(formed.points), 1.0 / len(formed.points))
        last = 1e-3 * float(fabric.compaction.pressures[-1])
        for name in ("contact", "tool"):
            pressure = getattr(formed, f"{name}_pressure")
            if pressure is not None:
                yield f"{name} pressure", 1e-3 * pressure, last, "kPa", even
    if isinstance(fabric.bending, BendingCurve) and formed.curvature is not None:
        even = np.full(len(formed.points), 1.0 / len(formed.points))
        for family, name in enumerate(("warp", "weft")):
            last = float(fabric.bending.curvatures[-1])
            yield f"{name} curvature", np.abs(formed.curvature[:, family]), last, "1/m", even
