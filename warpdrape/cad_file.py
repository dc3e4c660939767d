"""Facets of CAD files, STEP and IGES, in metres and with the surfaces' own normals.

Such a file states its unit, so that nothing is left to be scaled. It is read through Open CASCADE.
"""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import trimesh

from warpdrape.errors import InputError, length

CAD = {".step": "STEP", ".stp": "STEP", ".p21": "STEP", ".iges": "IGES", ".igs": "IGES"}
"""Endings of files that state their unit, and their format."""
FINENESS = 2000.0
"""Size of a body over the chord error of its facets, where none is asked for [-]."""
FACET_ANGLE = 0.35
"""Largest angle between neighbouring facets of a curved face [rad], 20°: normals are exact."""
WITHIN = 0.5
"""What Open CASCADE is asked for over the chord error that is kept: it counts along the sides of
facets, and the middle of one on a sphere lies up to twice as far off [-]."""
MOST_FACETS = 2_000_000
MM = 1e-3
"""What Open CASCADE's readers give, whatever unit a file is in [m]."""


@dataclass(frozen=True)
class CadFacets:
    """What was read.

    Attributes:
        mesh: facets [m]; faces of a body share vertices where they meet.
        normals: of the true surface at each facet's corners, shape [facet, 3, 3].
        unit: the file's own unit of length, as it states it.
        tolerance: chord error of the facets [m].
    """

    mesh: trimesh.Trimesh
    normals: np.ndarray
    unit: str
    tolerance: float


def is_cad(path: Any) -> bool:
    """Whether a file is one that states its unit."""
    return isinstance(path, str | os.PathLike) and Path(path).suffix.lower() in CAD


def read_cad(who: str, path: str | os.PathLike[str], tolerance: float | None = None) -> CadFacets:
    """Read the faces of a CAD file as facets.

    Args:
        who: for errors, such as "tool 'mould'".
        path: a STEP or IGES file.
        tolerance: largest distance of facets from the true surface [m]; None takes a two
            thousandth of the body's size.

    Raises:
        InputError: if it cannot be read, holds no face, or Open CASCADE is not installed.
    """
    file = Path(path)
    if not file.is_file():
        raise InputError(f"{who}: no CAD file {os.fspath(path)!r}")
    kind = CAD[file.suffix.lower()]
    shape, unit = _shape(who, file, kind)
    size = _size(shape)
    if not size > 0.0:
        raise InputError(f"{who}: {file} holds no face: export the body or its surfaces as {kind}")
    chord = size / FINENESS if tolerance is None else length(f"{who}: tolerance", tolerance)
    if chord > 0.1 * size:
        raise InputError(
            f"{who}: tolerance = {chord:.4g} m is coarse for a body of {size:.4g} m: give metres, "
            "as in 0.1 * mm"
        )
    mesher = import_module("OCP.BRepMesh").BRepMesh_IncrementalMesh(
        shape, WITHIN * chord / MM, False, FACET_ANGLE, False
    )
    mesher.Perform()
    points, facets, normals = _facets(shape)
    if not len(facets):
        raise InputError(f"{who}: {file} holds no face: export the body or its surfaces as {kind}")
    if len(facets) > MOST_FACETS:
        raise InputError(
            f"{who}: tolerance = {chord:.4g} m makes {len(facets):.2g} facets: give a larger one"
        )
    mesh = trimesh.Trimesh(MM * points, facets, process=False)
    mesh.merge_vertices()
    solid = mesh.nondegenerate_faces()  # at a pole some facets have no area
    mesh.update_faces(solid)
    return CadFacets(mesh, normals[solid], unit, chord)


def _ocp(module: str) -> Any:
    try:
        return import_module(f"OCP.{module}")
    except ImportError as error:
        raise InputError(
            f"STEP and IGES files need Open CASCADE, which is not installed ({error}): "
            "pip install 'warpdrape[cad]', or save the body as STL"
        ) from error


def _shape(who: str, file: Path, kind: str) -> tuple[Any, str]:
    """The shape of a file, in millimetres, and the unit that the file states."""
    control = _ocp("STEPControl" if kind == "STEP" else "IGESControl")
    _ocp("Message").Message.DefaultMessenger_s().ChangePrinters().Clear()  # it prints on its own
    reader = control.STEPControl_Reader() if kind == "STEP" else control.IGESControl_Reader()
    status = reader.ReadFile(os.fspath(file))
    if status != _ocp("IFSelect").IFSelect_ReturnStatus.IFSelect_RetDone:
        raise InputError(f"{who}: cannot read {file}: it is no {kind} file, or damaged")
    if kind == "STEP" and (named := _units_of(reader)) and len(set(named)) > 1:
        unit = " and ".join(sorted(set(named)))
    elif kind == "STEP":
        unit = named[0] if named else ""
    else:
        unit = _iges_unit(file)
    if not unit:
        raise InputError(
            f"{who}: {file} states no unit of length, which every {kind} file should: export it "
            "again, or save the body as STL and give its unit"
        )
    reader.TransferRoots()
    if reader.NbShapes() == 0:
        raise InputError(f"{who}: {file} holds no shape: export the body or its surfaces as {kind}")
    return reader.OneShape(), unit


def _units_of(reader: Any) -> list[str]:
    """Names of the units of length in a STEP file."""
    sequence = _ocp("collections").Sequence_TCollection_AsciiString
    lengths, angles, solid_angles = sequence(), sequence(), sequence()
    reader.FileUnits(lengths, angles, solid_angles)
    return [lengths.Value(k).ToCString().lower() for k in range(1, lengths.Length() + 1)]


_IGES_UNITS = {
    "1": "inch",
    "2": "millimetre",
    "4": "foot",
    "5": "mile",
    "6": "metre",
    "7": "kilometre",
    "8": "mil",
    "9": "micrometre",
    "10": "centimetre",
    "11": "microinch",
}
"""Flags of the unit, the 14th parameter of an IGES file's global section (IGES 5.3, 2.2.4.3)."""


def _iges_unit(file: Path) -> str:
    """The unit that an IGES file states in its global section; "" where that cannot be read."""
    lines = file.read_text("latin-1").splitlines()
    text = "".join(line[:72].ljust(72) for line in lines[:400] if line[72:73] == "G")
    values: list[str] = []
    rest, delimiter = text, ","
    if text[:2] == "1H":
        delimiter = text[2]
    while rest and len(values) < 14:
        found = re.match(r"\s*(\d+)H", rest)
        end = found.end() + int(found[1]) if found else 0
        cut = rest.find(delimiter, end)
        if cut < 0:
            return ""
        values.append(rest[:cut].strip())
        rest = rest[cut + 1 :]
    return _IGES_UNITS.get(values[13], "") if len(values) == 14 else ""


def _size(shape: Any) -> float:
    """Diagonal of a shape's bounding box [m]."""
    box = _ocp("Bnd").Bnd_Box()
    _ocp("BRepBndLib").BRepBndLib.AddOptimal_s(shape, box, False, False)
    return 0.0 if box.IsVoid() else MM * float(box.SquareExtent()) ** 0.5


def _facets(shape: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points [mm], facets, and normals at their corners of a shape that has been meshed."""
    topology, tool = _ocp("TopoDS").TopoDS, _ocp("BRep").BRep_Tool
    kinds = _ocp("TopAbs")
    as_face = getattr(topology, "Face_s", None) or topology.Face
    explorer = _ocp("TopExp").TopExp_Explorer(shape, kinds.TopAbs_ShapeEnum.TopAbs_FACE)
    points: list[np.ndarray] = []
    facets: list[np.ndarray] = []
    normals: list[np.ndarray] = []
    count = 0
    while explorer.More():
        face = as_face(explorer.Current())
        explorer.Next()
        place = _ocp("TopLoc").TopLoc_Location()
        mesh = tool.Triangulation_s(face, place)
        if mesh is None or mesh.NbTriangles() == 0:
            continue
        backward = face.Orientation() == kinds.TopAbs_Orientation.TopAbs_REVERSED
        at, corners, along = _face_facets(face, mesh, place.Transformation(), backward)
        points.append(at)
        facets.append(corners + count)
        normals.append(along[corners])
        count += len(at)
    if not facets:
        return np.zeros((0, 3)), np.zeros((0, 3), int), np.zeros((0, 3, 3))
    return np.concatenate(points), np.concatenate(facets), np.concatenate(normals)


def _face_facets(
    face: Any, mesh: Any, place: Any, backward: bool
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points [mm] of one face, its facets, and the face's normals at the points."""
    nodes = range(1, mesh.NbNodes() + 1)
    at = np.array([_xyz(mesh.Node(k).Transformed(place)) for k in nodes])
    corners = np.array([mesh.Triangle(k).Get() for k in range(1, mesh.NbTriangles() + 1)]) - 1
    corners = corners[:, ::-1] if backward else corners
    flat = np.cross(at[corners[:, 1]] - at[corners[:, 0]], at[corners[:, 2]] - at[corners[:, 0]])
    mean = np.zeros_like(at)
    for k in range(3):
        np.add.at(mean, corners[:, k], flat)
    if mesh.HasUVNodes():
        true = _true_normals(face, mesh, -1.0 if backward else 1.0)
        # At a pole two of the surface's directions are one, and it has no normal of its own.
        mean = np.where(np.isfinite(true).all(axis=1, keepdims=True), true, mean)
    size = np.linalg.norm(mean, axis=1, keepdims=True)
    return at, corners, mean / np.where(size > 0.0, size, 1.0)


def _true_normals(face: Any, mesh: Any, sense: float) -> np.ndarray:
    """Outward normals of a face's surface at its points, NaN where it has none, shape [n, 3]."""
    gp, surface = _ocp("gp"), _ocp("BRepAdaptor").BRepAdaptor_Surface(face)
    along_u, along_v, at = gp.gp_Vec(), gp.gp_Vec(), gp.gp_Pnt()
    found = np.full((mesh.NbNodes(), 2, 3), np.nan)
    for k in range(mesh.NbNodes()):
        place = mesh.UVNode(k + 1)
        surface.D1(place.X(), place.Y(), at, along_u, along_v)
        found[k] = _xyz(along_u), _xyz(along_v)
    across = sense * np.cross(found[:, 0], found[:, 1])
    size = np.linalg.norm(across, axis=1)
    sides = np.linalg.norm(found, axis=2).prod(axis=1)
    good = size > 1e-6 * np.maximum(sides, 1e-300)
    return np.where(good[:, None], across / np.where(good, size, 1.0)[:, None], np.nan)


def _xyz(of: Any) -> tuple[float, float, float]:
    return of.X(), of.Y(), of.Z()
