"""What the USD stage looks like: prims, primvars, materials; no frame is written here."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pxr import Gf, Kind, Sdf, Tf, Usd, UsdGeom, UsdShade, Vt

from warpdrape.distinct import distinct_rows
from warpdrape.errors import InputError, said
from warpdrape.results.shading import ply_normals, tool_normals
from warpdrape.results.shear_colors import COLOR_RANGE_DEG

TIME_ATTRIBUTE = "warpdrape:simulatedTime"
"""Attribute of ``/World`` that holds the simulated time of each frame [s]."""
TIME_PATH = Sdf.Path(f"/World.{TIME_ATTRIBUTE}")
"""Where it is in the file."""

_TOOL_COLOR = Gf.Vec3f(0.36, 0.38, 0.41)
_TOOL_OPACITY = 0.35
_FLOATS, _VECTORS = Sdf.ValueTypeNames.FloatArray, Sdf.ValueTypeNames.Vector3fArray
_PRIMVARS = {  # field of PlyFrame: (name, type, what the file says about it)
    "warp": ("warp", _VECTORS, "current warp direction, unit length, world frame"),
    "weft": ("weft", _VECTORS, "current weft direction, unit length, world frame"),
    "shear_angle_deg": ("shearAngle", _FLOATS, "shear angle, signed [deg]"),
    "warp_strain": ("warpStrain", _FLOATS, "warp yarn strain"),
    "weft_strain": ("weftStrain", _FLOATS, "weft yarn strain"),
    "warp_tension": ("warpTension", _FLOATS, "warp tension [N per metre of width]"),
    "weft_tension": ("weftTension", _FLOATS, "weft tension [N per metre of width]"),
}
_SOME_PRIMVARS = {  # the same, of plies that have them
    "thickness": ("thickness", _FLOATS, "thickness [m]"),
    "fibre_volume_fraction": ("fibreVolumeFraction", _FLOATS, "fibre volume fraction"),
    "wrinkle": ("wrinkle", _FLOATS, "amplitude of wrinkles, 0 where there is none [m]"),
}
MAY_BE_EMPTY = ("warp_tension", "weft_tension")
"""Those that every ply has, without values where an approach gives none."""
TRIANGLE_PRIMVARS = _PRIMVARS | _SOME_PRIMVARS
VERTEX_PRIMVARS = {  # the same at vertices, of plies that have them
    "warp_curvature": (
        "warpCurvature",
        _FLOATS,
        "curvature of the warp yarns out of the ply's plane [1/m]",
    ),
    "weft_curvature": (
        "weftCurvature",
        _FLOATS,
        "curvature of the weft yarns out of the ply's plane [1/m]",
    ),
    "slip": (
        "slip",
        _VECTORS,
        "way along the ply from where it lay on the ply above, the topmost on that below [m]",
    ),
    "contact_pressure": ("contactPressure", _FLOATS, "pressure of plies on either face [Pa]"),
    "tool_pressure": ("toolPressure", _FLOATS, "pressure of tools [Pa]"),
    "temperature": ("temperature", _FLOATS, "temperature [K]"),
    "warp_slide": ("warpSlide", _FLOATS, "warp yarn gone through its crossover [m]"),
    "weft_slide": ("weftSlide", _FLOATS, "weft yarn gone through its crossover [m]"),
}


@dataclass(frozen=True)
class MeshPrim:
    """A checked mesh under the name that it has in the file.

    Args:
        label: how errors call it: kind and the user's name.
        prim_name: the name in the file, a valid USD identifier.
        points: vertex positions [m], shape (n, 3).
        triangles: vertex numbers, shape (m, 3).
    """

    label: str
    prim_name: str
    points: NDArray[np.float32]
    triangles: NDArray[np.int32]

    @staticmethod
    def check(kind: str, name: str, points: ArrayLike, triangles: ArrayLike) -> MeshPrim:
        """Return the mesh; raise `InputError` naming it when it is unusable."""
        if not isinstance(name, str) or not name:
            raise InputError(f"{kind} name = {said(name)} must be a word, such as {kind}_0")
        label = f"{kind} {name!r}"
        points, triangles = np.asarray(points, np.float64), np.asarray(triangles)
        if points.ndim != 2 or points.shape[1] != 3 or not np.isfinite(points).all():
            raise InputError(f"{label}: points must be finite and of shape (n, 3)")
        if triangles.ndim != 2 or triangles.shape[1] != 3 or triangles.dtype.kind not in "iu":
            raise InputError(f"{label}: triangles must be integers of shape (m, 3)")
        if not len(triangles) or triangles.min() < 0 or triangles.max() >= len(points):
            raise InputError(
                f"{label}: triangles must be one or more, of vertices 0 to {len(points) - 1}"
            )
        identifier = Tf.MakeValidIdentifier(name)
        return MeshPrim(label, identifier, points.astype(np.float32), triangles.astype(np.int32))


def refuse_duplicates(kind: str, meshes: Sequence[MeshPrim]) -> None:
    """Raise `InputError` where two meshes would have one name in the file."""
    seen: dict[str, str] = {}
    for mesh in meshes:
        if mesh.prim_name in seen:
            raise InputError(
                f"{mesh.label} and {seen[mesh.prim_name]} would both be {mesh.prim_name!r} in the "
                f"USD file: give each {kind} its own name"
            )
        seen[mesh.prim_name] = mesh.label


def extent(points: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the lowest and the highest corner of the box round ``points``, shape (2, 3)."""
    columns = np.ascontiguousarray(points.T)  # down the rows numpy takes ten times as long
    return np.stack([columns.min(axis=1), columns.max(axis=1)])


def to_usd(values: NDArray) -> Vt.FloatArray | Vt.IntArray | Vt.Vec3fArray:
    """Return ``values`` of shape (n,) or (n, 3) as the array that USD stores."""
    flat = Vt.IntArray if values.dtype.kind == "i" else Vt.FloatArray
    array = flat if values.ndim == 1 else Vt.Vec3fArray
    return array.FromNumpy(np.ascontiguousarray(values))


def set_up_stage(
    stage: Usd.Stage, frames_per_second: float, about: Mapping[str, str] | None = None
) -> None:
    """Author units, axis, frame rate, what made it, and the prims that hold everything else.

    Args:
        stage: the stage, empty.
        frames_per_second: that a viewer plays.
        about: what the layer says of where it comes from, such as program and scene.
    """
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    stage.SetTimeCodesPerSecond(frames_per_second)
    stage.SetFramesPerSecond(frames_per_second)
    stage.GetRootLayer().customLayerData = {**(about or {}), "units": _units()}
    world = UsdGeom.Xform.Define(stage, "/World").GetPrim()
    stage.SetDefaultPrim(world)
    time = world.CreateAttribute(TIME_ATTRIBUTE, Sdf.ValueTypeNames.Double, custom=True)
    time.SetDocumentation("simulated time of the frame [s]")
    Usd.ModelAPI(world).SetKind(Kind.Tokens.assembly)
    for folder in ("plies", "tools"):
        group = UsdGeom.Xform.Define(stage, f"/World/{folder}").GetPrim()
        Usd.ModelAPI(group).SetKind(Kind.Tokens.group)
    UsdGeom.Scope.Define(stage, "/World/materials")


def _units() -> dict[str, str]:
    """Units of what the file holds, by the names that it has there."""
    units = {"points": "m", "restPoints": "m", TIME_ATTRIBUTE: "s"}
    for name, _, text in (TRIANGLE_PRIMVARS | VERTEX_PRIMVARS).values():
        units[name] = text.partition(" [")[2].rstrip("]") or "1"
    return units


def define_materials(stage: Usd.Stage) -> tuple[UsdShade.Material, UsdShade.Material]:
    """Return the cloth, coloured by ``displayColor``, and the tools' translucent grey metal."""
    color = Sdf.ValueTypeNames.Color3f
    cloth, surface = _define_surface(stage, "ply", roughness=0.7, metallic=0.0, opacity=1.0)
    reader = UsdShade.Shader.Define(stage, cloth.GetPath().AppendChild("color"))
    reader.CreateIdAttr("UsdPrimvarReader_float3")
    reader.CreateInput("varname", Sdf.ValueTypeNames.String).Set("displayColor")
    output = reader.CreateOutput("result", Sdf.ValueTypeNames.Float3)
    surface.CreateInput("diffuseColor", color).ConnectToSource(output)
    metal, surface = _define_surface(
        stage, "tool", roughness=0.35, metallic=0.6, opacity=_TOOL_OPACITY
    )
    surface.CreateInput("diffuseColor", color).Set(_TOOL_COLOR)
    return cloth, metal


def _define_surface(
    stage: Usd.Stage, name: str, **numbers: float
) -> tuple[UsdShade.Material, UsdShade.Shader]:
    material = UsdShade.Material.Define(stage, f"/World/materials/{name}")
    surface = UsdShade.Shader.Define(stage, material.GetPath().AppendChild("surface"))
    surface.CreateIdAttr("UsdPreviewSurface")
    for key, value in numbers.items():
        surface.CreateInput(key, Sdf.ValueTypeNames.Float).Set(value)
    output = surface.CreateOutput("surface", Sdf.ValueTypeNames.Token)
    material.CreateSurfaceOutput().ConnectToSource(output)
    return material, surface


def _define_mesh(
    stage: Usd.Stage, folder: str, mesh: MeshPrim, material: UsdShade.Material
) -> UsdGeom.Mesh:
    usd_mesh = UsdGeom.Mesh.Define(stage, f"/World/{folder}/{mesh.prim_name}")
    usd_mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    usd_mesh.CreateDoubleSidedAttr(True)
    counts = np.full(len(mesh.triangles), 3, np.int32)
    usd_mesh.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(counts))
    usd_mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(mesh.triangles.ravel()))
    UsdShade.MaterialBindingAPI.Apply(usd_mesh.GetPrim()).Bind(material)
    Usd.ModelAPI(usd_mesh.GetPrim()).SetKind(Kind.Tokens.component)
    return usd_mesh


def define_ply(
    stage: Usd.Stage,
    mesh: MeshPrim,
    material: UsdShade.Material,
    at_vertices: Sequence[str] = (),
    in_triangles: Sequence[str] = (),
) -> dict[str, Sdf.Path]:
    """Return where the values of each frame go, by their names."""
    usd_mesh = _define_mesh(stage, "plies", mesh, material)
    primvars = UsdGeom.PrimvarsAPI(usd_mesh)
    rest = primvars.CreatePrimvar(
        "restPoints", Sdf.ValueTypeNames.Point3fArray, UsdGeom.Tokens.vertex
    )
    rest.Set(to_usd(mesh.points))
    rest.GetAttr().SetDocumentation("the flat blank [m]")
    attributes = {
        "points": usd_mesh.CreatePointsAttr(),
        "extent": usd_mesh.CreateExtentAttr(),
        "normals": usd_mesh.CreateNormalsAttr(),
    }
    usd_mesh.SetNormalsInterpolation(UsdGeom.Tokens.vertex)
    attributes["points"].Set(to_usd(mesh.points))  # outside the frames it lies flat
    attributes["extent"].Set(to_usd(extent(mesh.points)))
    attributes["normals"].Set(to_usd(ply_normals(mesh.points, mesh.triangles)))
    for key, (name, kind, text) in _for_each_triangle(in_triangles).items():
        attribute = primvars.CreatePrimvar(name, kind, UsdGeom.Tokens.uniform).GetAttr()
        attribute.SetDocumentation(text)
        attributes[key] = attribute
    for key in at_vertices:
        name, kind, text = VERTEX_PRIMVARS[key]
        attribute = primvars.CreatePrimvar(name, kind, UsdGeom.Tokens.vertex).GetAttr()
        attribute.SetDocumentation(text)
        attributes[key] = attribute
    color = usd_mesh.CreateDisplayColorPrimvar(UsdGeom.Tokens.uniform).GetAttr()
    color.SetDocumentation("shear angle |γ| on the viridis scale (linear light)")
    color.SetCustomData({"scale": "viridis", "minimumDeg": 0.0, "maximumDeg": COLOR_RANGE_DEG})
    attributes["color"] = color
    return {key: attribute.GetPath() for key, attribute in attributes.items()}


def _for_each_triangle(some: Sequence[str]) -> dict[str, tuple[str, Sdf.ValueTypeName, str]]:
    return _PRIMVARS | {key: _SOME_PRIMVARS[key] for key in some}


def define_tool(
    stage: Usd.Stage,
    mesh: MeshPrim,
    material: UsdShade.Material,
    axis: ArrayLike | None = None,
    point: ArrayLike | None = None,
) -> tuple[Sdf.Path, Sdf.Path | None]:
    """Return where the translation of each frame goes, and its angle [deg] if the tool turns.

    A tool turns by one angle about an axis: between frames a viewer goes on by angle, whole turns
    and all, as it could not by matrices or quaternions. Two static operations each bring the axis
    to z and back.
    """
    usd_mesh = _define_mesh(stage, "tools", mesh, material)
    usd_mesh.CreatePointsAttr(to_usd(mesh.points))
    usd_mesh.CreateExtentAttr(to_usd(extent(mesh.points)))
    at_corners = tool_normals(mesh.points, mesh.triangles)
    first, which = distinct_rows(at_corners)
    normals = UsdGeom.PrimvarsAPI(usd_mesh).CreatePrimvar(
        "normals", Sdf.ValueTypeNames.Normal3fArray, UsdGeom.Tokens.faceVarying
    )
    normals.Set(to_usd(at_corners[first]))
    normals.SetIndices(to_usd(which.astype(np.int32)))
    usd_mesh.CreateDisplayColorPrimvar(UsdGeom.Tokens.constant).Set([_TOOL_COLOR])
    usd_mesh.CreateDisplayOpacityPrimvar(UsdGeom.Tokens.constant).Set([_TOOL_OPACITY])
    way = usd_mesh.AddTranslateOp()
    if axis is None:
        return way.GetAttr().GetPath(), None
    double = UsdGeom.XformOp.PrecisionDouble
    to_axis = Gf.Rotation(Gf.Vec3d.ZAxis(), Gf.Vec3d(*np.asarray(axis, float).tolist()))
    pivot = usd_mesh.AddTranslateOp(double, "pivot")
    pivot.Set(Gf.Vec3d(*np.asarray(point, float).tolist()))
    tilt = usd_mesh.AddOrientOp(double, "axis")
    tilt.Set(Gf.Quatd(to_axis.GetQuat()))
    angle = usd_mesh.AddRotateZOp(double)
    back = usd_mesh.AddOrientOp(double, "axis", isInverseOp=True)
    home = usd_mesh.AddTranslateOp(double, "pivot", isInverseOp=True)
    usd_mesh.SetXformOpOrder([way, pivot, tilt, angle, back, home])
    return way.GetAttr().GetPath(), angle.GetAttr().GetPath()
