"""A ply: a flat blank of a fabric with its yarns at an angle; and the lay-up of a stack."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from warpdrape.blanks.drawn import read_outline
from warpdrape.blanks.dxf_curves import WELD
from warpdrape.blanks.flat_mesh import FlatMesh
from warpdrape.blanks.meshing import mesh_outline
from warpdrape.blanks.outlines import Disc, Polygon, Rectangle
from warpdrape.errors import InputError, finite, length, said
from warpdrape.materials.fabric import Fabric
from warpdrape.materials.fabric_library import load_fabric
from warpdrape.materials.viscosity import check_temperature
from warpdrape.wording import heading, surface


@dataclass(frozen=True, kw_only=True, eq=False)
class Ply:
    """A flat blank before forming.

    Attributes:
        name: how results call it.
        fabric: its fabric, or the name or file of one.
        mesh: flat triangles in x, y [m].
        warp_angle: from the x axis to the warp [rad].
        z: height of its mid-surface [m].
        temperature: at the start [K]; None for that at which its matrix's viscosity is given.
    """

    name: str
    fabric: Fabric
    mesh: FlatMesh
    warp_angle: float = 0.0
    z: float = 0.0
    temperature: float | None = None

    if TYPE_CHECKING:  # what is given is wider than what is kept

        def __init__(
            self,
            *,
            name: str,
            fabric: Fabric | str | os.PathLike[str],
            mesh: FlatMesh,
            warp_angle: float = 0.0,
            z: float = 0.0,
            temperature: float | None = None,
        ) -> None: ...

    def __repr__(self) -> str:
        return (
            f"{heading(self)}: {surface(self.mesh.vertices, self.mesh.triangles)}, "
            f"warp at {math.degrees(self.warp_angle):.4g}°, z {1e3 * self.z:.4g} mm, "
            f"fabric {self.fabric.name!r}"
        )

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not self.name.isidentifier():
            raise InputError(
                f"ply name = {said(self.name)} must be a plain identifier, such as 'ply_0'"
            )
        if not isinstance(self.fabric, Fabric):
            object.__setattr__(self, "fabric", load_fabric(self.fabric))
        if not isinstance(self.mesh, FlatMesh):
            raise InputError(f"ply {self.name!r}: mesh = {said(self.mesh)} is not a FlatMesh")
        finite(f"ply {self.name!r}: warp_angle", self.warp_angle, unit="rad")
        finite(f"ply {self.name!r}: z", self.z, unit="m")
        if abs(self.warp_angle) > 2 * math.pi:
            raise InputError(
                f"ply {self.name!r}: warp_angle = {self.warp_angle:.4g} rad must lie in ±360°: "
                "give radians, as in 45 * deg"
            )
        self._check_temperature()

    def _check_temperature(self) -> None:
        """Refuse a temperature that nothing asks for, or at which the matrix is solid."""
        if self.temperature is None:
            return
        name, matrix = f"ply {self.name!r}: temperature", self.fabric.matrix
        if matrix is None or matrix.shift is None:
            raise InputError(
                f"{name} = {said(self.temperature)} is of no use: fabric {self.fabric.name!r} has "
                "no matrix whose viscosity depends on it; leave it out, or give matrix.shift"
            )
        lowest = matrix.shift.lowest_temperature
        if check_temperature(name, self.temperature) < lowest:
            raise InputError(
                f"{name} = {self.temperature:g} K is below the lowest of its matrix's data, "
                f"{lowest:g} K: form it hotter"
            )

    @property
    def warmth(self) -> float | None:
        """Temperature at the start [K]; None where its fabric asks for none."""
        if self.temperature is not None or self.fabric.matrix is None:
            return self.temperature
        return self.fabric.matrix.temperature

    @property
    def yarn_directions(self) -> tuple[np.ndarray, np.ndarray]:
        """Unit vectors t1, t2 of warp and weft in the flat blank, each shape [2]."""
        weft = self.warp_angle + self.fabric.yarn_angle
        return (
            np.array([math.cos(self.warp_angle), math.sin(self.warp_angle)]),
            np.array([math.cos(weft), math.sin(weft)]),
        )

    @property
    def rest_points(self) -> np.ndarray:
        """Vertices of the flat blank in place [m], shape [n, 3]."""
        flat = np.asarray(self.mesh.vertices, dtype=float)
        return np.column_stack([flat, np.full(len(flat), self.z)])

    @classmethod
    def rectangle(
        cls,
        name: str,
        fabric: Fabric | str,
        width: float,
        height: float | None = None,
        *,
        cells: int | None = None,
        edge: float | None = None,
        mesh: str = "aligned",
        warp_angle: float = 0.0,
        z: float = 0.0,
        temperature: float | None = None,
    ) -> Ply:
        """Make a rectangular blank centred at the origin.

        Args:
            name: how results call it.
            fabric: fabric, or the name or file of one.
            width: along x [m].
            height: along y [m]; the width if None.
            cells: squares along the width; or give ``edge``.
            edge: mesh size [m].
            mesh: "aligned" to the yarns, "grid" along the outline, "diagonal" or "random".
            warp_angle: from x to the warp [rad].
            z: height of its mid-surface [m].
            temperature: at the start [K]; None for that at which its matrix's viscosity is given.
        """
        outline = Rectangle(width, width if height is None else height)
        return cls._meshed(name, fabric, outline, cells, edge, mesh, warp_angle, z, temperature)

    @classmethod
    def disc(
        cls,
        name: str,
        fabric: Fabric | str,
        radius: float,
        *,
        cells: int | None = None,
        edge: float | None = None,
        mesh: str = "aligned",
        warp_angle: float = 0.0,
        z: float = 0.0,
        temperature: float | None = None,
    ) -> Ply:
        """Make a round blank centred at the origin; arguments as for `rectangle`."""
        return cls._meshed(
            name, fabric, Disc(radius), cells, edge, mesh, warp_angle, z, temperature
        )

    @classmethod
    def polygon(
        cls,
        name: str,
        fabric: Fabric | str,
        points: Sequence[Sequence[float]],
        *,
        holes: Sequence[Sequence[Sequence[float]]] = (),
        cells: int | None = None,
        edge: float | None = None,
        mesh: str = "aligned",
        warp_angle: float = 0.0,
        z: float = 0.0,
        temperature: float | None = None,
    ) -> Ply:
        """Make a blank from a polygon [m] with holes; other arguments as for `rectangle`."""
        return cls._meshed(
            name, fabric, Polygon(points, holes), cells, edge, mesh, warp_angle, z, temperature
        )

    @classmethod
    def from_file(
        cls,
        name: str,
        fabric: Fabric | str,
        path: str | os.PathLike[str],
        *,
        scale: float = 1.0,
        warp_angle: float = 0.0,
        z: float = 0.0,
        temperature: float | None = None,
    ) -> Ply:
        """Make a blank from a flat triangle mesh in any file that trimesh reads.

        Args:
            name: how results call it.
            fabric: fabric, or the name or file of one.
            path: the mesh file.
            scale: metres per unit of the file.
            warp_angle: from x to the warp [rad].
            z: height of its mid-surface [m].
            temperature: at the start [K]; None for that at which its matrix's viscosity is given.
        """
        mesh = FlatMesh.from_file(path, scale=scale)
        return cls(
            name=name,
            fabric=fabric,
            mesh=mesh,
            warp_angle=warp_angle,
            z=z,
            temperature=temperature,
        )

    @classmethod
    def from_dxf(
        cls,
        name: str,
        fabric: Fabric | str,
        path: str | os.PathLike[str],
        *,
        edge: float,
        unit: str | None = None,
        layer: str | None = None,
        weld: float = WELD,
        centre: Sequence[float] | None = None,
        mesh: str = "aligned",
        warp_angle: float = 0.0,
        z: float = 0.0,
        temperature: float | None = None,
    ) -> Ply:
        """Make a blank from a drawing: polylines, circles, ellipses, splines, lines and arcs.

        The largest closed curve is the outline, those in it are holes; holes narrower than ``edge``
        are left out, with a warning. Needs ``warpdrape[dxf]``.

        Args:
            name: how results call it.
            fabric: fabric, or the name or file of one.
            path: the DXF file.
            edge: mesh size [m].
            unit: "mm", "cm", "m" or "inch" of a drawing that states none.
            layer: the one that is read; None reads all.
            weld: gap between two ends of curves that is closed [m].
            centre: where the middle of the outline's box comes to lie [m], shape [2]; None leaves
                it where it is drawn.
            mesh: as for `rectangle`.
            warp_angle: from x to the warp [rad].
            z: height of its mid-surface [m].
            temperature: at the start [K]; None for that at which its matrix's viscosity is given.
        """
        size = length("edge", edge)
        outline = read_outline(path, unit=unit, layer=layer, weld=weld).without_small_holes(size)
        outline = outline if centre is None else outline.centred(centre)
        return cls._meshed(name, fabric, outline, None, size, mesh, warp_angle, z, temperature)

    @classmethod
    def _meshed(cls, name, fabric, outline, cells, edge, mesh, warp_angle, z, temperature) -> Ply:
        finite("warp_angle", warp_angle, unit="rad")
        flat = mesh_outline(outline, cells=cells, edge=edge, pattern=mesh, warp_angle=warp_angle)
        return cls(
            name=name,
            fabric=fabric,
            mesh=flat,
            warp_angle=warp_angle,
            z=z,
            temperature=temperature,
        )


def lay_up(plies: Sequence[Ply], *, z: float = 0.0) -> tuple[Ply, ...]:
    """Lay plies on each other, the first at the bottom, touching without pressing.

    Args:
        plies: from the bottom up.
        z: height of the surface that carries the first one [m].

    Returns:
        The plies with their heights set, in the same order.
    """
    _refuse_others(plies)
    laid = []
    top = finite("z", z, unit="m")
    for ply in plies:
        laid.append(replace(ply, z=top + 0.5 * ply.fabric.thickness))
        top += ply.fabric.thickness
    return tuple(laid)


def stack_top(plies: Sequence[Ply]) -> float:
    """Height of a stack's upper surface [m]."""
    _refuse_others(plies)
    return max(ply.z + 0.5 * ply.fabric.thickness for ply in plies)


def longest_yarn(ply: Ply) -> float:
    """How far a flat ply reaches along its yarns at most [m]."""
    flat = np.asarray(ply.mesh.vertices)
    return float(max(np.ptp(flat @ direction) for direction in ply.yarn_directions))


def _refuse_others(plies: Sequence[Ply]) -> None:
    """Raise `InputError` unless these are plies, one or more."""
    several = isinstance(plies, Sequence) and not isinstance(plies, str)
    if not several or not plies or not all(isinstance(ply, Ply) for ply in plies):
        raise InputError(f"plies = {said(plies)} must be a list of one Ply or more")
