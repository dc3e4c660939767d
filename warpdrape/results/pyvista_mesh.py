"""Plies and tools as PyVista meshes, every field an array that has its unit in its name."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from warpdrape.optional import needed
from warpdrape.results.fields import fields_of

if TYPE_CHECKING:
    from pyvista import MultiBlock, PolyData

    from warpdrape.results.result import FormedPly, PlacedTool


def ply_mesh(ply: FormedPly) -> PolyData:
    """Return a ply as a surface: fields per triangle as cell data, those at vertices as point data.

    Args:
        ply: the formed ply.
    """
    mesh = _surface(ply.points, ply.triangles)
    for field, values in fields_of(ply).items():
        data = mesh.point_data if field.at_vertices else mesh.cell_data
        data[field.column] = values
    mesh.point_data["rest_points_m"] = np.asarray(ply.rest_points)
    mesh.cell_data.active_scalars_name = "shear_angle_deg"
    return mesh


def tool_mesh(tool: PlacedTool) -> PolyData:
    """Return a tool as a surface."""
    return _surface(tool.vertices, tool.triangles)


def blocks(plies: Sequence[FormedPly], tools: Sequence[PlacedTool]) -> MultiBlock:
    """Return plies and tools by name, the plies first and from the bottom up."""
    pyvista = needed("pyvista", "vtk")
    found = pyvista.MultiBlock()
    for ply in plies:
        found.append(ply_mesh(ply), ply.name)
    for tool in tools:
        found.append(tool_mesh(tool), tool.name)
    return found


def _surface(points: np.ndarray, triangles: np.ndarray) -> PolyData:
    pyvista = needed("pyvista", "vtk")
    return pyvista.PolyData.from_regular_faces(np.asarray(points), np.asarray(triangles, np.int64))
