"""What the animation shows: plies and tools as they start, and plies at one moment."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from numpy.typing import ArrayLike


@dataclass(frozen=True)
class PlyShape:
    """A ply as it lies on the table.

    Args:
        name: the ply's name; made a valid USD identifier in the file.
        rest_points: the flat blank [m], shape (n, 3).
        triangles: vertex numbers, shape (m, 3).
        at_vertices: quantities of its frames that are given at vertices, by their names there.
        in_triangles: the same of those in triangles that not every ply has.
    """

    name: str
    rest_points: ArrayLike
    triangles: ArrayLike
    at_vertices: Sequence[str] = ()
    in_triangles: Sequence[str] = ()


@dataclass(frozen=True)
class ToolShape:
    """A rigid tool where it starts.

    Args:
        name: the tool's name; made a valid USD identifier in the file.
        vertices: vertex positions at translation zero [m], shape (n, 3).
        triangles: vertex numbers, shape (m, 3).
        axis: unit, about which it turns, shape (3,); None if it does not.
        point: of that axis [m], shape (3,).
    """

    name: str
    vertices: ArrayLike
    triangles: ArrayLike
    axis: ArrayLike | None = None
    point: ArrayLike | None = None


@dataclass(frozen=True)
class PlyFrame:
    """One ply at one moment; all but ``points`` per triangle.

    Args:
        points: vertex positions [m], shape (n, 3).
        warp: unit warp directions, shape (m, 3).
        weft: unit weft directions, shape (m, 3).
        shear_angle_deg: signed shear angle [deg], shape (m,).
        warp_strain: strain of the warp yarns, shape (m,).
        weft_strain: strain of the weft yarns, shape (m,).
        warp_tension: [N per metre of width], shape (m,); None of an approach without forces, whose
            primvar is empty then, as the next.
        weft_tension: [N per metre of width], shape (m,).
        warp_curvature: of the warp yarns out of the ply's plane at vertices [1/m], shape (n,);
            None where the ply has no bending, as the next.
        weft_curvature: of the weft yarns.
        slip: along the ply from where a vertex lay on the next one [m], shape (n, 3); None where
            there is none, as the next three.
        contact_pressure: of plies [Pa], shape (n,).
        tool_pressure: of tools [Pa], shape (n,).
        temperature: [K], shape (n,).
        thickness: [m], shape (m,).
        fibre_volume_fraction: [-], shape (m,).
        wrinkle: amplitude of wrinkles, 0 where there is none [m], shape (m,).
        warp_slide: how much warp yarn has gone through the crossover at a vertex, along the warp
            [m], shape (n,); None where crossovers are pinned, as the next.
        weft_slide: of weft yarn.
    """

    points: ArrayLike
    warp: ArrayLike
    weft: ArrayLike
    shear_angle_deg: ArrayLike
    warp_strain: ArrayLike
    weft_strain: ArrayLike
    warp_tension: ArrayLike | None
    weft_tension: ArrayLike | None
    warp_curvature: ArrayLike | None = None
    weft_curvature: ArrayLike | None = None
    slip: ArrayLike | None = None
    contact_pressure: ArrayLike | None = None
    tool_pressure: ArrayLike | None = None
    temperature: ArrayLike | None = None
    thickness: ArrayLike | None = None
    fibre_volume_fraction: ArrayLike | None = None
    wrinkle: ArrayLike | None = None
    warp_slide: ArrayLike | None = None
    weft_slide: ArrayLike | None = None
