"""Vertices of a ply that a clamp holds or a spring pulls at, chosen by number or by a mask."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from warpdrape.errors import InputError

Chosen = Callable[[np.ndarray], np.ndarray] | Sequence[int]
"""Vertex numbers; or a function of the flat points [m], shape [n, 3], to them or to a mask."""


def chosen_vertices(who: str, where: Chosen, ply: str, points: np.ndarray) -> np.ndarray:
    """Numbers of the chosen vertices, rising.

    Args:
        who: what chooses them, in errors.
        where: the choice.
        ply: name of the ply.
        points: of the flat ply [m], shape [n, 3].

    Raises:
        InputError: if it chooses none, one that is not there, or is no choice at all.
    """
    try:
        chosen = np.asarray(where(points) if callable(where) else where)
        number = chosen.astype(np.int64) if chosen.dtype.kind in "iu" else chosen
    except (TypeError, ValueError, OverflowError) as error:
        words = " ".join(str(error).split())
        raise InputError(f"{who}: where gives no vertices of ply {ply!r} ({words})") from None
    if chosen.dtype == bool:
        if chosen.shape != (len(points),):
            raise InputError(
                f"{who}: its mask has shape {chosen.shape}, not ({len(points)},), one for each "
                f"vertex of ply {ply!r}"
            )
        number = np.flatnonzero(chosen)
    if number.size == 0:
        raise InputError(f"{who} holds no vertex of ply {ply!r}")
    if number.dtype != np.int64 or number.ndim != 1:
        raise InputError(f"{who}: where must give vertex numbers or a mask")
    if number.min() < 0 or number.max() >= len(points):
        odd = number[(number < 0) | (number >= len(points))][0]
        raise InputError(f"{who}: ply {ply!r} has no vertex {odd}, only 0..{len(points) - 1}")
    return np.unique(number)
