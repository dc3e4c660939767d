"""Flat patterns of trimmed parts, against closed forms of surfaces that unroll or are mapped so."""

import json
from dataclasses import replace

import numpy as np
import pytest
import trimesh
from flat_plies import flat_ply

import warpdrape as wd
from warpdrape import cli
from warpdrape.blanks.loops import loop_area
from warpdrape.exports.cutting import trimmed
from warpdrape.exports.export import export
from warpdrape.exports.on_ply import PlySearch
from warpdrape.exports.outlines import inside
from warpdrape.exports.pattern import patterns_of
from warpdrape.exports.trim import Curves, Side, read_trim
from warpdrape.exports.trim_file import read_curves
from warpdrape.results.result import PlacedTool

RADIUS = 0.1
TOLERANCE = 0.1  # mm; triangles of 5 mm lie 5²/8R = 0.03 mm inside the surface


@pytest.fixture(scope="module")
def rolled():
    """A sheet on a cylinder along y: x is the angle times the radius."""
    flat = wd.Ply.rectangle("p", "carbon_interlock", 0.24, 0.16, edge=5e-3, mesh="random")
    s, y, _ = flat.rest_points.T
    points = RADIUS * np.stack([np.sin(s / RADIUS), y / RADIUS, np.cos(s / RADIUS)], axis=1)
    return replace(flat_ply(flat.rest_points, flat.mesh.triangles, 30.0, 120.0), points=points)


def on_sphere(polar, azimuth, radius=RADIUS):
    sin = np.sin(polar)
    return radius * np.stack([sin * np.cos(azimuth), sin * np.sin(azimuth), np.cos(polar)], axis=-1)


@pytest.fixture(scope="module")
def cap():
    return disc_on_sphere(5e-3)


def disc_on_sphere(edge):
    """A disc on a sphere, its radii laid along meridians at their length."""
    flat = wd.Ply.disc("p", "carbon_interlock", 0.13, edge=edge, mesh="random")
    x, y, _ = flat.rest_points.T
    points = on_sphere(np.hypot(x, y) / RADIUS, np.arctan2(y, x))
    return replace(flat_ply(flat.rest_points, flat.mesh.triangles), points=points)


def small_circle(pole, angle, radius=RADIUS, count=400):
    """A circle on the sphere round a pole at (polar, azimuth), and what it is on the disc [mm]."""
    axis = on_sphere(*pole, 1.0)
    side = np.cross(axis, [0.3, -0.2, 0.9])
    side /= np.linalg.norm(side)
    t = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)[:, None]
    round_it = np.cos(t) * side + np.sin(t) * np.cross(axis, side)
    unit = np.cos(angle) * axis + np.sin(angle) * round_it
    return radius * unit, flat_of(unit)


def flat_of(unit):
    """Where points of the unit sphere lie on the disc [mm]."""
    polar = np.arccos(np.clip(unit[:, 2], -1.0, 1.0))
    along = unit[:, :2] / np.maximum(np.linalg.norm(unit[:, :2], axis=1, keepdims=True), 1e-12)
    return 1e3 * RADIUS * polar[:, None] * along


def distance_to(points, loop):
    """Of points from a closed line, by brute force."""
    a, b = loop[None], np.roll(loop, -1, axis=0)[None]
    p, d = points[:, None], b - a
    share = np.clip(((p - a) * d).sum(-1) / np.maximum((d * d).sum(-1), 1e-300), 0.0, 1.0)
    return np.linalg.norm(p - a - share[..., None] * d, axis=-1).min(axis=1)


def test_a_cylinder_cut_across_is_the_unrolled_curve(rolled):
    (loop,) = trimmed(rolled, read_trim("x+0.5*y<20mm"))
    inner = (np.abs(loop[:, 1]) < 79.99) & (loop[:, 0] > -119.99)
    exact = 1e3 * RADIUS * np.arcsin((0.02 - 0.5e-3 * loop[inner, 1]) / RADIUS)
    assert inner.sum() > 20 and np.abs(loop[inner, 0] - exact).max() < TOLERANCE
    y = np.linspace(-0.08, 0.08, 2001)
    width = 0.12 + RADIUS * np.arcsin((0.02 - 0.5 * y) / RADIUS)
    assert loop_area(loop) == pytest.approx(1e6 * np.trapezoid(width, y), abs=160 * TOLERANCE)
    (other,) = trimmed(rolled, read_trim("x + 0.5*y > 0.02"))
    both = loop_area(loop) + loop_area(other)
    assert both == pytest.approx(240 * 160, abs=1.8)  # 180 mm of cut, 5 µm each


def test_a_sphere_cut_at_a_latitude_is_a_circle(cap):
    (loop,) = trimmed(cap, Side(np.array([0.0, 0.0, -1.0]), -RADIUS * np.cos(0.9)))
    assert np.abs(np.hypot(*loop.T) - 90.0).max() < TOLERANCE
    assert loop_area(loop) == pytest.approx(np.pi * 90.0**2, abs=2 * np.pi * 90 * TOLERANCE)


def test_a_plane_cuts_the_better_the_finer_the_mesh():
    """As the square of the edge; worst points of random meshes scatter, so 1.5 will do."""
    side, errors = Side(np.array([0.0, 0.0, -1.0]), -RADIUS * np.cos(0.9)), []
    for edge in (12e-3, 6e-3, 3e-3):
        (loop,) = trimmed(disc_on_sphere(edge), side)
        errors.append(np.abs(np.hypot(*loop.T) - 90.0).max())
    assert np.log2(errors[0] / errors[2]) / 2.0 > 1.5, errors


@pytest.mark.parametrize("off", [0.0, 2e-3])
def test_curves_near_a_sphere_are_mapped_along_its_normals(cap, off):
    """An outer loop round another pole than the mesh's, a hole in it, whichever way they run."""
    outer, flat_outer = small_circle((0.2, 1.0), 0.8, RADIUS + off)
    hole, flat_hole = small_circle((0.5, -2.0), 0.15, RADIUS + off)
    for turn in (1, -1):
        loops = trimmed(cap, Curves([outer[::turn], hole], "it"))
        assert [loop_area(loop) > 0.0 for loop in loops] == [True, False]
        for loop, exact in zip(loops, (flat_outer, flat_hole), strict=True):
            assert distance_to(loop, exact).max() < TOLERANCE
            assert distance_to(exact, loop).max() < TOLERANCE
            assert abs(loop_area(loop)) == pytest.approx(abs(loop_area(exact)), rel=2e-3)


@pytest.mark.parametrize("axis", ["z", "x"])
def test_a_curve_from_a_drawing_cuts_along_the_line_of_sight(cap, axis):
    """A circle in plan, a metre away from the part; along x the whole part is turned."""
    t = np.linspace(0.0, 2.0 * np.pi, 600, endpoint=False)
    x, y = 0.02 + 0.05 * np.cos(t), 0.01 + 0.05 * np.sin(t)
    curve = np.stack([x, y, 1.0 + 0 * t], axis=1)
    exact = flat_of(np.stack([x, y, np.sqrt(RADIUS**2 - x**2 - y**2)], axis=1) / RADIUS)
    if axis == "x":
        turn = np.array([(0, 0, -1), (0, 1, 0), (1, 0, 0.0)])  # its upper side looks back along x
        cap, curve = replace(cap, points=cap.points @ turn.T), curve @ turn.T
    (loop,) = trimmed(cap, Curves([curve], "it", axis))
    assert distance_to(loop, exact).max() < TOLERANCE
    assert distance_to(exact, loop).max() < TOLERANCE


def test_along_a_line_of_sight_folds_under_are_refused_and_what_lies_before_them_cut():
    flat = wd.Ply.disc("p", "carbon_interlock", 0.13, edge=5e-3, mesh="random")
    x, y, _ = flat.rest_points.T  # more than half of a sphere of 60 mm
    points = on_sphere(np.hypot(x, y) / 0.06, np.arctan2(y, x), 0.06)
    ply = replace(flat_ply(flat.rest_points, flat.mesh.triangles), points=points)
    t = np.linspace(0.0, 2.0 * np.pi, 600, endpoint=False)
    ring = np.stack([np.cos(t), np.sin(t), 0.0 * t], axis=1)
    (loop,) = trimmed(ply, Curves([0.03 * ring], "it", "z"))
    np.testing.assert_allclose(np.hypot(*loop.T), 60.0 * np.pi / 6.0, atol=0.15)  # 5²/8·60 tan 30°
    with pytest.raises(wd.InputError, match=r"passes where p folds under itself, .* along z, at x"):
        trimmed(ply, Curves([0.055 * ring], "it", "z"))
    sheet = flat_ply(flat.rest_points, flat.mesh.triangles)
    with pytest.raises(wd.InputError, match="along = x: p stands on its edge; take another axis"):
        trimmed(sheet, Curves([0.03 * ring], "it", "x"))


def test_along_a_line_of_sight_a_curve_drops_down_walls():
    flat = wd.Ply.rectangle("p", "carbon_interlock", 0.2, 0.1, cells=10, mesh="grid")
    s, y, _ = flat.rest_points.T
    wall = 0.02  # up at s = 0, two cells high
    points = np.stack([np.minimum(s, np.maximum(s - wall, 0.0)), y, np.clip(s, 0.0, wall)], axis=1)
    ply = replace(flat_ply(flat.rest_points, flat.mesh.triangles), points=points)
    square = np.array([(-0.05, -0.03, 0), (0.04, -0.03, 0), (0.04, 0.03, 0), (-0.05, 0.03, 0.0)])
    (loop,) = trimmed(ply, Curves([square], "it", "z"))
    assert loop_area(loop) == pytest.approx((50 + 20 + 40) * 60, rel=1e-3)
    assert loop.min(axis=0) == pytest.approx([-50.0, -30.0], abs=0.01)


def test_holes_of_the_blank_stay_where_they_are_inside_and_go_outside():
    square = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * 0.01
    holes = [square, square + np.array([0.06, 0.0])]
    outline = [(-0.1, -0.1), (0.1, -0.1), (0.1, 0.1), (-0.1, 0.1)]
    flat = wd.Ply.polygon("p", "carbon_interlock", outline, holes=holes, edge=0.01, mesh="random")
    ply = flat_ply(flat.rest_points, flat.mesh.triangles)
    curve = np.array([(-0.03, -0.03, 0), (0.04, -0.03, 0), (0.04, 0.03, 0), (-0.03, 0.03, 0)])
    loops = trimmed(ply, Curves([curve], "it"))
    assert sorted(map(loop_area, loops)) == pytest.approx([-400.0, 70 * 60], rel=1e-4)
    loops = trimmed(ply, read_trim("x<40mm"))
    assert sorted(map(loop_area, loops)) == pytest.approx([-400.0, 140 * 200], rel=1e-4)


def test_a_curve_that_leaves_the_ply_is_said_and_follows_its_edge():
    flat = wd.Ply.rectangle("p", "carbon_interlock", 0.2, 0.2, edge=0.01, mesh="random")
    ply = flat_ply(flat.rest_points, flat.mesh.triangles)
    curve = np.array(
        [(-0.05, -0.05, 1e-3), (0.13, -0.05, 1e-3), (0.13, 0.05, 1e-3), (-0.05, 0.05, 1e-3)]
    )
    with pytest.warns(UserWarning, match="leaves p on 160 mm of its 560 mm, by up to 30 mm"):
        (loop,) = trimmed(ply, Curves([curve], "it"))
    assert loop_area(loop) == pytest.approx(150 * 100, rel=1e-4)
    far = np.array([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0.0)])
    with pytest.warns(UserWarning, match="leaves p on 8000 mm of its 8000 mm"):
        (loop,) = trimmed(ply, Curves([far], "it"))
    assert loop_area(loop) == pytest.approx(200 * 200, rel=1e-4)
    with pytest.warns(UserWarning), pytest.raises(wd.InputError, match="keeps nothing of p"):
        trimmed(ply, Curves([curve + np.array([0.3, 0.0, 0.0])], "it"))


def test_a_curve_all_round_a_disc_keeps_the_disc():
    disc = wd.Ply.disc("p", "carbon_interlock", 0.1, edge=0.01, mesh="random")
    ply = flat_ply(disc.rest_points, disc.mesh.triangles)
    t = np.linspace(0.0, 2.0 * np.pi, 60, endpoint=False)
    curve = 0.2 * np.stack([np.cos(t), np.sin(t), 0.0 * t], axis=1)
    with pytest.warns(UserWarning, match="leaves p on 1256 mm of its 1256 mm, by up to 100 mm"):
        (loop,) = trimmed(ply, Curves([curve], "it"))
    assert loop_area(loop) == pytest.approx(1e6 * disc.mesh.areas.sum(), rel=1e-4)


def test_a_curve_far_off_or_across_a_fold_is_refused():
    flat = wd.Ply.rectangle("p", "carbon_interlock", 0.2, 0.1, edge=5e-3, mesh="random")
    ply = flat_ply(flat.rest_points, flat.mesh.triangles)
    square = np.array([(-0.04, -0.03, 0.05), (0.04, -0.03, 0.05), (0.04, 0.03, 0.05)])
    with pytest.raises(wd.InputError, match="lies up to 50 mm off p: give it in the run's coord"):
        trimmed(ply, Curves([square], "it"))
    s, y, _ = flat.rest_points.T  # folded over x = 0, 4 mm between the leaves
    folded = np.stack([np.abs(s), y, 0.002 * np.tanh(s / 0.002)], axis=1)
    ply = replace(ply, points=folded)
    through = square * [0.2, 1.0, 0.0] + [0.06, 0.0, 0.0] + np.outer([1, 1, -1], [0, 0, 0.002])
    with pytest.raises(wd.InputError, match=r"jumps on p at \(\d+, -?\d+, -?0\) mm from one leaf"):
        trimmed(ply, Curves([through], "it"))


def test_the_nearest_point_is_that_of_brute_force(cap):
    chance = np.random.default_rng(1)
    points = on_sphere(0.9 * chance.random(200), 6.28 * chance.random(200))
    points *= 0.7 + 0.6 * chance.random((200, 1))
    feet = PlySearch(cap).nearest(points)
    corners = cap.points[cap.triangles]
    every = [
        trimesh.triangles.closest_point(corners, np.tile(p, (len(corners), 1))) - p for p in points
    ]
    shortest = np.linalg.norm(every, axis=2).min(axis=1)
    np.testing.assert_allclose(feet.distance, shortest, atol=1e-12)
    places = feet.of(cap.points, cap.triangles)
    np.testing.assert_allclose(np.linalg.norm(places - points, axis=1), shortest, atol=1e-9)


def test_notches_lie_where_axes_meet_the_outline_and_point_inwards(rolled):
    (pattern,) = patterns_of([rolled])
    assert len(pattern.notches) == 4
    for notch in pattern.notches:
        assert distance_to(notch[:1], pattern.loops[0])[0] < 1e-6
        assert distance_to(notch[1:], pattern.loops[0])[0] > 3.0
    along = pattern.notches[0][1] - pattern.notches[0][0]
    assert np.linalg.norm(along) == pytest.approx(4.0)
    assert np.degrees(np.arctan2(along[1], along[0])) % 180.0 == pytest.approx(30.0, abs=1e-6)


def curve_files(folder, loops):
    """The same curves in every kind of file and unit."""
    (folder / "c.json").write_text(
        json.dumps({"unit": "cm", "loops": [(100.0 * loop).tolist() for loop in loops]})
    )
    rows = ["loop,x_mm,y_mm,z_mm"]
    rows += [f"{k},{x},{y},{z}" for k, loop in enumerate(loops) for x, y, z in 1e3 * loop]
    (folder / "c.csv").write_text("\n".join(rows) + "\n")
    ezdxf = pytest.importorskip("ezdxf")
    drawing = ezdxf.new("R2010", units=ezdxf.units.IN)
    for loop in loops:
        drawing.modelspace().add_polyline3d((loop / 0.0254).tolist(), close=True)
    drawing.saveas(folder / "c.dxf")
    return [folder / f"c.{kind}" for kind in ("json", "csv", "dxf")]


def test_curves_are_read_alike_from_every_kind_of_file(tmp_path):
    given = [small_circle((0.2, 1.0), 0.8, count=9)[0], small_circle((0.5, -2.0), 0.15, count=5)[0]]
    for path in curve_files(tmp_path, given):
        for loop, exact in zip(read_curves(path), given, strict=True):
            np.testing.assert_allclose(loop, exact, atol=1e-9)


def test_curves_of_a_drawing_are_followed_and_open_ones_are_said(tmp_path):
    ezdxf = pytest.importorskip("ezdxf")
    drawing = ezdxf.new("R2010", units=0)  # none: millimetres
    drawing.modelspace().add_circle((10, 20, 5), 30)
    drawing.saveas(tmp_path / "c.dxf")
    (loop,) = read_curves(tmp_path / "c.dxf")
    np.testing.assert_allclose(loop[:, 2], 5e-3)
    np.testing.assert_allclose(np.hypot(loop[:, 0] - 0.01, loop[:, 1] - 0.02), 0.03, atol=1e-9)
    sides = np.linalg.norm(loop - np.roll(loop, 1, axis=0), axis=1)
    assert (0.03 - np.sqrt(0.03**2 - sides**2 / 4)).max() < 1e-5
    drawing = ezdxf.new("R2010")
    drawing.modelspace().add_line((0, 0), (1, 0))
    drawing.saveas(tmp_path / "c.dxf")
    with pytest.raises(wd.InputError, match=r"holds no closed polyline.*join its lines"):
        read_curves(tmp_path / "c.dxf")


def test_the_border_of_a_tool_cuts_and_a_closed_tool_has_none():
    ring = trimesh.creation.annulus(0.02, 0.05, 0.01)
    top = ring.faces[(ring.vertices[ring.faces][:, :, 2] > 0.0049).all(axis=1)]
    tools = [PlacedTool("plate", ring.vertices, top), PlacedTool("ring", ring.vertices, ring.faces)]
    loops = read_trim("tool:plate", tools).loops
    radii = sorted(float(np.hypot(*loop[0, :2])) for loop in loops)
    assert radii == pytest.approx([0.02, 0.05])
    with pytest.raises(wd.InputError, match="tool:ring: the tool is closed, it has no border"):
        read_trim("tool:ring", tools)
    with pytest.raises(wd.InputError, match="unknown tool 'plat'; did you mean 'plate'"):
        read_trim("tool:plat", tools)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ("z<", "must be a side of a plane, such as z<-20mm"),
        ("q<3", "must be a side of a plane"),
        ("z<3inch", "must be a side of a plane"),
        ("x-x<3", "is no plane: its terms cancel"),
        ("nowhere.dxf", "does not exist: give a file, a side such as"),
        ("a.txt", "unknown kind of trim file '.txt'; "),
        ("a.csv", "has columns x, y, z: give x_mm, y_mm and z_mm"),
        ("two.csv", "curve 1 must have three points or more"),
        ("nan.csv", "curve 1 must be points of three finite numbers"),
        ("a.json", 'must be {"unit": "mm", "loops"'),
        ("broken.json", "cannot be read: "),
        ("deep.json", "cannot be read: "),
        ("huge.json", "cannot be read: "),
        ("a.dxf", "cannot be read: "),
        (3.0, "trim = 3.0 must be a file, a side such as z<-20mm, or tool:NAME"),
    ],
)
def test_what_says_no_trim_is_refused(given, words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    files = {
        "a.txt": "x", "a.csv": "x,y,z\n0,0,0\n", "a.json": "[]", "broken.json": "{", "a.dxf": "x",
        "two.csv": "x_m,y_m,z_m\n0,0,0\n1,0,0\n0,0,0\n",
        "deep.json": "[" * 100_000,
        "huge.json": '{"unit": "m", "loops": [[[1' + "0" * 400 + ", 0, 0]]]}",
        "nan.csv": "x_m,y_m,z_m\n0,0,nan\n1,0,0\n0,1,0\n",
    }  # fmt: skip
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    with pytest.raises(wd.InputError) as refused:
        read_trim(given)
    assert words in str(refused.value)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"trim": "z<0", "along": "z"}, "is a plane, which along = z does not go with"),
        ({"trim": "tool:die", "along": "up"}, "unknown axis 'up'"),
        ({"along": "z"}, "along = z goes with trim: say where the part ends"),
    ],
)
def test_a_line_of_sight_goes_with_curves_only(given, words, pressed, tmp_path):
    with pytest.raises(wd.InputError) as refused:
        export(pressed[1], "svg", tmp_path / "p.svg", **given)
    assert words in str(refused.value)


def test_the_kit_of_a_run_is_read_back_by_another_library(pressed, tmp_path, capsys):
    pytest.importorskip("ezdxf")
    out = tmp_path / "kit.dxf"
    words = ["export", str(pressed[1]), "--to", "dxf", "--trim", "z<-8mm", "--out", str(out)]
    assert cli.main(words) == 0
    drawing = trimesh.load_path(out)
    lines = {}
    for entity in drawing.entities:
        lines.setdefault(str(entity.layer), []).append(drawing.vertices[entity.points])
    right = -np.inf
    for ply in wd.read_run(pressed[1]).plies:
        (loop,) = lines[f"CUT_{ply.name}".upper()]
        assert abs(loop_area(loop[:-1])) == pytest.approx(
            sum(map(loop_area, trimmed(ply, read_trim("z<-8mm")))), rel=1e-6
        )
        assert len(lines[f"NOTCH_{ply.name}".upper()]) == 4
        assert loop[:, 0].min() > right
        right = loop[:, 0].max()
    assert cli.main(["export", str(pressed[1]), "--to", "csv", "--trim", "z<0"]) == 2
    assert (
        "trim does not go with the format 'csv': it goes with dxf, svg" in capsys.readouterr().err
    )
    with pytest.raises(wd.InputError, match="trim keeps nothing of ply_0: give the other side"):
        export(pressed[1], "svg", tmp_path / "no.svg", trim="z<-1")
    assert [f.name for f in tmp_path.iterdir()] == ["kit.dxf"]


def test_a_hole_is_out_and_an_island_in_it_is_in():
    square = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
    points = np.array([(0.0, 0.0), (0.5, 0.0), (0.8, 0.0), (1.2, 0.0)])
    loops = [square, 0.6 * square, 0.3 * square]
    np.testing.assert_array_equal(inside(points, loops), [True, False, True, False])
