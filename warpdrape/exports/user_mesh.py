"""A structural mesh of the user's own: shells in a file that VTK or meshio reads."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from warpdrape.errors import InputError, said
from warpdrape.results.pyvista_mesh import needed

if TYPE_CHECKING:
    from pyvista import UnstructuredGrid

OWN = (".vtk", ".vtu", ".vtp", ".stl", ".ply", ".obj")
"""Endings that PyVista reads by itself; others go to meshio."""
CORNERS = {5: 3, 9: 4, 22: 3, 23: 4, 28: 4}
"""VTK's numbers of triangles and quadrilaterals, with middle nodes too → how many are corners."""


@dataclass(frozen=True)
class UserMesh:
    """Shells of a structural mesh.

    Attributes:
        grid: all of it, as it was read.
        shells: numbers of the cells that are shells, counted from 0 in the file's order.
        centers: of these [m], shape [shell, 3].
        normals: unit vectors, shape [shell, 3].
        sides: unit vectors from first to second node, in the plane, shape [shell, 3].
    """

    grid: UnstructuredGrid
    shells: np.ndarray
    centers: np.ndarray
    normals: np.ndarray
    sides: np.ndarray


def read_mesh(path: str | Path, unit: float = 1.0) -> UserMesh:
    """Read a mesh.

    Args:
        path: the file.
        unit: of its lengths [m].

    Raises:
        InputError: if there is none, it cannot be read, or it has no shells.
    """
    if not isinstance(path, str | Path):
        raise InputError(f"onto = {said(path)} must be the name of a file")
    path = Path(path)
    pyvista = needed("pyvista", "vtk")
    if not path.is_file():
        raise InputError(f"onto = {path} does not exist: give a structural mesh")
    own = path.suffix.lower() in OWN
    if not own:
        needed("meshio", "meshes")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of packages, about themselves
            mesh = pyvista.read(path) if own else pyvista.read_meshio(path)
            grid = mesh.cast_to_unstructured_grid()
    except (Exception, SystemExit) as error:  # readers raise whatever they raise; meshio exits
        raise InputError(
            f"onto = {path} cannot be read ({error or type(error).__name__}): save it as .vtu, .stl"
        ) from error
    points = np.asarray(grid.points, float)
    if not len(points) or not np.isfinite(points).all():
        raise InputError(f"onto = {path} holds no mesh, or nodes that are no finite numbers")
    grid.points = unit * points
    return _shells(grid, path)


def _shells(grid: UnstructuredGrid, path: Path) -> UserMesh:
    vtk_numpy = needed("vtk.util.numpy_support", "vtk")
    kinds = np.asarray(grid.celltypes)
    shells = np.flatnonzero(np.isin(kinds, list(CORNERS)))
    if not len(shells):
        raise InputError(f"onto = {path} has no triangles or quadrilaterals: give a mesh of shells")
    points = np.asarray(grid.points, float)
    nodes = np.asarray(grid.cell_connectivity)
    start = vtk_numpy.vtk_to_numpy(grid.GetCells().GetOffsetsArray())
    count = np.array([CORNERS[kind] for kind in kinds[shells].tolist()])
    a, b, c = (points[nodes[start[shells] + k]] for k in range(3))
    last = points[nodes[start[shells] + count - 1]]
    four = (count == 4)[:, None]
    centers = np.where(four, 0.25 * (a + b + c + last), (a + b + c) / 3.0)
    normals = np.where(four, np.cross(c - a, last - b), np.cross(b - a, c - a))
    size = np.linalg.norm(normals, axis=1)
    flat = size <= 1e-12 * np.abs(points).max() ** 2
    if flat.any():
        number = int(shells[np.argmax(flat)]) + 1
        raise InputError(f"onto = {path}: element {number} has no area: repair the mesh")
    normals /= size[:, None]
    sides = (b - a) - ((b - a) * normals).sum(axis=1, keepdims=True) * normals
    return UserMesh(
        grid, shells, centers, normals, sides / np.linalg.norm(sides, axis=1, keepdims=True)
    )
