"""Half-edges of facets: half-edge 3 f + k runs from corner k to corner k + 1 of facet f."""

from __future__ import annotations

import numpy as np


def ends_of(facets: np.ndarray) -> np.ndarray:
    """Vertices from and to which half-edges run, shape [3 facet, 2]."""
    return facets[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)


def twins_of(facets: np.ndarray, vertices: int) -> np.ndarray:
    """Half-edge 3 f + k on the other side of each, −1 at a border, shape [3 facet].

    Args:
        facets: of one sense, shape [facet, 3].
        vertices: how many.
    """
    ends = ends_of(facets)
    forth, back = ends[:, 0] * vertices + ends[:, 1], ends[:, 1] * vertices + ends[:, 0]
    order = np.argsort(forth)
    at = np.minimum(np.searchsorted(forth[order], back), len(forth) - 1)
    return np.where(forth[order[at]] == back, order[at], -1)
