"""Where the material points of one run's plies lie on the plies of another: by place on the blank.

Runs are compared at points of the flat sheet. Where two meshes are the same, vertices and triangles
are those of the same number. Where not, a vertex has a place in a triangle of the other mesh, whose
corners' values are blended linearly, and the middle of a triangle has a triangle of the other mesh,
whose value is taken as it is: what is constant in triangles is not smoothed. A point beside the
other blank has no counterpart.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from warpdrape.blanks.places import locate
from warpdrape.report.packing import Blocks
from warpdrape.report.run_data import PlyFrames

_SAME = 1e-6  # of a blank's size, within which two flat places are one


def match_plies(
    plies: Sequence[PlyFrames], first: Sequence[PlyFrames], blocks: Blocks
) -> list[dict[str, Any] | None]:
    """Counterparts of a run's plies in the first run, as the page holds them; None for none.

    Plies of one name belong together; where no names agree, those of one place in their stacks.
    """
    names = [ply.name for ply in first]
    by_name = any(ply.name in names for ply in plies)
    found: list[dict[str, Any] | None] = []
    for k, ply in enumerate(plies):
        at = names.index(ply.name) if ply.name in names else None if by_name else k
        if at is None or at >= len(first):
            found.append(None)
        elif _one_mesh(ply, first[at]):
            found.append({"ply": at, "same": True})
        else:
            found.append({"ply": at, "same": False, **_pack(ply, first[at], blocks)})
    return found


def _one_mesh(ply: PlyFrames, other: PlyFrames) -> bool:
    if ply.rest.shape != other.rest.shape or not np.array_equal(ply.triangles, other.triangles):
        return False
    off = np.abs(ply.rest[:, :2] - other.rest[:, :2]).max()
    return bool(off <= _SAME * np.ptp(other.rest, axis=0).max())


def _pack(ply: PlyFrames, other: PlyFrames, blocks: Blocks) -> dict[str, Any]:
    """Blocks of where vertices and middles of triangles lie; a triangle's number is one more."""
    flat = ply.rest[:, :2]
    vertices = locate(flat, other.rest[:, :2], other.triangles)
    middles = locate(flat[ply.triangles].mean(axis=1), other.rest[:, :2], other.triangles)
    return {
        "vertices": blocks.whole_numbers(vertices.triangles + 1),
        "weights": blocks.values(vertices.weights[None, :, 1:], 0.0, 1.0),
        "middles": blocks.whole_numbers(middles.triangles + 1),
    }
