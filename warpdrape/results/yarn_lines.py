"""Some of the yarns of a ply as lines: pieces that lie in triangles and move with them.

On the flat blank yarns are straight. A line at the distance k·spacing from the blank's centre,
across the yarns, cuts a triangle's sides where its corners lie on both sides of it; the piece is
kept as the places of its two ends on the sides, so that it follows the formed ply exactly.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

ABREAST = 25
"""About how many lines lie across a blank."""
_ROUND = (1.0, 2.0, 5.0, 10.0)
_DIGITS = 9  # of a distance in spacings: a vertex that close to a line lies on it


@dataclass(frozen=True)
class YarnLines:
    """Pieces of lines along one family of yarns, over k pieces.

    Attributes:
        triangles: that each lies in, shape [k].
        weights: of the triangle's second and third corner, at the start and at the end [-], shape
            [k, 2 ends, 2]; the first corner has the rest.
    """

    triangles: NDArray[np.int64]
    weights: NDArray[np.float64]


def round_spacing(rest: NDArray[np.float64]) -> float:
    """A round length that puts some 25 lines across the blank [m].

    Args:
        rest: the flat blank [m], shape [n, 2 or 3].
    """
    across = float(np.ptp(rest, axis=0).max()) / ABREAST
    power = 10.0 ** np.floor(np.log10(across))
    return float(power * min(_ROUND, key=lambda digit: abs(np.log(digit * power / across))))


def on_blank(
    rest: NDArray[np.float64],
    points: NDArray[np.float64],
    triangles: NDArray[np.int64],
    directions: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Direction of the yarns on the flat blank whose images on the ply are ``directions``.

    Args:
        rest: the flat blank [m], shape [n, 3].
        points: the formed ply [m], shape [n, 3].
        triangles: shape [m, 3].
        directions: unit vectors on the formed ply, shape [m, 3].

    Returns:
        A unit vector, the mean over the triangles, shape [2].
    """
    a, b, c = np.moveaxis(triangles, 1, 0)
    now = np.stack([points[b] - points[a], points[c] - points[a]], axis=2)
    flat = np.stack([rest[b] - rest[a], rest[c] - rest[a]], axis=2)[:, :2]
    back = np.einsum("mij,mjk,mk->mi", flat, np.linalg.pinv(now), directions)
    mean = (back / np.linalg.norm(back, axis=1, keepdims=True)).mean(axis=0)
    return mean / np.linalg.norm(mean)


def yarn_lines(
    rest: NDArray[np.float64],
    triangles: NDArray[np.int64],
    direction: NDArray[np.float64],
    spacing: float,
) -> YarnLines:
    """Lines along one family, ``spacing`` apart on the blank.

    Args:
        rest: the flat blank [m], shape [n, 2 or 3].
        triangles: shape [m, 3].
        direction: of the yarns on the blank, unit, shape [2].
        spacing: [m].
    """
    flat = rest[:, :2] - rest[:, :2].mean(axis=0)
    across = flat @ [-direction[1], direction[0]] / spacing
    corners = np.round(across, _DIGITS)[triangles]
    first = np.ceil(corners.min(axis=1)).astype(np.int64)
    count = np.maximum(np.floor(corners.max(axis=1)).astype(np.int64) - first + 1, 0)
    of = np.repeat(np.arange(len(triangles)), count)
    line = np.arange(len(of)) - np.repeat(np.cumsum(count) - count, count) + first[of]
    return _pieces(of, corners[of] - line[:, None])


def _pieces(of: NDArray[np.int64], height: NDArray[np.float64]) -> YarnLines:
    """Pieces in triangles whose corners lie at ``height`` across a line, shape [k, 3]."""
    below = height < 0.0  # a corner on the line counts as above it: two sides are cut, or none
    proper = below.any(axis=1) & ~below.all(axis=1)
    of, height, below = of[proper], height[proper], below[proper]
    alone = np.argmax(below == (below.sum(axis=1) == 1)[:, None], axis=1)
    row = np.arange(len(of))
    weights = np.zeros((len(of), 2, 3))
    for end in (0, 1):
        other = (alone + 1 + end) % 3
        share = height[row, alone] / (height[row, alone] - height[row, other])
        weights[row, end, alone] = 1.0 - share
        weights[row, end, other] = share
    return YarnLines(of, weights[:, :, 1:])
