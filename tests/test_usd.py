import json
import os
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import trimesh
from pxr import Sdf, Tf, Usd, UsdGeom, UsdShade, UsdUtils
from synthetic_run import ANGLES_DEG, FRAMES, STROKE_S, frames_at, shapes, write_run
from test_engine import small_press

from warpdrape.errors import InputError, RunFailed
from warpdrape.results import usd
from warpdrape.results.shading import ply_normals, tool_normals
from warpdrape.results.shear_colors import shear_color
from warpdrape.results.usd import PlyFrame, PlyShape, ToolShape, UsdWriter
from warpdrape.results.usd_layer import check_space
from warpdrape.results.usd_stage import TIME_ATTRIBUTE


@pytest.fixture(scope="module")
def scene_path(tmp_path_factory):
    return write_run(tmp_path_factory.mktemp("usd") / "run").scene_path


@pytest.fixture
def stage(scene_path):
    return Usd.Stage.Open(str(scene_path))


def writer_in(folder: Path) -> UsdWriter:
    return UsdWriter(folder / "scene.usdc", *shapes())


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


def test_a_frame_takes_no_more_than_its_numbers(tmp_path):
    """Nor does the layer keep copies of what stays."""
    sizes = []
    for frames in (2, 22):
        with UsdWriter(tmp_path / f"{frames}.usdc", *shapes()) as writer:
            for k in range(frames):
                writer.write(k, 0.01 * k, frames_at((k + 1) / 23), [[0, 0, 0]])
        sizes.append((tmp_path / f"{frames}.usdc").stat().st_size)
    vertices, triangles = (len(a) for a in (shapes()[0][0].rest_points, shapes()[0][0].triangles))
    # positions, normals; directions, colours and 5 scalars; a tenth for the layer's own tables
    numbers = 3 * (24 * vertices + 56 * triangles)
    assert (sizes[1] - sizes[0]) / 20 < 1.1 * numbers


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


def test_killed_run_leaves_its_frames(tmp_path):
    code = (
        "import os, sys; sys.path.insert(0, 'tests')\n"
        "from test_usd import *\n"
        "from warpdrape.results import usd; usd.SAVE_EVERY = 0.0\n"
        "writer = writer_in(Path(sys.argv[1]))\n"
        "for k in range(3): writer.write(k, 0.01 * k, frames_at(k / 3), [[0, 0, -k]])\n"
        "os._exit(9)"
    )
    root = Path(__file__).parent.parent
    path = os.pathsep.join([str(root), os.environ.get("PYTHONPATH", "")])
    done = subprocess.run(
        [sys.executable, "-c", code, str(tmp_path)], cwd=root, env=os.environ | {"PYTHONPATH": path}
    )
    assert done.returncode == 9
    assert [f.name for f in tmp_path.iterdir()] == [".scene.partial.usdc"]
    stage = Usd.Stage.Open(str(tmp_path / ".scene.partial.usdc"))
    points = UsdGeom.Mesh(stage.GetPrimAtPath("/World/plies/ply_2")).GetPointsAttr()
    assert points.GetTimeSamples() == [0.0, 1.0, 2.0]
    np.testing.assert_allclose(np.array(points.Get(2)), frames_at(2 / 3)[2].points, atol=1e-7)
    assert stage.GetEndTimeCode() == 2.0


def test_frames_that_come_fast_are_saved_together(tmp_path, monkeypatch):
    now, save, saved = [100.0], Sdf.Layer.Save, []
    monkeypatch.setattr(usd.time, "monotonic", lambda: now[0])
    monkeypatch.setattr(Sdf.Layer, "Save", lambda layer: saved.append(now[0]) or save(layer))
    with writer_in(tmp_path) as writer:
        for k in range(8):
            now[0] += 0.4 * usd.SAVE_EVERY
            writer.write(k, 0.01 * k, frames_at(k / 8), [[0, 0, 0]])
    # Opened, the third and the sixth frame, and the last two when it is closed.
    assert (np.round((np.array(saved) - 100.0) / usd.SAVE_EVERY, 1) == [0.0, 1.2, 2.4, 3.2]).all()
    stage = Usd.Stage.Open(str(tmp_path / "scene.usdc"))
    points = UsdGeom.Mesh(stage.GetPrimAtPath("/World/plies/ply_1")).GetPointsAttr()
    assert points.GetTimeSamples() == list(range(8))


def test_saving_as_it_goes_takes_little_room(tmp_path, monkeypatch):
    """Each save leaves an index of all frames so far behind: all saved, 2.5 times the file."""
    chance, sizes, saves, save = np.random.default_rng(0), [], [], Sdf.Layer.Save
    monkeypatch.setattr(Sdf.Layer, "Save", lambda layer: saves.append(1) or save(layer))
    points, triangles = chance.random((60, 3)), chance.integers(0, 60, (100, 3))
    monkeypatch.setattr(usd, "_PAGE_BYTES", 0)
    for every in (0.0, 1e9):
        monkeypatch.setattr(usd, "SAVE_EVERY", every)
        path = tmp_path / f"{every:.0f}.usdc"
        with UsdWriter(path, [PlyShape("ply_0", points, triangles)]) as writer:
            for k in range(200):
                values = chance.random((5, 100))
                directions = chance.random((2, 100, 3))
                writer.write(k, 0.01 * k, [PlyFrame(chance.random((60, 3)), *directions, *values)])
        sizes.append(path.stat().st_size)
    assert len(saves) > 15 and sizes[1] < sizes[0] < 1.06 * sizes[1]


def test_a_disk_that_fills_at_the_end_is_a_failed_run(tmp_path, monkeypatch):
    save, calls = Sdf.Layer.Save, []

    def full(layer):
        calls.append(layer)
        return save(layer) if len(calls) == 1 else Tf.RaiseRuntimeError("no space left")

    monkeypatch.setattr(Sdf.Layer, "Save", full)
    monkeypatch.setattr(usd, "SAVE_EVERY", 1e9)
    out = tmp_path / "run"
    result = small_press(duration=4e-4).run(out, frames=2)
    assert not result.completed and "is lost: is the disk full" in result.summary["message"]
    assert sorted(f.name for f in out.iterdir()) == ["history.csv", "run.json", "summary.json"]


def test_failing_run_keeps_its_frames_under_the_final_name(tmp_path):
    with pytest.raises(RuntimeError, match="blew up"), writer_in(tmp_path) as writer:
        writer.write(0, 0.0, frames_at(0.0), [[0, 0, 0]])
        raise RuntimeError("blew up")
    assert [f.name for f in tmp_path.iterdir()] == ["scene.usdc"]
    assert not Sdf.Layer.Find(str(tmp_path / ".scene.partial.usdc"))  # Windows could not rename
    with pytest.raises(ValueError, match="closed"):
        writer.write(1, 0.1, frames_at(0.1), [[0, 0, 0]])


def test_no_frame_no_file(tmp_path):
    writer = writer_in(tmp_path)
    writer.close()
    writer.close()
    assert list(tmp_path.iterdir()) == []


def test_rewritten_file_is_seen_by_those_who_hold_it(tmp_path):
    def run(part):
        with writer_in(tmp_path) as writer:
            writer.write(0, 0.0, frames_at(part), [[0, 0, 0]])

    run(0.0)
    held = Usd.Stage.Open(str(tmp_path / "scene.usdc"))
    (tmp_path / "scene.usdc").unlink()
    run(1.0)
    points = UsdGeom.Mesh(held.GetPrimAtPath("/World/plies/ply_0")).GetPointsAttr()
    np.testing.assert_allclose(np.array(points.Get(0)), frames_at(1.0)[0].points, atol=1e-7)


@pytest.mark.parametrize("quantity", ["points", "weft", "shear_angle_deg", "warp_tension"])
@pytest.mark.parametrize("bad", [np.nan, np.inf, 1e300])
def test_non_finite_value_is_refused_and_nothing_written(tmp_path, quantity, bad):
    frames = frames_at(0.5)
    values = np.array(getattr(frames[1], quantity))
    values[7] = bad  # 1e300 is infinite in the file's float32
    with writer_in(tmp_path) as writer:
        writer.write(0, 0.0, frames_at(0.0), [[0, 0, 0]])
        frames[1] = replace(frames[1], **{quantity: values})
        with pytest.raises(ValueError, match=rf"'ply_1': {quantity} .* first at 7"):
            writer.write(1, 0.1, frames, [[0, 0, 0]])
    stage = Usd.Stage.Open(str(tmp_path / "scene.usdc"))
    for name in ("ply_0", "ply_1"):
        points = UsdGeom.Mesh(stage.GetPrimAtPath(f"/World/plies/{name}")).GetPointsAttr()
        assert points.GetTimeSamples() == [0.0]


def test_misuse_says_what_is_wrong(tmp_path):
    with writer_in(tmp_path) as writer:
        writer.write(3, 0.0, frames_at(0.0), [[0, 0, 0]])
        with pytest.raises(ValueError, match="must be above the last, 3"):
            writer.write(3, 0.1, frames_at(0.0), [[0, 0, 0]])
        with pytest.raises(ValueError, match="2 ply frames for 3 plies"):
            writer.write(4, 0.1, frames_at(0.0)[:2], [[0, 0, 0]])
        with pytest.raises(ValueError, match=r"translation has shape \(2, 3\), must be \(1, 3\)"):
            writer.write(4, 0.1, frames_at(0.0), np.zeros((2, 3)))
        with pytest.raises(ValueError, match="translation has 1 non-finite"):
            writer.write(4, 0.1, frames_at(0.0), [[0, 0, np.nan]])
        with pytest.raises(ValueError, match="time_s = nan"):
            writer.write(4, float("nan"), frames_at(0.0), [[0, 0, 0]])
        short = replace(frames_at(0.0)[0], weft_strain=np.zeros(3))
        with pytest.raises(ValueError, match=r"'ply_0': weft_strain has shape \(3,\)"):
            writer.write(4, 0.1, [short, *frames_at(0.0)[1:]], [[0, 0, 0]])


def test_unusable_shapes_are_refused_before_a_file_appears(tmp_path):
    points, triangles = np.eye(3), np.array([[0, 1, 2]])

    def refuse(message, *plies):
        with pytest.raises(InputError, match=message):
            UsdWriter(tmp_path / "scene.usdc", plies)
        assert list(tmp_path.iterdir()) == []

    ply = PlyShape("a b", points, triangles)
    refuse("'a_b' and ply 'a b' would both be 'a_b'", ply, PlyShape("a_b", points, triangles))
    refuse("ply name = ''", PlyShape("", points, triangles))
    refuse("vertices 0 to 2", PlyShape("a", points, triangles + 1))
    refuse("integers", PlyShape("a", points, triangles * 1.0))
    refuse("finite", PlyShape("a", points * np.nan, triangles))


def test_file_in_the_way_and_missing_folder(tmp_path):
    (tmp_path / "scene.usdc").write_text("precious")
    with pytest.raises(InputError, match="exists already"):
        writer_in(tmp_path)
    assert (tmp_path / "scene.usdc").read_text() == "precious"
    with pytest.raises(InputError, match="cannot be created"):
        writer_in(tmp_path / "scene.usdc")


def test_nearly_full_disk_stops_the_run_and_keeps_its_frames(tmp_path, monkeypatch):
    with writer_in(tmp_path) as writer:
        writer.write(0, 0.0, frames_at(0.0), [[0, 0, 0]])
        monkeypatch.setattr("shutil.disk_usage", lambda _: SimpleNamespace(free=1000))
        with pytest.raises(RunFailed, match=r"0 MB left.* the frames up to 0 are kept"):
            writer.write(1, 0.1, frames_at(0.1), [[0, 0, 0]])
    stage = Usd.Stage.Open(str(tmp_path / "scene.usdc"))
    points = UsdGeom.Mesh(stage.GetPrimAtPath("/World/plies/ply_0")).GetPointsAttr()
    assert points.GetTimeSamples() == [0.0]


def test_folder_removed_during_the_run_is_a_failed_run(tmp_path):
    folder = tmp_path / "run"
    folder.mkdir()
    writer = writer_in(folder)
    writer.write(np.int64(0), np.float64(0.0), frames_at(0.0), [[0, 0, 0]])
    shutil.rmtree(folder)
    with pytest.raises(RunFailed, match="the folder is gone"):
        writer.write(1, 0.1, frames_at(0.1), [[0, 0, 0]])
    with pytest.raises(RunFailed, match=r"could not be saved at frame 0.*the folder gone"):
        writer.close()


def test_spoilt_file_never_gets_the_final_name(tmp_path, monkeypatch):
    monkeypatch.setattr(usd, "SAVE_EVERY", 0.0)
    with writer_in(tmp_path) as writer:
        writer.write(0, 0.0, frames_at(0.0), [[0, 0, 0]])
        monkeypatch.setattr(Sdf.Layer, "Save", lambda _: Tf.RaiseRuntimeError("no space left"))
        with pytest.raises(RunFailed, match="at frame 1 and is lost: is the disk full"):
            writer.write(1, 0.1, frames_at(0.1), [[0, 0, 0]])
    assert list(tmp_path.iterdir()) == []


def test_no_tools(tmp_path):
    plies, _ = shapes()
    with UsdWriter(tmp_path / "scene.usdc", plies) as writer:
        writer.write(0, 0.0, frames_at(0.0))
    stage = Usd.Stage.Open(str(tmp_path / "scene.usdc"))
    assert stage.GetPrimAtPath("/World/tools").GetChildren() == []


def test_a_save_needs_room_for_its_frames_twice(tmp_path, monkeypatch):
    """Frames, the index and small files: one byte too few and nothing is begun."""
    room = SimpleNamespace(free=3_000_000)
    monkeypatch.setattr("shutil.disk_usage", lambda _: room)
    check_space(tmp_path, 1_000_000, 4)
    room.free -= 1
    with pytest.raises(RunFailed, match=r"has 3 MB left, .* up to 4 are kept"):
        check_space(tmp_path, 1_000_000, 4)
