"""Every quantity of a formed ply under one name, with its unit and its place: what exports hold.

The list is the one of the USD file's primvars; what is added there is here, and in every export.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from pxr import Sdf

from warpdrape.results.usd_stage import TRIANGLE_PRIMVARS, VERTEX_PRIMVARS

if TYPE_CHECKING:
    from warpdrape.results.result import FormedPly

_ENDINGS = {"N per metre of width": "n_per_m", "1/m": "per_m"}
_VECTORS = (Sdf.ValueTypeNames.Vector3fArray, Sdf.ValueTypeNames.Point3fArray)


@dataclass(frozen=True)
class Field:
    """A quantity.

    Attributes:
        name: in `PlyFrame`.
        primvar: in the USD file.
        text: what it is, in words.
        unit: of its values; empty for a ratio or a direction.
        at_vertices: whether it is given at vertices; else per triangle.
        vector: whether it has three components.
    """

    name: str
    primvar: str
    text: str
    unit: str
    at_vertices: bool
    vector: bool

    @property
    def column(self) -> str:
        """Its name with the unit at the end, such as ``warp_tension_n_per_m``."""
        ending = _ENDINGS.get(self.unit, re.sub(r"\W+", "_", self.unit.lower()))
        if not ending or self.name.endswith(f"_{ending}"):
            return self.name
        return f"{self.name}_{ending}"

    def shape(self, vertices: int, triangles: int) -> tuple[int, ...]:
        """Shape of its values on a ply of so many vertices and triangles."""
        count = vertices if self.at_vertices else triangles
        return (count, 3) if self.vector else (count,)

    def of(self, ply: FormedPly) -> np.ndarray | None:
        """Its values on a formed ply; None where that has none."""
        values = getattr(ply.frame(), self.name)
        return None if values is None else np.asarray(values)


def _listed() -> tuple[Field, ...]:
    found = []
    for at_vertices, table in ((False, TRIANGLE_PRIMVARS), (True, VERTEX_PRIMVARS)):
        for name, (primvar, kind, text) in table.items():
            words, _, unit = text.partition(" [")
            vector = kind in _VECTORS
            found.append(Field(name, primvar, words, unit.rstrip("]"), at_vertices, vector))
    return tuple(found)


FIELDS = _listed()
"""All of them, per triangle first."""


def fields_of(ply: FormedPly) -> dict[Field, np.ndarray]:
    """The quantities that a formed ply has, with their values."""
    frame = ply.frame()
    values = ((field, getattr(frame, field.name)) for field in FIELDS)
    return {field: np.asarray(array) for field, array in values if array is not None}
