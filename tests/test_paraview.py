"""Exports for ParaView, read back by its own interpreter where there is one."""

import shutil
import subprocess

import numpy as np
import pytest

import warpdrape as wd
from warpdrape.exports.export import export
from warpdrape.results.fields import fields_of

PVPYTHON = shutil.which("pvpython")
READS = """
import sys
import numpy as np
from paraview.servermanager import Fetch
from paraview.simple import OpenDataFile
from vtk.util.numpy_support import vtk_to_numpy


def leaves(blocks):
    if not blocks.IsA("vtkMultiBlockDataSet"):
        return [blocks]
    inside = map(blocks.GetBlock, range(blocks.GetNumberOfBlocks()))
    return [leaf for each in inside if each for leaf in leaves(each)]


reader, found = OpenDataFile(sys.argv[1]), {}
for frame, time in enumerate(reader.TimestepValues):
    reader.UpdatePipeline(time)
    found[f"{frame} time"] = time
    for part, mesh in enumerate(leaves(Fetch(reader))):
        found[f"{frame} {part} points"] = vtk_to_numpy(mesh.GetPoints().GetData())
        corners = vtk_to_numpy(mesh.GetPolys().GetConnectivityArray())
        found[f"{frame} {part} triangles"] = corners.reshape(-1, 3)
        for data in (mesh.GetPointData(), mesh.GetCellData()):
            for k in range(data.GetNumberOfArrays()):
                array = data.GetArray(k)
                found[f"{frame} {part} field {array.GetName()}"] = vtk_to_numpy(array)
np.savez(sys.argv[2], **found)
"""


def in_paraview(file, folder):
    """What ParaView has of a file, by frame, part and name."""
    script, out = folder / "reads.py", folder / "read.npz"
    script.write_text(READS, encoding="utf-8")
    run = [PVPYTHON, str(script), str(file), str(out)]
    done = subprocess.run(run, capture_output=True, text=True)
    assert out.is_file(), done.stderr[-2000:]
    with np.load(out) as arrays:
        return dict(arrays)


@pytest.mark.skipif(PVPYTHON is None, reason="needs ParaView")
def test_paraview_reads_the_numbers_of_the_run(pressed, tmp_path):
    pytest.importorskip("pyvista")
    found = in_paraview(export(pressed[1], "vtk", tmp_path / "film.pvd"), tmp_path)
    frames = len(pressed[0].history["time_s"])
    assert sum(name.endswith(" time") for name in found) == frames == 5
    for frame in range(frames):
        result = wd.read_run(pressed[1], frame=frame)
        assert found[f"{frame} time"] == result.time_s
        for part, ply in enumerate(result.plies):
            at = f"{frame} {part}"
            np.testing.assert_allclose(found[f"{at} points"], ply.points, rtol=0, atol=1e-8)
            np.testing.assert_array_equal(found[f"{at} triangles"], ply.triangles)
            fields = {field.column: values for field, values in fields_of(ply).items()}
            assert len(fields) > 12
            names = {name for name in found if name.startswith(f"{at} field ")}
            assert {f"{at} field {name}" for name in fields} <= names
            for name, values in fields.items():
                read = found[f"{at} field {name}"]
                np.testing.assert_allclose(read, values, rtol=1e-6, atol=1e-12, err_msg=name)
