"""Fields mapped to a structural mesh, against fields that are known everywhere."""

import csv
import warnings
from dataclasses import replace

import numpy as np
import pytest
from flat_plies import flat_ply
from test_exports import vtp

import warpdrape as wd
from warpdrape import cli
from warpdrape.exports.export import export
from warpdrape.exports.mapped import on_mesh
from warpdrape.exports.user_mesh import read_mesh

pyvista = pytest.importorskip("pyvista")
RADIUS, EDGE, WARP_DEG = 0.1, 5e-3, 25.0


@pytest.fixture(scope="module")
def rolled():
    """A sheet on a cylinder along y; its thickness is linear in the angle, its slip in y."""
    flat = wd.Ply.rectangle("p", "carbon_interlock", 0.24, 0.16, edge=EDGE, mesh="random")
    s, y, _ = flat.rest_points.T
    points = RADIUS * np.stack([np.sin(s / RADIUS), y / RADIUS, np.cos(s / RADIUS)], axis=1)
    middle = flat.rest_points[flat.mesh.triangles].mean(axis=1)
    ply = flat_ply(flat.rest_points, flat.mesh.triangles)
    warp, weft = (along(middle[:, 0] / RADIUS, WARP_DEG + turn) for turn in (0.0, 70.0))
    slip = np.stack([0 * y, y, 0 * y], axis=1)
    thickness = 5e-4 + 1e-3 * middle[:, 0] / RADIUS
    return replace(ply, points=points, warp=warp, weft=weft, thickness=thickness, slip=slip)


def along(theta, degrees):
    """A direction on the cylinder, at an angle from its circumference towards y."""
    a = np.radians(degrees)
    return np.stack(
        [np.cos(a) * np.cos(theta), np.sin(a) + 0 * theta, -np.cos(a) * np.sin(theta)], axis=1
    )


def shells(radius, kinds="both", width=1.0, count=24):
    """A structural mesh round the same axis: quadrilaterals, half of them cut in two triangles."""
    theta, y = np.linspace(-width, width, count + 1), np.linspace(-0.07, 0.07, 11)
    t, v = (grid.ravel() for grid in np.meshgrid(theta, y, indexing="ij"))
    points = np.stack([radius * np.sin(t), v, radius * np.cos(t)], axis=1)
    cells = []
    for i in range(count):
        for j in range(10):
            a, d = i * 11 + j, i * 11 + j + 1
            b, c = a + 11, d + 11
            whole = kinds == "quads" or (kinds == "both" and i % 2)
            cells += [[a, b, c, d]] if whole else [[a, b, c], [a, c, d]]
    faces = np.concatenate([[len(cell), *cell] for cell in cells])
    return pyvista.PolyData(points, faces), [points[cell].mean(axis=0) for cell in cells]


@pytest.mark.parametrize("radius", [RADIUS - 2e-3, RADIUS, RADIUS + 3e-3])
def test_a_manufactured_field_comes_across(rolled, radius, tmp_path):
    mesh, centers = shells(radius)
    mesh.save(tmp_path / "m.vtp")
    read = read_mesh(tmp_path / "m.vtp")
    found = on_mesh(rolled, read, 6e-3)
    theta, y = np.arctan2(*np.array(centers)[:, [0, 2]].T), np.array(centers)[:, 1]
    assert (found["triangle"] >= 0).all()
    # a triangle's middle lies up to an edge from where the line meets it
    np.testing.assert_allclose(found["thickness_m"], 5e-4 + 1e-3 * theta, atol=1e-3 * EDGE / RADIUS)
    np.testing.assert_allclose(found["slip_m"][:, 1], y, atol=EDGE)
    # both surfaces are of chords: ply 5²/8R = 0.03 mm, mesh 8.3²/8R = 0.09 mm inside their arcs
    np.testing.assert_allclose(found["way_m"], RADIUS - radius, atol=1.5e-4)
    np.testing.assert_allclose(found["warp"], along(theta, WARP_DEG), atol=EDGE / RADIUS)
    assert np.abs((found["warp"] * read.normals).sum(axis=1)).max() < 1e-12  # in its plane
    first = np.abs(along(theta, 0.0) * read.sides).sum(axis=1)
    circumferential = first > 0.99
    assert circumferential.sum() > 200
    for name, angle in (("warp", WARP_DEG), ("weft", WARP_DEG + 70.0)):
        values = found[f"{name}_angle_deg"][circumferential]
        np.testing.assert_allclose(values, angle, atol=0.2)  # chords again


def test_turned_elements_see_the_other_side(rolled, tmp_path):
    mesh, _ = shells(RADIUS + 3e-3)
    turned = mesh.copy()
    turned.faces = np.concatenate([[len(f), *f[::-1]] for f in mesh.irregular_faces])
    for name, each in (("a", mesh), ("b", turned)):
        each.save(tmp_path / f"{name}.vtp")
    up, down = (on_mesh(rolled, read_mesh(tmp_path / f"{n}.vtp"), 6e-3) for n in "ab")
    np.testing.assert_array_equal(up["triangle"], down["triangle"])
    np.testing.assert_allclose(up["way_m"], -down["way_m"], atol=1e-9)
    np.testing.assert_allclose(up["warp"], down["warp"], atol=1e-9)


def test_what_lies_beyond_the_ply_is_empty(rolled, tmp_path):
    mesh, centers = shells(RADIUS, width=1.5)
    mesh.save(tmp_path / "m.vtp")
    found = on_mesh(rolled, read_mesh(tmp_path / "m.vtp"), 6e-3)
    beyond = np.abs(np.arctan2(*np.array(centers)[:, [0, 2]].T)) - 1.2  # [rad], past its edge
    none = found["triangle"] < 0
    assert none[beyond > 0.02].all() and not none[beyond < -0.02].any()
    for name, values in found.items():
        if name != "triangle":
            assert np.isnan(values[none]).all() and np.isfinite(values[~none]).all(), name


def test_a_run_is_mapped_ply_by_ply_and_read_back(pressed, tmp_path, capsys):
    """Onto the run's own middle ply, in millimetres: each shell meets its own triangle."""
    pytest.importorskip("meshio")
    plies = wd.read_run(pressed[1]).plies
    ply = plies[1]
    surface = pyvista.PolyData.from_regular_faces(1e3 * ply.points, ply.triangles)
    surface.save(tmp_path / "m.stl")
    words = ["export", str(pressed[1]), "--to", "mapped", "--onto", str(tmp_path / "m.stl")]
    out = tmp_path / "m.csv"
    assert cli.main([*words, "--set", "unit=1mm", "--out", str(out)]) == 0
    with out.open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [row["ply"] for row in rows[::144]] == ["ply_0", "ply_1", "ply_2"]
    own = rows[144:288]
    assert [int(row["element"]) for row in own] == list(range(1, 145))
    assert [int(row["triangle"]) for row in own] == list(range(144))
    np.testing.assert_allclose([float(row["way_m"]) for row in own], 0.0, atol=1e-7)
    shear = [float(row["shear_angle_deg"]) for row in own]
    np.testing.assert_allclose(shear, ply.shear_angle_deg, rtol=1e-8, atol=1e-9)
    warp = [[float(row[f"warp_{axis}"]) for axis in "xyz"] for row in own]
    np.testing.assert_allclose(warp, ply.warp, atol=1e-5)  # single precision of the .stl
    above = [float(row["way_m"]) for row in rows[288:] if row["way_m"]]
    assert len(above) > 100 and np.median(above) == pytest.approx(6e-4, abs=3e-4)
    assert cli.main([*words, "--out", str(tmp_path / "n.csv")]) == 2
    assert "no ply is met within 10 mm along the normals" in capsys.readouterr().err


def test_the_mesh_is_given_back_with_its_fields(pressed, tmp_path):
    plies = wd.read_run(pressed[1]).plies
    surface = pyvista.PolyData.from_regular_faces(plies[0].points, plies[0].triangles)
    surface.cell_data["mine"] = np.arange(144.0)
    surface.save(tmp_path / "m.vtp")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # of shells beyond an edge
        out = export(pressed[1], "mapped-vtk", tmp_path / "o.vtu", onto=str(tmp_path / "m.vtp"))
    arrays = vtp(out)
    np.testing.assert_array_equal(arrays["CellData", "mine"], np.arange(144.0))
    np.testing.assert_array_equal(
        arrays["CellData", "ply_0_shear_angle_deg"], plies[0].shear_angle_deg
    )
    assert ("CellData", "ply_2_warp") in arrays


def test_meshes_of_solvers_are_read(tmp_path):
    meshio = pytest.importorskip("meshio")
    mesh, centers = shells(RADIUS, "quads")
    cells = mesh.regular_faces
    for name in ("m.inp", "m.msh"):
        meshio.Mesh(mesh.points, [("quad", cells)]).write(tmp_path / name)
    lines = [f"GRID,{k},,{x:.6f},{y:.6f},{z:.6f}" for k, (x, y, z) in enumerate(mesh.points, 1)]
    lines += [f"CQUAD4,{k},1,{a},{b},{c},{d}" for k, (a, b, c, d) in enumerate(cells + 1, 1)]
    (tmp_path / "m.bdf").write_text("\n".join(["BEGIN BULK", *lines, "ENDDATA"]) + "\n")
    for name in ("m.inp", "m.msh", "m.bdf"):
        read = read_mesh(tmp_path / name)
        np.testing.assert_allclose(read.centers, centers, atol=1e-6)
    outwards = np.array(centers) * [1.0, 0.0, 1.0]
    assert (np.abs((read.normals * outwards).sum(axis=1)) > 0.99 * RADIUS).all()


@pytest.mark.parametrize(
    ("name", "words"),
    [
        (None, "needs your mesh: --onto MESH"),
        (3, "onto = 3 must be the name of a file"),
        ("no.stl", "does not exist: give a structural mesh"),
        ("text.stl", "onto = "),
        ("text.inp", "holds no mesh, or nodes that are no finite numbers"),
        ("text.msh", "cannot be read ("),
        ("line.vtp", "has no triangles or quadrilaterals: give a mesh of shells"),
        ("flat.vtp", "element 2 has no area: repair the mesh"),
    ],
)
def test_what_is_no_mesh_of_shells_is_refused(name, words, pressed, tmp_path):
    pytest.importorskip("meshio")
    for text in ("text.stl", "text.inp", "text.msh"):
        (tmp_path / text).write_text("nothing\n")
    points = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (2, 0, 0.0)])
    pyvista.PolyData(points, lines=[2, 0, 1]).save(tmp_path / "line.vtp")
    pyvista.PolyData(points, [3, 0, 1, 2, 3, 0, 1, 3]).save(tmp_path / "flat.vtp")
    onto = name if name in (None, 3) else str(tmp_path / name)
    with pytest.raises(wd.InputError) as refused:
        export(pressed[1], "mapped", tmp_path / "o.csv", onto=onto)
    assert words in str(refused.value)
    assert not (tmp_path / "o.csv").exists()
