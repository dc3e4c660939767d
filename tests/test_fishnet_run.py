"""A scene computed as a net: its result, its run folder, and what a net cannot give."""

import csv
import json
import math
from dataclasses import replace

import numpy as np
import pytest

import warpdrape as wd
from warpdrape.cli import main
from warpdrape.fishnet.press import pressed_surface, taut
from warpdrape.results.net_picture import cell_triangles
from warpdrape.scenes import circular_table, hemisphere, three_ply_hemisphere
from warpdrape.tools.pose import shifted
from warpdrape.units import deg, mm


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    out = tmp_path_factory.mktemp("net") / "run"
    words = ["run", "hemisphere", "--out", str(out), "--quiet"]
    assert main([*words, "--set", "approach=fishnet", "--set", "cells=14"]) == 0
    return out


def test_run_folder_reads_back(folder):
    result = wd.read_run(folder)
    (ply,) = result.plies
    assert result.completed and result.frame in (-1, 1)
    assert ply.line_tension is None and ply.tool_pressure is None and ply.wrinkle is None
    assert not any(name.endswith(("_j", "_n")) for name in result.history)
    flat = wd.read_run(folder, frame=0).plies[0]
    assert np.abs(flat.points - flat.rest_points).max() < 1e-6
    assert flat.max_shear_deg < 1e-3
    assert "shear up to" in repr(result)
    assert len(result.plot().axes) == 1  # shear alone: no forces, no energies


def test_left_out_is_neither_zero_nor_missing(folder):
    summary = json.loads((folder / "summary.json").read_text("utf-8"))
    for name in ("energy_error", "kinetic_ratio", "quasi_static", "max_penetration_m"):
        assert summary[name] is None
    assert {"forces", "friction", "energies", "wrinkles"} <= set(summary["not_given"])
    assert summary["plies"][0]["defects"]["wrinkles"] is None
    assert summary["tools"][0]["force_n"] is None
    assert summary["tools"][0]["displacement_m"] == pytest.approx(0.075, abs=1e-6)
    with (folder / "history.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 2
    assert {row["kinetic_j"] for row in rows} == {""} == {row["punch_force_n"] for row in rows}
    record = json.loads((folder / "run.json").read_text("utf-8"))
    assert record["approach"] == "fishnet" == record["parameters"]["approach"]


def test_pictures_and_judge(folder, capsys):
    assert main(["picture", str(folder), "--out", str(folder / "net.png")]) == 0
    assert main(["judge", str(folder)]) == 0
    assert "wrinkles (the approach cannot show them)" in capsys.readouterr().out
    assert main(["picture", str(folder), "--field", "warp-tension"]) == 2
    assert "has no warp tension in this run" in capsys.readouterr().err
    for kind in ("csv", "inp"):
        assert main(["export", str(folder), "--to", kind]) == 0


def test_shear_of_the_ply_is_that_of_the_net(folder):
    summary = json.loads((folder / "summary.json").read_text("utf-8"))
    (entry,) = summary["plies"]
    # Triangles of 21 mm see less than cells of 4 mm.
    assert entry["max_shear_deg"] == pytest.approx(entry["net"]["max_shear_deg"], abs=2.5)
    # The press's semi-discrete runs: 45 to 48°, 36.6 mm, 7.3 to 7.8 mm.
    assert 44.0 < entry["max_shear_deg"] < 50.0
    assert entry["draw_in_m"]["warp"] == pytest.approx(36.6 * mm, abs=1.0 * mm)
    assert entry["draw_in_m"]["bias"] == pytest.approx(7.5 * mm, abs=1.0 * mm)


def test_ply_lies_on_the_punch():
    result = hemisphere.build(approach="fishnet", cells=14).run()
    (ply,) = result.plies
    half = 0.5 * hemisphere.build().plies[0].fabric.thickness
    punch = result.tools[0]
    center = np.array([0.0, 0.0, punch.vertices[:, 2].min() + 0.075])
    pole = np.hypot(*ply.points[:, :2].T) < 0.05
    away = np.linalg.norm(ply.points[pole] - center, axis=1) - 0.075 - half
    assert np.abs(away).max() < 0.15 * mm  # sag of the surface's squares, 2.2 mm wide


def test_plies_of_a_stack_keep_their_distance():
    result = three_ply_hemisphere.build(approach="fishnet", cells=8).run()
    low, middle, high = result.plies
    thick = low.rest_points[0, 2], middle.rest_points[0, 2], high.rest_points[0, 2]
    for one, other, far in (
        (low, middle, thick[1] - thick[0]),
        (middle, high, thick[2] - thick[1]),
    ):
        pole = np.argmin(np.hypot(*one.rest_points[:, :2].T))
        same = np.argmin(np.linalg.norm(other.points[:, :2] - one.points[pole, :2], axis=1))
        assert other.points[same, 2] - one.points[pole, 2] == pytest.approx(far, abs=0.02 * mm)
    assert result.summary["central_ply"]["max_shear_deg"] > 30.0


@pytest.mark.filterwarnings("ignore:Mean of empty slice", "ignore:invalid value")
def test_part_of_a_ply_that_the_net_does_not_reach_is_left_out():
    scene = circular_table.build(approach="fishnet", cells=20)
    scene = replace(scene, tools=[wd.Tool.table(radius=0.2, depth=0.01)])
    result = scene.run()
    (ply,) = result.plies
    assert len(ply.triangles) < len(scene.plies[0].mesh.triangles)
    assert np.isfinite(ply.points).all()
    assert ply.points[:, 2].min() > -0.011
    (warning,) = [w for w in result.summary["warnings"] if "are left out" in w]
    assert "the surface ends there" in warning


def test_membrane_between_tools_is_the_closed_form():
    """Between a disc pressed into a ring and the ring: z = depth · ln(r/outer)/ln(inner/outer)."""
    inner, outer, depth = 0.03, 0.09, 0.02
    line = np.linspace(-0.12, 0.12, 121)
    r = np.maximum(np.hypot(*np.meshgrid(line, line)), 1e-6)
    lower = np.where(r >= outer, 0.0, -1.0)
    upper = np.where(r <= inner, -depth, 1.0)
    z = taut(np.clip(np.zeros_like(r), lower, upper), lower, upper)
    between = (r > inner + 0.004) & (r < outer - 0.004)
    exact = -depth * np.log(r / outer) / math.log(inner / outer)
    assert np.abs(z - exact)[between].max() < 0.03 * depth  # rims of stairs, 2 mm
    assert (z >= lower - 1e-12).all() and (z <= upper + 1e-12).all()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"tools": ()}, "needs tools to drape over"),
        ({"tools": "punch"}, "needs tools above and below the plies"),
    ],
)
def test_scenes_without_a_surface(change, words):
    scene = hemisphere.build(approach="fishnet", cells=4)
    if change["tools"]:
        change = {"tools": [tool for tool in scene.tools if tool.name == "punch"]}
    with pytest.raises(wd.InputError, match=words):
        replace(scene, **change).run()


def test_what_a_net_does_not_do(tmp_path):
    with pytest.raises(wd.InputError, match="unknown approach 'fishnets'; did you mean 'fishnet'"):
        hemisphere.build(approach="fishnets")
    with pytest.raises(wd.InputError, match="has no checkpoints: run the scene again"):
        hemisphere.build(approach="fishnet", cells=4).run(resume=tmp_path)


def test_pressed_surface_needs_tools_over_the_plies():
    die = wd.Tool.plate("low", width=0.2, height=0.2).moved((0.0, 0.0, -0.01))
    far = wd.Tool.plate("high", width=0.2, height=0.2, facing="down").moved((5.0, 0.0, 0.01))
    box = np.array([[-0.05, -0.05], [0.05, 0.05]])
    with pytest.raises(wd.InputError, match="no tool lies above or below the plies"):
        pressed_surface([die, far], [shifted(), shifted()], 1e-3, 0.0, box, 0.01)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (
            {"start": (0.0, 0.0, 0.5)},
            r"start = \(0, 0, 0.5\) m lies 0.5 m off the surface.*nearest",
        ),
        ({"warp": (0.0, 0.0, 1.0)}, "is square to the surface at the start"),
        ({"warp": (0.0, 0.0, 0.0)}, "warp must not be the zero vector"),
        ({"spacing": 0.4}, "spacing = 0.4 m is more than half of the surface"),
        ({"spacing": 1e-5}, r"makes more than 2e\+07 crossovers: take a larger"),
        ({"generators": "straight"}, "unknown generators 'straight'; known: geodesic"),
        ({"yarn_angle": 4.0}, "must lie between 0 and 180°"),
        ({"shear_limit": 60.0}, "must be below 90°: give radians"),
        ({"outline": [(1.0, 1.0), (2.0, 1.0), (1.0, 2.0)]}, r"must go round \(0, 0\)"),
        ({"outline": [(1.0, 1.0)]}, "must be three points"),
        ({"holes": "fill"}, "holes = 'fill' must be 'span' or 'end'"),
        ({"start": [(0.0, 0.0, 0.0)]}, "must be two points"),
        ({"start": [(0.0, 0.0, 0.0), (0.0, 0.0, 9.0)]}, "lies 9 m off the surface"),
        ({"start": [(0.0, 0.0, 0.0), (0.1, 0.0, 0.0)], "generators": "plane"}, "leave one of them"),
    ],
)
def test_bad_input_has_its_remedy(given, words):
    plate = wd.Tool.plate(width=0.4, height=0.4).surface.mesh
    with pytest.raises(wd.InputError, match=words):
        wd.drape_fishnet(plate, **({"spacing": 0.02} | given))


def test_surfaces_that_are_none():
    import trimesh

    points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1)]
    book = trimesh.Trimesh(points, [[0, 1, 2], [0, 3, 1], [0, 1, 4]], process=False)
    with pytest.raises(wd.InputError, match="3 facets of the surface meet in one edge"):
        wd.drape_fishnet(book, 0.1)
    around = np.linspace(0.0, 2 * math.pi, 13)[:-1]
    rim = [
        [(1 + w * math.cos(0.5 * a)) * math.cos(a), (1 + w * math.cos(0.5 * a)) * math.sin(a),
         w * math.sin(0.5 * a)]
        for a in around
        for w in (-0.2, 0.2)
    ]  # fmt: skip
    facets = []
    for k in range(12):
        a, b, c, d = 2 * k, 2 * k + 1, (2 * k + 2) % 24, (2 * k + 3) % 24
        c, d = (d, c) if k == 11 else (c, d)
        facets += [[a, b, c], [b, d, c]]
    with pytest.raises(wd.InputError, match="one side only"):
        wd.drape_fishnet(trimesh.Trimesh(rim, facets, process=False), 0.1)
    with pytest.raises(wd.InputError, match="must be a Tool, a mesh or the path"):
        wd.drape_fishnet(5, 0.1)
    with pytest.raises(wd.InputError, match="no mesh file"):
        wd.drape_fishnet("nowhere.stl", 0.1)
    with pytest.raises(wd.InputError, match="needs locking"):
        wd.best_fishnet(wd.Tool.sphere(radius=0.1), 0.02, objective="past_locking")
    net = wd.drape_fishnet(wd.Tool.plate(width=0.4, height=0.4), 0.05)
    with pytest.raises(wd.InputError, match="give radians, as in 50"):
        wd.suggest_darts(net, 50.0)
    assert wd.suggest_darts(net, 50 * deg) == ()


def test_net_is_drawn_as_its_cells():
    net = wd.drape_fishnet(wd.Tool.plate(width=0.4, height=0.4), 0.05)
    triangles, cell = cell_triangles(net)
    assert len(triangles) == 2 * np.count_nonzero(net.cells)
    corners = net.points.reshape(-1, 3)[triangles]
    twice = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert np.allclose(0.5 * twice[:, 2], 0.5 * 0.05**2)  # all face up, half a cell each
    assert net.cells.ravel()[cell].all()
    assert wd.net_picture(net).axes
    with pytest.raises(wd.InputError, match="has no cell to draw"):
        wd.net_picture(net.within(np.zeros(net.status.shape, dtype=bool)))
