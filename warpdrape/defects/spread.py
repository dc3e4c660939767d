"""How a quantity on triangles is spread over a ply: least, mean, largest, 95th percentile."""

from __future__ import annotations

import numpy as np

from warpdrape.blanks.triangles import area_percentile


def spread(values: np.ndarray, areas: np.ndarray) -> dict[str, float]:
    """Least, mean (by area) and largest of values on triangles, and what 95 % of the area is below.

    Args:
        values: shape [m].
        areas: flat [m²], shape [m].
    """
    return {
        "min": float(values.min()),
        "mean": float(np.average(values, weights=areas)),
        "max": float(values.max()),
        "p95": area_percentile(values, areas, 0.95),
    }
