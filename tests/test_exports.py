"""Exports, each read back by another hand than wrote it."""

import base64
import re
import shutil
import struct
import sys
import zlib
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import trimesh
from flat_plies import flat_ply

import warpdrape as wd
from warpdrape import cli
from warpdrape.exports.export import export
from warpdrape.exports.formats import FORMATS
from warpdrape.exports.pattern import patterns_of
from warpdrape.exports.vtkhdf import _arrays
from warpdrape.results.fields import fields_of
from warpdrape.results.run_folder import RunFolder

SINGLE = {"rtol": 1e-6, "atol": 1e-12}


# VTK


def vtp(path):
    """Number arrays of a .vtp by place and name: inline base64 of zlib blocks."""
    root = ElementTree.parse(path).getroot()
    assert root.get("compressor") == "vtkZLibDataCompressor"
    kinds = {"Float64": "f8", "Float32": "f4", "Int64": "i8", "Int32": "i4", "UInt8": "u1"}
    word = {"UInt32": "I", "UInt64": "Q"}[root.get("header_type")]
    found = {}
    for place in root.iter():
        for array in place.findall("DataArray"):
            text, size = "".join(array.text.split()), struct.calcsize(word)
            head = 4 * -(-3 * size // 3)
            (blocks,) = struct.unpack(word, base64.b64decode(text[:head])[:size])
            head = 4 * -(-(3 + blocks) * size // 3)
            sizes = struct.unpack(f"{3 + blocks}{word}", base64.b64decode(text[:head]))[3:]
            data, raw, at = base64.b64decode(text[head:]), b"", 0
            for length in sizes:
                raw += zlib.decompress(data[at : at + length])
                at += length
            values = np.frombuffer(raw, kinds[array.get("type")])
            width = int(array.get("NumberOfComponents", 1))
            found[place.tag, array.get("Name")] = values.reshape(-1, width).squeeze()
    return found


def listed(path):
    """Times, names and files of a .pvd."""
    entries = ElementTree.parse(path).getroot().findall("Collection/DataSet")
    times = [float(entry.get("timestep")) for entry in entries]
    return times, *([entry.get(key) for entry in entries] for key in ("name", "file"))


def test_vtk_lists_every_ply_and_tool_at_every_frame(pressed, tmp_path):
    pytest.importorskip("pyvista")
    result, folder = pressed
    out = export(folder, "vtk", tmp_path / "a" / "film.pvd")
    times, names, files = listed(out)
    assert times == np.repeat(result.history["time_s"], 3).tolist()
    assert names == 5 * ["ply_0", "ply_1", "ply_2"]
    tool_times, tools, tool_files = listed(out.with_name("film_tools.pvd"))
    assert tool_times == times and tools == 5 * ["punch", "die", "holder"]
    assert len(set(tool_files[0::3])) == 5
    assert len(set(tool_files[1::3])) == 1  # stands still
    for frame in (2, 4):
        read = wd.read_run(folder, frame=frame)
        for k, ply in enumerate(read.plies):
            arrays = vtp(out.parent / files[3 * frame + k])
            np.testing.assert_array_equal(arrays["Points", "Points"], ply.points)
            corners = arrays["Polys", "connectivity"].reshape(-1, 3)
            np.testing.assert_array_equal(corners, ply.triangles)
            np.testing.assert_array_equal(arrays["PointData", "rest_points_m"], ply.rest_points)
            for field, values in fields_of(ply).items():
                place = "PointData" if field.at_vertices else "CellData"
                np.testing.assert_array_equal(arrays[place, field.column], values)
        punch = vtp(out.parent / tool_files[3 * frame])
        np.testing.assert_array_equal(punch["Points", "Points"], read.tools[0].vertices)
    assert not list(out.parent.glob(".*"))


def test_vtkhdf_moves_with_time_in_another_library(pressed, tmp_path):
    vtk = pytest.importorskip("vtk")
    pytest.importorskip("h5py")
    from vtk.util.numpy_support import vtk_to_numpy

    result, folder = pressed
    out = export(folder, "vtkhdf", tmp_path / "film.vtkhdf")
    reader = vtk.vtkHDFReader()
    reader.SetFileName(str(out))
    reader.UpdateInformation()
    times = reader.GetOutputInformation(0).Get(vtk.vtkStreamingDemandDrivenPipeline.TIME_STEPS())
    np.testing.assert_array_equal(times, result.history["time_s"])
    for frame in (0, 3, 4):
        reader.UpdateTimeStep(times[frame])
        surface, plies = reader.GetOutput(), wd.read_run(folder, frame=frame).plies
        points = np.concatenate([ply.points for ply in plies])
        np.testing.assert_allclose(vtk_to_numpy(surface.GetPoints().GetData()), points, **SINGLE)
        assert surface.GetNumberOfCells() == 3 * 144
        number = vtk_to_numpy(surface.GetCellData().GetArray("ply"))
        assert number.tolist() == np.repeat([0, 1, 2], 144).tolist()
        corners = vtk_to_numpy(surface.GetPolys().GetConnectivityArray()).reshape(-1, 3)
        np.testing.assert_array_equal(corners[144:288] - len(plies[0].points), plies[1].triangles)
        for field in fields_of(plies[0]):
            data = surface.GetPointData() if field.at_vertices else surface.GetCellData()
            values = np.concatenate([fields_of(ply)[field] for ply in plies])
            read = vtk_to_numpy(data.GetArray(field.column))
            np.testing.assert_allclose(read, values, **SINGLE, err_msg=field.name)


def test_a_ply_without_a_quantity_has_nan_beside_others(pressed):
    low, high = pressed[0].plies[:2]
    arrays = _arrays([replace(low, curvature=None), high])
    values = arrays["PointData/weft_curvature_per_m"]
    assert np.isnan(values[: len(low.points)]).all()
    np.testing.assert_array_equal(values[len(low.points) :], high.curvature[:, 1])


# patterns


def area_of(loop):
    x, y = np.asarray(loop, float).T
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


def test_dxf_has_the_blanks_in_millimetres_with_their_axes(pressed, tmp_path):
    pytest.importorskip("ezdxf")
    drawing = trimesh.load_path(export(pressed[1], "dxf", tmp_path / "p.dxf"))
    assert drawing.units == "millimeters"
    of = {str(entity.layer): drawing.vertices[entity.points] for entity in drawing.entities}
    for k in range(3):
        assert abs(area_of(of[f"BLANK_PLY_{k}".upper()][:-1])) == pytest.approx(9e4, rel=1e-6)
        axes = [of[f"{family}_PLY_{k}"] for family in ("WARP", "WEFT")]
        x, y = axes[0][1] - axes[0][0]
        assert np.degrees(np.arctan2(y, x)) % 180.0 == pytest.approx((45, 0, 45)[k], abs=1e-3)
        assert (axes[0][1] - axes[0][0]) @ (axes[1][1] - axes[1][0]) == pytest.approx(0, abs=0.1)


def test_svg_has_them_side_by_side(pressed, tmp_path):
    out = export(pressed[1], "svg", tmp_path / "p.svg")
    svg = "{http://www.w3.org/2000/svg}"
    root = ElementTree.parse(out).getroot()
    low = -1.0
    for group, name in zip(root.findall(f"{svg}g"), ("ply_0", "ply_1", "ply_2"), strict=True):
        assert group.get("id") == name
        text = group.find(f"{svg}polygon").get("points")
        loop = [[float(x) for x in pair.split(",")] for pair in text.split()]
        assert abs(area_of(loop)) == pytest.approx(9e4) and len(loop) == 4
        left = min(x for x, _ in loop)
        assert left > low
        low = max(x for x, _ in loop)
    assert re.fullmatch(r"[\d.]+mm", root.get("width"))


def test_outlines_keep_corners_holes_and_curves_and_nothing_else():
    hole = [(-0.02, -0.02), (0.03, -0.02), (0.03, 0.01), (-0.02, 0.01)]
    frame = [(-0.1, -0.1), (0.1, -0.1), (0.1, 0.05), (0.0, 0.1), (-0.1, 0.05)]
    ply = wd.Ply.polygon("p", "carbon_interlock", frame, holes=[hole], edge=0.012, mesh="random")
    (pattern,) = patterns_of([flat_ply(ply.rest_points, ply.mesh.triangles, 30.0, 120.0)])
    outer, inner = sorted(pattern.loops, key=len, reverse=True)
    assert len(outer) == 5 and len(inner) == 4
    assert area_of(outer) == pytest.approx(1e6 * (0.2 * 0.15 + 0.5 * 0.2 * 0.05))
    assert area_of(inner) == pytest.approx(-1e6 * 0.05 * 0.03)
    assert pattern.angle == pytest.approx(30.0, abs=1e-3)
    disc = wd.Ply.disc("d", "carbon_interlock", 0.1, edge=0.003, mesh="random")
    (pattern,) = patterns_of([flat_ply(disc.rest_points, disc.mesh.triangles)])
    assert area_of(pattern.loops[0]) == pytest.approx(1e6 * disc.mesh.areas.sum(), rel=1e-6)


# what all have in common


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"to": "vkt"}, "unknown format 'vkt'; did you mean 'vtk'? known: csv, dxf, dyna, inp, "),
        ({"to": "Abaqus"}, "unknown format 'Abaqus': for it take inp"),
        ({"to": "ls-dyna"}, "unknown format 'ls-dyna': for it take dyna"),
        ({"to": ".bdf"}, "unknown format '.bdf': for it take nastran"),
        ({"to": "paraview"}, "unknown format 'paraview': for it take vtk or vtkhdf"),
        ({"to": "csv", "frame": 5}, "frame = 5 is out of range: the run has frames 0 to 4"),
        ({"to": "csv", "frame": "last"}, "must be a whole number, or 'all'"),
        ({"to": "inp", "frame": "all"}, "the format 'inp' holds one frame"),
        ({"to": "csv", "out": "x.txt"}, "must end in .csv"),
        ({"to": "csv", "out": "there.csv"}, "exists: give --overwrite"),
        ({"to": "csv", "out": "there.csv/x.csv"}, "cannot be written"),
    ],
)
def test_what_cannot_be_exported_is_refused(given, words, pressed, tmp_path):
    (tmp_path / "there.csv").write_text("mine")
    given = {"out": "a.csv"} | given
    with pytest.raises(wd.InputError) as refused:
        export(pressed[1], **given | {"out": tmp_path / given["out"]})
    assert words in str(refused.value)
    assert [f.name for f in tmp_path.iterdir()] == ["there.csv"]
    assert (tmp_path / "there.csv").read_text() == "mine"


@pytest.mark.parametrize(
    ("to", "package", "extra"),
    [
        ("vtk", "pyvista", "vtk"),
        ("vtkhdf", "h5py", "vtk"),
        ("parquet", "pyarrow.parquet", "tables"),
        ("dxf", "ezdxf", "dxf"),
    ],
)
def test_a_missing_package_is_named_with_its_extra(
    to, package, extra, pressed, tmp_path, monkeypatch
):
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(wd.InputError, match=rf"pip install 'warpdrape\[{extra}\]'"):
        export(pressed[1], to, tmp_path / FORMATS[to].file)
    assert list(tmp_path.iterdir()) == []


def test_the_command_writes_into_the_run_folder(pressed, tmp_path, capsys):
    run = shutil.copytree(pressed[1], tmp_path / "run")
    assert cli.main(["export", str(run), "--to", "csv", "--frame", "-2"]) == 0
    written = run / "export" / "triangles.csv"
    assert capsys.readouterr().out == f"{written}\n"
    assert written.read_text("utf-8").splitlines()[1].startswith("3,")
    assert cli.main(["export", str(run), "--to", "csv"]) == 2
    assert cli.main(["export", str(run), "--to", "csv", "--overwrite"]) == 0
    assert written.read_text("utf-8").splitlines()[1].startswith("4,")
    assert cli.main(["export", str(run), "--to", "csv", "--frame", "x", "--overwrite"]) == 2
    assert "--frame x must be a whole number" in capsys.readouterr().err
    assert wd.read_run(run).completed  # the run is as it was
    assert [f for f in Path(run, "export").iterdir()] == [written]
    kept = {}
    for text, number in (
        (written.read_text("utf-8"), ""),
        ("another run's", "_2"),
        ("third", "_3"),
    ):
        aside = run / f"export_of_the_run_before{number}"
        with pytest.warns(UserWarning, match=f"exports of the run before are in {aside} now"):
            RunFolder(run, overwrite=True).begin()
        kept[aside] = text
        assert not (run / "export").exists()
        for place, was in kept.items():  # nothing is lost, however often
            assert [f.name for f in place.iterdir()] == ["triangles.csv"]
            assert (place / "triangles.csv").read_text("utf-8") == was
        (run / "summary.json").write_text("{}")
        (run / "export").mkdir()
        written.write_text("another run's" if not number else "third")
