"""A flat ply as if it had just been laid down, for exports of what no run has made."""

import numpy as np

from warpdrape.results.result import FormedPly


def flat_ply(points, triangles, warp_deg=0.0, weft_deg=90.0):
    """A flat ply with yarns at two angles, as if it had just been laid down."""
    m = len(triangles)
    along = [(np.cos(a), np.sin(a), 0.0) for a in np.radians([warp_deg, weft_deg])]
    warp, weft = (np.tile(direction, (m, 1)) for direction in along)
    none = np.zeros(m)
    pairs = np.zeros((m, 2))
    return FormedPly("p", points, points, np.asarray(triangles), warp, weft, none, pairs, pairs)
