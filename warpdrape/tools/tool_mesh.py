"""Tools from mesh files: their surfaces, and normals estimated where none are known."""

from __future__ import annotations

import math
import os
import warnings
from typing import cast

import numpy as np
import trimesh

from warpdrape.cad_file import CAD, is_cad, read_cad
from warpdrape.errors import InputError, positive, said
from warpdrape.mesh_file import fault_of, why_unreadable
from warpdrape.tools.orientation import clash, oriented, without_doubles
from warpdrape.tools.profile import Surface

CREASE = math.radians(35.0)
"""Facets of an imported mesh that meet at a sharper angle [rad] keep a sharp edge."""


def read_surface(
    name: str,
    source: str | os.PathLike | trimesh.Trimesh,
    scale: float,
    tolerance: float | None = None,
) -> Surface:
    """Read a tool's surface: its facets as by `read_facets`, and normals.

    Those of a CAD file are its surfaces' own, others are estimated from the facets.

    Args:
        name: of the tool, for errors.
        source: file, or a mesh.
        scale: metres per unit of a mesh file.
        tolerance: chord error of the facets of a CAD file [m].
    """
    if not isinstance(source, trimesh.Trimesh) and is_cad(source):
        return cad_surface(name, source, scale, tolerance)[0]
    if tolerance is not None:
        raise InputError(
            f"tool {name!r}: tolerance = {said(tolerance)} is for CAD files ({', '.join(CAD)}), "
            "whose facets are made here: leave it out"
        )
    mesh = read_facets(name, source, scale)
    words = ""
    if not isinstance(source, trimesh.Trimesh):
        words = f"{os.path.basename(source)} with {scale:g} m to its unit"
    return Surface(mesh, creased_normals(mesh), exact=False, source=words)


def cad_surface(
    name: str, source: str | os.PathLike, scale: float = 1.0, tolerance: float | None = None
) -> tuple[Surface, str]:
    """A CAD file's surface, and the unit that the file states; arguments as of `read_surface`."""
    found = read_cad(f"tool {name!r}", source, tolerance)
    if scale != 1.0:
        raise InputError(
            f"tool {name!r}: scale = {said(scale)}, but {os.fspath(source)!r} states its unit, "
            f"{found.unit}, and is read in metres: leave scale out"
        )
    facets, turned = _one_way(name, found.mesh.vertices, found.mesh.faces)
    normals = np.where(turned[:, None, None], -found.normals[:, ::-1], found.normals)
    mesh = trimesh.Trimesh(found.mesh.vertices, facets, process=False)
    words = f"{os.path.basename(source)}, which is in {found.unit}"
    return Surface(mesh, normals, exact=True, source=words), found.unit


def read_facets(
    name: str, source: str | os.PathLike | trimesh.Trimesh, scale: float
) -> trimesh.Trimesh:
    """Read a tool's facets.

    Args:
        name: of the tool, for errors.
        source: file that trimesh reads, a CAD file, or a mesh.
        scale: metres per unit of the file.

    Facets are made to face one way, those of closed solids outward.

    Raises:
        InputError: if the file is missing, unreadable, empty or holds NaN.
    """
    positive("scale", scale)
    if not isinstance(source, trimesh.Trimesh) and is_cad(source):
        return cad_surface(name, source, scale)[0].mesh
    mesh = source if isinstance(source, trimesh.Trimesh) else _read_mesh(name, source)
    if len(mesh.faces) == 0:
        raise InputError(f"tool {name!r}: its mesh has no facets: give it a surface")
    if fault := fault_of(mesh):
        raise InputError(f"tool {name!r}: its mesh {fault}")
    if not np.isfinite(mesh.vertices).all():
        raise InputError(f"tool {name!r}: its mesh holds NaN or infinite vertices: repair it")
    mesh = trimesh.Trimesh(mesh.vertices * scale, mesh.faces, process=False)
    mesh.merge_vertices()
    mesh.update_faces(mesh.nondegenerate_faces())
    if len(mesh.faces) == 0:
        raise InputError(f"tool {name!r}: all facets of its mesh have zero area")
    return _of_one_sense(name, mesh)


def _of_one_sense(name: str, mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    """The mesh with each facet once and all facing one way; says what had to be turned."""
    points, facets = np.asarray(mesh.vertices), without_doubles(np.asarray(mesh.faces))
    facets, turned = _one_way(name, points, facets)
    if turned.any():
        warnings.warn(
            f"tool {name!r}: {np.count_nonzero(turned)} of {len(facets)} facets faced the other "
            "way and were turned",
            stacklevel=4,
        )
    return trimesh.Trimesh(points, facets, process=False)


def _one_way(name: str, points: np.ndarray, facets: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """`oriented` facets of a tool, and which of them were turned."""
    points = np.asarray(points)
    facets, turned = oriented(points, np.asarray(facets))
    if (edge := clash(facets)) is not None:
        x, y, z = 1e3 * points[edge].mean(axis=0)
        raise InputError(
            f"tool {name!r}: its facets cannot all face one way: a surface with one side only, "
            f"like a Möbius strip, goes through ({x:.4g}, {y:.4g}, {z:.4g}) mm; cut it, or mesh it "
            "anew"
        )
    return facets, turned


def _read_mesh(name: str, source: str | os.PathLike) -> trimesh.Trimesh:
    if not isinstance(source, str | os.PathLike):
        raise InputError(f"tool {name!r}: source = {said(source)} must be a mesh file or a trimesh")
    if not os.path.isfile(source):
        raise InputError(f"tool {name!r}: no mesh file {os.fspath(source)!r}")
    try:
        loaded = trimesh.load(os.fspath(source), force="mesh", process=False)
        mesh = cast(trimesh.Trimesh, loaded)
        if len(mesh.faces) == 0:  # also of bytes that a package for encodings made letters of
            raise ValueError("it holds no facets")
    except Exception as error:  # trimesh raises whatever its readers raise
        why = why_unreadable(source, error)
        raise InputError(f"tool {name!r}: cannot read {os.fspath(source)!r}: {why}") from None
    return mesh


def creased_normals(mesh: trimesh.Trimesh) -> np.ndarray:
    """Corner normals [-] averaged over the facets round a vertex, but not over sharp edges.

    Returns:
        shape [facet, 3, 3].
    """
    smooth = mesh.face_adjacency_angles < CREASE
    groups = trimesh.graph.connected_component_labels(
        mesh.face_adjacency[smooth], node_count=len(mesh.faces)
    )
    key = groups[:, None] * len(mesh.vertices) + mesh.faces
    _, index = np.unique(key, return_inverse=True)
    index = index.reshape(mesh.faces.shape)
    total = np.zeros((index.max() + 1, 3))
    weighted = mesh.face_normals[:, None, :] * mesh.face_angles[:, :, None]
    np.add.at(total, index, weighted)
    length = np.linalg.norm(total, axis=1, keepdims=True)
    return (total / np.where(length > 0.0, length, 1.0))[index]
