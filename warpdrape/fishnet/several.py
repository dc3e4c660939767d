"""``wd.drape_fishnets``: several starts, each with a net on the part of the surface next to it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from warpdrape.errors import InputError, said
from warpdrape.fishnet.drape import as_surface, drape_fishnet
from warpdrape.fishnet.net import Net


def drape_fishnets(
    surface: Any,
    spacing: float,
    starts: Sequence[Sequence[float]],
    *,
    warps: Sequence[Sequence[float]] | None = None,
    holes: str = "span",
    scale: float = 1.0,
    **options: Any,
) -> list[Net]:
    """Lay a net from each of several starts, and share the surface out between them.

    A cell stays in the net whose start is nearest to its middle, in a straight line. So patches
    meet along seams of cells, where plies would be cut and joined.

    Args:
        surface: a mould, as for `drape_fishnet`.
        spacing: of the crossovers [m].
        starts: points of the surface [m], shape [n, 3].
        warps: direction of the warp at each, shape [n, 3]; along x if None.
        holes: "span" or "end".
        scale: metres per unit of a mesh or file.
        options: others of `drape_fishnet`.

    Raises:
        InputError: as `drape_fishnet`; or if there are fewer than two starts, or not as many warps.
    """
    try:
        points = np.asarray(starts, dtype=float)
    except (TypeError, ValueError):
        points = np.zeros(0)
    if points.ndim != 2 or points.shape[1:] != (3,) or len(points) < 2:
        raise InputError(f"starts = {said(starts)} must be two points (x, y, z) [m] or more")
    if warps is None:
        warps = [(1.0, 0.0, 0.0)] * len(points)
    if len(warps) != len(points):
        raise InputError(f"{len(warps)} warps for {len(points)} starts: give one for each")
    mould = as_surface(surface, holes, scale)
    return [
        _own_part(drape_fishnet(mould, spacing, start=start, warp=warp, **options), number, points)
        for number, (start, warp) in enumerate(zip(points, warps, strict=True))
    ]


def _own_part(net: Net, number: int, starts: np.ndarray) -> Net:
    """A net without the cells that are nearer to the start of another."""
    p = net.points
    middle = 0.25 * (p[:-1, :-1] + p[1:, :-1] + p[1:, 1:] + p[:-1, 1:])
    far = np.linalg.norm(middle[..., None, :] - starts, axis=-1)
    own = net.cells & (far.argmin(axis=-1) == number)
    wanted = np.zeros(net.status.shape, dtype=bool)
    for i in (0, 1):
        for j in (0, 1):
            wanted[i : i + own.shape[0], j : j + own.shape[1]] |= own
    return net.within(wanted)
