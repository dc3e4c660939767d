"""What the animation holds: stage, plies, yarns, tools, normals, colours, materials, validators."""

import json

import numpy as np
import pytest
import trimesh
from pxr import Tf, Usd, UsdGeom, UsdShade, UsdUtils
from synthetic_run import ANGLES_DEG, FRAMES, STROKE_S, frames_at, shapes, write_run
from test_engine import small_press

from warpdrape.results.shading import ply_normals, tool_normals
from warpdrape.results.shear_colors import shear_color
from warpdrape.results.usd import ToolShape, UsdWriter
from warpdrape.results.usd_stage import TIME_ATTRIBUTE


@pytest.fixture(scope="module")
def scene_path(tmp_path_factory):
    return write_run(tmp_path_factory.mktemp("usd") / "run").scene_path


@pytest.fixture
def stage(scene_path):
    return Usd.Stage.Open(str(scene_path))


def test_stage_is_as_promised(stage):
    assert UsdGeom.GetStageMetersPerUnit(stage) == 1.0
    assert UsdGeom.GetStageUpAxis(stage) == "Z"
    assert stage.GetDefaultPrim().GetPath() == "/World"
    assert stage.GetTimeCodesPerSecond() == 24.0
    assert (stage.GetStartTimeCode(), stage.GetEndTimeCode()) == (0.0, FRAMES - 1.0)
    time = stage.GetPrimAtPath("/World").GetAttribute(TIME_ATTRIBUTE)
    assert [time.Get(k) for k in range(FRAMES)] == pytest.approx(
        [STROKE_S * k / (FRAMES - 1) for k in range(FRAMES)], abs=1e-15
    )


def test_ply_holds_what_an_outside_tool_reads(stage):
    prims = stage.GetPrimAtPath("/World/plies").GetChildren()
    assert [p.GetName() for p in prims] == ["ply_0", "ply_1", "ply_2"]
    for prim, angle in zip(prims, ANGLES_DEG, strict=True):
        mesh, primvars = UsdGeom.Mesh(prim), UsdGeom.PrimvarsAPI(prim)
        assert mesh.GetSubdivisionSchemeAttr().Get() == "none"
        assert mesh.GetDoubleSidedAttr().Get()
        times = mesh.GetPointsAttr().GetTimeSamples()
        assert times == [float(k) for k in range(FRAMES)]
        assert mesh.GetExtentAttr().GetTimeSamples() == times
        assert mesh.GetFaceVertexIndicesAttr().GetNumTimeSamples() == 0
        rest = primvars.GetPrimvar("restPoints")
        assert (rest.GetInterpolation(), rest.GetAttr().GetNumTimeSamples()) == ("vertex", 0)
        assert rest.GetTypeName() == "point3f[]"
        for name in ("warp", "weft", "shearAngle", "warpStrain", "weftStrain", "warpTension",
                     "weftTension", "displayColor"):  # fmt: skip
            primvar = primvars.GetPrimvar(name)
            assert primvar.GetInterpolation() == "uniform"
            assert primvar.GetAttr().GetTimeSamples() == primvar.GetTimeSamples() == times
            counts = mesh.GetFaceVertexCountsAttr().Get()
            assert len(primvar.Get(times[-1])) == len(counts)  # one a triangle, not indexed
        check_colours(primvars, times[-1])
        check_yarns(mesh, primvars, np.array(rest.Get(), float), angle)


def check_colours(primvars, time):
    """Darker and brighter in the order of |γ|, as linear light of a scale that gets brighter."""
    shear = np.abs(primvars.GetPrimvar("shearAngle").Get(time))
    color = np.array(primvars.GetPrimvar("displayColor").Get(time), float)
    bright = color @ [0.2126, 0.7152, 0.0722]
    order = np.argsort(shear)
    assert np.ptp(shear) > 5.0 and (np.diff(bright[order]) >= -1e-6).all()


def check_yarns(mesh, primvars, rest, angle_deg):
    """Compute yarn directions and shear again, from nothing but the points."""
    a, b, c = np.array(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 3).T
    for k in (0, FRAMES - 1):
        x = np.array(mesh.GetPointsAttr().Get(k), float)
        flat = np.stack([rest[b] - rest[a], rest[c] - rest[a]], 2)[:, :2]
        gradient = np.stack([x[b] - x[a], x[c] - x[a]], 2) @ np.linalg.inv(flat)
        t = np.radians(angle_deg)
        warp, weft = gradient @ [np.cos(t), np.sin(t)], gradient @ [-np.sin(t), np.cos(t)]
        warp /= np.linalg.norm(warp, axis=1)[:, None]
        weft /= np.linalg.norm(weft, axis=1)[:, None]
        shear = 90 - np.degrees(np.arccos(np.clip((warp * weft).sum(1), -1, 1)))
        if k:
            assert abs(shear).max() > 5.0
        for name, expected, tolerance in (
            ("warp", warp, 1e-5),  # float32 of points 0.1 m away over 0.05 m edges
            ("weft", weft, 1e-5),
            ("shearAngle", shear, 1e-3),
        ):
            stored = np.array(primvars.GetPrimvar(name).Get(k), float)
            np.testing.assert_allclose(stored, expected, atol=tolerance)
        low, high = np.array(mesh.GetExtentAttr().Get(k))
        np.testing.assert_array_equal(low, x.min(axis=0))
        np.testing.assert_array_equal(high, x.max(axis=0))


def test_tool_moves_and_keeps_its_points(stage):
    (prim,) = stage.GetPrimAtPath("/World/tools").GetChildren()
    mesh = UsdGeom.Mesh(prim)
    assert prim.GetName() == Tf.MakeValidIdentifier("punch no. 1")
    assert mesh.GetPointsAttr().GetNumTimeSamples() == 0
    for k in range(FRAMES):
        moved = mesh.ComputeLocalToWorldTransform(k).ExtractTranslation()
        assert tuple(moved) == pytest.approx((0.0, 0.0, -0.01 * k), abs=1e-15)


def test_normals_are_those_of_the_surface_at_every_frame(stage):
    """Against the saddle's own normal at middle vertices, exact but for the mesh's diagonals."""
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/World/plies/ply_1"))
    assert mesh.GetNormalsInterpolation() == "vertex"
    rest = np.array(UsdGeom.PrimvarsAPI(mesh).GetPrimvar("restPoints").Get(), float)
    inner = np.abs(rest[:, :2]).max(axis=1) < 0.14
    for k in range(FRAMES):
        amount = k / (FRAMES - 1)
        normals = np.array(mesh.GetNormalsAttr().Get(k), float)
        np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, atol=1e-6)
        x, y, _ = rest.T
        one = np.ones_like(x)
        along_x = np.stack([one, 0.1 * amount * one, 4 * amount * y], axis=1)
        along_y = np.stack([0.3 * amount * one, one, 4 * amount * x], axis=1)
        exact = np.cross(along_x, along_y)
        exact /= np.linalg.norm(exact, axis=1, keepdims=True)
        # one diagonal a square: 2 % of the slope 4 · 0.05 across a cell
        assert np.linalg.norm(normals - exact, axis=1)[inner].max() < 0.02 * amount + 1e-6
    assert np.abs(exact[inner, :2]).max() > 0.3


def test_sharp_edges_of_tools_stay_sharp_and_round_ones_round(tmp_path):
    box, ball = trimesh.creation.box((0.2, 0.1, 0.05)), trimesh.creation.icosphere(3, 0.1)
    tools = [ToolShape(n, m.vertices, m.faces) for n, m in (("box", box), ("ball", ball))]
    with UsdWriter(tmp_path / "scene.usdc", shapes()[0], tools) as writer:
        writer.write(0, 0.0, frames_at(0.0), np.zeros((2, 3)))
    stage = Usd.Stage.Open(str(tmp_path / "scene.usdc"))

    def corners(name):
        primvars = UsdGeom.PrimvarsAPI(stage.GetPrimAtPath(f"/World/tools/{name}"))
        normals = primvars.GetPrimvar("normals")
        assert normals.GetInterpolation() == "faceVarying"
        return np.array(normals.ComputeFlattened(), float), len(normals.Get())

    flat, count = corners("box")
    np.testing.assert_allclose(flat, np.repeat(box.face_normals, 3, axis=0), atol=1e-6)
    assert count == 6
    smooth, count = corners("ball")
    # icosphere of 642 vertices: weighted means are within 0.3 degrees of the radius
    np.testing.assert_allclose(smooth, 10.0 * ball.vertices[ball.faces.ravel()], atol=5e-3)
    assert count == len(ball.vertices)


def test_vertices_of_no_triangle_and_facets_without_area_get_a_normal():
    points = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0], [5, 5, 5.0]], np.float32)
    triangles = np.array([[0, 1, 2], [0, 3, 1]])
    normals = ply_normals(points, triangles)
    np.testing.assert_array_equal(normals[:, 2], [-1, -1, 1, -1, 1])
    assert (np.linalg.norm(tool_normals(points, triangles), axis=1) == 1.0).all()


def test_the_file_says_what_it_is(tmp_path):
    small_press(duration=4e-4).run(tmp_path / "run", frames=1)
    stage = Usd.Stage.Open(str(tmp_path / "run" / "scene.usdc"))
    about = stage.GetRootLayer().customLayerData
    record = json.loads((tmp_path / "run" / "run.json").read_text("utf-8"))
    assert about["program"] == "warpdrape" and about["scene"] == record["scene"]
    assert about["version"] == record["versions"]["warpdrape"]
    units = about["units"]
    assert units["points"] == "m" and units["shearAngle"] == "deg" and units["warpStrain"] == "1"
    assert units["warpTension"] == "N per metre of width" and units["toolPressure"] == "Pa"
    for prim in stage.Traverse():
        primvars = UsdGeom.PrimvarsAPI(prim).GetPrimvarsWithAuthoredValues() if prim else []
        names = {p.GetPrimvarName() for p in primvars}
        assert names - {"displayColor", "displayOpacity", "normals"} <= set(units)
    kinds = {p: Usd.ModelAPI(stage.GetPrimAtPath(p)).GetKind() for p in ("/World", "/World/plies")}
    assert kinds == {"/World": "assembly", "/World/plies": "group"}
    for folder in ("plies", "tools"):
        for prim in stage.GetPrimAtPath(f"/World/{folder}").GetChildren():
            assert prim.IsModel() and Usd.ModelAPI(prim).GetKind() == "component"
    lying = UsdGeom.Mesh(stage.GetPrimAtPath("/World/plies").GetChildren()[0])
    flat = UsdGeom.PrimvarsAPI(lying).GetPrimvar("restPoints").Get()
    assert lying.GetPointsAttr().Get() == flat  # at no time


def test_validator_of_another_hand_finds_no_failure(scene_path):
    validator = pytest.importorskip("omni.asset_validator")
    found = validator.ValidationEngine().validate(str(scene_path))
    bad = (validator.IssueSeverity.ERROR, validator.IssueSeverity.FAILURE)
    assert [str(issue) for issue in found.issues() if issue.severity in bad] == []


def test_materials_are_bound(stage):
    for group, material in (("plies", "ply"), ("tools", "tool")):
        for prim in stage.GetPrimAtPath(f"/World/{group}").GetChildren():
            bound, _ = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()
            assert bound.GetPath() == f"/World/materials/{material}"
            assert bound.ComputeSurfaceSource()[0].GetIdAttr().Get() == "UsdPreviewSurface"


def test_validators_find_no_error(stage, scene_path):
    ran = 0
    try:
        from pxr import UsdValidation
    except ImportError:
        pass
    else:
        validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
        errors = UsdValidation.ValidationContext(validators).Validate(stage)
        assert [e.GetErrorAsString() for e in errors] == []
        ran += len(validators)
    if hasattr(UsdUtils, "ComplianceChecker"):
        checker = UsdUtils.ComplianceChecker()
        checker.CheckCompliance(str(scene_path))
        assert checker.GetErrors() + checker.GetFailedChecks() == []
        ran += 1
    assert ran


def test_colours_are_the_published_scale_in_linear_light():
    from matplotlib import colormaps

    shear = np.array([0.0, -7.0, 23.0, -41.0, 60.0, 85.0])
    linear = shear_color(shear).astype(float)
    srgb = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    expected = colormaps["viridis"](np.minimum(abs(shear) / 60.0, 1.0))[:, :3]
    assert abs(srgb - expected).max() < 0.01  # 17 knots instead of 256


def test_no_tools(tmp_path):
    plies, _ = shapes()
    with UsdWriter(tmp_path / "scene.usdc", plies) as writer:
        writer.write(0, 0.0, frames_at(0.0))
    stage = Usd.Stage.Open(str(tmp_path / "scene.usdc"))
    assert stage.GetPrimAtPath("/World/tools").GetChildren() == []
