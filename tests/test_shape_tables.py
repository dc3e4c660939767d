"""Tables of the benchmark pages: each has its place, and what needs no run is as the scenes say."""

import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from warpdrape import DefectThresholds
from warpdrape.blanks.ply import Ply

ROOT = Path(__file__).parents[1]


@pytest.fixture(scope="module")
def shapes():
    """The modules of the script, for this file only."""
    before = set(sys.modules)
    sys.path.insert(0, str(ROOT / "bench" / "shapes"))
    try:
        import approaches
        import bending
        import dimensions
        import pages
        import press
        import tables
        import wrinkled_meshes as meshes

        yield SimpleNamespace(
            approaches=approaches,
            bending=bending,
            dimensions=dimensions,
            meshes=meshes,
            pages=pages,
            press=press,
            tables=tables,
        )
    finally:
        sys.path.remove(str(ROOT / "bench" / "shapes"))
        for name in set(sys.modules) - before:
            if str(getattr(sys.modules[name], "__file__", "")).startswith(str(ROOT / "bench")):
                del sys.modules[name]


def in_page(shapes, name):
    page = (ROOT / "docs" / shapes.tables.TABLES[name][0]).read_text("utf-8")
    start, end = shapes.pages.marks(name)
    assert page.count(start) == page.count(end) == 1, name
    return page.partition(start)[2].partition(end)[0].strip()


def test_every_table_has_its_place_and_is_written(shapes):
    for name in shapes.tables.TABLES:
        table = in_page(shapes, name)
        assert table.startswith("| ") and table.count("\n") >= 3, name


def test_no_page_has_a_table_that_nothing_makes(shapes):
    for page in (ROOT / "docs").rglob("*.md"):
        for line in page.read_text("utf-8").splitlines():
            if line.startswith("<!-- table "):
                name = line.split()[2].rstrip(":")
                assert shapes.tables.TABLES[name][0] == page.relative_to(ROOT / "docs").as_posix()


def test_dimensions_are_the_scenes_own(shapes):
    for name in shapes.dimensions.SHAPES:
        table = shapes.dimensions.dimensions(name, None)
        assert in_page(shapes, f"{name}_dimensions") == table
    assert "| `slope_deg` | 60° |" in shapes.dimensions.dimensions("tetrahedron", None)
    assert "| `dome_radius` | 50 mm |" in shapes.dimensions.dimensions("double_dome", None)


def test_a_table_is_put_between_its_lines_only(shapes, tmp_path):
    start, end = shapes.pages.marks("some")
    page = tmp_path / "page.md"
    page.write_text(f"before\n{start}\n\n| old |\n\n{end}\nafter\n", "utf-8")
    shapes.pages.written("page.md", "some", "| new \\1 |", tmp_path)
    assert page.read_text("utf-8") == f"before\n{start}\n\n| new \\1 |\n\n{end}\nafter\n"
    assert list(tmp_path.iterdir()) == [page]
    with pytest.raises(SystemExit, match="one place for table other"):
        shapes.pages.written("page.md", "other", "| x |", tmp_path)


def test_an_exponent_is_found_with_its_error(shapes):
    stiffness = np.array([1e-3, 3e-3, 1e-2, 3e-2])
    assert shapes.bending.exponent(stiffness, 0.2 * stiffness**0.25) == "0.25 ± 0.00"
    waves = 0.2 * stiffness**0.25 * np.exp([0.1, -0.1, -0.1, 0.1])
    x = np.log(stiffness)
    design = np.stack([x, np.ones(4)], axis=1)
    fit, *_ = np.linalg.lstsq(design, np.log(waves), rcond=None)
    left = np.log(waves) - design @ fit
    error = np.sqrt(left @ left / 2 * np.linalg.inv(design.T @ design)[0, 0])
    assert shapes.bending.exponent(stiffness, waves) == f"{fit[0]:.2f} ± {error:.2f}"


def test_a_surface_is_measured_alike_on_other_meshes(shapes):
    """Waves of 40 mm and 1 mm on squares of 6.25 mm, carried over to coarser ones."""
    ply = Ply.rectangle("ply", "carbon_interlock", 0.3, cells=48, mesh="grid")
    flat = np.asarray(ply.mesh.vertices)
    height = 1e-3 * np.cos(2.0 * np.pi * flat[:, 0] / 0.04)
    points = np.column_stack([flat, height])
    scene = SimpleNamespace(plies=[ply], tools=[], defects=DefectThresholds())
    formed = SimpleNamespace(rest_points=ply.rest_points, points=points)
    result = SimpleNamespace(plies=[formed], tools=[])
    run = SimpleNamespace(scene=scene, at=lambda _: result)
    for cells, mesh in ((48, "grid"), (40, "grid"), (40, "random")):
        found = shapes.meshes.measured_on(run, cells, mesh).those(resolved=True)
        waves = [wrinkle.wavelength for wrinkle in found]
        assert np.median(waves) == pytest.approx(0.04, rel=0.02), (cells, mesh)
        amplitude = np.median([wrinkle.amplitude for wrinkle in found])
        assert amplitude == pytest.approx(1e-3, rel=0.05), (cells, mesh)


def bowl(cells, mesh, **moved):
    """A ply formed to z = x² + y²/2, every vertex moved by more."""
    ply = Ply.rectangle("ply", "carbon_interlock", 0.3, cells=cells, mesh=mesh)
    flat = np.asarray(ply.mesh.vertices)
    points = np.column_stack([flat, flat[:, 0] ** 2 + 0.5 * flat[:, 1] ** 2])
    points = points + moved.get("by", np.zeros(3))
    triangles = np.asarray(ply.mesh.triangles)
    return ply, SimpleNamespace(rest_points=ply.rest_points, points=points, triangles=triangles)


def test_crossovers_of_bars_are_compared_where_they_lie_on_the_blank(shapes):
    """A translation is its length apart, and what straight triangles leave of a bowl is h² ψ."""
    tables = shapes.approaches
    ply, coarse = bowl(6, "grid", by=np.array([3e-3, 0.0, 4e-3]))
    places = tables.crossovers(SimpleNamespace(scene=SimpleNamespace(plies=[ply])))
    assert len(places) == 49  # the corners of squares, not their middles
    _, same = bowl(12, "grid")
    assert tables.apart(coarse, places, same) == pytest.approx(5e-3, rel=1e-9)
    _, exact = bowl(6, "grid")
    off = [tables.apart(exact, places, bowl(cells, "random")[1]) for cells in (10, 20, 40)]
    assert tables.rate((10, 20, 40), off) == pytest.approx(2.0, abs=0.3)


def test_two_plies_of_one_mesh_are_compared_triangle_by_triangle(shapes):
    shear, points = np.linspace(-40.0, 40.0, 101), np.zeros((7, 3))
    moved, other = points.copy(), shear.copy()
    moved[3] = [2e-3, 1e-3, 2e-3]
    other[50] += 0.7
    one = SimpleNamespace(shear_angle_deg=shear, points=points)
    two = SimpleNamespace(shear_angle_deg=other, points=moved)
    most, nearly, way = shapes.approaches.off_the_other(one, two)
    assert (most, nearly, way) == (pytest.approx(0.7), pytest.approx(0.0), pytest.approx(3e-3))


def test_room_under_a_ply_is_that_between_its_face_and_the_nearest_tool(shapes):
    """Half a ply stands 3 mm off a plate and 5 mm under another, half lies on it: no room there."""
    ply = Ply.rectangle("ply", "carbon_interlock", 0.2, cells=8, mesh="grid")
    flat = np.asarray(ply.mesh.vertices)
    half = 0.5 * ply.fabric.thickness
    height = half + 3e-3 * np.clip(1.0 + flat[:, 0] / 0.025, 0.0, 1.0)
    formed = SimpleNamespace(
        points=np.column_stack([flat, height]), triangles=np.asarray(ply.mesh.triangles)
    )
    square = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    plates = [
        SimpleNamespace(
            vertices=np.column_stack([square, np.full(4, z)]),
            triangles=np.array([[0, 1, 2], [0, 2, 3]]),
        )
        for z in (0.0, 3e-3 + 2.0 * half + 5e-3)
    ]
    result = SimpleNamespace(plies=[formed], tools=plates)
    room, most = shapes.press.off_the_tools(result, ply.fabric.thickness)
    step = np.hypot(0.025, 3e-3) / 0.025  # of the row of squares that rises
    exact = 3e-3 * (0.1 * 0.2 + 0.5 * 0.025 * 0.2 * step)
    assert room == pytest.approx(exact, rel=1e-9)
    assert most == pytest.approx(3e-3, rel=1e-9)
