"""What a person sees in a notebook: short words, a table, pictures; and the example runs."""

import base64
import io
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from matplotlib import image

import warpdrape as wd
from warpdrape import laws
from warpdrape.materials.fabric_library import fabric_names, load_fabric
from warpdrape.units import deg, kN, ms

ROOT = Path(__file__).parents[1]
EXAMPLE = ROOT / "examples" / "forming.ipynb"
STRIP = wd.Ply.rectangle("strip", "carbon_interlock", 0.3, 0.2, cells=6, warp_angle=30 * deg, z=0.1)
ROWS = np.linspace(0.0, 0.3, 50)


@pytest.mark.parametrize(
    ("thing", "words"),
    [
        (STRIP, "Ply 'strip': 300 × 200 mm, 49 vertices, 76 triangles, warp at 30°, z 100 mm, "),
        (STRIP.mesh, "FlatMesh: 300 × 200 mm, "),
        (STRIP.fabric, "Fabric 'carbon_interlock': 630 g/m², 0.6 mm thick, unit cell "),
        (wd.Tool.punch(radius=0.075), "Tool 'punch': 150 × 150 × "),
        (wd.Stroke(travel=(0, 0, -0.06), duration=0.04), "Stroke: travel (0, 0, -60) mm, duratio"),
        (wd.Float(force=100.0, ramp=5 * ms), "Float: force 100 N, axis (0, 0, -1), ramp 5 ms, dam"),
        (wd.Still(), "Still"),
        (
            wd.Path(times=ROWS, positions=[(0, 0, x) for x in ROWS]),
            "Path: times 50 from 0 to 300 ms, positions 50 × 3 from 0 to 300 mm",
        ),
        (wd.Clamp(name="a", ply="b", where=lambda p: p), "Clamp 'a': ply 'b', where a function"),
        (wd.Numerics(), "Numerics"),
        (wd.Numerics(damping=3.0, minimum_time_step=2e-3), "Numerics: damping 3 1/s, minimum_time"),
        (wd.Bending(warp=2e-3, weft=1e-3), "Bending: warp 2 N·mm, weft 1 N·mm, twist 0.1414 N·mm"),
        (
            wd.BendingCurve(curvatures=100 * ROWS, moments_warp=ROWS, moments_weft=ROWS),
            "BendingCurve: curvatures 50 from 0 to 30 1/m, moments_warp 50 from 0 to 0.3 N, ",
        ),
        (
            wd.Compaction(thicknesses=(6e-4, 5e-4, 4e-4), pressures=(0, 1e3, 5e3)),
            "Compaction: thicknesses (0.6, 0.5, 0.4) mm, pressures (0, 1000, 5000) Pa",
        ),
        (laws.LinearTension(30 * kN, 20 * kN), "LinearTension: warp 3e+04 N per unit strain, weft"),
        (
            laws.TabulatedTension(ROWS, ROWS, np.zeros((50, 50)), np.ones((50, 50))),
            "TabulatedTension: strain_warp 50 from 0 to 0.3, strain_weft 50 from 0 to 0.3, tension",
        ),
        (laws.NoShear(), "NoShear"),
        (laws.ShearPolynomial((1e-4,)), "ShearPolynomial: coefficients (0.0001) N·m per cell"),
        (laws.ShearTable(ROWS, ROWS), "ShearTable: angles 50 from 0 to 17.19°, couples 50 from 0 "),
        (laws.IsotropicMembrane(1e4), "IsotropicMembrane: stiffness 1e+04 N/m"),
    ],
)
def test_things_show_themselves_in_a_line(thing, words):
    assert repr(thing).startswith(words)
    assert "\n" not in repr(thing) and len(repr(thing)) < 250


@pytest.mark.parametrize("name", fabric_names())
def test_every_fabric_and_its_laws_are_short(name):
    fabric = load_fabric(name)
    for thing in (fabric, fabric.tension, fabric.shear, fabric.bending, fabric.compaction):
        assert len(repr(thing)) < 250


def test_a_scene_lists_what_is_in_it_and_not_more_than_a_dozen():
    plies = wd.lay_up([wd.Ply.disc(f"p{k}", "carbon_interlock", 0.1, cells=4) for k in range(20)])
    few = wd.Scene(name="few", plies=plies[:2], tools=[wd.Tool.table(radius=0.1)], duration=0.01)
    lines = repr(few).splitlines()
    assert lines[0] == "Scene 'few': 10 ms" and len(lines) == 4
    assert lines[1].startswith("  Ply 'p0': ") and lines[3].startswith("  Tool 'table': ")
    many = repr(wd.Scene(name="many", plies=plies, duration=0.01)).splitlines()
    assert len(many) == 13 and many[-1] == "  … and 9 more"


def test_a_result_shows_how_it_ended_and_its_plies(pressed):
    result, _ = pressed
    first, *rest = repr(result).splitlines()
    assert re.match(r"Result: Completed: 12 ms simulated \([\d,]+ steps, 432 triangles", first)
    assert rest[0] == f"  ply_0: 144 triangles, shear up to {result.plies[0].max_shear_deg:.1f}°"
    assert len(rest) == 3
    assert len(repr(result.plies[0])) < 250 and "tool_pressure" in repr(result.plies[0])
    assert repr(result.tools[0]).startswith("PlacedTool 'punch': 150 × 150 × ")


def test_a_result_that_failed_shows_why(pressed):
    result, _ = pressed
    summary = dict(result.summary) | {"status": "failed", "message": "blew up <there>"}
    failed = wd.Result(result.plies, summary, result.history)
    assert repr(failed).splitlines()[1] == "  blew up <there>"
    assert "blew up &lt;there&gt;" in failed._repr_html_()


def test_the_table_and_the_picture_of_a_result(pressed):
    result, folder = pressed
    page = result._repr_html_()
    for entry in result.summary["plies"]:
        assert f"<td>{entry['name']}</td><td>{entry['max_shear_deg']:.1f}°</td>" in page
    assert page.count("<tr>") == 1 + 3 + 1 + 3  # plies and tools, with their heads
    assert "Warning: not quasi-static" in page and "Tables:" not in page
    flat = wd.read_run(folder, frame=2)._repr_html_()
    assert (
        f"<p>Tables: at the end. Picture: at {1e3 * result.history['time_s'][2]:.4g} ms.</p>"
        in flat
    )
    (data,) = re.findall(r'src="data:image/png;base64,([^"]+)"', page)
    pixels = image.imread(io.BytesIO(base64.b64decode(data)))
    assert pixels.shape[1] == 800 and len(np.unique(pixels[..., :3].reshape(-1, 3), axis=0)) > 500


def test_curves_are_those_of_the_history(pressed):
    result, _ = pressed
    figure = result.plot()
    forces, shear, energies = figure.axes
    assert [line.get_label() for line in forces.lines] == ["punch", "die", "holder"]
    np.testing.assert_array_equal(forces.lines[0].get_ydata(), result.history["punch_force_n"])
    np.testing.assert_allclose(shear.lines[2].get_xdata(), 1e3 * result.history["time_s"])
    np.testing.assert_array_equal(shear.lines[2].get_ydata(), result.history["ply_2_max_shear_deg"])
    assert "[J]" in energies.get_ylabel() and "[ms]" in energies.get_xlabel()
    assert figure._repr_png_().startswith(b"\x89PNG")


def test_pictures_of_other_fields_and_of_one_ply(pressed):
    result, folder = pressed
    titles = [text.get_text() for text in result.picture("slip", ply="ply_1").texts]
    assert titles[0] == "ply_1" and titles[1].startswith("slip up to ")
    read = [text.get_text() for text in wd.read_run(folder).picture("slip", ply="ply_1").texts]
    assert read[1] == titles[1]
    for field, ply, words in (("slop", None, "did you mean 'slip'"), ("slip", "x", "unknown ply")):
        with pytest.raises(wd.InputError, match=words):
            result.picture(field, ply)


def test_pyvista_has_plies_and_tools_with_their_fields(pressed):
    pytest.importorskip("pyvista")
    result, _ = pressed
    found = result.to_pyvista()
    assert found.keys() == ["ply_0", "ply_1", "ply_2", "punch", "die", "holder"]
    ply, mesh = result.plies[1], found["ply_1"]
    np.testing.assert_array_equal(mesh.points, ply.points)
    np.testing.assert_array_equal(mesh.regular_faces, ply.triangles)
    np.testing.assert_array_equal(mesh.cell_data["shear_angle_deg"], ply.shear_angle_deg)
    np.testing.assert_array_equal(mesh.cell_data["weft_tension_n_per_m"], ply.line_tension[:, 1])
    np.testing.assert_array_equal(mesh.cell_data["warp"], ply.warp)
    np.testing.assert_array_equal(mesh.point_data["slip_m"], ply.slip)
    np.testing.assert_array_equal(mesh.point_data["tool_pressure_pa"], ply.tool_pressure)
    np.testing.assert_array_equal(found["punch"].points, result.tools[0].vertices)
    flat = np.linalg.norm(
        np.cross(
            *(ply.points[ply.triangles[:, k]] - ply.points[ply.triangles[:, 0]] for k in (1, 2))
        ),
        axis=1,
    )
    assert mesh.area == pytest.approx(0.5 * flat.sum(), rel=1e-9)


def test_without_pyvista_the_extra_is_named(pressed, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyvista", None)
    with pytest.raises(wd.InputError, match=r"pip install 'warpdrape\[vtk\]'"):
        pressed[0].to_pyvista()


def test_the_first_run_in_a_process_says_nothing():
    code = """
import warpdrape as wd
ply = wd.Ply.rectangle("p", "carbon_interlock", 0.1, cells=2)
wd.Scene(name="s", plies=[ply], tools=[wd.Tool.table(radius=0.1).moved((0, 0, -0.01))],
         duration=1e-4).run(frames=1)
"""
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT)
    assert (ended.returncode, ended.stdout, ended.stderr) == (0, "", "")


def test_the_example_runs_and_shows_its_results_in_few_words(tmp_path, monkeypatch):
    nbformat, nbclient = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")
    notebook = nbformat.read(EXAMPLE, as_version=4)
    assert all(not cell.get("outputs") for cell in notebook.cells)  # no output is kept in it
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(p for p in sys.path if p))
    options = {"timeout": 120, "resources": {"metadata": {"path": str(tmp_path)}}}
    nbclient.NotebookClient(notebook, kernel_name="python3", **options).execute()
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", ())]
    assert [o for o in outputs if o.get("name") == "stderr"] == []
    texts = [o["data"]["text/plain"] for o in outputs if "data" in o]
    assert all(len(text) < 1500 for text in texts) and len(texts) == 6
    assert sum("image/png" in o.get("data", {}) for o in outputs) == 2
    assert sum("<table>" in o.get("data", {}).get("text/html", "") for o in outputs) == 2
    (said,) = [o["text"] for o in outputs if o.get("name") == "stdout"]
    assert 10.0 < float(re.search(r"largest shear angle (\d+\.\d)°", said)[1]) < 30.0
    assert not any("Warning" in o.get("data", {}).get("text/html", "") for o in outputs)
    assert (tmp_path / "runs" / "notebook" / "scene.usdc").is_file()
