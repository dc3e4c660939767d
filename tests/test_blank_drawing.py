"""Blanks from DXF drawings: closed curves, gaps, holes, units, layers."""

import math
import warnings
from pathlib import Path

import numpy as np
import pytest

import warpdrape as wd
from warpdrape.blanks.drawn import read_outline
from warpdrape.units import mm

ezdxf = pytest.importorskip("ezdxf")
BLANK = Path(__file__).parents[1] / "examples" / "tutorial" / "tray_blank.dxf"
SQUARE = [(0, 0), (100, 0), (100, 60), (0, 60)]


@pytest.fixture
def draw(tmp_path):
    """Write a drawing: ``draw(function of its space)`` gives the file."""

    def write(entities, units=4, name="blank.dxf"):
        drawing = ezdxf.new("R2010", units=units)
        entities(drawing.modelspace())
        drawing.saveas(tmp_path / name)
        return tmp_path / name

    return write


def lines(space, corners, layer="0", gap=0.0):
    for k, start in enumerate(corners):
        end = np.array(corners[(k + 1) % len(corners)], float)
        back = end - np.array(start)
        space.add_line(start, end - gap * back / np.linalg.norm(back), dxfattribs={"layer": layer})


def test_the_tutorial_s_blank_has_its_area_and_loses_its_small_hole_with_a_word():
    outline = read_outline(BLANK)
    exact = 0.2 * 0.16 - (4.0 - math.pi) * 0.01**2 - math.pi * 2.5e-3**2
    assert outline.area == pytest.approx(exact, rel=2e-6)
    assert (outline.unit, outline.states_unit) == ("mm", True) and outline.welded < 1e-12
    with pytest.warns(UserWarning, match=r"narrower .* 8 mm are left out: 5 mm at \(12, 12\) mm"):
        ply = wd.Ply.from_dxf("ply", "carbon_interlock", BLANK, edge=8 * mm, centre=(0.01, 0.02))
    low, high = ply.mesh.vertices.min(axis=0), ply.mesh.vertices.max(axis=0)
    np.testing.assert_allclose(0.5 * (low + high), (0.01, 0.02), atol=1e-9)
    np.testing.assert_allclose(high - low, (0.2, 0.16), atol=2e-4)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        fine = wd.Ply.from_dxf("ply", "carbon_interlock", BLANK, edge=4 * mm)
    assert _area(fine.mesh) == pytest.approx(exact, rel=2e-3)


def _area(mesh):
    a, b, c = (np.asarray(mesh.vertices)[np.asarray(mesh.triangles)[:, k]] for k in range(3))
    u, v = b - a, c - a
    return 0.5 * np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]).sum()


def test_curves_of_every_kind(draw):
    bulge = math.tan(math.pi / 8.0)  # a quarter of a circle

    def polyline(space):
        points = [
            (10, 0, 0),
            (90, 0, bulge),
            (100, 10, 0),
            (100, 60, 0),
            (0, 60, 0),
            (0, 10, bulge),
        ]
        space.add_lwpolyline(points, format="xyb", close=True)

    rounded = read_outline(draw(polyline))
    assert rounded.area == pytest.approx(0.006 - 2 * (1 - math.pi / 4) * 1e-4, rel=1e-5)
    circle = read_outline(draw(lambda s: s.add_circle((5, 5), 40)))
    assert circle.area == pytest.approx(math.pi * 0.04**2, rel=1e-4)
    ellipse = read_outline(draw(lambda s: s.add_ellipse((0, 0), (50, 0), ratio=0.5)))
    assert ellipse.area == pytest.approx(math.pi * 0.05 * 0.025, rel=1e-4)
    angle = np.radians(np.arange(0, 360, 10))
    ring = [(30 * math.cos(a), 30 * math.sin(a), 0) for a in angle]
    spline = read_outline(draw(lambda s: s.add_spline([*ring, ring[0]])))
    assert spline.area == pytest.approx(math.pi * 0.03**2, rel=1e-3)


def test_a_blank_of_straight_sides_is_meshed_to_its_corners(draw):
    outline = read_outline(draw(lambda s: lines(s, SQUARE)))
    (loop,) = outline.loops(7 * mm)
    for corner in np.array(SQUARE) * mm:
        assert np.linalg.norm(loop - corner, axis=1).min() < 1e-12
    sides = np.linalg.norm(np.roll(loop, -1, axis=0) - loop, axis=1)
    assert sides.min() > 6 * mm and sides.max() < 8 * mm
    ply = wd.Ply.from_dxf("p", "carbon_interlock", draw(lambda s: lines(s, SQUARE)), edge=7 * mm)
    assert _area(ply.mesh) == pytest.approx(0.006, rel=1e-9)


def test_a_circle_keeps_its_points_in_each_quarter(draw):
    (loop,) = read_outline(draw(lambda s: s.add_circle((0, 0), 40))).loops(10 * mm)
    assert len(loop) % 4 == 0
    np.testing.assert_allclose(np.linalg.norm(loop, axis=1), 0.04, rtol=1e-4)


def test_gaps_are_welded_up_to_what_is_said(draw):
    near = draw(lambda s: lines(s, SQUARE, gap=0.05))
    outline = read_outline(near)
    assert outline.welded == pytest.approx(0.05 * mm) and outline.area == pytest.approx(
        6e-3, rel=1e-3
    )
    wide = draw(lambda s: lines(s, SQUARE, gap=0.5))
    words = r"ends at \(.*\) mm, and the next end is 0.5 mm away, more than the 0.1 mm that are"
    with pytest.raises(wd.InputError, match=words):
        read_outline(wide)
    assert read_outline(wide, weld=0.6 * mm).welded == pytest.approx(0.5 * mm)


def test_lines_may_run_either_way(draw):
    def mixed(space):
        for k, (start, end) in enumerate(zip(SQUARE, [*SQUARE[1:], SQUARE[0]], strict=True)):
            space.add_line(*((start, end) if k % 2 else (end, start)))

    assert read_outline(draw(mixed)).area == pytest.approx(0.006, rel=1e-12)


def test_what_is_drawn_twice_counts_once_and_blocks_are_opened(draw):
    def twice(space):
        lines(space, SQUARE)
        lines(space, SQUARE[::-1])

    assert read_outline(draw(twice)).area == pytest.approx(0.006)

    def block(space):
        lines(space.doc.blocks.new("BLANK"), SQUARE)
        space.add_blockref("BLANK", (1000, 0))
        space.add_text("a note")

    np.testing.assert_allclose(read_outline(draw(block)).bounds, (1.0, 0.0, 1.1, 0.06), atol=1e-9)


@pytest.mark.parametrize(("units", "factor"), [(1, 25.4e-3), (4, 1e-3), (5, 1e-2), (6, 1.0)])
def test_the_unit_that_a_drawing_states_is_taken(draw, units, factor):
    outline = read_outline(draw(lambda s: s.add_circle((0, 0), 10), units))
    assert outline.bounds[2] == pytest.approx(10 * factor, rel=1e-4)


def test_a_drawing_without_a_unit_needs_one_and_one_with_takes_no_other(draw):
    bare = draw(lambda s: lines(s, SQUARE), 0)
    with pytest.raises(wd.InputError, match=r"states no unit \(\$INSUNITS is 0\): give one of"):
        read_outline(bare)
    outline = read_outline(bare, unit="cm")
    assert outline.bounds[2] == pytest.approx(1.0) and not outline.states_unit
    with pytest.raises(wd.InputError, match="states that it is in mm, not in cm"):
        read_outline(draw(lambda s: lines(s, SQUARE)), unit="cm")
    with pytest.raises(wd.InputError, match="unknown unit 'ell'"):
        read_outline(bare, unit="ell")


def test_layers_and_several_outlines(draw):
    def both(space):
        lines(space, SQUARE, "A")
        lines(space, [(x + 200, y) for x, y in SQUARE], "B")
        space.add_circle((30, 30), 10, dxfattribs={"layer": "A"})

    path = draw(both)
    with pytest.raises(wd.InputError, match=r"2 outlines beside each other.*layers: A, B"):
        read_outline(path)
    assert read_outline(path, layer="A").area == pytest.approx(0.006 - math.pi * 1e-4, rel=1e-4)
    assert read_outline(path, layer="B").bounds[0] == pytest.approx(0.2)
    with pytest.raises(wd.InputError, match="no curve on layer 'C'"):
        read_outline(path, layer="C")


@pytest.mark.parametrize(
    ("entities", "words"),
    [
        (lambda s: None, "holds no closed curve"),
        (lambda s: s.add_line((0, 0), (10, 0)), "a curve ends at"),
        (lambda s: [lines(s, SQUARE), s.add_line((0, 0), (50, 30))], "3 curves meet at|ends at"),
        (lambda s: lines(s, [(0, 0, 0), (9, 0, 0), (9, 9, 5), (0, 9, 5)]), "z varies by 5 mm"),
        (lambda s: lines(s, [(0, 0), (50, 50), (50, 0), (0, 50)]), "meets side"),
    ],
)
def test_what_is_no_outline_is_refused_with_what_is_wrong(draw, entities, words):
    with pytest.raises(wd.InputError, match=words):
        read_outline(draw(entities))


def test_no_drawing_at_all(tmp_path):
    with pytest.raises(wd.InputError, match="does not exist"):
        read_outline(tmp_path / "none.dxf")
    (tmp_path / "a.dxf").write_text("nonsense")
    with pytest.raises(wd.InputError, match=r"a.dxf cannot be read"):
        read_outline(tmp_path / "a.dxf")
