"""How far the shear angles of one run's ply are off those of another, at the same rest points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warpdrape.blanks.places import locate
from warpdrape.blanks.triangles import area_percentile
from warpdrape.results.result import FormedPly


@dataclass(frozen=True)
class ShearDifference:
    """Differences of signed shear angles over a ply's flat area.

    Attributes:
        median_deg: half of the area differs by less [deg].
        p95_deg: 95 % of the area differs by less [deg].
        share: of the ply's area that has a counterpart on the other ply [-].
    """

    median_deg: float
    p95_deg: float
    share: float


def shear_difference(ply: FormedPly, first: FormedPly) -> ShearDifference | None:
    """Compare a ply with the same ply of another run; None where no point of it is on the other.

    The middle of each triangle, on the flat blank, lies in a triangle of the other mesh, whose
    shear angle is taken as it is. A middle beside the other blank has no counterpart.

    Args:
        ply: whose triangles are asked.
        first: what they are compared with; its mesh may be another.
    """
    corners = ply.rest_points[ply.triangles][:, :, :2]
    middles = corners.mean(axis=1)
    found = locate(middles, first.rest_points[:, :2], first.triangles).triangles
    met = found >= 0
    if not met.any():
        return None
    u, v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    areas = 0.5 * np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])
    off = np.abs(ply.shear_angle_deg[met] - first.shear_angle_deg[found[met]])
    median, most = (area_percentile(off, areas[met], share) for share in (0.5, 0.95))
    return ShearDifference(median, most, float(areas[met].sum() / areas.sum()))
