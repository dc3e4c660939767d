"""Fibre misalignment: how far yarns turn from a direction that is wanted in a region of a ply."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from warpdrape.blanks.triangles import area_percentile
from warpdrape.defects.wrinkle_field import face_vectors
from warpdrape.errors import InputError, one_of, said
from warpdrape.tools.motion import vector


@dataclass(frozen=True, kw_only=True, eq=False)
class WantedDirection:
    """A direction that the yarns of one family should have in a region.

    Attributes:
        name: how results call it.
        ply: name of the ply.
        direction: on the formed part, any length, shape [3]; its projection on the ply counts.
        family: "warp" or "weft".
        where: function of the flat points [m] (shape [n, 3]), here the triangles' middles, to a
            mask; the whole ply if None.
    """

    name: str
    ply: str
    direction: Sequence[float]
    family: str = "warp"
    where: Callable[[np.ndarray], np.ndarray] | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not self.name.isidentifier():
            raise InputError(
                f"wanted direction name = {said(self.name)} must be a plain identifier"
            )
        one_of(f"family of {self.name!r}", self.family, ("warp", "weft"))
        if not np.linalg.norm(vector(f"{self.name!r}: direction", self.direction)) > 0.0:
            raise InputError(f"wanted direction {self.name!r}: direction must not be zero")

        if self.where is not None and not callable(self.where):
            raise InputError(
                f"wanted direction {self.name!r}: where must be a function of points to a mask"
            )

    def region(self, middles: np.ndarray) -> np.ndarray:
        """Mask of the triangles in it, by their middles on the flat ply [m], shape [m, 3]."""
        if self.where is None:
            return np.ones(len(middles), dtype=bool)
        mask = np.asarray(self.where(middles))
        if mask.shape != (len(middles),) or mask.dtype != bool:
            raise InputError(
                f"wanted direction {self.name!r}: where must give {len(middles)} truth values, "
                f"one for each triangle of ply {self.ply!r}, not {mask.dtype} of shape {mask.shape}"
            )
        if not mask.any():
            raise InputError(
                f"wanted direction {self.name!r} holds no triangle of ply {self.ply!r}"
            )
        return mask


def misalignments(
    yarns: np.ndarray, points: np.ndarray, triangles: np.ndarray, direction: Sequence[float]
) -> np.ndarray:
    """Angles from the wanted direction, as seen in each triangle's plane, to yarns [rad], [m].

    Args:
        yarns: unit directions, shape [m, 3]; a yarn has no sense, so that angles end at 90°.
        points: formed positions [m], shape [n, 3].
        triangles: vertices, shape [m, 3].
        direction: wanted, shape [3].
    """
    normals = face_vectors(points, triangles)
    normals = normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    wanted = np.asarray(direction, dtype=float)
    within = wanted - (normals @ wanted)[:, None] * normals
    along = (within * yarns).sum(axis=1)
    across = np.linalg.norm(np.cross(within, yarns), axis=1)
    return np.arctan2(across, np.abs(along))


def misalignment_entry(
    wanted: WantedDirection, angles: np.ndarray, areas: np.ndarray, region: np.ndarray
) -> dict[str, Any]:
    """Entry of ``summary.json`` of one wanted direction.

    Args:
        wanted: the direction.
        angles: of all triangles [rad], shape [m].
        areas: flat [m²], shape [m].
        region: mask of triangles, shape [m].
    """
    inside, weights = np.degrees(angles[region]), areas[region]
    return {
        "name": wanted.name,
        "family": wanted.family,
        "mean_deg": float(np.average(inside, weights=weights)),
        "p95_deg": area_percentile(inside, weights, 0.95),
        "max_deg": float(inside.max()),
    }
