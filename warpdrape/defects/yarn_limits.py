"""How far shear and yarn strains are past what the fabric's card allows."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from warpdrape.materials.fabric import Fabric


def shear_past_locking(fabric: Fabric, shear: np.ndarray, areas: np.ndarray) -> dict[str, Any]:
    """Shear past the locking angle of the fabric's card; not judged where it has none.

    Args:
        fabric: of the ply.
        shear: signed shear angles [rad], shape [m].
        areas: flat [m²], shape [m].

    Returns:
        ``locking_angle_deg``, ``max_past_deg`` and ``area_share``, None where not judged.
    """
    locking = fabric.locking_angle
    if locking is None:
        return {"locking_angle_deg": None, "max_past_deg": None, "area_share": None}
    past = np.abs(shear) - locking
    return {
        "locking_angle_deg": math.degrees(locking),
        "max_past_deg": math.degrees(max(float(past.max()), 0.0)),
        "area_share": _share(past > 0.0, areas),
    }


def yarn_strains(
    fabric: Fabric, strain: np.ndarray, areas: np.ndarray, compression: float
) -> dict[str, Any]:
    """Yarns past failure, where the card has a failure strain, and yarns in compression.

    Args:
        fabric: of the ply.
        strain: of warp and weft [-], shape [m, 2].
        areas: flat [m²], shape [m].
        compression: shortening from which on a yarn counts as compressed [-].

    Returns:
        By family ``failure_strain``, ``max_strain``, ``failed_area_share`` (None where not
        judged), ``min_strain`` and ``compressed_area_share``.
    """
    found = {}
    for number, family in enumerate(("warp", "weft")):
        own, limit = strain[:, number], getattr(fabric, f"failure_strain_{family}")
        found[family] = {
            "failure_strain": limit,
            "max_strain": float(own.max()),
            "failed_area_share": None if limit is None else _share(own > limit, areas),
            "min_strain": float(own.min()),
            "compressed_area_share": _share(own < -compression, areas),
        }
    return found


def _share(where: np.ndarray, areas: np.ndarray) -> float:
    return float(areas[where].sum() / areas.sum())
