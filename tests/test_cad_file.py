"""STEP and IGES files: the unit they state, facets within a tolerance, true normals."""

import sys
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh

import warpdrape as wd
from warpdrape import cad_file
from warpdrape.cad_file import read_cad
from warpdrape.fishnet.drape import as_surface
from warpdrape.tools import tool_mesh

pytest.importorskip("OCP.STEPControl")
TRAY = Path(__file__).parents[1] / "examples" / "tutorial" / "tray.step"
RADIUS = 30.0


@pytest.fixture(scope="module")
def ball():
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeSphere

    return BRepPrimAPI_MakeSphere(RADIUS).Shape()


def write(shape, path, unit="MM"):
    """Write a shape whose numbers are in millimetres to a file that is in ``unit``."""
    from OCP.IGESControl import IGESControl_Writer
    from OCP.Interface import Interface_Static
    from OCP.Message import Message
    from OCP.STEPControl import STEPControl_StepModelType, STEPControl_Writer

    Message.DefaultMessenger_s().ChangePrinters().Clear()
    if path.suffix == ".igs":
        writer = IGESControl_Writer(unit, 0)
        writer.AddShape(shape)
    else:
        writer = STEPControl_Writer()
        Interface_Static.SetCVal_s("write.step.unit", unit)
        writer.Transfer(shape, STEPControl_StepModelType.STEPControl_AsIs)
        Interface_Static.SetCVal_s("write.step.unit", "MM")
    assert writer.Write(str(path))
    return path


@pytest.mark.parametrize("ending", [".step", ".igs"])
@pytest.mark.parametrize(("unit", "said"), [("MM", "millimetre"), ("INCH", "inch"), ("M", "metre")])
def test_a_file_in_any_unit_arrives_in_metres(ball, tmp_path, ending, unit, said):
    unit = {"INCH": "IN"}.get(unit, unit) if ending == ".igs" else unit
    found = read_cad("tool", write(ball, tmp_path / f"ball{ending}", unit))
    assert found.unit == said
    size = np.ptp(found.mesh.vertices, axis=0)
    np.testing.assert_allclose(size, 2e-3 * RADIUS, rtol=5e-3)
    np.testing.assert_allclose(np.linalg.norm(found.mesh.vertices, axis=1), 0.03, rtol=1e-6)


def test_facets_keep_the_tolerance_and_their_normals_are_the_sphere_s(ball, tmp_path):
    path = write(ball, tmp_path / "ball.step")
    counts = []
    for tolerance in (4e-4, 1e-4, 2.5e-5):
        found = read_cad("tool", path, tolerance)
        sag = 0.03 - np.linalg.norm(found.mesh.triangles_center, axis=1)
        assert 0.0 < sag.max() <= tolerance
        radial = found.mesh.triangles / 0.03
        np.testing.assert_allclose(found.normals, radial, atol=1e-6)
        assert found.mesh.is_watertight
        counts.append(len(found.mesh.faces))
    assert counts[0] < counts[1] < counts[2] < 30_000


def test_the_tray_is_closed_and_of_few_facets():
    tool = wd.Tool.from_mesh("mould", TRAY, tolerance=1e-4)
    np.testing.assert_allclose(np.ptp(tool.vertices, axis=0), (0.22, 0.18, 0.04), atol=1e-9)
    assert tool.surface.exact and tool.surface.mesh.is_watertight and len(tool.triangles) < 4000
    facing = np.einsum("fi,fki->fk", tool.surface.mesh.face_normals, tool.surface.normals)
    assert facing.min() > np.cos(np.radians(15.0))
    assert "tray.step, which is in millimetre" in tool.surface.source
    assert tool.moved((0.0, 0.0, 1.0)).surface.source == tool.surface.source


def test_a_body_inside_out_is_turned_with_its_normals(ball, tmp_path, monkeypatch):
    found = read_cad("ball", write(ball, tmp_path / "ball.step"))
    inside_out = trimesh.Trimesh(found.mesh.vertices, found.mesh.faces[:, ::-1], process=False)
    hollow = replace(found, mesh=inside_out, normals=-found.normals[:, ::-1])
    monkeypatch.setattr(tool_mesh, "read_cad", lambda *_: hollow)
    tool = wd.Tool.from_mesh("ball", "ball.step")
    assert tool.surface.mesh.volume > 0.0
    np.testing.assert_allclose(
        tool.surface.normals, tool.vertices[tool.triangles] / 0.03, atol=1e-6
    )


def test_scale_and_tolerance_are_refused_where_they_have_no_meaning(tmp_path):
    with pytest.raises(wd.InputError, match=r"scale = 0.001, but .* states its unit, millimetre"):
        wd.Tool.from_mesh("mould", TRAY, scale=1e-3)
    with pytest.raises(wd.InputError, match=r"tolerance = 0.1 m is coarse .* give metres"):
        wd.Tool.from_mesh("mould", TRAY, tolerance=0.1)
    trimesh.creation.icosphere(1, 0.1).export(tmp_path / "ball.stl")
    with pytest.raises(wd.InputError, match=r"tolerance = 0.001 is for CAD files \(.step"):
        wd.Tool.from_mesh("ball", tmp_path / "ball.stl", tolerance=1e-3)
    with pytest.raises(wd.InputError, match=r"has surfaces, not triangles.*Ply.from_dxf"):
        wd.Ply.from_file("ply", "carbon_interlock", TRAY)


def test_a_net_is_laid_on_a_cad_file_in_its_own_size():
    assert as_surface(TRAY).size == pytest.approx(np.linalg.norm((0.22, 0.18, 0.04)), rel=1e-6)


@pytest.mark.parametrize("name", ["a.step", "a.igs"])
@pytest.mark.parametrize("text", ["", "nonsense\n", "ISO-10303-21;\nHEADER;\nENDSEC;\n"])
def test_what_is_no_cad_file_is_refused_in_a_line_and_nothing_is_printed(
    name, text, tmp_path, capfd
):
    (tmp_path / name).write_text(text)
    with pytest.raises(wd.InputError, match=rf"tool 'x'.*{name}") as refused:
        wd.Tool.from_mesh("x", tmp_path / name)
    assert "\n" not in str(refused.value)
    assert capfd.readouterr() == ("", "")
    with pytest.raises(wd.InputError, match="no CAD file"):
        wd.Tool.from_mesh("x", tmp_path / f"none_{name}")


def test_a_file_without_its_unit_is_refused(ball, tmp_path):
    path = write(ball, tmp_path / "ball.igs")
    text = path.read_text("latin-1")
    assert ",2,2HMM," in text.replace("\n", "")
    path.write_text(text.replace(",2,2HMM,", ",3,2HXX,"), "latin-1")
    with pytest.raises(wd.InputError, match="states no unit of length"):
        read_cad("tool", path)


def test_without_the_library_the_remedy_is_said(monkeypatch):
    for name in [name for name in sys.modules if name.split(".")[0] == "OCP"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "OCP", None)
    with pytest.raises(wd.InputError, match=r"pip install 'warpdrape\[cad\]', or save the body"):
        wd.Tool.from_mesh("mould", TRAY)


def test_a_pole_without_a_normal_of_its_own_takes_that_of_its_facets(tmp_path):
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeCone

    path = write(BRepPrimAPI_MakeCone(20.0, 0.0, 20.0).Shape(), tmp_path / "cone.step")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = read_cad("tool", path)
    assert np.isfinite(found.normals).all()
    np.testing.assert_allclose(np.linalg.norm(found.normals, axis=2), 1.0, atol=1e-9)
    assert cad_file.FACET_ANGLE < 0.5
