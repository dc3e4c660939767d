"""The blank of a new scene: a drawing or a rectangle, and whether it goes with the mould."""

from __future__ import annotations

import argparse
import re
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from warpdrape.errors import InputError, positive

if TYPE_CHECKING:
    from warpdrape.blanks.drawn import Drawn
    from warpdrape.tools.mould import Mould

MARGIN = 10e-3
"""How far a blank that is not given stays within the mould's border [m]."""
SHARES = 100
"""Sizes that are tried for it, down from the mould's own."""
FEWEST = 1.0 / 3.0
"""Size of a blank over the mould's shape below which one of them has another unit [-]."""
_SIZE = re.compile(r"\s*([\d.]+)\s*[x×]\s*([\d.]+)\s*(mm|cm|m)\s*")


def blank_of(
    arguments: argparse.Namespace, mould: Mould
) -> tuple[Drawn | None, tuple[float, float], bool, list[str]]:
    """The drawing, or the sizes of a rectangle [m]; whether it is moved; what is to be said."""
    import shapely

    if not arguments.blank:
        sizes, words = _within(mould)
        return None, sizes, False, [words]
    if found := _SIZE.fullmatch(arguments.blank):
        factor = {"mm": 1e-3, "cm": 1e-2, "m": 1.0}[found[3]]
        x, y = (positive("--blank", float(found[k]) * factor, unit="m") for k in (1, 2))
        return None, (x, y), False, []
    from warpdrape.blanks.drawn import read_outline
    from warpdrape.blanks.dxf_curves import states_unit

    if not arguments.blank.lower().endswith(".dxf"):
        raise InputError(f"--blank {arguments.blank} must be a .dxf, or a size such as 300x200mm")
    unit = None if states_unit(Path(arguments.blank)) else arguments.units or None
    drawn = read_outline(arguments.blank, layer=arguments.layer, unit=unit)
    polygon = shapely.Polygon(drawn.polygon.points)
    centred = not polygon.contains(mould.face.outline.buffer(-1e-3))
    states = f"states its unit, {drawn.unit}" if drawn.states_unit else f"counts in {drawn.unit}"
    told = [f"Blank: {arguments.blank} {states}"]
    if drawn.polygon.holes:
        count = len(drawn.polygon.holes)
        told[0] += f", with {count} hole{'s' if count > 1 else ''}"
    if drawn.welded > 1e-9:
        told[0] += f", gaps up to {1e3 * drawn.welded:.2g} mm welded"
    if centred:
        told[0] += "; drawn elsewhere, it is laid with its middle over the mould's"
    return drawn, (0.0, 0.0), centred, told


def _within(mould: Mould) -> tuple[tuple[float, float], str]:
    """Sizes [m] of a rectangle within the mould's border, in proportion, and what is said of it.

    Where the border is round, or has cut corners, none there may cover the mould's shape: the
    rectangle covers it then, and goes beyond the border.
    """
    import shapely

    middle = np.asarray(mould.middle)
    low, high = np.reshape(mould.face.outer.bounds, (2, 2))
    whole = [max(float(side) - 2.0 * MARGIN, 0.5 * float(side)) for side in high - low]
    border = mould.face.outer.buffer(1e-6)
    corners = np.array([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)]) * whole
    shares = np.linspace(1.0, 0.0, SHARES, endpoint=False)
    fits = [share for share in shares if border.contains(shapely.Polygon(middle + share * corners))]
    low, high = np.reshape(mould.face.outline.bounds, (2, 2))
    reach = 2.0 * np.maximum(middle - low, high - middle) + 2.0 * MARGIN
    least = min(float((reach / whole).max()), 1.0)
    share = max(fits[0] if fits else 0.0, least)
    x, y = (1e-3 * round(1e3 * share * side) for side in whole)
    where = "within the mould"
    if not fits or fits[0] < least:
        where = "as the mould's shape needs, with corners beyond its border"
    return (x, y), f"No blank was given: {1e3 * x:g} × {1e3 * y:g} mm, {where}."


def checked_against(mould: Mould, sizes: tuple[float, float]) -> list[str]:
    """Refuse a blank of another unit than the mould; say where it is too small."""
    low, high = np.reshape(mould.face.outline.bounds, (2, 2))
    shape = high - low
    if max(sizes) < FEWEST * max(shape) or min(sizes) > max(shape) / FEWEST**3:
        raise InputError(
            f"the blank of {1e3 * sizes[0]:.4g} × {1e3 * sizes[1]:.4g} mm does not go with the "
            f"mould's shape of {1e3 * shape[0]:.4g} × {1e3 * shape[1]:.4g} mm: look at the units"
        )
    if (np.array(sizes) < shape).any():
        return [
            f"The blank of {1e3 * sizes[0]:.4g} × {1e3 * sizes[1]:.4g} mm does not cover the "
            f"mould's shape of {1e3 * shape[0]:.4g} × {1e3 * shape[1]:.4g} mm."
        ]
    return []
